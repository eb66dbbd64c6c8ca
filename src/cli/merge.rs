//! `decore merge`: shards into one dataset.

use std::path::PathBuf;

use clap::Args;

use super::caller::Caller;
use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::json::print_result;
use super::outputs::{Form, Output, check_outputs};
use super::text::eprint_line;
use decore_dataset::{DatasetReader, Existing};
use decore_lab::report::{ReportSettings, summarise};

#[derive(Debug, Args)]
pub(super) struct MergeArguments {
    /// Folders of all shards of one sweep
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Folder for the combined dataset
    #[arg(short, long)]
    output: PathBuf,
    /// Replace a dataset that is already in the folder
    #[arg(long)]
    replace: bool,
    /// Print the summary as JSON (schemas/report.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn merge(arguments: &MergeArguments) -> Result<Exit, Failure> {
    let existing = if arguments.replace { Existing::Replace } else { Existing::Resume };
    arguments.shards.iter().try_for_each(|shard| expect_dataset(shard))?;
    let output = Output { flag: "--output", path: Some(&arguments.output), form: Form::Dataset };
    // That no shard is the output is the merge's own to say.
    check_outputs(&[], &[output])?;
    let merged = decore_dataset::merge(&arguments.shards, &arguments.output, existing)?;
    merged.notes.iter().for_each(|note| eprint_line(note));
    let summary = summarise(&DatasetReader::open(&arguments.output)?, &ReportSettings::default())?;
    Caller::wrote(&arguments.output);
    print_result(arguments.json, &summary, || summary.to_string())?;
    Ok(if merged.manifest.rows_failed() == 0 { Exit::Done } else { Exit::RowsFailed })
}
