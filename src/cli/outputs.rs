//! The study of a command, and its outputs: what a command reads, it does not overwrite.

use std::path::{Path, PathBuf};

use super::exit::Failure;
use super::inputs::{expect_ending, expect_study};
use super::text::tell;
use crate::engine::{Engine, Rows, checked};
use crate::study::{CheckedStudy, Study};

/// A file or folder that a command was asked to write.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output<'a> {
    /// What names it on the command line.
    pub flag: &'static str,
    /// Where; `None`: it was not asked for.
    pub path: Option<&'a PathBuf>,
    /// How the name of the file has to end; `None`: as it likes.
    pub ending: Option<&'static str>,
}

/// The study that a command line names. Each way to take it looks at the command line before it reads, reads before it
/// reduces, and tells what looks wrong: a command has one call to make and no order to keep.
#[derive(Debug, Clone, Copy)]
pub(super) struct StudyArguments<'a> {
    /// The study's file.
    pub file: &'a Path,
    /// Settings `path=value` over its own.
    pub overrides: &'a [String],
    /// What the command writes.
    pub outputs: &'a [Output<'a>],
}

impl StudyArguments<'_> {
    /// The study ready to run.
    ///
    /// # Errors
    /// As for [`Self::study`]; what [`Engine::new`] finds wrong.
    pub fn engine(&self) -> Result<Engine, Failure> {
        ready(self.study()?)
    }

    /// Another study in place of the file's, that of a dataset, with the same settings and outputs, ready to run.
    ///
    /// # Errors
    /// As for [`Self::engine`].
    pub fn engine_of(&self, study: Study) -> Result<Engine, Failure> {
        ready(self.set(study)?)
    }

    /// The study held to its machine, which is not reduced: rows to look at, not to run.
    ///
    /// # Errors
    /// As for [`Self::study`]; what is wrong with the files of its machine.
    pub fn checked(&self) -> Result<CheckedStudy, Failure> {
        let checked = checked(self.study()?)?;
        warn(&checked);
        Ok(checked)
    }

    /// The study by itself.
    ///
    /// # Errors
    /// A path that cannot be a study, a study with faults, outputs of another kind or that are a file which it reads.
    pub fn study(&self) -> Result<Study, Failure> {
        expect_study(self.file)?;
        self.set(Study::load(self.file)?)
    }

    fn set(&self, study: Study) -> Result<Study, Failure> {
        let study = study.with_overrides(self.overrides)?;
        refuse_inputs(&study.files(), self.outputs)?;
        Ok(study)
    }
}

/// A study made ready to run, with a word about what was not as expected.
fn ready(study: Study) -> Result<Engine, Failure> {
    let engine = Engine::new(study)?;
    engine.notes().for_each(|note| tell(&format_args!("note: {note}")));
    warn(engine.checked());
    Ok(engine)
}

/// Tells what looks wrong with a study; it is run nevertheless.
fn warn(study: &CheckedStudy) {
    study.warnings().iter().for_each(|warning| tell(&format_args!("warning: {warning}")));
}

/// Refuses outputs that are one of the inputs, by whatever path, or of another kind than their name says; a folder for outputs
/// must not hold an input.
pub(super) fn refuse_inputs(inputs: &[PathBuf], outputs: &[Output<'_>]) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    for output in outputs.iter().filter_map(|output| output.path) {
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
    outputs
        .iter()
        .try_for_each(|output| output.ending.map_or(Ok(()), |ending| expect_ending(output.flag, output.path, ending)))
}
