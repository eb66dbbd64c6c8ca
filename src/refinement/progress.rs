//! How far a goal is reached: plain data, the same in text and JSON.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::acquisition::Beside;
use crate::sensitivity::four_digits;

/// How far a goal is reached.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Progress {
    /// Name of the study.
    pub study: String,
    /// Rows of the design, all of which are run.
    pub rows: u64,
    /// Rows of them that failed, where the boundary to those is sought; null otherwise.
    pub failed: Option<u64>,
    /// The outputs that are modelled; none where it is sought where rows fail.
    pub outputs: Vec<OutputProgress>,
    /// The best row within the limits; null where none is, or none is sought.
    pub best: Option<Best>,
    /// Largest expected improvement of the best row by a run, times its probability to be within the limits, in the output's unit;
    /// null without a best row.
    pub gain: Option<f64>,
    /// Where the limit is passed or rows begin to fail; null where neither is sought.
    pub boundary: Option<Boundary>,
    /// Whether all that was asked for is reached.
    pub reached: bool,
}

/// How well an output is known.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OutputProgress {
    /// Column of `runs`.
    pub output: String,
    /// Its unit.
    pub unit: String,
    /// Rows that have it.
    pub used: u64,
    /// Share of the variance that is predicted of rows left out: the smaller of that one at a time and that of a tenth at a time.
    pub q2: f64,
    /// Width of the 95 % intervals of new rows, on average over the ranges of the factors, in the output's unit.
    pub width: f64,
}

/// The best row so far.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Best {
    /// Its index in the design.
    pub row: u64,
    /// What it gave.
    pub value: f64,
    /// What the model expects there of a run.
    pub expected: f64,
    /// Standard deviation of that expectation, noise included.
    pub std_dev: f64,
}

/// Where a limit is passed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Boundary {
    /// Share of the ranges of the factors that is within the limit, or where rows succeed, as the model expects.
    pub within: f64,
    /// Share that the model takes for the wrong side, as it expects itself.
    pub unsure: f64,
}

impl Progress {
    /// Of rows of which nothing else is said yet.
    pub(super) fn new(study: String, rows: u64) -> Self {
        Self { study, rows, failed: None, outputs: Vec::new(), best: None, gain: None, boundary: None, reached: false }
    }
}

impl Boundary {
    /// Of places all over the ranges.
    pub(super) fn new(places: &[Beside]) -> Self {
        let mean = |of: &dyn Fn(&Beside) -> f64| places.iter().map(of).sum::<f64>() / places.len() as f64;
        Self { within: mean(&|at| at.within), unsure: mean(&|at| at.within.min(1.0 - at.within)) }
    }
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} rows", self.rows)?;
        if let Some(failed) = self.failed {
            write!(f, ", {failed} of which failed")?;
        }
        for OutputProgress { output, unit, used, q2, width } in &self.outputs {
            let from = if *used == self.rows { String::new() } else { format!(" (from {used} rows)") };
            let (width, unit) = (four_digits(*width), spaced(unit));
            write!(f, "\n  {output}{from}: Q2 {q2:.3}, 95 % intervals {width}{unit} wide")?;
        }
        if let (Some(best), Some(output)) = (&self.best, self.outputs.first()) {
            let [value, expected, std_dev] = [best.value, best.expected, best.std_dev].map(four_digits);
            let (row, unit) = (best.row, spaced(&output.unit));
            write!(f, "\n  best row {row}: {value}{unit}, where the model expects {expected} +- {std_dev}{unit}")?;
            if let Some(gain) = self.gain {
                write!(f, "; a run may improve it by {}{unit}", four_digits(gain))?;
            }
        }
        if let Some(Boundary { within, unsure }) = self.boundary {
            let [within, unsure] = [within, unsure].map(|share| 100.0 * share);
            let what = if self.failed.is_some() { "rows succeed in" } else { "within the limit" };
            write!(f, "\n  {what} {within:.1} % of the ranges, on the wrong side {unsure:.2} %")?;
        }
        Ok(())
    }
}

fn spaced(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}
