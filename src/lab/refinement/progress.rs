//! Progress towards a goal: plain data, equal in text and JSON.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::acquisition::LimitSide;
use crate::sensitivity::four_digits;

/// Progress towards a goal.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Progress {
    /// Name of the study.
    pub study: String,
    /// Number of rows of the design; all have run.
    pub rows: u64,
    /// Number of failed rows, for the goal `failures`; null otherwise.
    pub failed: Option<u64>,
    /// Number of failed rows whose values describe no feasible scene; such places do not count in the shares of `boundary`. Null if
    /// `failed` is.
    pub without_scene: Option<u64>,
    /// The outputs that are modelled; none if it is sought where rows fail.
    pub outputs: Vec<OutputProgress>,
    /// Rows that are within all limits; null if no optimum is sought.
    pub rows_within: Option<u64>,
    /// The best row within the limits; null if none is, or none is sought.
    pub best: Option<Best>,
    /// Largest expected improvement of the best row by a run, times its probability to be within the limits, in the output's unit; null
    /// without a best row. It comes from the model that chooses rows, whose noise may be as small as 1e-10; the noise of `decore surrogate`
    /// is at least 1e-6.
    pub gain: Option<f64>,
    /// Boundary of the limit or of failures; null for other goals.
    pub boundary: Option<Boundary>,
    /// Notes on the models, a sentence each, as printed by `decore surrogate`.
    pub notes: Vec<String>,
    /// Whether all requested aims are reached.
    pub reached: bool,
    /// Whether the goal is not reached, and no place is left for a further row: all feasible places are rows already, or too near to one.
    pub exhausted: bool,
}

/// Progress of an output.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OutputProgress {
    /// Column of `runs`.
    pub output: String,
    /// Unit.
    pub unit: String,
    /// Rows that have it.
    pub used: u64,
    /// Value of an output that is the same in all rows, and needs no model: its Q2 is 1 and its intervals are 0 wide; otherwise null.
    pub constant: Option<f64>,
    /// Share of the variance that is predicted for left-out rows: the smaller of both figures of `decore surrogate`, for one row at a time
    /// and for a tenth.
    pub q2: f64,
    /// Width of the 95 % intervals of new rows, on average over the ranges of the factors, in the output's unit.
    pub width: f64,
}

/// The best row so far.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Best {
    /// Index in the design.
    pub row: u64,
    /// Result of the run.
    pub value: f64,
    /// Expectation of the model of `decore surrogate` for a run there.
    pub expected: f64,
    /// Standard deviation of that expectation, noise included.
    pub std_dev: f64,
}

/// Boundary of a limit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Boundary {
    /// Expected share of the feasible places that are within the limit, or where rows succeed. Feasible places are in the ranges of the
    /// factors, meet all constraints and describe a scene.
    pub within: f64,
    /// Share of them that the model takes for the wrong side, as it expects itself.
    pub unsure: f64,
}

impl Progress {
    /// New progress with this number of rows.
    pub(super) fn new(study: String, rows: u64) -> Self {
        Self {
            study,
            rows,
            failed: None,
            without_scene: None,
            outputs: Vec::new(),
            rows_within: None,
            best: None,
            gain: None,
            boundary: None,
            notes: Vec::new(),
            reached: false,
            exhausted: false,
        }
    }
}

impl Boundary {
    /// Of places all over the ranges.
    pub(super) fn new(places: &[LimitSide]) -> Self {
        let mean = |of: &dyn Fn(&LimitSide) -> f64| places.iter().map(of).sum::<f64>() / places.len() as f64;
        Self { within: mean(&|at| at.within), unsure: mean(&|at| at.within.min(1.0 - at.within)) }
    }
}

impl fmt::Display for OutputProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = spaced(&self.unit);
        match self.constant {
            Some(value) => write!(f, "{}{unit} in all rows that have it", four_digits(value)),
            None => write!(f, "Q2 {:.3}, 95 % intervals {}{unit} wide", self.q2, four_digits(self.width)),
        }
    }
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} rows", self.rows)?;
        if let Some(failed) = self.failed {
            write!(f, ", {failed} of which failed")?;
        }
        if let Some(without_scene @ 1..) = self.without_scene {
            write!(f, " ({without_scene} describe no scene)")?;
        }
        for output in &self.outputs {
            let from = if output.used == self.rows { String::new() } else { format!(" (from {} rows)", output.used) };
            write!(f, "\n  {}{from}: {output}", output.output)?;
        }
        if self.rows_within == Some(0) {
            write!(f, "\n  no row is within all limits")?;
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
            write!(
                f,
                "\n  {what} {within:.1} % of the places that meet the constraints and describe a scene, on the wrong side {unsure:.2} %"
            )?;
        }
        self.notes.iter().try_for_each(|note| write!(f, "\n  {note}"))
    }
}

fn spaced(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_say_what_they_count() {
        let mut progress = Progress::new("a".to_owned(), 40);
        (progress.failed, progress.without_scene) = (Some(7), Some(6));
        progress.boundary = Some(Boundary { within: 0.999, unsure: 0.001 });
        assert_eq!(
            progress.to_string(),
            "40 rows, 7 of which failed (6 describe no scene)\n  rows succeed in 99.9 % of the places that meet the constraints and \
             describe a scene, on the wrong side 0.10 %"
        );
        (progress.failed, progress.without_scene) = (None, None);
        assert!(progress.to_string().contains("\n  within the limit 99.9 % of the places that meet the constraints"));
    }
}
