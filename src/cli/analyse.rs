//! `decore analyse`: which factors matter to a dataset's outputs.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::exit::{Exit, Failure};
use super::inputs::{expect_dataset, expect_ending};
use super::text::{fit, say, terminal_columns};
use crate::analysis::{Bootstrap, Estimator};
use crate::dataset::{DatasetReader, write_table};
use crate::sensitivity::{Sensitivity, SensitivitySettings, columns};

/// Replicates at most: more would only take time.
const MOST_REPLICATES: u64 = 1_000_000;

#[derive(Debug, Args)]
pub(super) struct AnalyseArguments {
    /// Folder of the dataset.
    dataset: PathBuf,
    /// Columns of the table of runs. Default: delivered work, work of the first impacts, hit frequency, largest velocity of
    /// the castings, air.
    #[arg(short, long = "output", num_args = 1.., value_name = "NAME")]
    outputs: Vec<String>,
    /// Estimator of Sobol' indices: `salib` as SALib, `jansen` and `martinez` as OpenTURNS.
    #[arg(long, default_value = Estimator::default().name(), value_parser = estimator())]
    estimator: Estimator,
    /// Bootstrap replicates for the 95 % intervals; 0: none.
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u64).range(..=MOST_REPLICATES))]
    bootstrap: u64,
    /// Seed of the replicates.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print the result as JSON (schemas/sensitivity.schema.json).
    #[arg(long)]
    json: bool,
    /// Also write the indices to this Parquet file, a row per output and index.
    #[arg(long, value_name = "FILE")]
    parquet: Option<PathBuf>,
}

/// Reads an estimator by its name.
fn estimator() -> impl TypedValueParser<Value = Estimator> {
    let named = |name: String| Estimator::ALL.into_iter().find(|one| one.name() == name).unwrap_or_default();
    PossibleValuesParser::new(Estimator::ALL.map(Estimator::name)).map(named)
}

pub(super) fn analyse(arguments: &AnalyseArguments) -> Result<Exit, Failure> {
    expect_dataset(&arguments.dataset)?;
    expect_ending("--parquet", arguments.parquet.as_ref(), "parquet")?;
    let reader = DatasetReader::open(&arguments.dataset)?;
    let bootstrap =
        Bootstrap { replicates: arguments.bootstrap as usize, seed: arguments.seed, level: Bootstrap::LEVEL };
    let settings =
        SensitivitySettings { outputs: arguments.outputs.clone(), estimator: arguments.estimator, bootstrap };
    let found = crate::sensitivity::analyse(&reader, &settings)?;
    if let Some(path) = &arguments.parquet {
        write_table(path, &reader.manifest().study, ("sensitivity", &columns(&found)))?;
    }
    say(&if arguments.json { json(&found) } else { readable(&found) })?;
    Ok(Exit::Done)
}

fn json(found: &Sensitivity) -> String {
    format!("{:#}", serde_json::json!(found))
}

fn readable(found: &Sensitivity) -> String {
    let text = found.to_string();
    let text = terminal_columns().map_or_else(|| text.clone(), |columns| fit(&text, columns));
    text.trim_end().to_owned()
}
