//! `decore analyse`: which factors matter to a dataset's outputs.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::caller::Caller;
use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::json::print_result;
use super::more_rows::{Goal, Source, Wanted};
use super::outputs::{Form, Output, check_outputs};
use super::run::stop_on_interrupt;
use decore_dataset::{DatasetReader, table_batch, write_table};
use decore_lab::sensitivity::{SensitivitySettings, columns};
use decore_statistics::analysis::{Bootstrap, Estimator};

/// Replicates at most: more would only take time.
const MOST_REPLICATES: u64 = 1_000_000;

#[derive(Debug, Args)]
pub(super) struct AnalyseArguments {
    /// Folder of the dataset
    dataset: PathBuf,
    /// Columns of the table of runs
    ///
    /// By default: delivered work, work of the first impacts, hit frequency, largest casting velocity and air.
    #[arg(short, long = "output", num_args = 1.., value_name = "NAME")]
    outputs: Vec<String>,
    /// Estimator of Sobol' indices
    ///
    /// `salib` (the default) is SALib's estimator, `jansen` and `martinez` are those that OpenTURNS also has. This is an error if the
    /// design has no such indices.
    #[arg(long, value_parser = estimator())]
    estimator: Option<Estimator>,
    /// Use only the base points of a Saltelli design, as for any other rows
    ///
    /// This is an error for other designs.
    #[arg(long)]
    given: bool,
    /// Bootstrap replicates for the 95 % intervals, at least 20; 0: no intervals
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = replicates)]
    bootstrap: u64,
    /// Seed of the replicates
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Study file of the dataset, for --repair and --grow-until
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,
    /// Run failed rows again before the analysis
    ///
    /// Each row gets up to three retries, each with a 100 times tighter tolerance. Rows that ran out of steps or time need a larger budget
    /// (`--set solver.max_steps=...`).
    #[arg(long, requires = "study")]
    repair: bool,
    /// Add rows until no 95 % interval is wider than this
    ///
    /// The width is a share of the variance. For mu*, it is relative to the output's largest value. Base points or whole trajectories are
    /// added where the design has them.
    #[arg(long, requires = "study", value_name = "WIDTH", value_parser = width)]
    grow_until: Option<f64>,
    /// With --grow-until: maximum number of rows
    #[arg(long, requires = "grow_until", default_value_t = 100_000, value_name = "ROWS")]
    most_rows: u64,
    /// With --repair: set a budget, for example `solver.max_steps=1000000`; repeatable
    ///
    /// Settings that the dataset was made with stay set.
    #[arg(long = "set", requires = "repair", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Print the result as JSON (schemas/sensitivity.schema.json)
    #[arg(long)]
    json: bool,
    /// Also write the indices to this Parquet file
    #[arg(long, value_name = "FILE")]
    parquet: Option<PathBuf>,
    /// With --parquet: replace an existing file
    #[arg(long, requires = "parquet")]
    replace: bool,
}

/// Reads an estimator by its name.
fn estimator() -> impl TypedValueParser<Value = Estimator> {
    let named = |name: String| Estimator::ALL.into_iter().find(|one| one.name() == name).unwrap_or_default();
    PossibleValuesParser::new(Estimator::ALL.map(Estimator::name)).map(named)
}

/// Reads a number of replicates.
fn replicates(text: &str) -> Result<u64, String> {
    let least = Bootstrap::LEAST_REPLICATES as u64;
    let count = text.parse::<u64>().ok().filter(|count| *count == 0 || (least..=MOST_REPLICATES).contains(count));
    count.ok_or_else(|| format!("expected 0 (no intervals) or a whole number from {least} to {MOST_REPLICATES}"))
}

/// Reads the width of an interval.
fn width(text: &str) -> Result<f64, String> {
    let width = text.parse::<f64>().ok().filter(|width| *width > 0.0 && width.is_finite());
    width.ok_or_else(|| "expected a positive number, e.g. 0.1".to_owned())
}

pub(super) fn analyse(arguments: &AnalyseArguments) -> Result<Exit, Failure> {
    expect_dataset(&arguments.dataset)?;
    let parquet = Output {
        flag: "--parquet",
        path: arguments.parquet.as_deref(),
        form: Form::File { endings: &["parquet"], replace: arguments.replace },
    };
    check_outputs(std::slice::from_ref(&arguments.dataset), &[parquet])?;
    let bootstrap =
        Bootstrap { replicates: arguments.bootstrap as usize, seed: arguments.seed, level: Bootstrap::LEVEL };
    let (outputs, estimator) = (arguments.outputs.clone(), arguments.estimator);
    let settings = SensitivitySettings { outputs, estimator, given: arguments.given, bootstrap };
    decore_lab::sensitivity::check(&DatasetReader::open(&arguments.dataset)?, &settings)?;
    let exit = run_more(arguments, &settings, parquet)?;
    let reader = DatasetReader::open(&arguments.dataset)?;
    let found = decore_lab::sensitivity::analyse(&reader, &settings)?;
    let (name, info) = ("sensitivity", &reader.manifest().study);
    if let Some(path) = &arguments.parquet {
        write_table(path, info, name, &columns(&found))?;
    }
    if let Some(caller) = Caller::current() {
        let table = table_batch(info, name, &columns(&found))?;
        caller.keep(|result| result.table = Some((name, table)));
    }
    print_result(arguments.json, &found, || found.to_string())?;
    Ok(exit)
}

/// Runs the rows that are asked for before the analysis.
fn run_more(
    arguments: &AnalyseArguments,
    settings: &SensitivitySettings,
    parquet: Output<'_>,
) -> Result<Exit, Failure> {
    let Some(study) = &arguments.study else { return Ok(Exit::Done) };
    let source = Source { study, folder: &arguments.dataset, overrides: &arguments.overrides, outputs: &[parquet] };
    source.check()?;
    let goal = arguments.grow_until.map(|width| Goal { width, most_rows: arguments.most_rows });
    if !arguments.repair && goal.is_none() {
        return Ok(Exit::Done);
    }
    stop_on_interrupt();
    let analyse = || decore_lab::sensitivity::analyse(&DatasetReader::open(&arguments.dataset)?, settings);
    source.run(Wanted { repair: arguments.repair, goal, analyse: &analyse })
}
