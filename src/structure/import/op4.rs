//! Nastran OUTPUT4 matrices, text and binary, dense and sparse columns.

use std::io::{Read, Write};

use sprs::CsMat;

use super::lines::{Lines, unpacked};
use super::triplets::Triplets;
use crate::structure::error::StructureError;

/// Reads the matrix of this name, without regard to case.
pub(super) fn parse(file: &str, bytes: &[u8], name: &str) -> Result<CsMat<f64>, StructureError> {
    let mut whole = Vec::new();
    unpacked(bytes).read_to_end(&mut whole).map_err(|error| StructureError::Matrix {
        file: file.to_owned(),
        reason: format!("the file is cut short or damaged ({error})"),
    })?;
    let matrices = match Records::detect(file, &whole) {
        Some(records) => binary(records, name)?,
        None => text(Lines::new(file, &whole), name)?,
    };
    match matrices {
        (Some((order, entries)), _) => entries.assemble_as_found(file, order),
        (None, others) => Err(StructureError::Matrix {
            file: file.to_owned(),
            reason: format!(
                "no matrix {name}; found: {}",
                if others.is_empty() { "none".into() } else { others.join(", ") }
            ),
        }),
    }
}

/// The wanted matrix, and the names of the others.
type Found = (Option<(usize, Triplets)>, Vec<String>);

/// Header of a matrix.
struct Header {
    columns: usize,
    rows: usize,
    /// Strings of sparse columns have a header of two numbers.
    big: bool,
    name: String,
    /// Words per value: 1 in single, 2 in double precision.
    words: usize,
}

impl Header {
    fn new(numbers: [i64; 4], name: &str) -> Result<Self, String> {
        let [columns, rows, _form, kind] = numbers;
        let words = match kind {
            1 | 2 => kind as usize,
            3 | 4 => return Err("a complex matrix: expected a real one (type 1 or 2)".to_owned()),
            other => return Err(format!("type {other}: expected 1 or 2 (real)")),
        };
        let size = |value: i64| usize::try_from(value).ok().filter(|value| (1..u32::MAX as usize).contains(value));
        match (size(columns), size(rows.abs())) {
            (Some(columns), Some(count)) if columns == count => {
                Ok(Self { columns, rows: count, big: rows < 0, name: name.trim().to_owned(), words })
            }
            _ => Err(format!("expected a square matrix, found {} rows and {columns} columns", rows.abs())),
        }
    }

    /// Row (from 0) of a value of a column, if it is one.
    fn row(&self, first: i64, offset: usize) -> Option<u32> {
        let row = usize::try_from(first - 1).ok()? + offset;
        (row < self.rows).then_some(row as u32)
    }
}

fn text(mut lines: Lines, name: &str) -> Result<Found, StructureError> {
    let mut others = Vec::new();
    let mut found = None;
    let mut more = lines.advance_past(&[])?;
    while more {
        let header = text_header(&lines)?;
        let wanted = header.name.eq_ignore_ascii_case(name);
        let entries = text_columns(&mut lines, &header)?;
        if wanted {
            found = Some((header.rows, entries));
        } else {
            others.push(header.name);
        }
        more = lines.advance_past(&[])?;
    }
    Ok((found, others))
}

fn text_header(lines: &Lines) -> Result<Header, StructureError> {
    let text = &lines.text;
    let field = |index: usize| text.get(8 * index..(8 * index + 8).min(text.len()));
    let number = |index: usize| field(index).and_then(|text| text.trim().parse::<i64>().ok());
    match (number(0), number(1), number(2), number(3)) {
        (Some(columns), Some(rows), Some(form), Some(kind)) => {
            Header::new([columns, rows, form, kind], field(4).unwrap_or_default()).map_err(|reason| lines.fault(reason))
        }
        _ => {
            let reason =
                format!("expected the header of a matrix (columns, rows, form, type, name), found \"{}\"", text.trim());
            Err(lines.fault(reason))
        }
    }
}

/// Width of the values of a matrix: that of `1P,3E23.16` at the end of its header.
fn text_width(lines: &Lines) -> Result<usize, StructureError> {
    let format = lines.text.get(40..).unwrap_or_default().to_ascii_uppercase();
    let width = format.find(['E', 'D']).and_then(|at| format[at + 1..].split('.').next()?.trim().parse().ok());
    width.filter(|width| (1..=64).contains(width)).ok_or_else(|| {
        lines.fault(format!("expected a format as 1P,3E23.16 after the name, found \"{}\"", format.trim()))
    })
}

fn text_columns(lines: &mut Lines, header: &Header) -> Result<Triplets, StructureError> {
    let width = text_width(lines)?;
    let mut entries = Triplets::default();
    let mut values: Vec<f64> = Vec::new();
    // Column and first row of the values that follow.
    let (mut column, mut first) = (0, 0);
    loop {
        if !lines.advance_past(&[])? {
            let reason =
                format!("the file is cut short: column {} or the end of matrix {} expected", column + 1, header.name);
            return Err(lines.fault(reason));
        }
        if !lines.text.is_ascii() {
            return Err(lines.fault("expected plain characters"));
        }
        if lines.text.contains('.') {
            let mut rest = lines.text.as_str();
            while !rest.trim().is_empty() {
                let (value, after) = rest.split_at(width.min(rest.len()));
                let row = header
                    .row(first, values.len())
                    .ok_or_else(|| lines.fault("more values than the matrix has rows"))?;
                let value = lines.number_in(value)?;
                if column as usize > header.columns {
                    return Ok(entries);
                }
                values.push(value);
                entries.push(row, (column - 1) as u32, value);
                rest = after;
            }
            continue;
        }
        values.clear();
        let numbers: Option<Vec<i64>> = lines.text.split_whitespace().map(|word| word.parse().ok()).collect();
        match numbers.as_deref() {
            Some([next, row, _]) if *next > column || entries.rows.is_empty() || *next > 0 => {
                if *next < 1 || *next > header.columns as i64 + 1 {
                    return Err(lines.fault(format!("column {next}: expected 1 to {}", header.columns)));
                }
                (column, first) = (*next, *row);
            }
            Some([length, row]) if header.big && *length > 0 && column > 0 => first = *row,
            Some([packed]) if !header.big && column > 0 => first = packed % 65536,
            _ => {
                let reason = format!(
                    "expected a column (number, first row, words) or a string, found \"{}\"",
                    lines.text.trim()
                );
                return Err(lines.fault(reason));
            }
        }
    }
}

/// Fortran records of a binary file.
struct Records<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    number: usize,
    little: bool,
}

impl<'a> Records<'a> {
    /// Told by the mark of the first record: a header of 24 bytes.
    fn detect(file: &'a str, bytes: &'a [u8]) -> Option<Self> {
        let mark: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        let little = match (u32::from_le_bytes(mark), u32::from_be_bytes(mark)) {
            (24, _) => true,
            (_, 24) => false,
            _ => return None,
        };
        Some(Self { file, bytes, at: 0, number: 0, little })
    }

    fn fault(&self, reason: impl std::fmt::Display) -> StructureError {
        let reason = format!("record {}: {reason}", self.number);
        StructureError::Matrix { file: self.file.to_owned(), reason }
    }

    fn word(&self, bytes: &[u8]) -> Option<i64> {
        let bytes: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        Some(i64::from(if self.little { i32::from_le_bytes(bytes) } else { i32::from_be_bytes(bytes) }))
    }

    /// The next record, `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&'a [u8]>, StructureError> {
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        self.number += 1;
        let length = self.word(&self.bytes[self.at..]).and_then(|length| usize::try_from(length).ok());
        let body = length.and_then(|length| self.bytes.get(self.at + 4..)?.get(..length));
        let Some(body) = body else { return Err(self.fault("the file is cut short")) };
        let end = self.at + 4 + body.len();
        if self.bytes.get(end..).and_then(|mark| self.word(mark)) != Some(body.len() as i64) {
            return Err(self.fault("its two length marks differ: the file is cut short or damaged"));
        }
        self.at = end + 4;
        Ok(Some(body))
    }

    fn value(&self, bytes: &[u8], words: usize) -> Option<f64> {
        let value = if words == 1 {
            let bytes: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
            f64::from(if self.little { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) })
        } else {
            let bytes: [u8; 8] = bytes.get(..8)?.try_into().ok()?;
            if self.little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) }
        };
        value.is_finite().then_some(value)
    }
}

fn binary(mut records: Records, name: &str) -> Result<Found, StructureError> {
    let mut others = Vec::new();
    let mut found = None;
    while let Some(record) = records.next()? {
        let number = |index: usize| records.word(record.get(4 * index..).unwrap_or_default());
        let (Some(columns), Some(rows), Some(form), Some(kind), 24) =
            (number(0), number(1), number(2), number(3), record.len())
        else {
            return Err(records.fault("expected the header of a matrix, 24 bytes"));
        };
        let title = String::from_utf8_lossy(record.get(16..).unwrap_or_default()).into_owned();
        let header = Header::new([columns, rows, form, kind], &title).map_err(|reason| records.fault(reason))?;
        let entries = binary_columns(&mut records, &header)?;
        if header.name.eq_ignore_ascii_case(name) {
            found = Some((header.rows, entries));
        } else {
            others.push(header.name);
        }
    }
    Ok((found, others))
}

fn binary_columns(records: &mut Records, header: &Header) -> Result<Triplets, StructureError> {
    let mut entries = Triplets::default();
    loop {
        let Some(record) = records.next()? else {
            return Err(records.fault(format!("the file is cut short: matrix {} has no end", header.name)));
        };
        let number = |index: usize| records.word(record.get(4 * index..).unwrap_or_default());
        let (Some(column), Some(row), Some(_)) = (number(0), number(1), number(2)) else {
            return Err(records.fault("expected a column: number, first row, words"));
        };
        if column == header.columns as i64 + 1 {
            return Ok(entries);
        }
        if !(1..=header.columns as i64).contains(&column) {
            return Err(records.fault(format!("column {column}: expected 1 to {}", header.columns)));
        }
        let body = record.get(12..).unwrap_or_default();
        let mut string = |first: i64, values: &[u8]| -> Result<(), StructureError> {
            for (offset, bytes) in values.chunks(4 * header.words).enumerate() {
                let value =
                    records.value(bytes, header.words).ok_or_else(|| records.fault("expected finite numbers"))?;
                let row =
                    header.row(first, offset).ok_or_else(|| records.fault("more values than the matrix has rows"))?;
                entries.push(row, (column - 1) as u32, value);
            }
            Ok(())
        };
        if row > 0 {
            string(row, body)?;
            continue;
        }
        let mut rest = body;
        while !rest.is_empty() {
            let (first, length, skip) = string_head(records, header, rest)?;
            let values = rest.get(skip..skip + 4 * length).ok_or_else(|| records.fault("a string is cut short"))?;
            string(first, values)?;
            rest = &rest[skip + 4 * length..];
        }
    }
}

/// First row and words of values of a string, and the bytes of its head.
fn string_head(records: &Records, header: &Header, bytes: &[u8]) -> Result<(i64, usize, usize), StructureError> {
    let fault = || records.fault("a string is cut short");
    let word = records.word(bytes).ok_or_else(fault)?;
    let (first, length, skip) = if header.big {
        (records.word(&bytes[4..]).ok_or_else(fault)?, word - 1, 8)
    } else {
        (word % 65536, word / 65536 - 1, 4)
    };
    let length = usize::try_from(length).map_err(|_| fault())?;
    Ok((first, length, skip))
}

/// Writes a symmetric matrix as text, both triangles in dense columns, 17 digits.
pub(super) fn write_text(out: &mut dyn Write, name: &str, matrix: &CsMat<f64>) -> std::io::Result<()> {
    let order = matrix.rows();
    writeln!(out, "{order:>8}{order:>8}{:>8}{:>8}{name:<8}1P,3E23.16", 6, 2)?;
    for (column, first, values) in dense_columns(matrix) {
        writeln!(out, "{:>8}{:>8}{:>8}", column + 1, first + 1, values.len())?;
        for line in values.chunks(3) {
            let words: Vec<String> = line.iter().map(|value| fortran(*value)).collect();
            writeln!(out, "{}", words.concat())?;
        }
    }
    writeln!(out, "{:>8}{:>8}{:>8}\n{}", order + 1, 1, 1, fortran(1.0))
}

/// Writes a symmetric matrix as little-endian binary, both triangles in dense columns.
pub(super) fn write_binary(out: &mut dyn Write, name: &str, matrix: &CsMat<f64>) -> std::io::Result<()> {
    let order = matrix.rows() as i32;
    let words = |numbers: &[i32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let mut record = |body: Vec<u8>| -> std::io::Result<()> {
        let mark = (body.len() as u32).to_le_bytes();
        out.write_all(&mark)?;
        out.write_all(&body)?;
        out.write_all(&mark)
    };
    let mut header = words(&[order, order, 6, 2]);
    header.extend_from_slice(format!("{name:<8}").as_bytes());
    record(header)?;
    for (column, first, values) in dense_columns(matrix) {
        let mut body = words(&[column as i32 + 1, first as i32 + 1, 2 * values.len() as i32]);
        body.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        record(body)?;
    }
    let mut trailer = words(&[order + 1, 1, 2]);
    trailer.extend_from_slice(&1.0_f64.to_le_bytes());
    record(trailer)
}

/// Column, first row and the values from there to the last one that is not 0, of columns that have any.
fn dense_columns(matrix: &CsMat<f64>) -> impl Iterator<Item = (usize, usize, Vec<f64>)> + '_ {
    matrix.outer_iterator().enumerate().filter_map(|(column, view)| {
        let entries: Vec<(usize, f64)> =
            view.iter().filter(|(_, value)| **value != 0.0).map(|(r, v)| (r, *v)).collect();
        let (first, last) = (entries.first()?.0, entries.last()?.0);
        let mut values = vec![0.0; last - first + 1];
        for (row, value) in entries {
            values[row - first] = value;
        }
        Some((column, first, values))
    })
}

/// `%23.16E` with a two-digit exponent.
fn fortran(value: f64) -> String {
    let text = format!("{value:.16e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>23}", format!("{mantissa}E{sign}{:02}", exponent.abs()))
}
