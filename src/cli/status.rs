//! `decore status`: how far sweeps are, from another terminal.

use std::path::{Path, PathBuf};

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::json::print_result;
use super::progress::clock;
use super::text::shell_word;
use decore_dataset::{DatasetReader, SweepState, SweepStatus};

#[derive(Debug, Args)]
pub(super) struct StatusArguments {
    /// Folders of datasets or shards
    #[arg(required = true)]
    datasets: Vec<PathBuf>,
    /// Print the status of each folder as JSON (schemas/status.schema.json)
    #[arg(long)]
    json: bool,
}

/// Progress of a sweep.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct DatasetStatus {
    /// Folder of the dataset.
    dataset: PathBuf,
    /// Contents of its `status.json`.
    status: SweepStatus,
    /// Damage found by names and lengths, a sentence each; not checked while the sweep runs.
    damage: Vec<String>,
}

pub(super) fn status(arguments: &StatusArguments) -> Result<Exit, Failure> {
    let mut found = Vec::with_capacity(arguments.datasets.len());
    for folder in &arguments.datasets {
        expect_dataset(folder)?;
        let status = SweepStatus::read(folder)?;
        // The parts of a sweep that runs change while they are looked at.
        let damage = match status.state {
            SweepState::Running => Vec::new(),
            _ => DatasetReader::open(folder)?.damage_at_a_glance().iter().map(ToString::to_string).collect(),
        };
        found.push(DatasetStatus { dataset: folder.clone(), status, damage });
    }
    print_result(arguments.json, &found, || words(&found))?;
    Ok(Exit::Done)
}

fn words(found: &[DatasetStatus]) -> String {
    let mut lines = Vec::new();
    for DatasetStatus { dataset: folder, status, damage } in found {
        lines.push(text(folder, status));
        lines.extend(damage.iter().map(|line| format!("  DAMAGED: {line}")));
        lines.push(format!("  the contents of the parts were not read: `decore verify {}` does", shell_word(folder)));
    }
    if found.len() > 1 {
        let sum = |count: fn(&SweepStatus) -> u64| found.iter().map(|one| count(&one.status)).sum::<u64>();
        let (done, rows, failed) = (sum(|s| s.rows_done), sum(|s| s.rows), sum(|s| s.rows_failed));
        lines.push(format!("together: {done} of {rows} rows, {failed} failed"));
    }
    lines.join("\n")
}

fn text(folder: &Path, status: &SweepStatus) -> String {
    let state = match status.state {
        SweepState::Running => format!("running (process {} on {})", status.process, status.host),
        SweepState::Complete => "complete".to_owned(),
        SweepState::Interrupted => "interrupted; the same command goes on".to_owned(),
        SweepState::StoppedAtOnce => {
            "stopped at once by a second interrupt: rows that ended are kept, those that ran are not; the same command goes on"
                .to_owned()
        }
        SweepState::TooManyFailed => "stopped, too many rows failed".to_owned(),
        SweepState::NotWritten => format!("stopped, results could not be written: {}", status.message),
        SweepState::Lost => {
            "not running: killed, or its machine went down; the same command goes on".to_owned()
        }
    };
    let percent = 100.0 * status.rows_done as f64 / status.rows.max(1) as f64;
    let mut text = format!(
        "{}: {state}\n  {} of {} rows ({percent:.1} %), {} failed",
        folder.display(),
        status.rows_done,
        status.rows,
        status.rows_failed
    );
    if status.rows_per_s > 0.0 {
        text += &format!(", {:.4} rows/s", status.rows_per_s);
    }
    if let (SweepState::Running, Some(left)) = (status.state, status.seconds_left) {
        text += &format!(", {} left", clock(left));
        let age = SweepStatus::now_unix_s().saturating_sub(status.updated_unix_s);
        text += &format!(" (as of {age} s ago)");
    }
    for error in &status.last_errors {
        text += &format!("\n  row {}: {}: {}", error.row, error.status, error.reason);
    }
    text
}
