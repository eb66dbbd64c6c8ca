//! A dataset, opened.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::json;

use super::error::Raise;
use super::surrogate::Surrogate;
use super::table::Table;
use super::wait::Work;
use decore_dataset::{DatasetReader, TableName, table_batch};
use decore_lab::sensitivity::{SensitivitySettings, analyse, columns};
use decore_lab::surrogate::{SurrogateSettings, fit};
use decore_quantity::words::{did_you_mean, nearest};
use decore_statistics::analysis::{Bootstrap, Estimator};

/// A dataset as it was when it was opened.
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

    /// Means of signals: a row per instant of the runs whose signals the study keeps; `None` where it keeps none.
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

    /// Rows that are there, whatever their status.
    #[getter]
    fn rows_done(&self) -> u64 {
        self.reader.manifest().rows_done
    }

    /// Of these, rows with another status than done.
    #[getter]
    fn rows_failed(&self) -> u64 {
        self.reader.manifest().rows_failed()
    }

    /// Which factor matters to which output: as `decore analyse`.
    #[pyo3(signature = (outputs=Vec::new(), *, estimator=None, given=false, bootstrap=1000, seed=0))]
    fn analyse(
        &self,
        py: Python<'_>,
        outputs: Vec<String>,
        estimator: Option<&str>,
        given: bool,
        bootstrap: usize,
        seed: u64,
    ) -> PyResult<Analysis> {
        let estimator = estimator.map(named).transpose()?;
        if (1..Bootstrap::LEAST_REPLICATES).contains(&bootstrap) {
            let least = Bootstrap::LEAST_REPLICATES;
            return Err(PyValueError::new_err(format!("bootstrap is {bootstrap}, expected 0 or at least {least}")));
        }
        let bootstrap = Bootstrap { replicates: bootstrap, seed, level: Bootstrap::LEVEL };
        let settings = SensitivitySettings { outputs, estimator, given, bootstrap };
        let reader = Arc::clone(&self.reader);
        let found = Work::new(move |_| analyse(&reader, &settings)).wait(py)?.map_err(|error| error.raise(py))?;
        let batch = table_batch(&self.reader.manifest().study, "sensitivity", &columns(&found));
        let table = Py::new(py, Table::new("sensitivity", batch.map_err(|error| error.raise(py))?))?;
        Ok(Analysis { table, json: json!(found).to_string(), text: found.to_string().trim_end().to_owned() })
    }

    /// Models of the outputs over the factors: as `decore surrogate`.
    #[pyo3(signature = (outputs=Vec::new(), *, least_q2=SurrogateSettings::default().least_q2))]
    fn surrogate(&self, py: Python<'_>, outputs: Vec<String>, least_q2: f64) -> PyResult<Surrogate> {
        if !(0.0..=1.0).contains(&least_q2) {
            return Err(PyValueError::new_err(format!("least_q2 is {least_q2}, expected a number from 0 to 1")));
        }
        let reader = Arc::clone(&self.reader);
        let settings = SurrogateSettings { outputs, least_q2, ..SurrogateSettings::default() };
        let fitted = move |_: &_| fit(&reader, &settings).and_then(|model| model.check().map(|()| model));
        let model = Work::new(fitted).wait(py)?.map_err(|error| error.raise(py))?;
        Ok(Surrogate::new(model))
    }

    fn __repr__(&self) -> String {
        let manifest = self.reader.manifest();
        let (folder, rows) = (self.reader.folder().display(), manifest.range.len());
        format!("<decore.Dataset {folder}: {}, {} of {rows} rows>", manifest.study.study_name, manifest.rows_done)
    }
}

fn named(name: &str) -> PyResult<Estimator> {
    let names = || Estimator::ALL.into_iter().map(Estimator::name);
    Estimator::ALL.into_iter().find(|one| one.name() == name).ok_or_else(|| {
        let hint = did_you_mean(nearest(name, names()));
        let known = names().collect::<Vec<_>>().join(", ");
        PyValueError::new_err(format!("estimator is `{name}`, expected one of {known}{hint}"))
    })
}

/// What was found of the factors of a dataset.
#[pyclass(module = "decore", frozen, get_all)]
pub struct Analysis {
    /// A row per output and index.
    table: Py<Table>,
    /// As JSON (schemas/sensitivity.schema.json).
    json: String,
    /// In words, as `decore analyse` prints it.
    text: String,
}

#[pymethods]
impl Analysis {
    fn __str__(&self) -> &str {
        &self.text
    }
}
