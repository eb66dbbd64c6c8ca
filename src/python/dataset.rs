//! An open dataset.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::error::Raise;
use super::surrogate::Surrogate;
use super::table::Table;
use super::wait::Work;
use decore_dataset::{DatasetReader, TableName};
use decore_lab::surrogate::{SurrogateSettings, fit};

/// A dataset as it was when it was opened.
///
/// >>> dataset.rows_done, len(dataset.runs), dataset.runs.units["delivered_work_j"]
/// (24, 24, 'J')
#[pyclass(module = "decore", frozen)]
pub struct Dataset {
    reader: Arc<DatasetReader>,
}

impl Dataset {
    /// Opens the dataset in a folder.
    ///
    /// # Errors
    /// As for [`DatasetReader::open`].
    pub fn open(py: Python<'_>, folder: &std::path::Path) -> PyResult<Self> {
        let reader = py.detach(|| DatasetReader::open(folder)).map_err(|error| error.raise(py))?;
        Ok(Self { reader: Arc::new(reader) })
    }
}

#[pymethods]
impl Dataset {
    /// The table of runs: a row per run.
    #[getter]
    fn runs(&self) -> Table {
        Table::stored(&self.reader, TableName::Runs)
    }

    /// The table of blows: a row per blow.
    #[getter]
    fn blows(&self) -> Table {
        Table::stored(&self.reader, TableName::Blows)
    }

    /// Wall time of each run.
    #[getter]
    fn timings(&self) -> Table {
        Table::stored(&self.reader, TableName::Timings)
    }

    /// Means of signals: a row per instant of the runs whose signals the study keeps; `None` if it keeps none.
    #[getter]
    fn signals(&self) -> Option<Table> {
        let is_there = self.reader.tables().any(|table| table == TableName::Signals);
        is_there.then(|| Table::stored(&self.reader, TableName::Signals))
    }

    /// The folder.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.reader.folder().to_owned()
    }

    /// Name of the study.
    #[getter]
    fn study_name(&self) -> &str {
        &self.reader.manifest().study.study_name
    }

    /// Text of the study file.
    #[getter]
    fn study_text(&self) -> &str {
        &self.reader.manifest().study.study_text
    }

    /// The values set over the study's, `path=value`.
    #[getter]
    fn overrides(&self) -> Vec<String> {
        self.reader.manifest().study.overrides.clone()
    }

    /// Seed of the design.
    #[getter]
    fn seed(&self) -> u64 {
        self.reader.manifest().study.seed
    }

    /// Rows that the dataset is to hold.
    #[getter]
    fn rows(&self) -> u64 {
        self.reader.manifest().range.len()
    }

    /// Existing rows, whatever their status.
    #[getter]
    fn rows_done(&self) -> u64 {
        self.reader.manifest().rows_done
    }

    /// Of these, rows with another status than done.
    #[getter]
    fn rows_failed(&self) -> u64 {
        self.reader.manifest().rows_failed()
    }

    /// Fits the models of `surrogate`.
    fn _fit(&self, py: Python<'_>, outputs: Vec<String>, least_q2: f64) -> PyResult<Surrogate> {
        if !(0.0..=1.0).contains(&least_q2) {
            return Err(PyValueError::new_err(format!("least_q2 is {least_q2}, expected a number from 0 to 1")));
        }
        let reader = Arc::clone(&self.reader);
        let settings = SurrogateSettings { outputs, least_q2, ..SurrogateSettings::default() };
        let fitted = move |_: &_| fit(&reader, &settings).and_then(|model| model.check().map(|()| model));
        let model = Work::new(fitted).wait(py)?.map_err(|error| error.raise(py))?;
        let models = Surrogate::new(model);
        models.warn(py)?;
        Ok(models)
    }

    /// A dataset is its folder where a path is taken.
    fn __fspath__(&self) -> OsString {
        self.folder().into_os_string()
    }

    /// Other processes open the folder.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PathBuf,))> {
        Ok((py.import("decore")?.getattr("open")?, (std::path::absolute(self.folder())?,)))
    }

    fn __repr__(&self) -> String {
        let manifest = self.reader.manifest();
        let (folder, rows) = (self.reader.folder().display(), manifest.range.len());
        format!("<decore.Dataset {folder}: {}, {} of {rows} rows>", manifest.study.study_name, manifest.rows_done)
    }
}
