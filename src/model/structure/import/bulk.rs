//! Entries of Nastran's bulk data: small, large and free field, with their continuations.

use super::lines::Lines;
use crate::structure::error::StructureError;

/// One entry: its name and its fields, four or eight per line.
pub(super) struct Card {
    pub name: String,
    pub line: usize,
    pub fields: Vec<String>,
}

impl Card {
    /// A field after the name; empty if the entry has none.
    pub fn field(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }
}

/// Reader of entries.
pub(super) struct Cards<'a> {
    pub lines: Lines<'a>,
    /// The line that ended the last entry.
    ahead: Option<String>,
}

impl<'a> Cards<'a> {
    pub fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Self { lines: Lines::new(file, bytes), ahead: None }
    }

    /// The next entry of one of these names (in capitals), `None` at the end of the file.
    pub fn next(&mut self, wanted: &[&str]) -> Result<Option<Card>, StructureError> {
        loop {
            let text = match self.ahead.take() {
                Some(text) => text,
                None if self.lines.advance_past(&["$"])? => self.lines.text.clone(),
                None => return Ok(None),
            };
            let name = text.split([' ', '\t', ',', '*']).next().unwrap_or_default().to_ascii_uppercase();
            if !wanted.contains(&name.as_str()) {
                continue;
            }
            let mut card = Card { name, line: self.lines.number, fields: split(&self.lines, &text)? };
            while self.lines.advance_past(&["$"])? {
                if !self.lines.text.starts_with(['*', '+', ' ', ',', '\t']) {
                    self.ahead = Some(self.lines.text.clone());
                    break;
                }
                card.fields.extend(split(&self.lines, &self.lines.text)?);
            }
            return Ok(Some(card));
        }
    }
}

/// Fields after the first: by commas, or by columns of 8 or 16 characters.
fn split(lines: &Lines, text: &str) -> Result<Vec<String>, StructureError> {
    if !text.is_ascii() {
        return Err(lines.fault("expected plain characters"));
    }
    let untabbed = if text.contains(',') { text.to_owned() } else { without_tabs(text) };
    let text = untabbed.as_str();
    let name = text.split(',').next().unwrap_or_default();
    let large = name[..name.len().min(8)].contains('*');
    let (count, width) = if large { (4, 16) } else { (8, 8) };
    if text.contains(',') {
        let mut fields: Vec<String> = text.split(',').skip(1).map(|field| field.trim().to_owned()).collect();
        fields.resize(fields.len().div_ceil(4).max(1) * 4, String::new());
        fields.truncate(count);
        return Ok(fields);
    }
    let field = |index: usize| {
        let begin = (8 + index * width).min(text.len());
        text[begin..(begin + width).min(text.len())].trim().to_owned()
    };
    Ok((0..count).map(field).collect())
}

/// The text with tabs to columns of eight, as Nastran reads them.
fn without_tabs(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        out.push(if character == '\t' { ' ' } else { character });
        while character == '\t' && !out.len().is_multiple_of(8) {
            out.push(' ');
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabs_lead_to_the_next_column() {
        let cards = |text: &str| {
            let mut cards = Cards::new("b", text.as_bytes());
            let card = cards.next(&["DMIG"]).expect("text").expect("a card");
            (card.name, card.fields)
        };
        let blanks =
            "DMIG*   KAA                           1               3\n*                     2               1 1.5\n";
        let tabs = "DMIG*\tKAA\t\t      1\t\t      3\n*\t\t      2\t\t      1 1.5\n";
        assert_eq!(cards(blanks), cards(tabs));
        assert_eq!(cards(tabs).1[..6], ["KAA", "1", "3", "", "2", "1"]);
    }
}
