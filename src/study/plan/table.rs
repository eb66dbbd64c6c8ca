//! Tables given by the user: a CSV or Parquet file with a column per factor, named like it or `factor_` and its name; or with columns of
//! any names.

use std::cell::RefCell;
use std::path::Path;

use super::factor::FactorInfo;
use super::parquet::ColumnPlace;
use super::{delimited, parquet};
use decore_quantity::words::{did_you_mean, identifier, nearest};
use decore_quantity::{Kind, Value};
use decore_statistics::design::{Distribution, Level};

/// A row of a file: where it is, for messages, and a cell per factor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableRow {
    /// Line or row, in words.
    pub place: String,
    /// The cells, as texts.
    pub cells: Vec<String>,
}

/// The column with the numbers of rows in files that decore writes.
const ROW: &str = "row";

/// Prefix of a factor's column in files that decore writes.
pub(super) const PREFIX: &str = "factor_";

/// Reads the factors' columns; columns of other names are left alone.
pub(super) fn read(file: &Path, factors: &[&FactorInfo]) -> Result<Vec<Vec<Level>>, String> {
    let name = file.display();
    let names: Vec<&str> = factors.iter().map(|factor| factor.name.as_str()).collect();
    let rows = factor_rows(file, &names)?;
    if !names.contains(&ROW) {
        check_numbers(file)?;
    }
    let levels = |row: TableRow| {
        let read = row.cells.iter().zip(factors).map(|(cell, factor)| {
            let told = |message| format!("{name}, {}, column `{}`: {message}", row.place, factor.name);
            parse(cell, factor).map_err(told)
        });
        read.collect::<Result<Vec<Level>, String>>()
    };
    rows.into_iter().map(levels).collect()
}

/// Rows are numbered in the order of the file: a column `row` with other numbers would not be theirs. Texts there are names.
fn check_numbers(file: &Path) -> Result<(), String> {
    let numbers = column_rows(file, &[ROW]).unwrap_or_default();
    let number = |row: &TableRow| row.cells.first().and_then(|cell| cell.parse::<f64>().ok());
    let wrong = numbers.iter().enumerate().find_map(|(expected, row)| {
        let found = number(row)?;
        (found != expected as f64).then_some((expected, found, row))
    });
    wrong.map_or(Ok(()), |(expected, found, row)| {
        Err(format!(
            "{}, {}, column `{ROW}`: it is {found}, but rows get the numbers 0, 1, ... in the order of the file, here {expected}: sort \
             the file, or rename the column to keep these numbers for yourself",
            file.display(),
            row.place
        ))
    })
}

/// Range of a factor's column: the ends of its numbers, or its values if they are texts or a single one. `integer`: values are whole
/// numbers.
pub(super) fn span(file: &Path, factor: &str, integer: bool) -> Result<CellSpan, String> {
    let column = factor_rows(file, &[factor])?;
    let texts = || column.iter().filter_map(|row| row.cells.first());
    let numbers: Option<Vec<f64>> =
        texts().map(|cell| cell.parse::<f64>().ok().filter(|number| number.is_finite())).collect();
    let Some(numbers) = numbers else {
        let mut values: Vec<Value> = Vec::new();
        for value in texts().cloned().map(Value::Text) {
            if !values.contains(&value) {
                values.push(value);
            }
        }
        return Ok(CellSpan::Values(values));
    };
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low < high {
        return Ok(CellSpan::Range([low, high]));
    }
    Ok(CellSpan::Values(vec![if integer { Value::Integer(low as i64) } else { Value::Real(low) }]))
}

/// Range of the cells of a column.
pub(super) enum CellSpan {
    Range([f64; 2]),
    Values(Vec<Value>),
}

/// The cells of these factors in a CSV or Parquet file, row by row; at least one row. Columns are named like the factor, or
/// `factor_` and its name.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn factor_rows(file: &Path, factors: &[&str]) -> Result<Vec<TableRow>, String> {
    rows(file, factors, &|factor, header| place(file, factor, header), false)
}

/// The cells of columns of these names in a CSV or Parquet file, row by row; at least one row.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn column_rows(file: &Path, columns: &[&str]) -> Result<Vec<TableRow>, String> {
    rows(file, columns, &|column, header| column_place(file, column, header), false)
}

/// As [`column_rows`]; cells may be empty, in Parquet files null.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn sparse_rows(file: &Path, columns: &[&str]) -> Result<Vec<TableRow>, String> {
    rows(file, columns, &|column, header| column_place(file, column, header), true)
}

/// Names of the columns of a CSV or Parquet file with a column `known`.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn column_names(file: &Path, known: &str) -> Result<Vec<String>, String> {
    let names = RefCell::new(Vec::new());
    // What separates cells is seen by the known column.
    let note = |column: &str, header: &[String]| {
        header.clone_into(&mut names.borrow_mut());
        column_place(file, column, header)
    };
    rows(file, &[known], &note, true)?;
    Ok(names.into_inner())
}

fn column_place(file: &Path, column: &str, header: &[String]) -> Result<usize, String> {
    header.iter().position(|name| name == column).ok_or_else(|| {
        let hint = did_you_mean(nearest(column, header.iter().map(String::as_str)));
        format!("{} has no column `{column}`; it has: {}{hint}", file.display(), header.join(", "))
    })
}

fn is_parquet(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"))
}

/// `sparse`: whether a Parquet file may have nulls.
fn rows(file: &Path, columns: &[&str], place: ColumnPlace<'_>, sparse: bool) -> Result<Vec<TableRow>, String> {
    let place: ColumnPlace<'_> = &|column, header| {
        let found = place(column, header)?;
        match header.iter().enumerate().position(|(other, name)| other != found && Some(name) == header.get(found)) {
            None => Ok(found),
            Some(other) => Err(format!(
                "{}: columns {} and {} both are `{column}`: rename the one that is not meant",
                file.display(),
                found.min(other) + 1,
                found.max(other) + 1
            )),
        }
    };
    let rows: Vec<TableRow> = if is_parquet(file) {
        let rows = parquet::read(file, columns, place, sparse)?.into_iter().enumerate();
        rows.map(|(row, cells)| TableRow { place: format!("row {row}"), cells }).collect()
    } else {
        let rows = delimited::read(file, columns, place)?.into_iter();
        rows.map(|(line, cells)| TableRow { place: format!("line {line}"), cells }).collect()
    };
    if rows.is_empty() {
        return Err(format!("{} has no rows", file.display()));
    }
    Ok(rows)
}

/// Finds a factor's column.
fn place(file: &Path, factor: &str, header: &[String]) -> Result<usize, String> {
    // Files that decore writes have underscores for all but letters and digits; datasets have a letter first besides.
    let safe = |name: &str| identifier(name, "n");
    let at = |wanted: &str| header.iter().position(|column| safe(column) == wanted);
    let own = header.iter().position(|column| column == factor);
    let written = at(&safe(&format!("{PREFIX}{factor}"))).or_else(|| at(&format!("{PREFIX}{}", safe(factor))));
    let file = file.display();
    match (own, written.filter(|_| !factor.starts_with(PREFIX) || own.is_none())) {
        (Some(place), None) | (None, Some(place)) => Ok(place),
        (Some(_), Some(_)) => Err(format!(
            "{file} has a column `{factor}` and a column `{PREFIX}{factor}`: rename the one that is not meant"
        )),
        (None, None) => {
            Err(format!("{file} has no column `{factor}` (or `{PREFIX}{factor}`); it has: {}", header.join(", ")))
        }
    }
}

fn parse(cell: &str, factor: &FactorInfo) -> Result<Level, String> {
    if factor.kind == Kind::Text || !factor.values.is_empty() {
        let same = |value: &Value| match value {
            Value::Text(text) => text == cell,
            number => cell.parse::<f64>().is_ok_and(|cell| number.number() == Some(cell)),
        };
        let place = factor.values.iter().position(same);
        return place.map(Level::Category).ok_or_else(|| format!("`{cell}` is none of {}", factor.domain()));
    }
    if let Some(&(Distribution::Integer { low, high } | Distribution::LogInteger { low, high })) = factor.distribution()
    {
        let number = cell.parse::<f64>().ok().filter(|number| number.fract() == 0.0);
        let number = number.filter(|number| (low as f64..=high as f64).contains(number));
        return number
            .map(|number| Level::Integer(number as i64))
            .ok_or_else(|| format!("`{cell}` is no whole number from {low} to {high}"));
    }
    let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
    let number = number.ok_or_else(|| format!("`{cell}` is no number"))?;
    let unbounded = matches!(factor.distribution(), Some(Distribution::Normal { .. }));
    match factor.distribution().and_then(Distribution::range).filter(|_| !unbounded) {
        Some((low, high)) if !(low..=high).contains(&number) => {
            Err(format!("{number} lies outside the factor's range, {low} to {high}"))
        }
        _ => Ok(Level::Real(number)),
    }
}
