//! `decore design`: the rows of a design as a file, which a `table` design reads back.

use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::outputs::{Form, Output, StudyArguments};
use super::text::plural;
use super::written::Written;
use decore_dataset::{TableColumn, write_table};
use decore_study::engine::design_table;

#[derive(Debug, Args)]
pub(super) struct DesignArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// File to write: `.parquet` or `.csv`
    ///
    /// The table has the row number and a column `factor_NAME` for each factor.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    replace: bool,
    /// Set a value of the study, for example `design.rows=500`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn design(arguments: &DesignArguments) -> Result<Exit, Failure> {
    let file = &arguments.output;
    let outputs = [Output {
        flag: "--output",
        path: Some(file),
        form: Form::File { endings: &["parquet", "csv"], replace: arguments.replace },
    }];
    let study =
        StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs }.checked()?;
    let (info, columns) = design_table(&study);
    if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv")) {
        let failed = |source: std::io::Error| Failure::Write { path: file.display().to_string(), source };
        write_file(file, table_csv(&columns).map_err(failed)?)?;
    } else {
        write_table(file, &info, "design", &columns)?;
    }
    let mut written = Written::default();
    written.table("design", file, study.row_count())?;
    written.note("`kind = \"table\"` reads it back");
    let (rows, factors) = (plural(study.row_count(), "row"), plural(info.factors.len(), "factor"));
    let words = format_args!("wrote {}: {rows} of {factors}; `kind = \"table\"` reads it back", file.display());
    written.print(arguments.json, &words)?;
    Ok(Exit::Done)
}

/// Numbers in the shortest form that reads back the same.
fn table_csv(columns: &[TableColumn]) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.iter().map(|column| column.name.as_str()))?;
    for row in 0..columns.iter().map(|column| column.values.count).min().unwrap_or(0) {
        writer.write_record(columns.iter().map(|column| column.values.text(row)))?;
    }
    writer.into_inner().map_err(csv::IntoInnerError::into_error)
}
