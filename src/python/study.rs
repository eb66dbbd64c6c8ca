//! A study: its rows, simulated one by one, as a function, or as a sweep.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyInt, PyMapping, PyString};

use super::error::{Raise, StudyError, StudyWarning, warn};
use super::factor::Factor;
use super::frame::factor;
use super::function::{Definition, Function};
use super::ready::{Asked, Chosen, Ready, Shared, Wanted};
use super::row::Row;
use super::table::Table;
use super::value::{FilePath, given, repeated, settings, truth};
use super::wait::Work;
use decore_dataset::{DatasetError, TableName, table_batch};
use decore_model::run::{DEFAULT_RETRIES, thread_count};
use decore_statistics::design::Level;
use decore_study::CheckedStudy;
use decore_study::engine::{checked, design_table};

/// Origin of a study, which other processes read again: path, overrides, retries, hash.
pub type Origin = (PathBuf, Vec<String>, u32, String);

/// Studies made ready most recently, for functions that come from another process: it sends one with each piece of work.
static READY: Mutex<Vec<(Origin, Shared)>> = Mutex::new(Vec::new());
/// Largest number of stored ones.
const MOST_READY: usize = 4;

/// A study, checked against its machine. The machine is reduced when the first row runs.
///
/// `path`: the study file. `overrides`: values over the file's, by their paths, like `--set`. `retries`: times a row that diverged is
/// run again. Raises `StudyError` with all problems, and `MachineError` if the machine's files cannot be read.
///
/// >>> decore.Study("studies/placement.toml", {"design.rows": 24})
/// <decore.Study Placement and pressure: 24 rows>
#[pyclass(module = "decore", frozen)]
pub struct Study {
    checked: CheckedStudy,
    /// File, valid in any working directory.
    path: PathBuf,
    retries: u32,
    ready: OnceLock<Shared>,
}

impl Study {
    /// Reads a study file, with settings `path=value` over its own.
    fn load(py: Python<'_>, path: &Path, overrides: Vec<String>, retries: u32) -> PyResult<Self> {
        let file = path.to_owned();
        let work = move |_: &_| checked(decore_study::Study::load(&file)?.with_overrides(&overrides)?);
        let checked = Work::new(work).wait(py)?.map_err(|error| error.raise(py))?;
        Ok(Self { checked, path: std::path::absolute(path)?, retries, ready: OnceLock::new() })
    }

    /// The study ready to run.
    fn ready(&self, py: Python<'_>) -> PyResult<&Shared> {
        if let Some(ready) = self.ready.get() {
            return Ok(ready);
        }
        let (checked, retries) = (self.checked.clone(), self.retries);
        let made = Work::new(move |_| Ready::new(&checked, retries)).wait(py)?.map_err(|error| error.raise(py))?;
        for note in made.engine.notes() {
            warn(py, &py.get_type::<StudyWarning>(), note)?;
        }
        Ok(self.ready.get_or_init(|| Arc::new(made)))
    }

    fn origin(&self) -> Origin {
        let study = self.checked.study();
        (self.path.clone(), study.overrides(), self.retries, study.hash().to_owned())
    }

    /// The study of a function that comes from another process, ready to run.
    ///
    /// # Errors
    /// As for [`unpickled`].
    pub fn ready_again(py: Python<'_>, origin: &Origin) -> PyResult<Shared> {
        let list = || READY.lock().unwrap_or_else(PoisonError::into_inner);
        let known = list().iter().find(|(one, _)| one == origin).map(|(_, ready)| Arc::clone(ready));
        if let Some(ready) = known {
            return Ok(ready);
        }
        let (path, overrides, retries, hash) = origin.clone();
        let ready = Arc::clone(unpickled(py, path, overrides, retries, &hash)?.ready(py)?);
        let mut known = list();
        known.insert(0, (origin.clone(), Arc::clone(&ready)));
        known.truncate(MOST_READY);
        Ok(ready)
    }

    /// The row that is meant: its index, or values by the names of the factors.
    fn asked(&self, py: Python<'_>, row: &Bound<'_, PyAny>) -> PyResult<Asked> {
        if row.hasattr("keys")? {
            // Mappings, and rows of frames with the columns of tables.
            let values = py.get_type::<PyDict>().call1((row,))?;
            let values = given(values.cast::<PyMapping>()?)?.into_iter().filter(|(name, _)| name != "row");
            let values: Vec<_> = values.map(|(name, value)| (factor(&name).to_owned(), value)).collect();
            let levels: Result<Vec<Level>, decore_study::StudyError> = self.checked.levels(&values);
            return levels.map(Asked::Point).map_err(|error| error.raise(py));
        }
        let index = row.extract::<i64>();
        // A whole number that is too large for any row is one nevertheless.
        if truth(row).is_some() || (index.is_err() && !row.is_instance_of::<PyInt>()) {
            let found = row.get_type().name()?;
            return Err(PyTypeError::new_err(format!("expected the index of a row or a mapping, found {found}")));
        }
        let rows = self.checked.row_count();
        let index = index.ok().and_then(|index| usize::try_from(index).ok()).filter(|index| *index < rows);
        index
            .map(Asked::Row)
            .ok_or_else(|| PyIndexError::new_err(format!("the study has the rows 0 to {}, not {row}", rows - 1)))
    }

    /// The place of a column of numbers in the table of runs.
    pub fn place(ready: &Ready, name: &str) -> Result<usize, DatasetError> {
        let (table, columns) = (TableName::Runs.folder(), ready.columns.describe(TableName::Runs));
        match columns.iter().position(|column| column.name == name) {
            Some(place) if columns.get(place).is_some_and(|column| !column.kind.is_text()) => Ok(place),
            Some(_) => Err(DatasetError::NotANumber { table, column: name.to_owned() }),
            None => Err(DatasetError::UnknownColumn {
                table,
                column: name.to_owned(),
                known: columns.into_iter().map(|column| column.name).collect(),
            }),
        }
    }
}

#[pymethods]
impl Study {
    /// Reads a study file, with values set over its own.
    #[new]
    #[pyo3(signature = (path, overrides=None, *, retries=DEFAULT_RETRIES))]
    fn new(py: Python<'_>, path: FilePath, overrides: Option<&Bound<'_, PyMapping>>, retries: u32) -> PyResult<Self> {
        let overrides = overrides.map(settings).transpose()?.unwrap_or_default();
        let study = Self::load(py, &path.0, overrides, retries)?;
        for warning in study.checked.warnings() {
            warn(py, &py.get_type::<StudyWarning>(), &warning.to_string())?;
        }
        Ok(study)
    }

    /// Title of the study.
    #[getter]
    fn title(&self) -> &str {
        self.checked.study().title()
    }

    /// Hash of everything that determines its rows.
    #[getter]
    fn hash(&self) -> &str {
        self.checked.study().hash()
    }

    /// The study's file.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// The values set over the study's, `path=value`.
    #[getter]
    fn overrides(&self) -> Vec<String> {
        self.checked.study().overrides()
    }

    /// Times a row that diverged is run again.
    #[getter]
    fn retries(&self) -> u32 {
        self.retries
    }

    /// Names of the hammers.
    #[getter]
    fn hammers(&self) -> Vec<&str> {
        self.checked.study().hammer_names()
    }

    /// Names of the castings.
    #[getter]
    fn castings(&self) -> Vec<&str> {
        self.checked.study().casting_names()
    }

    /// The factors of the design.
    #[getter]
    fn factors(&self, py: Python<'_>) -> PyResult<Vec<Factor>> {
        self.checked.study().factors().iter().map(|factor| Factor::new(py, factor)).collect()
    }

    fn __len__(&self) -> usize {
        self.checked.row_count()
    }

    /// The design: a row per run, a column per factor. Nothing is run.
    ///
    /// >>> study.rows().keys()[:2]
    /// ['row', 'factor_position']
    fn rows(&self, py: Python<'_>) -> PyResult<Table> {
        let batch = py.detach(|| {
            let (info, columns) = design_table(&self.checked);
            table_batch(&info, "design", &columns)
        });
        Ok(Table::new("design", batch.map_err(|error| error.raise(py))?))
    }

    /// Simulates a row of the design, or one with these values of the factors.
    ///
    /// `row`: index from 0, or the values of all factors by their names: a mapping, or the row of a pandas frame. `signals`: names of
    /// signals to keep, or `True` for all. `signal_interval_s`: time between two of their values in s. A row that cannot be
    /// simulated raises nothing: its `status` and `reason` show why.
    ///
    /// >>> row = study.scene(3, signals=["hammer_casting_force_n"])
    /// >>> row.status, len(row.signals)
    /// ('done', 3001)
    #[pyo3(signature = (row=None, *, signals=None, signal_interval_s=1e-4))]
    fn scene(
        slf: &Bound<'_, Self>,
        row: Option<&Bound<'_, PyAny>>,
        signals: Option<&Bound<'_, PyAny>>,
        signal_interval_s: f64,
    ) -> PyResult<Row> {
        let (py, this) = (slf.py(), slf.get());
        let asked = row.map_or(Ok(Asked::Row(0)), |row| this.asked(py, row))?;
        let index = if let Asked::Row(index) = &asked { Some(*index) } else { None };
        let wanted = chosen(signals)?.map(|chosen| Wanted { chosen, interval_s: signal_interval_s });
        if !(signal_interval_s > 0.0 && signal_interval_s.is_finite()) {
            let message = format!("signal_interval_s is {signal_interval_s}, expected a positive number");
            return Err(PyValueError::new_err(message));
        }
        let ready = Arc::clone(this.ready(py)?);
        let found = Work::new(move |_| ready.simulate(&asked, wanted.as_ref())).wait(py)?;
        Row::new(py, (slf.clone().unbind(), index), found.map_err(|error| error.raise(py))?)
    }

    /// Outputs as a function of factors, over arrays.
    ///
    /// `outputs`: columns of the table of runs; one name alone for results without an axis of outputs. `factors`: columns of X; all
    /// that are not in `fixed` unless named. `fixed`: values of the other factors. `threads`: 0 for one per core.
    ///
    /// >>> fixed = {"position": 0.0, "standoff": 0.08, "fixture_stiffness": 3e7}
    /// >>> work = study.function("delivered_work_j", factors=["pressure"], fixed=fixed)
    /// >>> work([[4.5], [5.5]]).shape
    /// (2,)
    #[pyo3(signature = (outputs, *, factors=None, fixed=None, threads=0))]
    fn function(
        &self,
        py: Python<'_>,
        outputs: &Bound<'_, PyAny>,
        factors: Option<Vec<String>>,
        fixed: Option<&Bound<'_, PyMapping>>,
        threads: usize,
    ) -> PyResult<Function> {
        check_threads(threads)?;
        let fixed = fixed.map(given).transpose()?.unwrap_or_default();
        let single = outputs.is_instance_of::<PyString>();
        let names = if single { vec![outputs.extract()?] } else { outputs.extract::<Vec<String>>()? };
        let factors = factors.unwrap_or_else(|| {
            let left = self.checked.free_factors().filter(|factor| fixed.iter().all(|(name, _)| *name != factor.name));
            left.map(|factor| factor.name.clone()).collect()
        });
        let ready = self.ready(py)?;
        let place = |name: String| Self::place(ready, &name).map(|place| (name, place));
        let outputs = names.into_iter().map(place).collect::<Result<_, _>>().map_err(|error| error.raise(py))?;
        let definition = Definition { factors, fixed, outputs, single, threads };
        Function::new(py, (ready, self.origin()), definition)
    }

    /// Other processes read the study again, from its file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Origin)> {
        Ok((py.import("decore._decore")?.getattr("_study")?, self.origin()))
    }

    fn __repr__(&self) -> String {
        format!("<decore.Study {}: {} rows>", self.title(), self.checked.row_count())
    }
}

/// A study that comes from another process, which has warned of it.
///
/// # Errors
/// As for a study that is read; `StudyError` where its files are not what they were.
#[pyfunction]
#[pyo3(name = "_study")]
pub fn unpickled(py: Python<'_>, path: PathBuf, overrides: Vec<String>, retries: u32, hash: &str) -> PyResult<Study> {
    let study = Study::load(py, &path, overrides, retries)?;
    if study.checked.study().hash() == hash {
        return Ok(study);
    }
    let message = "the study or one of its files changed since it was passed to this process; load it again and pass \
        the new study";
    Err(StudyError::new_err(format!("{}: {message}", path.display())))
}

fn check_threads(threads: usize) -> PyResult<()> {
    thread_count(threads).map(drop).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Listener of the progress: the package's own display, a callable, or none.
///
/// # Errors
/// What the object raised when it was asked whether it is true.
pub fn listener(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Py<PyAny>>> {
    match progress {
        None => Ok(None),
        Some(one) if one.is_callable() => Ok(Some(one.clone().unbind())),
        Some(one) if one.is_truthy()? => Ok(Some(py.import("decore._progress")?.getattr("Display")?.call0()?.unbind())),
        Some(_) => Ok(None),
    }
}

/// The requested signals: a list of names, or `True` for all.
fn chosen(signals: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Chosen>> {
    match signals {
        None => Ok(None),
        Some(one) => match truth(one) {
            Some(all) => Ok(all.then_some(Chosen::All)),
            None => {
                let names: Vec<String> = one.extract()?;
                if let Some(name) = repeated(&names) {
                    return Err(PyValueError::new_err(format!(
                        "signal `{name}` is in `signals` twice: give each once"
                    )));
                }
                Ok(Some(Chosen::Named(names)))
            }
        },
    }
}
