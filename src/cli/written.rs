//! Output of commands that write files, in one form.

use std::fmt::Display;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::exit::Failure;
use super::json::print_result;
use super::text::eprint_line;

/// Files that a command wrote, with notes, warnings and next steps.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Written {
    /// Files written, the main one first.
    files: Vec<WrittenFile>,
    /// Jobs that were given to a scheduler, by its numbers, in the order in which they run.
    jobs: Vec<String>,
    /// Notes.
    notes: Vec<String>,
    /// Warnings; also on standard error.
    warnings: Vec<String>,
    /// Commands that go on from here, in their order.
    next: Vec<String>,
}

/// One file.
#[derive(Debug, Serialize, JsonSchema)]
struct WrittenFile {
    /// Path, as on the command line.
    path: String,
    /// Content, e.g. `design`, `predictions`, `page`.
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

    /// Adds a note.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Adds a warning, which is printed at the end.
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

    /// Prints all of it as JSON, or `words` for people, then the warnings.
    ///
    /// # Errors
    /// As [`print_result`].
    pub fn print(&self, json: bool, words: &dyn Display) -> Result<(), Failure> {
        print_result(json, self, || words.to_string())?;
        self.warnings.iter().for_each(|warning| eprint_line(&format_args!("warning: {warning}")));
        Ok(())
    }
}
