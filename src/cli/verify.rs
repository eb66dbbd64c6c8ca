//! `decore verify`: reads all files of datasets and says whether they are whole.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::text::say;
use crate::dataset::{Verification, verify as verify_dataset};

#[derive(Debug, Args)]
pub(super) struct VerifyArguments {
    /// Folders of datasets.
    #[arg(required = true)]
    datasets: Vec<PathBuf>,
}

pub(super) fn verify(arguments: &VerifyArguments) -> Result<Exit, Failure> {
    let mut exit = Exit::Done;
    for folder in &arguments.datasets {
        expect_dataset(folder)?;
        let found = verify_dataset(folder)?;
        if !found.faults.is_empty() {
            exit = Exit::NotWhole;
        }
        say(&text(folder, &found))?;
    }
    Ok(exit)
}

fn text(folder: &Path, found: &Verification) -> String {
    let verdict = if found.faults.is_empty() { "whole" } else { "NOT WHOLE" };
    let study = &found.study;
    let mut text = format!(
        "{}: {verdict}\n  study `{}`, hash {}, seed {}, decore {}\n  {} of {} rows in {} parts ({} bytes)",
        folder.display(),
        study.study_name,
        study.study_hash,
        study.seed,
        study.program_version,
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
