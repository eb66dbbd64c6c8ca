//! The study of a command, and its outputs: what a command reads, it does not overwrite.

use std::path::{Path, PathBuf};

use super::exit::Failure;
use super::inputs::expect_study;
use super::text::tell;
use crate::engine::Engine;
use crate::study::Study;

/// The study of a command with the settings `path=value` over its own; refuses what cannot be a study, and outputs that
/// are a file which it reads.
pub(super) fn load_study(study: &Path, overrides: &[String], outputs: &[Option<&PathBuf>]) -> Result<Study, Failure> {
    expect_study(study)?;
    let study = Study::load(study)?.with_overrides(overrides)?;
    refuse_inputs(&study.files(), outputs)?;
    Ok(study)
}

/// A study made ready to run, with a word about what was not as expected.
pub(super) fn ready(study: Study) -> Result<Engine, Failure> {
    let engine = Engine::new(study)?;
    engine.notes().for_each(|note| tell(&format_args!("note: {note}")));
    Ok(engine)
}

/// Refuses outputs that are one of the inputs, by whatever path; a folder for outputs must not hold one of them.
pub(super) fn refuse_inputs(inputs: &[PathBuf], outputs: &[Option<&PathBuf>]) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    for output in outputs.iter().copied().flatten() {
        // What is not there yet is no input.
        let Ok(place) = output.canonicalize() else { continue };
        let clash = inputs.iter().find(|input| **input == place || input.parent() == Some(&place));
        if let Some(input) = clash {
            return Err(Failure::Argument(format!(
                "the output {} would overwrite what the command reads ({}): give another name or folder",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}
