//! `decore design`: the rows of a design as a file, which a `table` design reads back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::{Exit, Failure};
use super::outputs::{Output, StudyArguments};
use super::text::{plural, say};
use crate::dataset::{DatasetInfo, Factor, RowRecord, TableColumn, TableValues, write_table};
use crate::engine::dataset_info;
use crate::quantity::{Kind, Value};
use crate::study::CheckedStudy;

#[derive(Debug, Args)]
pub(super) struct DesignArguments {
    /// Study file (TOML).
    study: PathBuf,
    /// File to write, Parquet or CSV by its extension: the row's index and a column `factor_NAME` per factor.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Set a value of the study, e.g. `design.rows=500`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
}

pub(super) fn design(arguments: &DesignArguments) -> Result<Exit, Failure> {
    let file = &arguments.output;
    let is = |name: &str| file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(name));
    if !is("parquet") && !is("csv") {
        let message = format!("--output {}: expected a file that ends in .parquet or .csv", file.display());
        return Err(Failure::Argument(message));
    }
    let outputs = [Output { flag: "--output", path: Some(file), ending: None }];
    let study =
        StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs }.checked()?;
    let info = dataset_info(&study, BTreeMap::new(), BTreeMap::new());
    let columns = columns(&study, &info);
    if is("csv") {
        let failed = |source: std::io::Error| Failure::Write { path: file.display().to_string(), source };
        write_csv(file, &columns).map_err(|error| failed(error.into()))?;
    } else {
        write_table(file, &info, "design", &columns)?;
    }
    let (rows, factors) = (plural(study.row_count(), "row"), plural(info.factors.len(), "factor"));
    say(&format_args!("wrote {}: {rows} of {factors}; `kind = \"table\"` reads it back", file.display()))?;
    Ok(Exit::Done)
}

/// The index of the row, then the factors, derived ones included.
fn columns(study: &CheckedStudy, info: &DatasetInfo) -> Vec<TableColumn> {
    let rows: Vec<Vec<Value>> = (0..study.row_count()).map(|row| study.row_values(row)).collect();
    let index = TableColumn {
        name: RowRecord::row.name.to_owned(),
        unit: RowRecord::row.unit.to_owned(),
        description: RowRecord::row.description(),
        values: TableValues::Integer((0..rows.len() as i64).collect()),
    };
    let factor = |(place, factor): (usize, &Factor)| {
        let cells = || rows.iter().filter_map(move |row| row.get(place));
        let number = |value: &Value| value.number().unwrap_or(f64::NAN);
        let whole = |value: &Value| match value {
            Value::Integer(value) => Some(*value),
            _ => None,
        };
        TableColumn {
            name: format!("factor_{}", factor.name),
            unit: factor.unit.clone(),
            description: factor.description.clone(),
            values: match factor.kind {
                Kind::Real | Kind::Count => TableValues::Real(cells().map(number).collect()),
                Kind::Integer => TableValues::Integer(cells().filter_map(whole).collect()),
                Kind::Text | Kind::Category => TableValues::Text(cells().map(ToString::to_string).collect()),
            },
        }
    };
    [index].into_iter().chain(info.factors.iter().enumerate().map(factor)).collect()
}

/// Numbers in the shortest form that reads back the same.
fn write_csv(file: &Path, columns: &[TableColumn]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_path(file)?;
    writer.write_record(columns.iter().map(|column| column.name.as_str()))?;
    let cell = |values: &TableValues, row: usize| match values {
        TableValues::Real(values) => values.get(row).map(ToString::to_string),
        TableValues::Integer(values) => values.get(row).map(ToString::to_string),
        TableValues::Text(values) => values.get(row).cloned(),
    };
    let mut row = 0;
    while let Some(cells) = columns.iter().map(|column| cell(&column.values, row)).collect::<Option<Vec<String>>>() {
        writer.write_record(cells)?;
        row += 1;
    }
    Ok(writer.flush()?)
}
