//! OUTPUT4 as Fortran records.
//!
//! Every record stands between two marks of four bytes that give its length. The header of a matrix has columns, rows, form,
//! type (integers of four bytes) and a name of eight characters, 24 bytes; programs with integers of eight bytes write 48,
//! the name as two words of four characters filled with blanks, and all values in eight bytes.

use super::contents::{Contents, Header};
use crate::structure::error::StructureError;
use crate::structure::import::triplets::Triplets;

/// Fortran records of a file.
pub(super) struct Records<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    number: usize,
    little: bool,
    /// Bytes of an integer: 4 or 8.
    integer: usize,
}

impl<'a> Records<'a> {
    /// Detects the form from the mark of the first record: a header of 24 or 48 bytes.
    pub fn detect(file: &'a str, bytes: &'a [u8]) -> Option<Self> {
        let mark: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        let (little, integer) = match (u32::from_le_bytes(mark), u32::from_be_bytes(mark)) {
            (24, _) => (true, 4),
            (48, _) => (true, 8),
            (_, 24) => (false, 4),
            (_, 48) => (false, 8),
            _ => return None,
        };
        Some(Self { file, bytes, at: 0, number: 0, little, integer })
    }

    fn fault(&self, reason: impl std::fmt::Display) -> StructureError {
        let reason = format!("record {}: {reason}", self.number);
        StructureError::Matrix { file: self.file.to_owned(), reason }
    }

    fn mark(&self, at: usize) -> Option<usize> {
        let bytes: [u8; 4] = self.bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
        let length = if self.little { i32::from_le_bytes(bytes) } else { i32::from_be_bytes(bytes) };
        usize::try_from(length).ok()
    }

    /// The integer at this place of a record, counted in integers.
    fn integer(&self, record: &[u8], place: usize) -> Option<i64> {
        let bytes = record.get(self.integer * place..self.integer * (place + 1))?;
        if let Ok(bytes) = <[u8; 8]>::try_from(bytes) {
            return Some(if self.little { i64::from_le_bytes(bytes) } else { i64::from_be_bytes(bytes) });
        }
        let bytes: [u8; 4] = bytes.try_into().ok()?;
        Some(i64::from(if self.little { i32::from_le_bytes(bytes) } else { i32::from_be_bytes(bytes) }))
    }

    /// The next record, `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&'a [u8]>, StructureError> {
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        self.number += 1;
        let body = self.mark(self.at).and_then(|length| self.bytes.get(self.at + 4..)?.get(..length));
        let Some(body) = body else { return Err(self.fault("the file is truncated")) };
        let end = self.at + 4 + body.len();
        if self.mark(end) != Some(body.len()) {
            return Err(self.fault("its two length marks differ: the file is truncated or damaged"));
        }
        self.at = end + 4;
        Ok(Some(body))
    }

    /// Bytes of a number.
    fn size(&self, header: &Header) -> usize {
        if self.integer == 8 { 8 } else { 4 * header.words() }
    }

    fn value(&self, bytes: &[u8]) -> Option<f64> {
        let value = if let Ok(bytes) = <[u8; 8]>::try_from(bytes) {
            if self.little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) }
        } else {
            let bytes: [u8; 4] = bytes.try_into().ok()?;
            f64::from(if self.little { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) })
        };
        value.is_finite().then_some(value)
    }
}

pub(super) fn read(mut records: Records, contents: &mut Contents) -> Result<(), StructureError> {
    while let Some(record) = records.next()? {
        let header = read_header(&records, record)?;
        let wanted = contents.meets(&header, &format!("record {}", records.number));
        let entries = read_columns(&mut records, &header, wanted)?;
        if wanted {
            contents.take(&header, entries);
        }
    }
    Ok(())
}

fn read_header(records: &Records, record: &[u8]) -> Result<Header, StructureError> {
    let length = 6 * records.integer;
    let number = |place| records.integer(record, place);
    let (Some(columns), Some(rows), Some(form), Some(kind), true) =
        (number(0), number(1), number(2), number(3), record.len() == length)
    else {
        let found = record.len();
        return Err(records.fault(format!("expected the header of a matrix, {length} bytes, found {found} bytes")));
    };
    let words = record.get(4 * records.integer..).unwrap_or_default().chunks(records.integer);
    let name: Vec<u8> = match records.integer {
        8 => words.flat_map(|word| word.get(..4).unwrap_or_default()).copied().collect(),
        _ => words.flatten().copied().collect(),
    };
    let name = String::from_utf8_lossy(&name);
    Header::new([columns, rows, form, kind], name.trim_end_matches('\0')).map_err(|reason| records.fault(reason))
}

fn read_columns(records: &mut Records, header: &Header, wanted: bool) -> Result<Triplets, StructureError> {
    let mut entries = Triplets::default();
    loop {
        let Some(record) = records.next()? else {
            return Err(records.fault(format!("the file is truncated: matrix {} has no end", header.name)));
        };
        let number = |place| records.integer(record, place);
        let (Some(column), Some(row), Some(words)) = (number(0), number(1), number(2)) else {
            return Err(records.fault("expected a column (number, first row, words)"));
        };
        if column < 1 || column > header.columns as i64 + 1 {
            return Err(records.fault(format!("column {column}: expected 1 to {}", header.columns)));
        }
        if column as usize > header.columns {
            return Ok(entries);
        }
        if !wanted {
            continue;
        }
        let body = record.get(3 * records.integer..).unwrap_or_default();
        let column = (column - 1) as u32;
        if row > 0 {
            let values = body.len() / records.size(header);
            if words != (values * header.words()) as i64 || values * records.size(header) != body.len() {
                let found = body.len();
                return Err(
                    records.fault(format!("column {} announces {words} words, but has {found} bytes", column + 1))
                );
            }
            run(records, header, Begin { row, column }, body, &mut entries)?;
            continue;
        }
        let mut rest = body;
        while !rest.is_empty() {
            let StringHead { first, length, own_length } = string_head(records, header, rest)?;
            let values = rest.get(own_length..).and_then(|rest| rest.get(..length));
            let values = values.ok_or_else(|| records.fault("a string is truncated"))?;
            run(records, header, Begin { row: first, column }, values, &mut entries)?;
            rest = &rest[own_length + length..];
        }
    }
}

/// Position of a column's first value.
struct Begin {
    row: i64,
    column: u32,
}

/// Values of a column from a row on.
fn run(
    records: &Records,
    header: &Header,
    Begin { row: first, column }: Begin,
    values: &[u8],
    entries: &mut Triplets,
) -> Result<(), StructureError> {
    for (offset, bytes) in values.chunks(records.size(header)).enumerate() {
        let value = records.value(bytes).ok_or_else(|| records.fault("expected finite numbers"))?;
        let row = header.row(first, offset).ok_or_else(|| records.fault("more values than the matrix has rows"))?;
        entries.push(row, column, value);
    }
    Ok(())
}

/// Header of a string of values.
struct StringHead {
    /// First row.
    first: i64,
    /// Bytes of the values.
    length: usize,
    /// Bytes of the head itself.
    own_length: usize,
}

fn string_head(records: &Records, header: &Header, bytes: &[u8]) -> Result<StringHead, StructureError> {
    let fault = || records.fault("a string is truncated");
    let word = records.integer(bytes, 0).ok_or_else(fault)?;
    let (first, words, integers) = if header.big {
        (records.integer(bytes, 1).ok_or_else(fault)?, word.checked_sub(1), 2)
    } else {
        (word.rem_euclid(65536), Some(word.div_euclid(65536) - 1), 1)
    };
    let words = words.and_then(|words| usize::try_from(words).ok()).ok_or_else(fault)?;
    let length = (words / header.words()).checked_mul(records.size(header)).ok_or_else(fault)?;
    Ok(StringHead { first, length, own_length: integers * records.integer })
}
