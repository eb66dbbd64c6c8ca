//! One simulated row.

use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList};

use super::ready::Simulated;
use super::study::Study;
use super::table::Table;
use decore_dataset::TableName;

/// A simulated row, and its tables. `row["column"]` is a value of the table of runs, `dict(row)` has all.
///
/// >>> study.scene(3).status
/// 'done'
#[pyclass(module = "decore", frozen, get_all)]
pub struct Row {
    /// `done`, `audit_failed`, `invalid`, `diverged` or `budget_exhausted`.
    status: &'static str,
    /// Reason why the row is not done; empty if it is.
    reason: String,
    /// Time that it took, in s.
    wall_time_s: f64,
    /// Row of the table of runs.
    runs: Py<Table>,
    /// Blows.
    blows: Py<Table>,
    /// Signals; none unless they were requested and the row could be simulated.
    signals: Option<Py<Table>>,
    /// Study of the row.
    study: Py<Study>,
    /// Place in the design; none for own values of factors.
    index: Option<usize>,
}

impl Row {
    /// The row for Python.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn new(py: Python<'_>, (study, index): (Py<Study>, Option<usize>), simulated: Simulated) -> PyResult<Self> {
        let Simulated { outcome, tables: [runs, blows, _], signals } = simulated;
        Ok(Self {
            study,
            index,
            status: outcome.status.name(),
            reason: outcome.reason,
            wall_time_s: outcome.wall_time_s,
            runs: Py::new(py, Table::new(TableName::Runs.folder(), runs))?,
            blows: Py::new(py, Table::new(TableName::Blows.folder(), blows))?,
            signals: signals.map(|signals| Py::new(py, Table::new("signals", signals))).transpose()?,
        })
    }
}

#[pymethods]
impl Row {
    /// The value of a column of the table of runs.
    fn __getitem__(&self, py: Python<'_>, column: &str) -> PyResult<Py<PyAny>> {
        let values = self.runs.get().values(py, column)?;
        Ok(values.iter().next().map_or_else(|| py.None(), Bound::unbind))
    }

    /// Names of the columns of the table of runs; `dict(row)` uses them with `[]`.
    ///
    /// >>> dict(study.scene(3))["factor_pressure"] == study.scene(3)["factor_pressure"]
    /// True
    fn keys(&self) -> Vec<String> {
        self.runs.get().names()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.keys())?.try_iter()
    }

    fn __len__(&self) -> usize {
        self.keys().len()
    }

    fn __contains__(&self, column: &Bound<'_, PyAny>) -> bool {
        self.runs.get().__contains__(column)
    }

    fn __repr__(&self) -> String {
        let reason = if self.reason.is_empty() { String::new() } else { format!(": {}", self.reason) };
        format!("<decore.Row {}{reason}>", self.status)
    }
}
