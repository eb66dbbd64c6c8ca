//! What an analysis finds: plain data, the same in text, JSON and Parquet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::Estimator;
use crate::quantity::named;

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
    /// What was computed.
    pub method: Method,
    /// How intervals were found.
    pub intervals: Intervals,
    /// What a reader must know, a sentence each.
    pub notes: Vec<String>,
    /// The outputs, as asked for.
    pub outputs: Vec<OutputSensitivity>,
}

/// What is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case", tag = "name")]
pub enum Method {
    /// Sobol' indices from the blocks of a Saltelli design.
    Sobol {
        /// How they are estimated.
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

/// How intervals are found.
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
    /// Its unit.
    pub unit: String,
    /// What it is, in words.
    pub description: String,
    /// The rows that were used.
    pub used: Used,
    /// Why there are no indices; null where there are.
    pub refused: Option<String>,
    /// The indices, by factor in the study's order.
    pub indices: Vec<Index>,
}

/// The rows that went into the indices of an output.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Used {
    /// What rows belong together as.
    pub unit: UnitName,
    /// Units all of whose rows have the output: only these are used.
    pub whole: u64,
    /// Units of the design.
    pub of: u64,
    /// Why the others are not whole.
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
    /// Status and reason of the rows, or what their output is.
    pub reason: String,
    /// Number of rows.
    pub count: u64,
    /// The first of the rows; none of rows that are not there.
    pub rows: Vec<u64>,
}

/// An index of a factor or a pair of factors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Index {
    /// Which index.
    pub index: IndexName,
    /// The factor, or the two factors of a pair.
    pub factors: Vec<String>,
    /// Its value; null where it has none.
    pub value: Option<f64>,
    /// Ends of its interval; null where there is none.
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
        /// Share of the variance that a pair of factors has beyond what each has alone.
        S2 = "s2",
        /// Mean size of the elementary effects, per range of the factor; in the output's unit.
        MuStar = "mu_star",
        /// Mean elementary effect, per range of the factor; in the output's unit.
        Mu = "mu",
        /// Standard deviation of the elementary effects; in the output's unit.
        Sigma = "sigma",
        /// Shapley effect: share of the variance; those of all factors add up to 1, also where factors depend on each other.
        Shapley = "shapley",
        /// First-order Sobol' index by ranks.
        Rank = "rank",
        /// Correlation ratio of classes of the factor.
        CorrelationRatio = "correlation_ratio",
        /// PAWN: median distance of the output's distributions in slices of the factor from that of all rows.
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
    /// Width of the widest interval of a factor's share (S1, ST, Shapley effect, S1 by ranks), or of a mu* over the largest mu* of
    /// its output; `None` where there is none.
    pub fn widest_interval(&self) -> Option<f64> {
        self.outputs.iter().flat_map(OutputSensitivity::widths).reduce(f64::max)
    }
}

impl OutputSensitivity {
    fn widths(&self) -> impl Iterator<Item = f64> {
        let sizes = self.indices.iter().filter(|index| index.index == IndexName::MuStar);
        let largest = sizes.filter_map(|index| index.value).fold(0.0, f64::max);
        self.indices.iter().filter_map(move |index| {
            let [low, high] = index.interval?;
            match index.index {
                IndexName::S1 | IndexName::St | IndexName::Shapley | IndexName::Rank => Some(high - low),
                IndexName::MuStar => Some((high - low) / largest),
                _ => None,
            }
        })
    }
}

impl IndexName {
    /// Its symbol in texts.
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
    /// Its name, in the plural.
    pub fn plural(self) -> &'static str {
        match self {
            Self::Blocks => "blocks",
            Self::Trajectories => "trajectories",
            Self::Rows => "rows",
        }
    }
}
