//! Models of a dataset's outputs, and what they say of rows not run.

use std::sync::Arc;

use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use serde_json::json;

use super::error::{PredictionWarning, Raise, warn};
use super::table::Table;
use super::value::{FilePath, entries, value};
use super::wait::{Work, give_way};
use decore_dataset::table_batch;
use decore_lab::surrogate::{Model, QueryRow, predict_rows, read, write};
use decore_quantity::words::{did_you_mean, nearest};

/// Models of the outputs of a dataset over its factors.
#[pyclass(module = "decore", frozen)]
pub struct Surrogate {
    model: Arc<Model>,
}

impl Surrogate {
    /// Models that were fitted or read.
    pub fn new(model: Model) -> Self {
        Self { model: Arc::new(model) }
    }

    /// The values of each row in the order of the factors, as texts that read back the same.
    fn rows(&self, factors: &Bound<'_, PyMapping>) -> PyResult<Vec<Vec<String>>> {
        let known = || self.model.surrogate.factors.iter().map(|factor| factor.name.as_str());
        let mut given = entries(factors)?;
        if let Some((unknown, _)) = given.iter().find(|(name, _)| !known().any(|factor| factor == name)) {
            let hint = did_you_mean(nearest(unknown, known()));
            return Err(PyKeyError::new_err(format!("there is no factor `{unknown}`{hint}")));
        }
        let mut rows: Vec<Vec<String>> = Vec::new();
        for (place, name) in known().enumerate() {
            let Some(at) = given.iter().position(|(given, _)| given == name) else {
                return Err(PyKeyError::new_err(format!("factor `{name}` has no values")));
            };
            let (_, values) = given.swap_remove(at);
            let text = |(row, one): (usize, PyResult<Bound<'_, PyAny>>)| {
                give_way(factors.py(), row)?;
                Ok(value(&one?)?.to_string())
            };
            let texts = values.try_iter()?.enumerate().map(text).collect::<PyResult<Vec<String>>>()?;
            if place > 0 && texts.len() != rows.len() {
                let message = format!("factor `{name}` has {} values, those before it {}", texts.len(), rows.len());
                return Err(PyValueError::new_err(message));
            }
            rows.resize_with(texts.len(), Vec::new);
            rows.iter_mut().zip(texts).for_each(|(row, text)| row.push(text));
        }
        Ok(rows)
    }
}

#[pymethods]
impl Surrogate {
    /// Reads the file of models that `save` or `decore surrogate --output` wrote.
    #[new]
    fn load(py: Python<'_>, file: FilePath) -> PyResult<Self> {
        let model = py.detach(|| read(&file.0)).map_err(|error| error.raise(py))?;
        Ok(Self::new(model))
    }

    /// Writes the models to a Parquet file, as `decore surrogate --output`.
    fn save(&self, py: Python<'_>, file: FilePath) -> PyResult<()> {
        py.detach(|| write(&self.model, &file.0)).map_err(|error| error.raise(py))
    }

    /// What rows would give that were not run: a list of values for each factor; as `decore predict`, with its
    /// warnings.
    fn predict(&self, py: Python<'_>, factors: &Bound<'_, PyMapping>) -> PyResult<Table> {
        let cells = self.rows(factors)?;
        let model = Arc::clone(&self.model);
        let predicted = Work::new(move |_| {
            let rows = cells.iter().enumerate().map(|(row, cells)| QueryRow { place: format!("row {row}"), cells });
            predict_rows(&model, &rows.collect::<Vec<_>>())
        });
        let predicted = predicted.wait(py)?.map_err(|error| error.raise(py))?;
        for warning in predicted.warnings(&self.model) {
            warn(py, &py.get_type::<PredictionWarning>(), &warning)?;
        }
        let batch =
            table_batch(&self.model.info, "predictions", &predicted.columns).map_err(|error| error.raise(py))?;
        Ok(Table::new("predictions", batch))
    }

    /// What cannot be relied on, a sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model.surrogate.warnings()
    }

    /// The models' figures as JSON (schemas/surrogate.schema.json).
    #[getter]
    fn json(&self) -> String {
        json!(self.model.surrogate).to_string()
    }

    /// In words, as `decore surrogate` prints it.
    #[getter]
    fn text(&self) -> String {
        self.model.surrogate.to_string().trim_end().to_owned()
    }

    fn __str__(&self) -> String {
        self.text()
    }
}
