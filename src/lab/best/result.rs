//! The answer: recommended values, expected outputs and their confidence.

use schemars::JsonSchema;
use serde::Serialize;

use decore_quantity::Value;

/// Certainty of the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Runs held the limits at the stated confidence.
    Proven,
    /// Runs did not hold the limits at the stated confidence.
    Refuted,
    /// The models expect that the limits hold; no run checked it.
    Unchecked,
    /// The limits may hold somewhere, but the models are not sure enough.
    Unsure,
    /// The models expect that no decision holds the limits.
    Infeasible,
}

/// A value to choose.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Setting {
    /// Name of the factor.
    pub factor: String,
    /// First parameter that it drives; empty if it drives none.
    pub path: String,
    /// The value.
    pub value: Value,
    /// Unit; empty if there is none.
    pub unit: String,
}

/// Expectation of a value over the uncertain factors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// The value, as the goal states it.
    pub text: String,
    /// Unit; empty if there is none.
    pub unit: String,
    /// Expected value: mean of the checks, or of the model.
    pub mean: f64,
    /// Below it lie 2.5 % of the runs, scatter included.
    pub low: f64,
    /// Above it lie 2.5 % of the runs, scatter included.
    pub high: f64,
    /// Standard deviation of the model's error of the mean.
    pub model_error: f64,
}

/// A limit at the proposal.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LimitState {
    /// The limited value.
    pub text: String,
    /// Unit; empty if there is none.
    pub unit: String,
    /// Whether it must be at most the limit; at least otherwise.
    pub at_most: bool,
    /// The limit.
    pub limit: f64,
    /// The value that the stated share of runs holds: of the checks, or of the model with its error on the bad side.
    pub reached: f64,
    /// Whether it prevents a better goal: `reached` is within 5 % of the limit, or beyond.
    pub binds: bool,
}

/// Runs of a decision.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Proof {
    /// Number of runs.
    pub runs: usize,
    /// Runs that held all limits.
    pub held: usize,
    /// Runs that are not done, or lack a value.
    pub failed: usize,
    /// First and last row in the dataset of added rows.
    pub rows: [u64; 2],
}

/// A decision at another place, by its runs, otherwise by the models.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Alternative {
    /// Values to choose.
    pub settings: Vec<Setting>,
    /// Expected goal.
    pub goal: f64,
    /// Expected value of each limited output, in the order of the limits.
    pub reached: Vec<f64>,
    /// Share of the runs that hold all limits by the models, with their error on the bad side.
    pub share: f64,
    /// Runs that compared or checked it; null without any.
    pub proof: Option<Proof>,
}

/// Predicted gain of a relaxed limit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Looser {
    /// The limited value.
    pub text: String,
    /// The looser limit.
    pub limit: f64,
    /// Expected goal; null where still no decision holds the limits.
    pub goal: Option<f64>,
    /// Values to choose then.
    pub settings: Vec<Setting>,
}

/// Effect of a factor at the proposal, by the models.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Effect {
    /// Name of the factor.
    pub factor: String,
    /// Whether it can be chosen: then changes are over a tenth of its range to either side (of names, over all); otherwise between the 5 %
    /// and 95 % points of its distribution.
    pub decision: bool,
    /// Change of the expected goal.
    pub goal: f64,
    /// Change of each limited value, in the order of the limits.
    pub limits: Vec<f64>,
}

/// Remaining uncertainty of the goal: standard deviations in its unit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Uncertainty {
    /// From the uncertain factors.
    pub factors: f64,
    /// From the model's error of the expected value.
    pub model: f64,
    /// From scatter between runs.
    pub scatter: f64,
    /// Advice how to reduce it.
    pub advice: String,
}

/// The answer to a study's goal.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Answer {
    /// Name of the study.
    pub study: String,
    /// All in one sentence.
    pub sentence: String,
    /// Certainty of the answer.
    pub verdict: Verdict,
    /// Share of runs that must hold the limits.
    pub confidence: f64,
    /// Values to choose.
    pub settings: Vec<Setting>,
    /// Estimate of the goal there.
    pub goal: Estimate,
    /// State of the limits there.
    pub limits: Vec<LimitState>,
    /// Share of runs that hold all limits by the models, with their error on the bad side.
    pub share: f64,
    /// Runs that prove it; null without any.
    pub proof: Option<Proof>,
    /// Rows that the models are made from.
    pub rows: u64,
    /// Decisions at other places.
    pub alternatives: Vec<Alternative>,
    /// Gains of relaxed limits.
    pub looser: Vec<Looser>,
    /// Effect of each factor.
    pub factors: Vec<Effect>,
    /// Remaining uncertainty.
    pub uncertainty: Uncertainty,
    /// Notes for the reader, a sentence each.
    pub notes: Vec<String>,
}
