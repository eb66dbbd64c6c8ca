//! Reasons why there is no answer.

use crate::surrogate::SurrogateError;
use decore_dataset::DatasetError;
use decore_statistics::design::DesignError;
use decore_statistics::regression::RegressionError;
use decore_study::StudyError;

/// Reason why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum BestError {
    /// A study that asks nothing.
    #[error(
        "the study has no goal: add, for example,\n\n  [goal]\n  maximise = \"delivered_work_j\"\n  limits = \
         [\"max_casting_point_velocity_m_s <= 4.5\"]\n\n(`decore help best`)"
    )]
    NoGoal,
    /// A study without a choice.
    #[error(
        "no factor can be chosen: give the study a [design.factor] whose role is not \"uncertain\" (`decore help best`)"
    )]
    NoDecision,
    /// A value of the goal or a limit that cannot be modelled.
    #[error("`{text}` cannot be predicted: {reason}")]
    NoModel {
        /// The value, as written.
        text: String,
        /// Reason, in words.
        reason: String,
    },
    /// No place was found.
    #[error(
        "none of {tried} combinations of the decision factors meets all constraints and describes a scene: widen the ranges of the \
         factors or the constraints"
    )]
    NoCandidates {
        /// Combinations that were tried.
        tried: usize,
    },
    /// The tables.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The models.
    #[error(transparent)]
    Surrogate(#[from] SurrogateError),
    /// The study.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The factors.
    #[error("the factors: {0}")]
    Design(#[from] DesignError),
    /// A model that does not predict.
    #[error("the models: {0}")]
    Regression(#[from] RegressionError),
}
