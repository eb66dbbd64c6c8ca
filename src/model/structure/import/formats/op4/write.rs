//! Writing OUTPUT4: symmetric matrices, both triangles, sparse columns in strings (BIGMAT).

use std::io::Write;

use sprs::CsMat;

use crate::structure::import::entry::Named;

/// Values of consecutive rows of a column: the first row (from 0) and where the values are.
type Strings = Vec<(usize, Vec<f64>)>;

/// All columns that hold a value, each with its strings.
fn columns(matrix: &CsMat<f64>) -> impl Iterator<Item = (usize, Strings)> + '_ {
    matrix.outer_iterator().enumerate().filter_map(|(column, view)| {
        let mut strings: Strings = Vec::new();
        for (row, value) in view.iter().filter(|(_, value)| **value != 0.0) {
            match strings.last_mut() {
                Some((first, values)) if *first + values.len() == row => values.push(*value),
                _ => strings.push((row, vec![*value])),
            }
        }
        (!strings.is_empty()).then_some((column, strings))
    })
}

/// Words of a column: two per value and two per head of a string.
fn words(strings: &Strings) -> usize {
    strings.iter().map(|(_, values)| 2 * values.len() + 2).sum()
}

/// Writes a symmetric matrix as text, 17 digits.
pub(super) fn write_text(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    let Named { name, matrix, .. } = *named;
    let order = matrix.rows();
    writeln!(out, "{order:>8}{:>8}{:>8}{:>8}{name:<8}1P,3E23.16", -(order as i64), 6, 2)?;
    for (column, strings) in columns(matrix) {
        writeln!(out, "{:>8}{:>8}{:>8}", column + 1, 0, words(&strings))?;
        for (first, values) in strings {
            writeln!(out, "{:>8}{:>8}", 2 * values.len() + 1, first + 1)?;
            for line in values.chunks(3) {
                line.iter().try_for_each(|value| write_value(out, *value))?;
                writeln!(out)?;
            }
        }
    }
    writeln!(out, "{:>8}{:>8}{:>8}", order + 1, 1, 1)?;
    write_value(out, 1.0)?;
    writeln!(out)
}

/// `%23.16E`; an exponent of three digits replaces its letter, as Fortran does.
fn write_value(out: &mut dyn Write, value: f64) -> std::io::Result<()> {
    let text = format!("{value:.16e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    let blanks = 19 - mantissa.len().min(19);
    match exponent.abs() {
        size @ 100.. => write!(out, "{:blanks$}{mantissa}{sign}{size}", ""),
        size => write!(out, "{:blanks$}{mantissa}E{sign}{size:02}", ""),
    }
}

/// Writes a symmetric matrix as little-endian binary.
pub(super) fn write_binary(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    let Named { name, matrix, .. } = *named;
    let order = matrix.rows() as i32;
    let mut body: Vec<u8> = Vec::new();
    put(&mut body, &[order, -order, 6, 2]);
    body.extend_from_slice(format!("{name:<8}").as_bytes());
    record(out, &mut body)?;
    for (column, strings) in columns(matrix) {
        put(&mut body, &[column as i32 + 1, 0, words(&strings) as i32]);
        for (first, values) in strings {
            put(&mut body, &[2 * values.len() as i32 + 1, first as i32 + 1]);
            body.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        record(out, &mut body)?;
    }
    put(&mut body, &[order + 1, 1, 2]);
    body.extend_from_slice(&1.0_f64.to_le_bytes());
    record(out, &mut body)
}

fn put(body: &mut Vec<u8>, numbers: &[i32]) {
    body.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

/// Writes a record between its marks and empties it.
fn record(out: &mut dyn Write, body: &mut Vec<u8>) -> std::io::Result<()> {
    let mark = (body.len() as u32).to_le_bytes();
    out.write_all(&mark)?;
    out.write_all(body)?;
    out.write_all(&mark)?;
    body.clear();
    Ok(())
}
