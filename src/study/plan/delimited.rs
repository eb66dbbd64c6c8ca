//! Columns of a text table: cells between commas, semicolons or tabs.

use std::path::Path;

use super::parquet::ColumnPlace;
use decore_files::Limit;

/// Possible separators of cells, the usual one first.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// The cells of these columns, row by row, each with its line. Between semicolons and tabs a comma in a number stands for the decimal
/// point, if no number of the columns has a point itself: then it might as well part thousands, as it might where all have three
/// digits behind it, which is refused.
///
/// # Errors
/// What is wrong with the file, in words.
pub(super) fn read(file: &Path, columns: &[&str], place: ColumnPlace<'_>) -> Result<Vec<(u64, Vec<String>)>, String> {
    let told = |reason: &dyn std::fmt::Display| format!("cannot read {}: {reason}", file.display());
    let fault = |error: csv::Error| told(&error);
    let bytes = decore_files::read(file, Limit::ROWS).map_err(|error| told(&error))?;
    let text = text(&bytes).map_err(|reason| told(&reason))?;
    let separator = separator(text, columns, place);
    let header = header(text, separator).map_err(fault)?;
    let places = columns.iter().map(|column| place(column, &header)).collect::<Result<Vec<usize>, String>>()?;
    let row = |record: Result<csv::StringRecord, csv::Error>| {
        let record = record.map_err(fault)?;
        let line = record.position().map_or(0, csv::Position::line);
        Ok((line, places.iter().filter_map(|place| record.get(*place)).map(str::to_string).collect()))
    };
    let mut rows: Vec<(u64, Vec<String>)> =
        reader(text, separator).records().map(row).collect::<Result<_, String>>()?;
    let mut cells = rows.iter().flat_map(|(_, cells)| cells);
    if separator != b',' && !cells.any(|cell| cell.contains('.') && is_number(cell)) {
        let is_comma = |cell: &&mut String| cell.contains(',') && is_number(&cell.replacen(',', ".", 1));
        let commas: Vec<&mut String> = rows.iter_mut().flat_map(|(_, cells)| cells).filter(is_comma).collect();
        if let (Some(first), true) = (commas.first(), commas.iter().all(|cell| may_part_thousands(cell))) {
            return Err(told(&format_args!(
                "is {first} a thousand or a decimal comma? All commas in the columns that are read have three digits behind them: write \
                 the numbers with decimal points, or without commas"
            )));
        }
        commas.into_iter().for_each(|cell| *cell = cell.replacen(',', ".", 1));
    }
    Ok(rows)
}

/// The text of a file, without the byte order mark that some programs begin with.
fn text(bytes: &[u8]) -> Result<&str, String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("it is text in UTF-16: save it as UTF-8".to_owned());
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
        format!("line {line}: not text in UTF-8 (Latin-1 or Windows-1252?): save it as UTF-8")
    })?;
    Ok(text.trim_start_matches('\u{feff}'))
}

/// Whether a number with a comma may be a whole one: `1,250`, but not `0,250` or `1,25`.
fn may_part_thousands(cell: &str) -> bool {
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let parts = cell.trim_start_matches(['+', '-']).split_once(',');
    parts.is_some_and(|(whole, rest)| {
        (1..=3).contains(&whole.len()) && !whole.starts_with('0') && rest.len() == 3 && digits(whole) && digits(rest)
    })
}

fn is_number(cell: &str) -> bool {
    cell.parse::<f64>().is_ok()
}

fn reader(text: &str, separator: u8) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new().trim(csv::Trim::All).delimiter(separator).from_reader(text.as_bytes())
}

fn header(text: &str, separator: u8) -> Result<Vec<String>, csv::Error> {
    Ok(reader(text, separator).headers()?.iter().map(str::to_string).collect())
}

/// Finds the separator of the cells: the first one that gives all columns, else the one with most columns in the header.
fn separator(text: &str, columns: &[&str], place: ColumnPlace<'_>) -> u8 {
    let header = |separator: u8| header(text, separator).unwrap_or_default();
    let finds_all = |separator: &u8| {
        let header = header(*separator);
        columns.iter().all(|column| place(column, &header).is_ok())
    };
    let most = || SEPARATORS.into_iter().rev().max_by_key(|separator| header(*separator).len());
    SEPARATORS.into_iter().find(finds_all).or_else(most).unwrap_or(b',')
}
