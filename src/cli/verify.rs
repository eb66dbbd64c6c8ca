//! `decore verify`: reads all files of datasets and checks that they are intact.

use std::path::{Path, PathBuf};

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::json::{print_json, wants_words};
use super::text::print_line;
use decore_dataset::{Verification, verify as verify_dataset};

#[derive(Debug, Args)]
pub(super) struct VerifyArguments {
    /// Folders of datasets
    #[arg(required = true)]
    datasets: Vec<PathBuf>,
    /// Print the findings as JSON (schemas/verification.schema.json)
    #[arg(long)]
    json: bool,
}

/// Result for a dataset.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Verified {
    /// Folder of the dataset.
    dataset: PathBuf,
    /// Whether no fault was found.
    whole: bool,
    /// Name of its study.
    study: String,
    /// Hash of its study.
    study_hash: String,
    /// Seed of its design.
    seed: u64,
    /// Version of the program that wrote it.
    program_version: String,
    /// Rows that it is to hold.
    rows: u64,
    /// Rows that are in whole parts.
    rows_done: u64,
    /// Rows that only the journal has.
    rows_in_journal: u64,
    /// Parts that were read.
    parts: u64,
    /// Their bytes.
    bytes: u64,
    /// Damaged, missing or foreign files, a sentence each.
    faults: Vec<String>,
}

pub(super) fn verify(arguments: &VerifyArguments) -> Result<Exit, Failure> {
    let mut all = Vec::with_capacity(arguments.datasets.len());
    for folder in &arguments.datasets {
        expect_dataset(folder)?;
        let found = Verified::of(folder, verify_dataset(folder)?);
        // Reading one takes a while: each is told when it was read.
        if wants_words(arguments.json) {
            print_line(&text(&found))?;
        }
        all.push(found);
    }
    if arguments.json {
        print_json(&all)?;
    }
    Ok(if all.iter().all(|found| found.whole) { Exit::Done } else { Exit::NotWhole })
}

impl Verified {
    fn of(folder: &Path, found: Verification) -> Self {
        Self {
            dataset: folder.to_owned(),
            whole: found.faults.is_empty(),
            study: found.study.study_name,
            study_hash: found.study.study_hash,
            seed: found.study.seed,
            program_version: found.study.program_version,
            rows: found.rows,
            rows_done: found.rows_done,
            rows_in_journal: found.rows_in_journal,
            parts: found.parts,
            bytes: found.bytes,
            faults: found.faults,
        }
    }
}

fn text(found: &Verified) -> String {
    let verdict = if found.whole { "whole" } else { "NOT WHOLE" };
    let mut text = format!(
        "{}: {verdict}\n  study `{}`, hash {}, seed {}, decore {}\n  {} of {} rows in {} parts ({} bytes)",
        found.dataset.display(),
        found.study,
        found.study_hash,
        found.seed,
        found.program_version,
        found.rows_done,
        found.rows,
        found.parts,
        found.bytes
    );
    if found.rows_in_journal > 0 {
        text += &format!(", {} more in the journal", found.rows_in_journal);
    }
    found.faults.iter().for_each(|fault| text += &format!("\n  {fault}"));
    text
}
