//! Conversion between Python values and values of a study.

use std::collections::HashSet;
use std::path::PathBuf;

use pyo3::Borrowed;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping, PyString, PyTuple};

use decore_quantity::Value;

/// Lists and tables within each other at most: no key of a study has as many, and a list that holds itself has no end.
const MOST_NESTED: usize = 16;

/// A path of a file or folder, as Python's own `open` takes it.
pub struct FilePath(pub PathBuf);

impl<'py> FromPyObject<'_, 'py> for FilePath {
    type Error = PyErr;

    fn extract(from: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let text = from.py().import("os")?.call_method1("fsdecode", (from,))?;
        Ok(Self(text.extract()?))
    }
}

/// Whether a value is true; `None` if it is not a truth value (Python's or NumPy's).
pub fn truth(from: &Bound<'_, PyAny>) -> Option<bool> {
    from.extract().ok()
}

/// A name that stands twice.
pub fn repeated<'n>(names: impl IntoIterator<Item = &'n String>) -> Option<&'n String> {
    let mut known = HashSet::new();
    names.into_iter().find(|name| !known.insert(*name))
}

/// A number or a text, numpy's included.
pub fn value(from: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(text) = from.cast::<PyString>() {
        return Ok(Value::Text(text.to_str()?.to_owned()));
    }
    if truth(from).is_none() {
        if let Ok(whole) = from.extract::<i64>() {
            return Ok(Value::Integer(whole));
        }
        if let Ok(real) = from.extract::<f64>() {
            return Ok(Value::Real(real));
        }
    }
    Err(PyTypeError::new_err(format!("expected a number or a text, found {}", from.repr()?)))
}

/// Values by the names of factors.
pub fn given(from: &Bound<'_, PyMapping>) -> PyResult<Vec<(String, Value)>> {
    entries(from)?.into_iter().map(|(name, given)| Ok((name, value(&given)?))).collect()
}

/// The settings `path=value` of a mapping: as `--set` takes them.
pub fn settings(from: &Bound<'_, PyMapping>) -> PyResult<Vec<String>> {
    let setting = |(path, value): (String, Bound<'_, PyAny>)| {
        // A text alone needs no quotes, and stands in a dataset as the command line puts it there.
        let text = match value.cast::<PyString>() {
            Ok(text) => text.to_str()?.to_owned(),
            Err(_) => toml(&value, &path, 0)?,
        };
        Ok(format!("{path}={text}"))
    };
    entries(from)?.into_iter().map(setting).collect()
}

/// Names and their values.
pub fn entries<'py>(from: &Bound<'py, PyMapping>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    from.items()?.iter().map(|item| item.extract::<(String, Bound<'py, PyAny>)>()).collect()
}

/// The value of a setting as TOML writes it. `path`: the setting's, for errors; `depth`: lists and tables around the value.
fn toml(from: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<String> {
    if depth > MOST_NESTED {
        return Err(PyValueError::new_err(format!(
            "`{path}`: lists and tables are nested more than {MOST_NESTED} deep, or one contains itself; no key of a \
             study permits this: give the value as in the study file"
        )));
    }
    if let Some(truth) = truth(from) {
        return Ok(truth.to_string());
    }
    if from.is_instance_of::<PyList>() || from.is_instance_of::<PyTuple>() {
        let parts: Vec<String> = from.try_iter()?.map(|part| toml(&part?, path, depth + 1)).collect::<PyResult<_>>()?;
        return Ok(format!("[{}]", parts.join(", ")));
    }
    if let Ok(table) = from.cast::<PyDict>() {
        let pairs = table.iter().map(|(key, value)| {
            let key = toml::Value::from(key.extract::<String>()?);
            Ok(format!("{key} = {}", toml(&value, path, depth + 1)?))
        });
        return Ok(format!("{{ {} }}", pairs.collect::<PyResult<Vec<String>>>()?.join(", ")));
    }
    Ok(match value(from)? {
        Value::Text(text) => toml::Value::from(text).to_string(),
        Value::Real(real) => toml::Value::from(real).to_string(),
        number => number.to_string(),
    })
}

/// A value for Python.
pub fn object(py: Python<'_>, value: &Value<impl AsRef<str>>) -> PyResult<Py<PyAny>> {
    Ok(match value {
        Value::Real(value) => value.into_pyobject(py)?.into_any().unbind(),
        Value::Integer(value) => value.into_pyobject(py)?.into_any().unbind(),
        Value::Count(value) => value.into_pyobject(py)?.into_any().unbind(),
        Value::Text(value) => value.as_ref().into_pyobject(py)?.into_any().unbind(),
    })
}
