//! Figures of a surrogate: plain data, equal in text, JSON and the file of a model.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::space::FactorSpace;
use crate::sensitivity::LeftOut;

/// Models of the outputs of a dataset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Surrogate {
    /// Name of the study.
    pub study: String,
    /// Hash of the study.
    pub study_hash: String,
    /// Version of the program that wrote the dataset.
    pub program_version: String,
    /// Rows of the design.
    pub rows: u64,
    /// Rows that the dataset holds, whatever their status.
    pub rows_there: u64,
    /// The factors, in the study's order.
    pub factors: Vec<FactorSpace>,
    /// Largest distance from the nearest place of the rows, in scaled factors, within which a place counts as covered: 1.5 times the second
    /// largest distance between a place and its nearest one. Null in files of older models.
    #[serde(default)]
    pub covered_distance: Option<f64>,
    /// Q2 below which a model warns.
    pub least_q2: f64,
    /// Probability of an interval.
    pub level: f64,
    /// Notes for the reader, a sentence each.
    pub notes: Vec<String>,
    /// The outputs, as requested.
    pub outputs: Vec<OutputSurrogate>,
}

/// Models of one output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutputSurrogate {
    /// Name of the column.
    pub output: String,
    /// Unit.
    pub unit: String,
    /// Description in words.
    pub description: String,
    /// Rows that the model is made from.
    pub used: u64,
    /// Reasons why other rows were left out.
    pub left_out: Vec<LeftOut>,
    /// Reason why there is no model; null if there is one.
    pub refused: Option<String>,
    /// The Gaussian process.
    pub process: Option<ProcessFigures>,
    /// Polynomial chaos for comparison; null if there is none.
    pub chaos: Option<ChaosFigures>,
    /// Reason why there is no polynomial chaos, e.g. too few rows, or a term that depends on a single row; null if there is one.
    #[serde(default)]
    pub chaos_refused: Option<String>,
    /// The probability that a row has the output; null if all rows have it.
    pub success: Option<SuccessFigures>,
    /// Median of the standard deviations that the rows' twins showed, in the output's unit; null without twins.
    pub twin_scatter: Option<f64>,
}

/// A Gaussian process: `y = mean + z + e`, where `z` has the variance `variance` and correlations by the kernel, `e` is independent
/// noise of each place and of each run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProcessFigures {
    /// `matern_5_2` or `squared_exponential`.
    pub kernel: String,
    /// Inverse squared lengths of the factors, in their scaled ranges.
    pub weights: Vec<f64>,
    /// Variance of the noise at each place over `variance`.
    pub noise: f64,
    /// Variance of the noise of each run over `variance`, from runs at one place or twins; 0 without them, and in files of older models.
    #[serde(default)]
    pub spread: f64,
    /// Evidence for `spread`: the sum of squared deviations of runs from the means of their places, twins' scatter included.
    #[serde(default)]
    pub run_squares: f64,
    /// Degrees of freedom of that sum.
    #[serde(default)]
    pub run_freedom: f64,
    /// The mean.
    pub mean: f64,
    /// The variance of the process.
    pub variance: f64,
    /// Standard deviation of the noise, in the output's unit.
    pub noise_std_dev: f64,
    /// Places that it is fitted to: rows with the same factors are one, with the mean of their values. 0 in files of models from before
    /// rows were brought together.
    #[serde(default)]
    pub places: u64,
    /// Number of groups of places that are left out together, because they are nearly one with `weights`; equal to the number of places if
    /// all are separate. 0 in files of older models.
    #[serde(default)]
    pub groups: u64,
    /// Share of the variance that is predicted for left-out rows, one group at a time.
    pub q2: f64,
    /// The same with a tenth of the groups left out at a time (one at a time below 20 groups) and a new fit of lengths and noise: more
    /// reliable for few rows. Null for more than 320 rows, where it makes no difference.
    pub q2_folds: Option<f64>,
    /// Root mean square of the errors of left-out rows, one group at a time, in the output's unit.
    pub rms_error: f64,
    /// Standard deviations that an interval reaches to both sides.
    pub reach: f64,
}

/// A polynomial chaos.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChaosFigures {
    /// Total degree.
    pub degree: usize,
    /// Number of terms.
    pub terms: usize,
    /// Share of the variance that is predicted for left-out rows, one group of the process at a time.
    pub q2: f64,
}

/// Probability that a row has the output: `1 / (1 + exp(-(slope m + offset) / sqrt(1 + pi slope^2 s^2 / 8)))`, `m` and `s` the mean and
/// standard deviation of a Gaussian process of 1 and -1. Constant if there is no such process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SuccessFigures {
    /// Share of the rows that have the output.
    pub share: f64,
    /// The probability that holds everywhere; null if it depends on the place.
    pub everywhere: Option<f64>,
    /// The process of 1 and -1; null if there is none.
    pub process: Option<ProcessFigures>,
    /// Slope and offset; null without a process.
    pub scaling: Option<[f64; 2]>,
}

impl ProcessFigures {
    /// Smaller of both predicted shares; NaN if one is NaN, which is worse than any number.
    pub fn least_q2(&self) -> f64 {
        match self.q2_folds {
            Some(folds) if folds.is_nan() || folds < self.q2 => folds,
            _ => self.q2,
        }
    }
}

impl Surrogate {
    /// Returns warnings for every use: models that predict too little, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let of = |output: &OutputSurrogate| {
            let q2 = output.process.as_ref()?.least_q2();
            // NaN is no Q2 that is large enough.
            (q2.is_nan() || q2 < self.least_q2).then(|| {
                format!(
                    "the model of `{}` predicts {:.0} % of the variance of rows that it does not know (Q2 {q2:.3}, below {}): do not \
                     rely on it; more rows help, unless the noise is larger than the effects",
                    output.output,
                    100.0 * q2.max(0.0),
                    self.least_q2
                )
            })
        };
        self.outputs.iter().filter_map(of).collect()
    }
}
