//! Goals for which rows are proposed.

use std::str::FromStr;

use super::acquisition::Side;

/// Goal for which rows are proposed.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// Models of outputs that predict rows not run.
    Learn {
        /// Outputs with their aims.
        targets: Vec<Target>,
    },
    /// The row with the best value of an output among those within the limits.
    Optimise {
        /// Column of `runs`.
        output: String,
        /// Whether the most or the least is sought.
        side: Side,
        /// Limits of outputs.
        limits: Vec<Limit>,
        /// Expected improvement, in the column's unit, below which it is reached; `None`: never.
        gain: Option<f64>,
    },
    /// Boundary of a limit.
    Bound {
        /// The limit.
        limit: Limit,
        /// Share of the places whose side may remain uncertain.
        unsure: f64,
    },
    /// Boundary between rows that are done and rows that fail.
    Separate {
        /// Share of the places whose side may remain uncertain.
        unsure: f64,
    },
}

/// An output to predict.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Column of `runs`.
    pub output: String,
    /// Aim of the prediction.
    pub aim: Aim,
}

/// Aim of a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// Q2 is at least this value.
    Q2(f64),
    /// The 95 % intervals of new rows are at most this wide, on average over the ranges of the factors, in the column's unit.
    Width(f64),
}

impl Goal {
    /// The columns that have to be modelled.
    pub fn outputs(&self) -> Vec<String> {
        match self {
            Self::Learn { targets } => targets.iter().map(|target| target.output.clone()).collect(),
            Self::Bound { limit, .. } => vec![limit.output.clone()],
            Self::Separate { .. } => Vec::new(),
            Self::Optimise { output, limits, .. } => {
                let mut names = vec![output.clone()];
                for limit in limits {
                    if !names.contains(&limit.output) {
                        names.push(limit.output.clone());
                    }
                }
                names
            }
        }
    }
}

/// Limit of an output: `NAME<=VALUE` or `NAME>=VALUE`.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// Column of `runs`.
    pub output: String,
    /// Side of the limit: at most, or at least the value.
    pub side: Side,
    /// The value, in the column's unit.
    pub value: f64,
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected NAME<=VALUE or NAME>=VALUE, e.g. max_casting_point_velocity_m_s<=1.5".to_owned();
        let (side, (output, value)) = match (text.split_once("<="), text.split_once(">=")) {
            (Some(parts), None) => (Side::Least, parts),
            (None, Some(parts)) => (Side::Most, parts),
            _ => return Err(wrong()),
        };
        let value = value.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong)?;
        let output = output.trim().to_owned();
        if output.is_empty() { Err(wrong()) } else { Ok(Self { output, side, value }) }
    }
}

impl Limit {
    /// Whether a value is within it; NaN is not.
    pub fn holds(&self, value: f64) -> bool {
        match self.side {
            Side::Least => value <= self.value,
            Side::Most => value >= self.value,
        }
    }
}
