//! `decore cores`: finds the dose at which cores are out from your tests, and predicts the time for the other rows.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::caller::Caller;
use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::json::print_result;
use super::outputs::{Form, Output, check_outputs};
use super::text::eprint_line;
use decore_dataset::{DatasetReader, table_batch, write_table};
use decore_lab::cores::{CoreSettings, solve};
use decore_statistics::lifetime::LifetimeLaw;

/// Name of the table of times.
const TABLE: &str = "core_times";

#[derive(Debug, Args)]
pub(super) struct CoresArguments {
    /// Folder of the dataset.
    dataset: PathBuf,
    /// CSV or Parquet file with a row per core and test: `row` (of the dataset) or the values of factors; `core` (CASTING.NAME) if there
    /// are several; `core_out_after_s`, empty if the core stayed in, and then `test_ended_after_s`.
    #[arg(long, value_name = "FILE")]
    tests: PathBuf,
    /// Law of the dose at which a core is out.
    #[arg(long, default_value = LifetimeLaw::default().name(), value_parser = law())]
    law: LifetimeLaw,
    /// Number of rows that are listed, the ones whose slowest core is out first.
    #[arg(long, default_value_t = 10, value_name = "ROWS")]
    best: usize,
    /// Write the times of all core points of all rows to this Parquet file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing table
    #[arg(long, requires = "output")]
    replace: bool,
    /// Print the result as JSON (schemas/cores.schema.json).
    #[arg(long)]
    json: bool,
}

/// Reads a law by its name.
fn law() -> impl TypedValueParser<Value = LifetimeLaw> {
    let named = |name: String| LifetimeLaw::ALL.into_iter().find(|law| law.name() == name).unwrap_or_default();
    PossibleValuesParser::new(LifetimeLaw::ALL.map(LifetimeLaw::name)).map(named)
}

pub(super) fn cores(arguments: &CoresArguments) -> Result<Exit, Failure> {
    expect_dataset(&arguments.dataset)?;
    let output = Output {
        flag: "--output",
        path: arguments.output.as_deref(),
        form: Form::File { endings: &["parquet"], replace: arguments.replace },
    };
    check_outputs(&[arguments.dataset.clone(), arguments.tests.clone()], &[output])?;
    let reader = DatasetReader::open(&arguments.dataset)?;
    let settings = CoreSettings { tests: arguments.tests.clone(), law: arguments.law, best: arguments.best };
    let (found, times) = solve(&reader, &settings)?;
    let info = &reader.manifest().study;
    if let Some(path) = &arguments.output {
        write_table(path, info, TABLE, &times.columns)?;
    }
    if let Some(caller) = Caller::current() {
        let table = table_batch(info, TABLE, &times.columns)?;
        caller.keep(|result| result.table = Some((TABLE, table)));
    }
    print_result(arguments.json, &found, || found.to_string())?;
    found.warnings.iter().for_each(|warning| eprint_line(&format_args!("warning: {warning}")));
    Ok(Exit::Done)
}
