//! What commands that write files say of them: one shape for all.

use std::fmt::Display;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::exit::Failure;
use super::json::print_result;
use super::text::eprint_line;

/// What a command wrote, and what it says besides.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Written {
    /// Files written, the main one first.
    files: Vec<WrittenFile>,
    /// Jobs that were given to a scheduler, by its numbers, in the order in which they run.
    jobs: Vec<String>,
    /// What is good to know.
    notes: Vec<String>,
    /// What looks wrong; also on standard error.
    warnings: Vec<String>,
    /// Commands that go on from here, in their order.
    next: Vec<String>,
}

/// One file.
#[derive(Debug, Serialize, JsonSchema)]
struct WrittenFile {
    /// Where it is, as the command line names it.
    path: String,
    /// What it holds, e.g. `design`, `predictions`, `page`.
    kind: &'static str,
    /// Ending of its name, e.g. `parquet`, `csv`, `html`; null without one.
    format: Option<String>,
    /// Size in bytes.
    bytes: u64,
    /// Rows of a table, its header not counted; null where it is none.
    rows: Option<u64>,
}

impl Written {
    /// Adds a file that was written.
    ///
    /// # Errors
    /// [`Failure::Write`]: it is not there.
    pub fn file(&mut self, kind: &'static str, path: &Path) -> Result<(), Failure> {
        self.add(kind, path, None)
    }

    /// Adds a table that was written, with its number of rows.
    ///
    /// # Errors
    /// As [`Self::file`].
    pub fn table(&mut self, kind: &'static str, path: &Path, rows: usize) -> Result<(), Failure> {
        self.add(kind, path, Some(rows as u64))
    }

    fn add(&mut self, kind: &'static str, path: &Path, rows: Option<u64>) -> Result<(), Failure> {
        let shown = path.display().to_string();
        let bytes = match std::fs::metadata(path) {
            Ok(metadata) => metadata.len(),
            Err(source) => return Err(Failure::Write { path: shown, source }),
        };
        let format = path.extension().map(|ending| ending.to_string_lossy().into_owned());
        self.files.push(WrittenFile { path: shown, kind, format, bytes, rows });
        Ok(())
    }

    /// Adds what is good to know.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Adds what looks wrong; it is told when all is printed.
    pub fn warn(&mut self, warning: impl Into<String>) {
        self.warnings.push(warning.into());
    }

    /// Adds a job that was given to a scheduler.
    pub fn job(&mut self, number: impl Into<String>) {
        self.jobs.push(number.into());
    }

    /// Adds a command that goes on from here.
    pub fn next(&mut self, command: impl Into<String>) {
        self.next.push(command.into());
    }

    /// Prints all of it as JSON, or the words for people; tells the warnings.
    ///
    /// # Errors
    /// As [`say`].
    pub fn print(&self, json: bool, words: &dyn Display) -> Result<(), Failure> {
        print_result(json, self, || words.to_string())?;
        self.warnings.iter().for_each(|warning| eprint_line(&format_args!("warning: {warning}")));
        Ok(())
    }
}
