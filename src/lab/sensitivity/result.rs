//! Result of an analysis: plain data, equal in text, JSON and Parquet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use decore_quantity::named;
use decore_statistics::analysis::{Estimator, shapley_rows};

/// Sensitivity of the outputs of a dataset to its factors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Sensitivity {
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
    /// The factors that are compared, in the study's order.
    pub factors: Vec<String>,
    /// Method of the analysis.
    pub method: Method,
    /// Method of the intervals.
    pub intervals: Intervals,
    /// Notes for the reader, a sentence each.
    pub notes: Vec<String>,
    /// The outputs, as requested.
    pub outputs: Vec<OutputSensitivity>,
}

/// Kind of indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case", tag = "name")]
pub enum Method {
    /// Sobol' indices from the blocks of a Saltelli design.
    Sobol {
        /// Estimator of the indices.
        estimator: Estimator,
        /// Rows of a block.
        block: usize,
    },
    /// Elementary effects from Morris trajectories.
    Morris {
        /// Levels of the grid.
        levels: u64,
        /// Rows of a trajectory.
        block: usize,
    },
    /// Indices that any rows have.
    Given,
}

/// Method of the intervals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Intervals {
    /// Bootstrap replicates, or halves of the rows; 0: there are no intervals.
    pub replicates: usize,
    /// Seed of the replicates.
    pub seed: u64,
    /// Probability of an interval.
    pub level: f64,
}

/// Sensitivity of one output.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OutputSensitivity {
    /// Name of the column.
    pub output: String,
    /// Unit.
    pub unit: String,
    /// Description in words.
    pub description: String,
    /// The rows that were used.
    pub used: Used,
    /// Reason why there are no indices; null if there are.
    pub refused: Option<String>,
    /// Notes on these indices: factors without indices, missing intervals.
    pub notes: Vec<String>,
    /// The indices, by factor in the study's order.
    pub indices: Vec<Index>,
}

/// The rows that went into the indices of an output.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Used {
    /// Unit of rows that belong together.
    pub unit: UnitName,
    /// Units all of whose rows have the output: only these are used.
    pub whole: u64,
    /// Units of the design.
    pub of: u64,
    /// Reasons why the others are incomplete.
    pub left_out: Vec<LeftOut>,
}

/// Rows that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UnitName {
    /// Blocks of a Saltelli design.
    Blocks,
    /// Morris trajectories.
    Trajectories,
    /// Rows by themselves.
    Rows,
}

/// Rows without the output, for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOut {
    /// Status and reason of the rows, or the state of their output.
    pub reason: String,
    /// Number of rows.
    pub count: u64,
    /// The first of the rows; none of rows that are not there.
    pub rows: Vec<u64>,
}

/// An index of a factor or a pair of factors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Index {
    /// Kind of index.
    pub index: IndexName,
    /// The factor, or the two factors of a pair.
    pub factors: Vec<String>,
    /// Value; null if there is none.
    pub value: Option<f64>,
    /// Ends of its interval; null if there is none.
    pub interval: Option<[f64; 2]>,
}

named! {
    /// The indices.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
    pub enum IndexName {
        /// Share of the variance that a factor has alone.
        S1 = "s1",
        /// Share of the variance that a factor has alone or together with others.
        St = "st",
        /// Share of the variance due to a pair of factors beyond each alone.
        S2 = "s2",
        /// Mean size of the elementary effects, per range of the factor; in the output's unit.
        MuStar = "mu_star",
        /// Mean elementary effect, per range of the factor; in the output's unit.
        Mu = "mu",
        /// Standard deviation of the elementary effects; in the output's unit.
        Sigma = "sigma",
        /// Shapley effect: share of the variance. The effects of all factors add up to 1, also if factors depend on each other.
        Shapley = "shapley",
        /// First-order Sobol' index by ranks.
        Rank = "rank",
        /// Correlation ratio of classes of the factor.
        CorrelationRatio = "correlation_ratio",
        /// PAWN: median distance between the output's distributions in slices of the factor and over all rows.
        Pawn = "pawn",
        /// The largest of these distances.
        PawnMaximum = "pawn_maximum",
        /// Normalised Hilbert-Schmidt independence criterion.
        HsicR2 = "hsic_r2",
        /// Probability of a larger criterion were factor and output independent.
        HsicPValue = "hsic_p_value",
    }
}

impl Sensitivity {
    /// Widths of the intervals of the factors.
    pub fn widths(&self) -> Widths {
        let widest = |settled: bool| {
            let all = self.outputs.iter().flat_map(move |output| output.widths(settled));
            all.flatten().reduce(f64::max)
        };
        let bare = |output: &&OutputSensitivity| {
            let mut widths = output.widths(false).peekable();
            widths.peek().is_none() || widths.any(|width| width.is_none())
        };
        let without = self.outputs.iter().filter(bare).map(|output| output.output.clone()).collect();
        Widths { widest: widest(false), settled: widest(true), without }
    }
}

/// Widths of the intervals of shares of factors (S1, ST, Shapley effects, S1 by ranks, or else eta2), or of mu* relative to the output's
/// largest mu*.
#[derive(Debug, Clone, PartialEq)]
pub struct Widths {
    /// Widest interval that more rows would narrow; `None` if there is none.
    pub widest: Option<f64>,
    /// The widest of Shapley effects that come of as many rows as they ever do.
    pub settled: Option<f64>,
    /// Outputs that lack such intervals, some or all.
    pub without: Vec<String>,
}

impl OutputSensitivity {
    /// Widths of the intervals that count, `None` of a missing one: of the Shapley effects that more rows do not narrow, or of all
    /// others.
    fn widths(&self, settled: bool) -> impl Iterator<Item = Option<f64>> {
        let count = |name: IndexName| self.indices.iter().filter(|index| index.index == name).count();
        let (shapley, by_ranks) = (count(IndexName::Shapley), count(IndexName::Rank) > 0);
        let is_settled = self.used.whole >= shapley_rows(shapley) as u64;
        let sizes = self.indices.iter().filter(|index| index.index == IndexName::MuStar);
        let largest = sizes.filter_map(|index| index.value).fold(0.0, f64::max);
        self.indices.iter().filter_map(move |index| {
            let width = index.interval.map(|[low, high]| high - low);
            match index.index {
                IndexName::Shapley if is_settled => settled.then_some(width),
                _ if settled => None,
                IndexName::S1 | IndexName::St | IndexName::Shapley | IndexName::Rank => Some(width),
                IndexName::CorrelationRatio if !by_ranks => Some(width),
                IndexName::MuStar => Some(width.map(|width| width / largest)),
                _ => None,
            }
        })
    }
}

impl IndexName {
    /// Whether intervals are found for it.
    pub fn has_interval(self) -> bool {
        !matches!(self, Self::Pawn | Self::PawnMaximum | Self::HsicR2 | Self::HsicPValue)
    }

    /// Symbol in texts.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::S1 => "S1",
            Self::St => "ST",
            Self::S2 => "S2",
            Self::MuStar => "mu*",
            Self::Mu => "mu",
            Self::Sigma => "sigma",
            Self::Shapley => "Shapley",
            Self::Rank => "S1 by ranks",
            Self::CorrelationRatio => "eta2",
            Self::Pawn => "PAWN",
            Self::PawnMaximum => "largest",
            Self::HsicR2 => "R2-HSIC",
            Self::HsicPValue => "p",
        }
    }
}

impl UnitName {
    /// Name in the plural.
    pub fn plural(self) -> &'static str {
        match self {
            Self::Blocks => "blocks",
            Self::Trajectories => "trajectories",
            Self::Rows => "rows",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(name: &str, whole: u64, indices: &[(IndexName, Option<f64>)]) -> OutputSensitivity {
        let index = |(index, width): &(IndexName, Option<f64>)| Index {
            index: *index,
            factors: vec!["x".into()],
            value: Some(0.5),
            interval: width.map(|width| [0.5 - width / 2.0, 0.5 + width / 2.0]),
        };
        OutputSensitivity {
            output: name.into(),
            unit: "1".into(),
            description: String::new(),
            used: Used { unit: UnitName::Rows, whole, of: whole, left_out: Vec::new() },
            refused: None,
            notes: Vec::new(),
            indices: indices.iter().map(index).collect(),
        }
    }

    fn widths(outputs: Vec<OutputSensitivity>) -> Widths {
        Sensitivity {
            study: String::new(),
            study_hash: String::new(),
            program_version: String::new(),
            rows: 0,
            rows_there: 0,
            factors: vec!["x".into()],
            method: Method::Given,
            intervals: Intervals { replicates: 100, seed: 0, level: 0.95 },
            notes: Vec::new(),
            outputs,
        }
        .widths()
    }

    #[test]
    fn shapley_effects_widen_growth_as_long_as_more_rows_narrow_them() {
        let indices =
            [(IndexName::Shapley, Some(0.5)), (IndexName::Rank, Some(0.25)), (IndexName::CorrelationRatio, Some(0.75))];
        let few = widths(vec![output("y", 1999, &indices)]);
        assert_eq!((few.widest, few.settled), (Some(0.5), None));
        let many = widths(vec![output("y", 2000, &indices)]);
        assert_eq!((many.widest, many.settled), (Some(0.25), Some(0.5)));
        // Where there are none by ranks, the correlation ratio counts.
        assert_eq!(widths(vec![output("y", 2000, &indices[2..])]).widest, Some(0.75));
    }

    #[test]
    fn outputs_without_intervals_are_named() {
        let whole = output("whole", 100, &[(IndexName::Rank, Some(0.125))]);
        let part = output("part", 100, &[(IndexName::Rank, Some(0.125)), (IndexName::Rank, None)]);
        let found = widths(vec![whole, part, output("none", 100, &[])]);
        assert_eq!((found.widest, found.without), (Some(0.125), vec!["part".to_owned(), "none".to_owned()]));
    }
}
