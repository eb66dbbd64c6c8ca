//! Rows of a design given by the user: a CSV or Parquet file with a column per factor.

use std::fs::File;
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int32Type, Int64Type};
use arrow_array::{Array, ArrayRef};
use arrow_schema::DataType;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::factors::{FactorInfo, FactorKind};
use super::file::FactorValue;
use crate::design::{Distribution, Level};

/// Reads the factors' columns; columns of other names are left alone.
pub(super) fn read(file: &Path, factors: &[&FactorInfo]) -> Result<Vec<Vec<Level>>, String> {
    let name = file.display();
    let parquet = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"));
    let rows = if parquet { read_parquet(file, factors)? } else { read_csv(file, factors)? };
    if rows.is_empty() {
        return Err(format!("{name} has no rows"));
    }
    let level = |(row, cells): (usize, Vec<String>)| {
        let cells = cells.iter().zip(factors);
        let read = cells.map(|(cell, factor)| {
            parse(cell, factor).map_err(|message| {
                let place = if parquet { format!("row {row}") } else { format!("line {}", row + 2) };
                format!("{name}, {place}, column `{}`: {message}", factor.name)
            })
        });
        read.collect::<Result<Vec<Level>, String>>()
    };
    rows.into_iter().enumerate().map(level).collect()
}

fn read_csv(file: &Path, factors: &[&FactorInfo]) -> Result<Vec<Vec<String>>, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut lines = text.lines();
    let split =
        |line: &str| -> Vec<String> { line.split(',').map(|cell| cell.trim().trim_matches('"').to_string()).collect() };
    let header = split(lines.next().unwrap_or(""));
    let places = factors.iter().map(|factor| {
        let place = header.iter().position(|column| *column == factor.name);
        place.ok_or_else(|| missing(file, factor, &header))
    });
    let places = places.collect::<Result<Vec<usize>, String>>()?;
    let mut rows = Vec::new();
    for (index, line) in lines.enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let cells = split(line);
        if cells.len() != header.len() {
            let (found, expected) = (cells.len(), header.len());
            return Err(format!(
                "{}, line {}: {found} columns, expected {expected} as in the header",
                file.display(),
                index + 2
            ));
        }
        rows.push(places.iter().filter_map(|place| cells.get(*place).cloned()).collect());
    }
    Ok(rows)
}

fn missing(file: &Path, factor: &FactorInfo, header: &[String]) -> String {
    format!("{} has no column `{}`; it has: {}", file.display(), factor.name, header.join(", "))
}

fn read_parquet(file: &Path, factors: &[&FactorInfo]) -> Result<Vec<Vec<String>>, String> {
    let fault = |error: &dyn std::fmt::Display| format!("cannot read {}: {error}", file.display());
    let opened = File::open(file).map_err(|error| fault(&error))?;
    let reader = ParquetRecordBatchReaderBuilder::try_new(opened).and_then(|builder| builder.build());
    let mut rows: Vec<Vec<String>> = Vec::new();
    for batch in reader.map_err(|error| fault(&error))? {
        let batch = batch.map_err(|error| fault(&error))?;
        let header: Vec<String> = batch.schema().fields().iter().map(|field| field.name().clone()).collect();
        let column = |factor: &&FactorInfo| {
            batch.column_by_name(&factor.name).cloned().ok_or_else(|| missing(file, factor, &header))
        };
        let columns = factors.iter().map(column).collect::<Result<Vec<ArrayRef>, String>>()?;
        for row in 0..batch.num_rows() {
            let cells = columns.iter().zip(factors).map(|(column, factor)| {
                cell(column, row).ok_or_else(|| {
                    let kind = column.data_type();
                    format!("{}: column `{}` has no number or text in row {row} ({kind})", file.display(), factor.name)
                })
            });
            rows.push(cells.collect::<Result<Vec<String>, String>>()?);
        }
    }
    Ok(rows)
}

/// A cell as text; numbers in the shortest form that reads back the same.
fn cell(column: &ArrayRef, row: usize) -> Option<String> {
    if column.is_null(row) {
        return None;
    }
    match column.data_type() {
        DataType::Float64 => Some(column.as_primitive::<Float64Type>().value(row).to_string()),
        DataType::Float32 => Some(column.as_primitive::<Float32Type>().value(row).to_string()),
        DataType::Int64 => Some(column.as_primitive::<Int64Type>().value(row).to_string()),
        DataType::Int32 => Some(column.as_primitive::<Int32Type>().value(row).to_string()),
        DataType::Utf8 => Some(column.as_string::<i32>().value(row).to_string()),
        DataType::LargeUtf8 => Some(column.as_string::<i64>().value(row).to_string()),
        _ => None,
    }
}

fn parse(cell: &str, factor: &FactorInfo) -> Result<Level, String> {
    if factor.kind == FactorKind::Text || !factor.values.is_empty() {
        let same = |value: &FactorValue| match value {
            FactorValue::Text(text) => text == cell,
            FactorValue::Integer(number) => cell.parse::<f64>().is_ok_and(|cell| cell == *number as f64),
            FactorValue::Real(number) => cell.parse::<f64>().is_ok_and(|cell| cell == *number),
        };
        let place = factor.values.iter().position(same);
        return place.map(Level::Category).ok_or_else(|| format!("`{cell}` is none of {}", factor.domain()));
    }
    if let Some(Distribution::Integer { low, high }) = factor.distribution {
        let number = cell.parse::<f64>().ok().filter(|number| number.fract() == 0.0);
        let number = number.filter(|number| (low as f64..=high as f64).contains(number));
        return number
            .map(|number| Level::Integer(number as i64))
            .ok_or_else(|| format!("`{cell}` is no whole number from {low} to {high}"));
    }
    let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
    let number = number.ok_or_else(|| format!("`{cell}` is no number"))?;
    let unbounded = matches!(factor.distribution, Some(Distribution::Normal { .. }));
    match factor.distribution.as_ref().and_then(Distribution::range).filter(|_| !unbounded) {
        Some((low, high)) if !(low..=high).contains(&number) => {
            Err(format!("{number} lies outside the factor's range, {low} to {high}"))
        }
        _ => Ok(Level::Real(number)),
    }
}
