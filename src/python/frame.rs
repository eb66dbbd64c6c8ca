//! Values by factor names: mappings, frames of pandas, polars and Arrow, rows, structured arrays.

use std::collections::HashSet;

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use decore_quantity::words::{did_you_mean, nearest};

/// Prefix of a factor's column in tables.
const PREFIX: &str = "factor_";
/// Column of tables that is not a factor and no mistake.
const ROW: &str = "row";

/// Values of `names`, in their order, from an object with columns or keys; `None` for numbers without names.
///
/// # Errors
/// `KeyError` that names all columns that are unknown, missing or there twice.
pub fn columns<'py>(given: &Bound<'py, PyAny>, names: &[String]) -> PyResult<Option<Vec<Bound<'py, PyAny>>>> {
    let found = given.py().import("decore._frames")?.call_method1("columns", (given,))?;
    let Some(found) = found.extract::<Option<Vec<(String, Bound<'py, PyAny>)>>>()? else { return Ok(None) };
    let columns: Vec<(&str, &Bound<'py, PyAny>)> = found.iter().map(|(name, values)| (factor(name), values)).collect();
    let mut known = HashSet::new();
    let twice = quoted(columns.iter().map(|(name, _)| *name).filter(|name| !known.insert(*name)));
    let unknown =
        columns.iter().map(|(name, _)| *name).filter(|name| *name != ROW && !names.iter().any(|one| one == name));
    let unknown: Vec<&str> = unknown.collect();
    let missing = quoted(names.iter().map(String::as_str).filter(|name| !known.contains(name)));
    let mut faults = Vec::new();
    if let Some(first) = unknown.first() {
        let hint = did_you_mean(nearest(first, names.iter().map(String::as_str)));
        faults.push(format!("unknown: {}{hint}", quoted(unknown.iter().copied())));
    }
    faults.extend(Some(missing).filter(|names| !names.is_empty()).map(|names| format!("missing: {names}")));
    faults.extend(Some(twice).filter(|names| !names.is_empty()).map(|names| format!("given twice: {names}")));
    if faults.is_empty() {
        let own =
            |name: &String| columns.iter().find(|(column, _)| column == name).map(|(_, values)| (*values).clone());
        return Ok(Some(names.iter().filter_map(own).collect()));
    }
    let expected = quoted(names.iter().map(String::as_str));
    Err(PyKeyError::new_err(format!("columns {}; expected the factors {expected}", faults.join("; "))))
}

/// The factor that a column is of.
pub fn factor(column: &str) -> &str {
    column.strip_prefix(PREFIX).unwrap_or(column)
}

fn quoted<'n>(names: impl Iterator<Item = &'n str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}
