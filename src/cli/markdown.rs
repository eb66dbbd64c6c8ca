//! Pages of the guide for a terminal: headings, lists, code and tables, with lines that end where the terminal does.

use anstyle::{AnsiColor, Style};
use comfy_table::{ColumnConstraint, ContentArrangement, LineStyle, Row, Table, TableStyle, Width};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// Blanks between the columns of a table.
const GAP: usize = 2;

/// A line below the head of a table, and no others.
const STYLE: TableStyle = TableStyle::new().header_separator(LineStyle::none().fill('-').junction('-'));

/// A page of Markdown as text with colours, whose lines have at most `columns` characters. Code is not wrapped.
pub(super) fn render(page: &str, columns: usize) -> String {
    let mut writer = Writer { columns, ..Writer::default() };
    for event in Parser::new_ext(page, Options::ENABLE_TABLES) {
        writer.take(event);
    }
    writer.end_paragraph();
    writer.text
}

/// A word with its colours, and the columns that it takes.
#[derive(Debug, Clone, Default)]
struct Word {
    text: String,
    width: usize,
}

/// The page so far.
#[derive(Default)]
struct Writer {
    columns: usize,
    text: String,
    /// Words of the paragraph, and whether the last one is still open.
    words: Vec<Word>,
    open: bool,
    style: Style,
    /// Next number of each list that is open; `None` for a list without numbers.
    lists: Vec<Option<u64>>,
    /// Mark of the list entry that has not been written yet.
    mark: Option<String>,
    in_code: bool,
    table: Vec<Vec<String>>,
    cell: Option<String>,
}

impl Writer {
    fn take(&mut self, event: Event<'_>) {
        match event {
            Event::Start(tag) => self.start(&tag),
            Event::End(tag) => self.end(tag),
            Event::Text(text) if self.in_code => {
                for line in text.lines() {
                    self.text.push_str(&format!("    {line}\n"));
                }
            }
            Event::Text(text) => self.push(&text, self.style),
            Event::Code(code) => self.push(&code, AnsiColor::Cyan.on_default()),
            Event::SoftBreak | Event::HardBreak => self.push(" ", self.style),
            Event::Html(text) | Event::InlineHtml(text) => self.push(&text, self.style),
            _ => {}
        }
    }

    fn start(&mut self, tag: &Tag<'_>) {
        match tag {
            Tag::Heading { .. } => {
                self.end_paragraph();
                self.gap();
                self.style = AnsiColor::Green.on_default().bold();
            }
            Tag::Paragraph if self.lists.is_empty() => self.gap(),
            Tag::CodeBlock(_) => {
                self.end_paragraph();
                self.gap();
                self.in_code = true;
            }
            Tag::List(first) => {
                self.end_paragraph();
                if self.lists.is_empty() {
                    self.gap();
                }
                self.lists.push(*first);
            }
            Tag::Item => {
                self.mark = Some(match self.lists.last_mut() {
                    Some(Some(number)) => {
                        *number += 1;
                        format!("{}. ", *number - 1)
                    }
                    _ => "- ".to_owned(),
                });
            }
            Tag::Table(_) => self.gap(),
            Tag::TableHead | Tag::TableRow => self.table.push(Vec::new()),
            Tag::TableCell => self.cell = Some(String::new()),
            Tag::Strong => self.style = self.style.bold(),
            Tag::Emphasis => self.style = self.style.italic(),
            _ => {}
        }
    }

    fn end(&mut self, tag: TagEnd) {
        match tag {
            TagEnd::Heading(_) => {
                self.end_paragraph();
                self.style = Style::new();
            }
            TagEnd::Paragraph | TagEnd::Item => self.end_paragraph(),
            TagEnd::CodeBlock => self.in_code = false,
            TagEnd::List(_) => {
                self.lists.pop();
            }
            TagEnd::TableCell => {
                let cell = self.cell.take().unwrap_or_default();
                if let Some(row) = self.table.last_mut() {
                    row.push(cell);
                }
            }
            TagEnd::Table => {
                let rows = std::mem::take(&mut self.table);
                self.text.push_str(&table(&rows, self.columns));
            }
            TagEnd::Strong | TagEnd::Emphasis => self.style = Style::new(),
            _ => {}
        }
    }

    /// Adds text to the paragraph or to the cell of a table.
    fn push(&mut self, text: &str, style: Style) {
        if let Some(cell) = &mut self.cell {
            return cell.push_str(text);
        }
        for (index, part) in text.split(char::is_whitespace).enumerate() {
            self.open &= index == 0;
            if part.is_empty() {
                continue;
            }
            if !self.open {
                self.words.push(Word::default());
            }
            self.open = true;
            if let Some(word) = self.words.last_mut() {
                word.text.push_str(&format!("{style}{part}{style:#}"));
                word.width += part.chars().count();
            }
        }
        self.open &= !text.ends_with(char::is_whitespace);
    }

    /// Writes the words so far, with the mark of their list entry.
    fn end_paragraph(&mut self) {
        self.open = false;
        let words = std::mem::take(&mut self.words);
        if words.is_empty() {
            return;
        }
        let mark = self.mark.take().unwrap_or_default();
        let outer = 2 * self.lists.len().saturating_sub(1);
        let indent = if self.lists.is_empty() { 0 } else { outer + mark.chars().count().max(2) };
        let head = format!("{}{mark}", " ".repeat(if mark.is_empty() { indent } else { outer }));
        self.text.push_str(&head);
        let mut used = head.chars().count();
        for (index, word) in words.iter().enumerate() {
            if index > 0 && used + 1 + word.width > self.columns {
                self.text.push('\n');
                self.text.push_str(&" ".repeat(indent));
                used = indent;
            } else if index > 0 {
                self.text.push(' ');
                used += 1;
            }
            self.text.push_str(&word.text);
            used += word.width;
        }
        self.text.push('\n');
    }

    /// An empty line before the next block.
    fn gap(&mut self) {
        if !self.text.is_empty() && !self.text.ends_with("\n\n") {
            self.text.push('\n');
        }
    }
}

/// A table as wide as the terminal at most; a list of its rows if its longest words leave no room for columns.
pub(super) fn table(rows: &[Vec<String>], columns: usize) -> String {
    let Some((head, body)) = rows.split_first() else { return String::new() };
    let longest = |column: usize| {
        let words = rows.iter().filter_map(|row| row.get(column)).flat_map(|cell| cell.split_whitespace());
        words.map(|word| word.chars().count()).max().unwrap_or(1).max(1)
    };
    let least: Vec<usize> = (0..head.len()).map(longest).collect();
    if least.iter().sum::<usize>() + GAP * head.len() > columns {
        return list(head, body, columns);
    }
    let mut table = Table::new();
    table.load_style(STYLE);
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(u16::try_from(columns).unwrap_or(u16::MAX));
    table.set_header(Row::from(head.clone()));
    body.iter().for_each(|row| {
        table.add_row(Row::from(row.clone()));
    });
    for (column, least) in table.column_iter_mut().zip(least) {
        // The columns' own separator is the other blank.
        column.set_padding((0, GAP as u16 - 1));
        let width = u16::try_from(least + GAP - 1).unwrap_or(u16::MAX);
        column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(width)));
    }
    table.trim_fmt() + "\n"
}

/// The rows of a table one below the other: the first cell, and below it the others with their headings.
fn list(head: &[String], body: &[Vec<String>], columns: usize) -> String {
    let title = head.first().map_or("", String::as_str);
    let mut text = format!("{title}\n{}\n", "-".repeat(title.chars().count()));
    for row in body {
        for (index, (heading, cell)) in head.iter().zip(row).enumerate().filter(|(_, (_, cell))| !cell.is_empty()) {
            let head = if index == 0 { String::new() } else { format!("  {heading}: ") };
            text.push_str(&super::text::hang(&head, cell, columns));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::TOPICS;

    /// A text without colours.
    fn plain(text: &str) -> String {
        anstream::adapter::strip_str(text).to_string()
    }

    #[test]
    fn a_page_is_laid_out() {
        let page = "# Title\n\nSome `code word`, and more text\nthat goes on.\n\n- one entry\n  goes on\n- two\n\nCode:\n\n    verbatim  text\n\n| a | b |\n|---|---|\n| `x` | long cell |\n";
        let shown = plain(&render(page, 20));
        let expected = "Title\n\nSome code word, and\nmore text that goes\non.\n\n- one entry goes on\n- two\n\nCode:\n\n    verbatim  text\n\na  b\n------------\nx  long cell\n";
        let lines = |text: &str| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
        assert_eq!(lines(&shown).replace('-', ""), lines(expected).replace('-', ""), "{shown}");
    }

    /// Every page at every width: no line is longer but code and single words, and no word is broken.
    #[test]
    fn pages_fit_and_keep_their_words() {
        for topic in TOPICS {
            for columns in [60, 80, 120] {
                let shown = plain(&render(topic.text, columns));
                let long = |line: &&str| line.chars().count() > columns && !line.starts_with("    ");
                let long: Vec<&str> = shown.lines().filter(long).filter(|line| line.trim().contains(' ')).collect();
                assert!(long.is_empty(), "{}: {long:#?}", topic.name);
                let words: Vec<&str> = shown.split_whitespace().collect();
                let typed = plain(&render(topic.text, 1000));
                for word in typed.split_whitespace().filter(|word| !word.starts_with("---")) {
                    assert!(words.iter().any(|one| one.contains(word)), "{} at {columns}: {word}", topic.name);
                }
            }
        }
    }
}
