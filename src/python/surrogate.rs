//! Models of a dataset's outputs, and their predictions.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::json;

use super::error::{PredictionWarning, Raise, warn, warn_above};
use super::frame::columns;
use super::table::Table;
use super::value::{FilePath, value};
use super::wait::{Work, give_way};
use decore_dataset::{table_batch, write_table};
use decore_lab::surrogate::{Model, QueryRow, from_bytes, predict_rows, read, to_bytes, write};

/// Models as another process gets them.
type Bytes = Cow<'static, [u8]>;
/// Stands for the file of pickled models in errors.
const PICKLE: &str = "pickled models";

/// Models of a dataset's outputs over its factors, or from a file of `save`; `str` describes them in words.
///
/// >>> models.save("out/models.parquet")
/// >>> decore.Surrogate("out/models.parquet").text == models.text
/// True
#[pyclass(module = "decore", frozen)]
pub struct Surrogate {
    model: Arc<Model>,
}

impl Surrogate {
    /// Models that were fitted or read.
    pub fn new(model: Model) -> Self {
        Self { model: Arc::new(model) }
    }

    /// Warns of each model that predicts poorly, where `Dataset.surrogate` was called.
    ///
    /// # Errors
    /// The warning, where Python is to raise warnings of its kind.
    pub fn warn(&self, py: Python<'_>) -> PyResult<()> {
        for warning in self.model.surrogate.warnings() {
            warn_above(py, &py.get_type::<PredictionWarning>(), &warning, 2)?;
        }
        Ok(())
    }

    fn factors(&self) -> Vec<String> {
        self.model.surrogate.factors.iter().map(|factor| factor.name.clone()).collect()
    }

    /// The values of each row in the order of the factors, as texts that read back the same.
    fn rows(&self, given: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<String>>> {
        let (py, names) = (given.py(), self.factors());
        let columns = match columns(given, &names)? {
            Some(columns) => columns,
            None => py.import("decore._frames")?.call_method1("unnamed", (given, names.len()))?.extract()?,
        };
        let mut rows: Vec<Vec<String>> = Vec::new();
        for (place, (name, values)) in names.iter().zip(columns).enumerate() {
            let text = |(row, one): (usize, PyResult<Bound<'_, PyAny>>)| {
                give_way(py, row)?;
                Ok(value(&one?)?.to_string())
            };
            let texts = match value(&values) {
                Ok(one) => vec![one.to_string()],
                Err(_) => values.try_iter()?.enumerate().map(text).collect::<PyResult<Vec<String>>>()?,
            };
            if place > 0 && texts.len() != rows.len() {
                let message =
                    format!("factor `{name}` has {} values, but the earlier factors have {}", texts.len(), rows.len());
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

    /// The models, with a warning for each that predicts poorly.
    fn _warned(slf: PyRef<'_, Self>) -> PyResult<PyRef<'_, Self>> {
        slf.warn(slf.py())?;
        Ok(slf)
    }

    /// Writes the models to a Parquet file.
    ///
    /// >>> models.save("out/models.parquet")
    fn save(&self, py: Python<'_>, file: FilePath) -> PyResult<()> {
        py.detach(|| write(&self.model, &file.0)).map_err(|error| error.raise(py))
    }

    /// Predicts rows that were not run, as `decore predict`.
    ///
    /// `table`: a frame, a `Table`, a mapping of values, rows as mappings, or an array; columns are taken by the names of the
    /// factors, `factor_` before them or not, and unknown and missing columns raise `KeyError`. `output`: write the predictions to
    /// this Parquet file too. `replace`: replace an existing file. Warns by `PredictionWarning` of rows that are extrapolated and of models that are poor.
    ///
    /// >>> models.predict(study.rows()).keys()[-2:]
    /// ['delivered_work_j_low', 'delivered_work_j_high']
    #[pyo3(signature = (table, output=None, *, replace=false))]
    fn predict(
        &self,
        py: Python<'_>,
        table: &Bound<'_, PyAny>,
        output: Option<FilePath>,
        replace: bool,
    ) -> PyResult<Table> {
        if let Some(taken) = output.as_ref().filter(|output| !replace && output.0.symlink_metadata().is_ok()) {
            let path = taken.0.display();
            let message =
                format!("{path} exists and was not changed: choose another name (output), or add replace=True");
            return Err(PyValueError::new_err(message));
        }
        let cells = self.rows(table)?;
        let model = Arc::clone(&self.model);
        let predicted = Work::new(move |_| {
            let rows = cells.iter().enumerate().map(|(row, cells)| QueryRow { place: format!("row {row}"), cells });
            predict_rows(&model, &rows.collect::<Vec<_>>())
        });
        let predicted = predicted.wait(py)?.map_err(|error| error.raise(py))?;
        for warning in predicted.warnings(&self.model) {
            warn(py, &py.get_type::<PredictionWarning>(), &warning)?;
        }
        if let Some(output) = output {
            let written = py.detach(|| write_table(&output.0, &self.model.info, "predictions", &predicted.columns));
            written.map_err(|error| error.raise(py))?;
        }
        let batch =
            table_batch(&self.model.info, "predictions", &predicted.columns).map_err(|error| error.raise(py))?;
        Ok(Table::new("predictions", batch))
    }

    /// Warnings, a sentence each.
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

    /// Other processes get the bytes of the models' file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bytes,))> {
        let bytes = to_bytes(&self.model, Path::new(PICKLE)).map_err(|error| error.raise(py))?;
        Ok((py.import("decore._decore")?.getattr("_models")?, (bytes.into(),)))
    }

    fn __repr__(&self) -> String {
        let outputs = self.model.surrogate.outputs.iter().map(|output| output.output.as_str());
        let outputs = outputs.collect::<Vec<_>>().join(", ");
        format!("<decore.Surrogate ({}) -> ({outputs}), {} rows>", self.factors().join(", "), self.model.rows.len())
    }

    fn __str__(&self) -> String {
        self.text()
    }
}

/// Models that come from another process, which has warned of them.
///
/// # Errors
/// `DatasetError` for bytes that are no models.
#[pyfunction]
#[pyo3(name = "_models")]
pub fn unpickled(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Surrogate> {
    from_bytes(bytes, Path::new(PICKLE)).map(Surrogate::new).map_err(|error| error.raise(py))
}
