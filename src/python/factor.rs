//! A factor of a design.

use pyo3::prelude::*;

use super::value::object;
use decore_statistics::design::Distribution;
use decore_study::FactorInfo;

/// A factor of a design.
#[pyclass(module = "decore", frozen, get_all)]
pub struct Factor {
    /// Name as in the study.
    name: String,
    /// Unit, if the study gives one.
    unit: Option<String>,
    /// Paths of the study that it drives.
    paths: Vec<String>,
    /// The values that it chooses from; empty for a range.
    values: Vec<Py<PyAny>>,
    /// The ends of its range; none for texts and derived factors.
    range: Option<(f64, f64)>,
    /// The expression of a derived factor.
    expression: Option<String>,
}

#[pymethods]
impl Factor {
    fn __repr__(&self) -> String {
        format!("<decore.Factor {}: {}>", self.name, self.paths.join(", "))
    }
}

impl Factor {
    /// The factor for Python.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn new(py: Python<'_>, factor: &FactorInfo) -> PyResult<Self> {
        Ok(Self {
            name: factor.name.clone(),
            unit: factor.unit.clone(),
            paths: factor.paths(),
            values: factor.values.iter().map(|value| object(py, value)).collect::<PyResult<_>>()?,
            range: ends(factor),
            expression: factor.expression().map(str::to_owned),
        })
    }
}

/// The ends of a factor's range; none for texts and derived factors.
pub fn ends(factor: &FactorInfo) -> Option<(f64, f64)> {
    match factor.distribution()? {
        Distribution::Integer { low, high } | Distribution::LogInteger { low, high } => {
            Some((*low as f64, *high as f64))
        }
        Distribution::Categories { .. } => {
            let numbers: Option<Vec<f64>> = factor.values.iter().map(|value| value.number()).collect();
            let numbers = numbers.filter(|numbers| !numbers.is_empty())?;
            let end = |pick: fn(f64, f64) -> f64, from: f64| numbers.iter().copied().fold(from, pick);
            Some((end(f64::min, f64::INFINITY), end(f64::max, f64::NEG_INFINITY)))
        }
        real => real.range(),
    }
}
