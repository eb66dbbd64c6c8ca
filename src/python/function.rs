//! Outputs as a function of factors over arrays, for optimisers and samplers.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyImportError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyList, PyTuple};

use super::error::{Raise, StudyWarning, warn};
use super::factor::ends;
use super::frame::columns;
use super::ready::{Asked, Ready, Shared};
use super::study::{Origin, Study};
use super::value::{object, repeated, value};
use super::wait::Work;
use decore_dataset::Source;
use decore_quantity::Value;
use decore_statistics::design::{Distribution, Level};
use decore_study::engine::{EngineError, RowRunner};
use decore_study::{CheckedStudy, FactorInfo};

/// Share of a range by which rounding may leave it.
const ROUNDING: f64 = 1e-9;

/// `f(X) -> Y`: a row of X per point, a column per factor; a row of Y per point, a column per output.
///
/// Y is NaN if a point cannot be simulated or a factor does not take its value (NaN, infinity, a value between whole numbers or
/// listed values). It has no axis of points for one point, and none of outputs if one output was requested by its name alone.
///
/// X is an array; or a frame, a mapping or rows, whose names are obeyed: other orders give the same, unknown and missing columns raise
/// `KeyError`.
///
/// >>> work = study.function("delivered_work_j")
/// >>> work.factors
/// ['position', 'pressure', 'standoff', 'fixture_stiffness']
/// >>> (work(study.rows()) == dataset.runs["delivered_work_j"]).all()
/// np.True_
#[pyclass(module = "decore", frozen)]
pub struct Function {
    ready: Shared,
    origin: Origin,
    factors: Vec<String>,
    fixed: Vec<(String, Value)>,
    outputs: Vec<String>,
    /// Places in the table of runs.
    places: Vec<usize>,
    /// Whether one output was requested by its name alone.
    single: bool,
    threads: usize,
}

/// A function as it is requested.
pub struct Definition {
    /// Factors that are columns of X.
    pub factors: Vec<String>,
    /// The others.
    pub fixed: Vec<(String, Value)>,
    /// Columns of Y with their places in the table of runs.
    pub outputs: Vec<(String, usize)>,
    /// Whether Y has no axis of outputs.
    pub single: bool,
    /// Threads; 0: all.
    pub threads: usize,
}

impl Definition {
    /// Holds the names and the fixed values to a study, so that a call can only fail by its points.
    ///
    /// # Errors
    /// `ValueError` for a name that stands twice and a factor of texts as a column; `StudyError` with all factors that are unknown,
    /// derived, overridden or without a value, and all values that a factor does not take.
    fn check(&self, py: Python<'_>, checked: &CheckedStudy) -> PyResult<()> {
        let wrong = |message: String| Err(PyValueError::new_err(message));
        if let Some(name) = repeated(self.outputs.iter().map(|(name, _)| name)) {
            return wrong(format!("output `{name}` is given twice: give each once"));
        }
        if let Some(name) = repeated(self.factors.iter()) {
            return wrong(format!("factor `{name}` is in `factors` twice: give each once"));
        }
        if let Some((name, _)) = self.fixed.iter().find(|(name, _)| self.factors.contains(name)) {
            return wrong(format!("factor `{name}` is in `factors` and in `fixed`: leave it out of one of them"));
        }
        let factors = || checked.study().factors().iter().filter(|factor| self.factors.contains(&factor.name));
        let is_text = |factor: &&FactorInfo| factor.values.iter().any(|value| value.number().is_none());
        if let Some(text) = factors().find(is_text) {
            let (name, domain) = (&text.name, text.domain());
            return wrong(format!(
                "factor `{name}` takes texts ({domain}), X holds numbers: give its value in `fixed`"
            ));
        }
        // Any permitted value of the factor can fill its column.
        let taken = |name: &String| {
            let factor = factors().find(|factor| factor.name == *name);
            factor.and_then(|factor| factor.values.first().cloned()).unwrap_or(Value::Integer(0))
        };
        let columns = self.factors.iter().map(|name| (name.clone(), taken(name)));
        let given: Vec<(String, Value)> = columns.chain(self.fixed.iter().cloned()).collect();
        checked.levels(&given).map(drop).map_err(|error| error.raise(py))
    }
}

impl Function {
    /// The function of a study.
    ///
    /// # Errors
    /// As for [`Definition::check`].
    pub fn new(py: Python<'_>, (ready, origin): (&Shared, Origin), definition: Definition) -> PyResult<Self> {
        definition.check(py, ready.engine.checked())?;
        let Definition { factors, fixed, outputs, single, threads } = definition;
        let (outputs, places) = outputs.into_iter().unzip();
        Ok(Self { ready: Arc::clone(ready), origin, factors, fixed, outputs, places, single, threads })
    }
}

impl Function {
    /// Warns of each factor with values outside its range in the design. A normal distribution has no ends.
    fn warn_outside(&self, py: Python<'_>, x: &[f64]) -> PyResult<()> {
        let all = self.ready.engine.study().factors();
        for (column, name) in self.factors.iter().enumerate() {
            let Some(factor) = all.iter().find(|factor| factor.name == *name) else { continue };
            let unbounded = matches!(factor.distribution(), Some(Distribution::Normal { .. }));
            let Some((low, high)) = ends(factor).filter(|_| !unbounded) else { continue };
            let slack = ROUNDING * (high - low);
            let outside = |value: &&f64| value.is_finite() && !(low - slack..=high + slack).contains(*value);
            if x.iter().skip(column).step_by(self.factors.len()).find(outside).is_some() {
                let message = format!(
                    "X has values of `{name}` outside its range in the design, {low} to {high}: these points are simulated \
                     nevertheless; widen the range if they are meant"
                );
                warn(py, &py.get_type::<StudyWarning>(), &message)?;
            }
        }
        Ok(())
    }
}

#[pymethods]
impl Function {
    /// Names of the factors, the columns of X.
    #[getter]
    fn factors(&self) -> Vec<String> {
        self.factors.clone()
    }

    /// Names of the outputs, the columns of Y.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.outputs.clone()
    }

    /// The range of each factor: its ends in the design.
    #[getter]
    fn bounds(&self) -> Vec<(f64, f64)> {
        let all = self.ready.engine.study().factors();
        let of = |name: &String| all.iter().find(|factor| factor.name == *name);
        self.factors.iter().filter_map(of).map(ends).map(Option::unwrap_or_default).collect()
    }

    /// The outputs at the points of X, computed on several threads.
    fn __call__<'py>(&self, py: Python<'py>, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let numpy = py.import("numpy").map_err(|error| {
            PyImportError::new_err(format!("{error}: functions over arrays need NumPy: run `pip install numpy`"))
        })?;
        let x = match columns(x, &self.factors)? {
            Some(columns) => {
                let columns = columns.iter().map(|column| unmasked(&numpy, column));
                let columns = PyList::new(py, columns.collect::<PyResult<Vec<_>>>()?)?;
                match columns.is_empty() {
                    true => numpy.call_method1("empty", ((1, 0),))?,
                    false => numpy.call_method1("stack", (columns, -1))?,
                }
            }
            None => unmasked(&numpy, x)?,
        };
        let array = numpy.call_method1("ascontiguousarray", (x, "float64"))?;
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let width = self.factors.len();
        if shape.last() != Some(&width) || shape.len() > 2 {
            let names = self.factors.join(", ");
            let message =
                format!("X has the shape {shape:?}, expected ({width},) or (points, {width}): columns {names}");
            return Err(PyValueError::new_err(message));
        }
        let x = PyBuffer::<f64>::get(&array)?.to_vec(py)?;
        let rows = shape.first().copied().filter(|_| shape.len() == 2).unwrap_or(1);
        self.warn_outside(py, &x)?;
        let task = Task {
            ready: Arc::clone(&self.ready),
            factors: self.factors.clone(),
            fixed: self.fixed.clone(),
            x,
            rows,
            places: self.places.clone(),
            threads: self.threads,
        };
        let found = Work::new(move |stop| task.run(stop)).wait(py)?.map_err(|error| error.raise(py))?;
        let outputs = Some(self.places.len()).filter(|_| !self.single);
        let shape: Vec<usize> = Some(rows).filter(|_| shape.len() == 2).into_iter().chain(outputs).collect();
        let bytes = PyByteArray::new(py, bytemuck::cast_slice(&found));
        let flat = numpy.call_method1("frombuffer", (bytes, "float64"))?;
        match shape.as_slice() {
            [] => flat.call_method1("item", (0,)),
            shape => flat.call_method1("reshape", (PyTuple::new(py, shape)?,)),
        }
    }

    /// Other processes make the function from the study's file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Handed,))> {
        let fixed = self.fixed.iter().map(|(name, value)| Ok((name.clone(), object(py, value)?)));
        let fixed = fixed.collect::<PyResult<_>>()?;
        let (factors, outputs) = (self.factors.clone(), self.outputs.clone());
        let handed = (self.origin.clone(), factors, fixed, outputs, self.single, self.threads);
        Ok((py.import("decore._decore")?.getattr("_function")?, (handed,)))
    }

    fn __repr__(&self) -> String {
        format!("<decore.Function ({}) -> ({})>", self.factors.join(", "), self.outputs.join(", "))
    }
}

/// A function as another process gets it: origin of the study, factors, fixed values, outputs, single, threads.
type Handed = (Origin, Vec<String>, Vec<(String, Py<PyAny>)>, Vec<String>, bool, usize);

/// A function that comes from another process.
///
/// # Errors
/// `StudyError` where the study's files are not what they were.
#[pyfunction]
#[pyo3(name = "_function")]
pub fn unpickled(py: Python<'_>, handed: Handed) -> PyResult<Function> {
    let (origin, factors, fixed, outputs, single, threads) = handed;
    let ready = Study::ready_again(py, &origin)?;
    let fixed = fixed.into_iter().map(|(name, own)| Ok((name, value(own.bind(py))?))).collect::<PyResult<_>>()?;
    let place = |name: String| Study::place(&ready, &name).map(|place| (name, place));
    let outputs = outputs.into_iter().map(place).collect::<Result<_, _>>().map_err(|error| error.raise(py))?;
    Function::new(py, (&ready, origin), Definition { factors, fixed, outputs, single, threads })
}

/// Numbers of a NumPy array, with masked ones as NaN: NumPy would pass on the values below the mask.
fn unmasked<'py>(numpy: &Bound<'py, PyModule>, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let masked = numpy.getattr("ma")?;
    match masked.call_method1("isMaskedArray", (x,))?.is_truthy()? {
        true => masked.call_method1("filled", (x.call_method1("astype", ("float64",))?, f64::NAN)),
        false => numpy.call_method1("asarray", (x, "float64")),
    }
}

/// Points to be simulated.
struct Task {
    ready: Arc<Ready>,
    factors: Vec<String>,
    fixed: Vec<(String, Value)>,
    /// A value per factor, point by point.
    x: Vec<f64>,
    /// Points.
    rows: usize,
    places: Vec<usize>,
    threads: usize,
}

impl Task {
    /// Outputs point by point; after a stop the remaining ones are skipped.
    fn run(&self, stop: &AtomicBool) -> Result<Vec<f64>, EngineError> {
        let engine = &self.ready.engine;
        let (places, points): (Vec<usize>, Vec<Vec<Level>>) =
            (0..self.rows).filter_map(|row| Some((row, self.levels(row)?))).unzip();
        let outcomes = match points.as_slice() {
            // No other thread is worth its start.
            [only] => vec![engine.outcome_at(only)],
            points => engine.outcomes_at(points, self.threads, stop)?.unwrap_or_default(),
        };
        let width = self.places.len();
        let mut found = vec![f64::NAN; self.rows * width];
        for ((row, levels), outcome) in places.into_iter().zip(points).zip(outcomes) {
            let record = self.ready.record(&Asked::Point(levels), outcome);
            let source = Source::new(&self.ready.info, &record);
            let column = |place: &usize| self.ready.columns.runs.get(*place);
            let cells = self.places.iter().filter_map(column).map(|column| column.cell(&source));
            for (found, cell) in found.iter_mut().skip(row * width).zip(cells) {
                *found = cell.and_then(|value| value.number()).unwrap_or(f64::NAN);
            }
        }
        Ok(found)
    }

    /// Levels of the factors at a point; `None` if a factor does not take its value, the only possible error after [`Definition::check`].
    fn levels(&self, row: usize) -> Option<Vec<Level>> {
        let width = self.factors.len();
        let own = self.x.get(row * width..(row + 1) * width)?;
        let own = self.factors.iter().zip(own).map(|(name, x)| (name.clone(), Value::Real(*x)));
        let given: Vec<(String, Value)> = own.chain(self.fixed.iter().cloned()).collect();
        self.ready.engine.checked().levels(&given).ok()
    }
}
