//! OUTPUT4 as text.
//!
//! A matrix is a header (columns, rows, form, type, name, format), then per column a line of three integers (column, first
//! row, words) with its values, or first row 0 and strings, each with a line of its own: length + 1 and first row, or both
//! packed into one number. A column beyond the last one ends the matrix. Values have a decimal point, integers have none.

use super::contents::{Contents, Header};
use crate::structure::error::StructureError;
use crate::structure::import::lines::Lines;
use crate::structure::import::triplets::Triplets;

/// Width of values where the header gives no format: Nastran's default is `5E16.9`.
const DEFAULT_WIDTH: usize = 16;

pub(super) fn read(mut lines: Lines, contents: &mut Contents) -> Result<(), StructureError> {
    let mut more = lines.advance_past(&[])?;
    while more {
        let (header, width) = read_header(&lines)?;
        let wanted = contents.meets(&header, &format!("line {}", lines.number));
        let (entries, at) = (Triplets::default(), Run::default());
        let mut columns = Columns { header: &header, width, wanted, entries, at, sizes: [true; 2] };
        columns.read(&mut lines)?;
        if wanted {
            let entries = columns.entries;
            contents.take(&header, entries);
        }
        more = lines.advance_past(&[])?;
    }
    Ok(())
}

/// The header and the width of the values.
fn read_header(lines: &Lines) -> Result<(Header, usize), StructureError> {
    // Wide integers are announced at the end of the line.
    let (text, wide) = match lines.text.trim_end().strip_suffix("|I16") {
        Some(text) => (text, 16),
        None => (lines.text.trim_end(), 8),
    };
    let number = |from: usize, width: usize| text.get(from..(from + width).min(text.len()))?.trim().parse::<i64>().ok();
    let after = 2 * wide;
    let numbers = (number(0, wide), number(wide, wide), number(after, 8), number(after + 8, 8));
    let (Some(columns), Some(rows), Some(form), Some(kind)) = numbers else {
        let reason =
            format!("expected the header of a matrix (columns, rows, form, type, name), found \"{}\"", text.trim());
        return Err(lines.fault(reason));
    };
    let name = text.get(after + 16..(after + 24).min(text.len())).unwrap_or_default();
    let header = Header::new([columns, rows, form, kind], name).map_err(|reason| lines.fault(reason))?;
    let format = text.get(after + 24..).unwrap_or_default().trim().to_ascii_uppercase();
    if format.is_empty() {
        return Ok((header, DEFAULT_WIDTH));
    }
    let width = format.find(['E', 'D']).and_then(|at| format[at + 1..].split('.').next()?.trim().parse().ok());
    let width = width
        .filter(|width| (1..=64).contains(width))
        .ok_or_else(|| lines.fault(format!("expected a format as 1P,3E23.16 after the name, found \"{format}\"")))?;
    Ok((header, width))
}

/// Consecutive values of a column.
#[derive(Default)]
struct Run {
    column: i64,
    /// Row of its first value, from 1; 0 before the first string of a sparse column.
    first: i64,
    /// Words that are announced.
    words: Option<i64>,
    /// Values met.
    values: usize,
}

struct Columns<'a> {
    header: &'a Header,
    width: usize,
    wanted: bool,
    entries: Triplets,
    at: Run,
    /// Whether all runs so far have one word per value, and whether all have two.
    sizes: [bool; 2],
}

impl Columns<'_> {
    fn read(&mut self, lines: &mut Lines) -> Result<(), StructureError> {
        loop {
            if !lines.advance_past(&[])? {
                let name = &self.header.name;
                let reason = format!(
                    "the file is truncated: column {} or the end of matrix {name} expected",
                    self.at.column + 1
                );
                return Err(lines.fault(reason));
            }
            if !lines.text.contains('.') {
                self.complete(lines)?;
                self.at = self.next_run(lines)?;
            } else if self.at.column > self.header.columns as i64 {
                return Ok(());
            } else if self.wanted {
                self.values(lines)?;
            }
        }
    }

    /// The column or string that a line without values begins.
    fn next_run(&self, lines: &Lines) -> Result<Run, StructureError> {
        let (header, column) = (self.header, self.at.column);
        match integers(&lines.text).as_deref() {
            Some([column, first, words]) => {
                if !(1..=header.columns as i64 + 1).contains(column) {
                    return Err(lines.fault(format!("column {column}: expected 1 to {}", header.columns)));
                }
                let words = (*first > 0).then_some(*words);
                Ok(Run { column: *column, first: *first, words, values: 0 })
            }
            Some([length, first]) if header.big && *length > 0 && column > 0 => {
                Ok(Run { column, first: *first, words: Some(length - 1), values: 0 })
            }
            Some([packed]) if !header.big && *packed > 0 && column > 0 => {
                Ok(Run { column, first: packed % 65536, words: Some(packed / 65536 - 1), values: 0 })
            }
            _ => {
                let reason = format!(
                    "expected a column (number, first row, words) or a string, found \"{}\"",
                    lines.text.trim()
                );
                Err(lines.fault(reason))
            }
        }
    }

    /// The values of a line.
    fn values(&mut self, lines: &Lines) -> Result<(), StructureError> {
        if !lines.text.is_ascii() {
            return Err(lines.fault("expected plain characters"));
        }
        let mut rest = lines.text.trim_end();
        while !rest.is_empty() {
            let (value, after) = rest.split_at(self.width.min(rest.len()));
            let row = self.header.row(self.at.first, self.at.values);
            let (Some(row), true) = (row, self.at.column > 0) else {
                let reason =
                    if self.at.first > 0 { "more values than the matrix has rows" } else { "values before their row" };
                return Err(lines.fault(reason));
            };
            self.entries.push(row, (self.at.column - 1) as u32, lines.number_in(value)?);
            self.at.values += 1;
            rest = after;
        }
        Ok(())
    }

    /// A run must have the values that it announces, one word or two for each in all runs of a matrix: programs count words or
    /// values, and pyNastran two words per value in single precision too. It also gives four words to a string of one value.
    fn complete(&mut self, lines: &Lines) -> Result<(), StructureError> {
        let values = self.at.values as i64;
        let Some(words) = self.at.words.filter(|words| self.wanted && (*words, values) != (4, 1)) else {
            return Ok(());
        };
        let fits = |size: i64| words == values * size;
        let kept = [self.sizes[0] && fits(1), self.sizes[1] && fits(2)];
        if kept == [false; 2] {
            let reason = format!(
                "column {} announces {words} words from row {} on, but {values} values were found before this line",
                self.at.column, self.at.first
            );
            return Err(lines.fault(reason));
        }
        // A run without values fits either.
        if values > 0 {
            self.sizes = kept;
        }
        Ok(())
    }
}

/// Integers between blanks, or in fields of eight characters where large ones leave no blank.
fn integers(text: &str) -> Option<Vec<i64>> {
    let text = text.trim_end();
    let words: Vec<&str> = text.split_whitespace().collect();
    let fields = text.len() / 8;
    if matches!(text.len(), 16 | 24) && words.len() < fields {
        let field = |index: usize| text.get(8 * index..8 * index + 8)?.trim().parse().ok();
        if let Some(numbers) = (0..fields).map(field).collect() {
            return Some(numbers);
        }
    }
    words.into_iter().map(|word| word.parse().ok()).collect()
}
