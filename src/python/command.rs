//! Commands of the command line for Python, with the same names and defaults.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;

use super::error::Raise;
use super::study::listener;
use super::sweep::{Counts, watched};
use super::table::Table;
use crate::cli::caller::{Called, Caller, Listener};

/// An argument of a command: name, option, kind, default, whether it is required, help.
type Argument = (String, Option<String>, &'static str, Option<String>, bool, String);
/// Exit code, JSON, text, notes, dataset and table of a command.
type Result = (i32, String, String, Vec<String>, Option<PathBuf>, Option<Table>);

/// The commands that have a result: name, help, arguments.
#[pyfunction]
#[pyo3(name = "_commands")]
pub fn commands() -> Vec<(String, String, Vec<Argument>)> {
    let argument =
        |one: crate::cli::caller::Argument| (one.name, one.option, one.kind, one.default, one.required, one.help);
    let commands = crate::cli::caller::commands().into_iter();
    commands.map(|(name, help, own)| (name, help, own.into_iter().map(argument).collect())).collect()
}

/// Calls a command by the words of its command line. `progress`: as for `Study.run`.
///
/// # Errors
/// The command's errors; after an interrupt rows that ended are kept.
#[pyfunction]
#[pyo3(name = "_call", signature = (words, progress=None))]
pub fn call(py: Python<'_>, words: Vec<OsString>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Result> {
    let told = listener(py, progress)?;
    let called = watched(py, told, move |stop, counts: &Arc<Counts>| {
        let counts = Arc::clone(counts);
        let hear: Listener = Arc::new(move |event| counts.hear(event));
        Caller::new(Arc::clone(stop), hear).call(&words)
    })?;
    let Called { exit, json, text, notes, dataset, table } = called.map_err(|failure| failure.raise(py))?;
    let table = table.map(|(name, batch)| Table::new(name, batch));
    Ok((exit, json, text.trim_end().to_owned(), notes, dataset, table))
}
