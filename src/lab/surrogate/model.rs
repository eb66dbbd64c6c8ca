//! A surrogate with all its predictors.

use super::error::SurrogateError;
use super::result::{OutputSurrogate, ProcessFigures, Surrogate};
use decore_dataset::DatasetInfo;
use decore_statistics::regression::{GaussianProcess, Hyperparameters, Kernel, Points, Residuals, Spread, Success};

/// A surrogate of a dataset, ready to predict.
#[derive(Debug, Clone)]
pub struct Model {
    /// Figures of the models.
    pub surrogate: Surrogate,
    /// The study that its rows are of.
    pub info: DatasetInfo,
    /// Index of each row in the design.
    pub rows: Vec<u64>,
    /// The rows' places.
    pub points: Points,
    /// For each output of the surrogate its processes.
    pub outputs: Vec<OutputModel>,
}

/// The processes of an output.
#[derive(Debug, Clone, Default)]
pub struct OutputModel {
    /// Of the output; `None` if it is refused.
    pub process: Option<RowsProcess>,
    /// Of 1 and -1; `None` if the probability of success is the same everywhere.
    pub success: Option<RowsProcess>,
    /// Value of a constant output, which has no process. Not stored in files.
    pub constant: Option<f64>,
}

/// A process of some of the rows, one for each place.
#[derive(Debug, Clone)]
pub struct RowsProcess {
    /// The first row at each place, by its place in the model.
    pub rows: Vec<usize>,
    /// The mean of the runs at each place.
    pub values: Vec<f64>,
    /// The process.
    pub process: GaussianProcess,
}

impl Model {
    /// Rows that an output is modelled from, by their places in the model: the first at each place.
    pub(super) fn used(outputs: &[OutputModel], rows: usize) -> Vec<usize> {
        let modelled = |row: &usize| {
            let mut processes = outputs.iter().filter_map(|output| output.process.as_ref());
            processes.any(|process| process.rows.binary_search(row).is_ok())
        };
        (0..rows).filter(modelled).collect()
    }

    /// Refuses a model that predicts nothing.
    ///
    /// # Errors
    /// [`SurrogateError::Empty`].
    pub fn check(&self) -> Result<(), SurrogateError> {
        if self.outputs.iter().any(|output| output.process.is_some()) {
            return Ok(());
        }
        let reason = |output: &OutputSurrogate| {
            format!("`{}`: {}", output.output, output.refused.as_deref().unwrap_or("it has no rows"))
        };
        Err(SurrogateError::Empty { reasons: self.surrogate.outputs.iter().map(reason).collect() })
    }
}

impl OutputModel {
    /// Probability that a row has the output; `None` if all rows have it.
    pub fn success_of(&self, output: &OutputSurrogate) -> Option<Success> {
        let figures = output.success.as_ref()?;
        Some(match (&self.success, figures.scaling) {
            (Some(of), Some(scaling)) => Success::ByPlace { process: Box::new(of.process.clone()), scaling },
            _ => Success::Everywhere(figures.everywhere.unwrap_or(figures.share)),
        })
    }
}

impl RowsProcess {
    /// A process of rows that have these places in the model.
    pub(super) fn new(process: GaussianProcess, rows: &[usize]) -> Self {
        let places = process.places();
        let first = places.first().iter().map(|place| rows[*place]).collect();
        Self { rows: first, values: places.values().to_vec(), process }
    }

    /// Figures of the process. `folds`: errors of left-out rows with a new fit.
    pub(super) fn figures(&self, folds: Option<&Residuals>, level: f64) -> ProcessFigures {
        let process = &self.process;
        let of = process.hyperparameters();
        ProcessFigures {
            kernel: process.kernel().name().to_owned(),
            weights: of.weights.clone(),
            noise: of.noise,
            spread: of.spread,
            run_squares: process.places().spread().squares,
            run_freedom: process.places().spread().freedom,
            mean: process.mean(),
            variance: process.variance(),
            noise_std_dev: process.noise_std_dev(),
            places: process.places().values().len() as u64,
            groups: process.groups().len() as u64,
            q2: process.residuals().q2(),
            q2_folds: folds.map(Residuals::q2),
            rms_error: process.residuals().rms(),
            reach: folds.unwrap_or(process.residuals()).reach(level),
        }
    }
}

impl ProcessFigures {
    /// Whether all are numbers: squares of very large or very small values are none.
    pub(super) fn are_finite(&self) -> bool {
        let of = [self.mean, self.variance, self.noise_std_dev, self.q2, self.rms_error, self.reach];
        of.into_iter().chain(self.q2_folds).all(f64::is_finite)
    }

    /// Noise of a single run, from runs at the same place.
    pub(super) fn evidence(&self) -> Spread {
        Spread { squares: self.run_squares, freedom: self.run_freedom }
    }

    /// Kernel, lengths and noise; `None` for a kernel of another name.
    pub(super) fn hyperparameters(&self) -> Option<(Kernel, Hyperparameters)> {
        let kernel = Kernel::ALL.into_iter().find(|kernel| kernel.name() == self.kernel)?;
        Some((kernel, Hyperparameters { weights: self.weights.clone(), noise: self.noise, spread: self.spread }))
    }
}
