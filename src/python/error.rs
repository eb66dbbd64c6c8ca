//! Exceptions, with file, line, key and suggestion.

use std::ffi::CString;

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyType};

use crate::cli::Failure;
use decore_lab::surrogate::SurrogateError;
use decore_study::FileLocation;
use decore_study::engine::EngineError;

create_exception!(decore, Error, PyException, "What decore raises; all its exceptions are of this class.");
create_exception!(
    decore,
    StudyError,
    Error,
    "A study is wrong. `problems` has its faults, one `Problem` each, by place."
);
create_exception!(decore, MachineError, Error, "A machine's files cannot be read, or the machine cannot be reduced.");
create_exception!(decore, DatasetError, Error, "A dataset cannot be written or read, or lacks what is asked for.");
create_exception!(decore, SweepError, Error, "Rows could not be run or stored; what is done is kept.");
create_exception!(decore, StudyWarning, PyUserWarning, "What about a study is possible but unlikely.");
create_exception!(decore, PredictionWarning, PyUserWarning, "What of a prediction cannot be relied on.");

/// Issues a warning.
///
/// # Errors
/// The warning, where Python is to raise warnings of its kind.
pub fn warn(py: Python<'_>, kind: &Bound<'_, PyType>, text: &str) -> PyResult<()> {
    warn_above(py, kind, text, 1)
}

/// As [`warn`], for functions of Python around it: `level` is 2 for one.
///
/// # Errors
/// As [`warn`].
pub fn warn_above(py: Python<'_>, kind: &Bound<'_, PyType>, text: &str, level: i32) -> PyResult<()> {
    // A text of a study holds no zero; one that does ends there.
    let text = CString::new(text.split('\0').next().unwrap_or_default())?;
    PyErr::warn(py, kind, &text, level)
}

/// Fields of a [`Problem`], in its order, for `pickle`.
type Fields = (String, Option<usize>, Option<usize>, String, String, Option<String>, Option<String>, String);

/// One fault of a study.
#[pyclass(module = "decore", frozen, get_all)]
#[derive(Clone)]
pub struct Problem {
    /// Name of the file, or the value set over it.
    file: String,
    /// Line, from 1; none if the fault belongs to no line.
    line: Option<usize>,
    /// Column in characters, from 1.
    column: Option<usize>,
    /// Path of the key; empty for a fault of syntax.
    key: String,
    /// The fault.
    message: String,
    /// Expected value, if it is not part of the message.
    expected: Option<String>,
    /// The nearest known key or name.
    suggestion: Option<String>,
    /// All of it as text, with the line of the file.
    text: String,
}

#[pymethods]
impl Problem {
    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!(":{line}"));
        format!("<decore.Problem {}{line} `{}`: {}>", self.file, self.key, self.message)
    }

    /// Exceptions go from process to process with their problems.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Fields,))> {
        let Self { file, line, column, key, message, expected, suggestion, text } = self.clone();
        let fields = (file, line, column, key, message, expected, suggestion, text);
        Ok((py.import("decore._decore")?.getattr("_problem")?, (fields,)))
    }
}

/// A problem that comes from another process.
#[pyfunction]
#[pyo3(name = "_problem")]
pub fn problem(fields: Fields) -> Problem {
    let (file, line, column, key, message, expected, suggestion, text) = fields;
    Problem { file, line, column, key, message, expected, suggestion, text }
}

impl Problem {
    fn new(problem: &decore_study::Problem) -> Self {
        let FileLocation { file, line, column, .. } = &problem.place;
        Self {
            file: file.clone(),
            line: *line,
            column: *column,
            key: problem.key.clone(),
            message: problem.message.clone(),
            expected: problem.expected.clone(),
            suggestion: problem.nearest.clone(),
            text: problem.to_string(),
        }
    }
}

/// An error of the library as the exception that stands for it.
pub trait Raise {
    /// The exception.
    fn raise(self, py: Python<'_>) -> PyErr;
}

impl Raise for decore_study::StudyError {
    fn raise(self, py: Python<'_>) -> PyErr {
        wrong_study(py, &self.to_string(), self.problems())
    }
}

/// The exception for a study that is wrong.
fn wrong_study(py: Python<'_>, message: &str, problems: &[decore_study::Problem]) -> PyErr {
    let error = StudyError::new_err(message.to_owned());
    let problems = problems.iter().map(|problem| Py::new(py, Problem::new(problem)));
    let attached = PyList::new(py, problems.filter_map(Result::ok));
    match attached.and_then(|problems| error.value(py).setattr("problems", problems)) {
        Ok(()) => error,
        Err(failure) => failure,
    }
}

impl Raise for decore_dataset::DatasetError {
    fn raise(self, _: Python<'_>) -> PyErr {
        DatasetError::new_err(self.to_string())
    }
}

impl Raise for EngineError {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Study(error) => error.raise(py),
            Self::Dataset(error) => error.raise(py),
            Self::Batch(error) => SweepError::new_err(error.to_string()),
            // Known only once the study is made ready: it has no place in the text.
            Self::Outputs { .. } => wrong_study(py, &self.to_string(), &[]),
            Self::Signals { .. } => Error::new_err(self.to_string()),
            Self::Structure(_) | Self::Read { .. } | Self::MissingPoint { .. } | Self::MovedPoint { .. } => {
                MachineError::new_err(self.to_string())
            }
        }
    }
}

impl Raise for Failure {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Study(error) => error.raise(py),
            Self::Engine(error) => error.raise(py),
            Self::Dataset(error) => error.raise(py),
            Self::Surrogate(error) => error.raise(py),
            Self::Structure(error) => MachineError::new_err(error.to_string()),
            Self::Argument(message) => PyValueError::new_err(message),
            Self::Threads(error) => PyValueError::new_err(error.to_string()),
            Self::Write { .. } | Self::Page(_) | Self::Plot(_) | Self::Paper(_) | Self::Print(_) => {
                Error::new_err(self.to_string())
            }
            Self::Sensitivity(_)
            | Self::Features(_)
            | Self::Refinement(_)
            | Self::Best(_)
            | Self::Cores(_)
            | Self::Comparison(_) => DatasetError::new_err(self.to_string()),
        }
    }
}

impl Raise for SurrogateError {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Dataset(error) => error.raise(py),
            other => DatasetError::new_err(other.to_string()),
        }
    }
}
