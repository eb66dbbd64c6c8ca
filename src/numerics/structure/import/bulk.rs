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
    /// A field after the name; empty where the entry has none.
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
            let name = text.split([' ', ',', '*']).next().unwrap_or_default().to_ascii_uppercase();
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
