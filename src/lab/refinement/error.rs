//! Reasons why no rows are proposed.

use crate::surrogate::SurrogateError;
use decore_statistics::design::DesignError;
use decore_statistics::regression::RegressionError;
use decore_study::StudyError;

/// Reason why no rows are proposed.
#[derive(Debug, thiserror::Error)]
pub enum RefinementError {
    /// The models of the outputs.
    #[error(transparent)]
    Surrogate(#[from] SurrogateError),
    /// The study's constraints.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The study's factors.
    #[error("the candidates for further rows: {0}")]
    Design(#[from] DesignError),
    /// A model that failed.
    #[error("the models: {0}")]
    Regression(#[from] RegressionError),
    /// An output that has no model.
    #[error("output `{output}` cannot be predicted: {reason}")]
    NoModel {
        /// Column of the output.
        output: String,
        /// Reason.
        reason: String,
    },
    /// No place was found.
    #[error(
        "no place was found for a further row: none of {tried} candidates meets all constraints and describes a scene; widen the \
         ranges of the factors or the constraints (the rows that there are have been run)"
    )]
    NoCandidates {
        /// Candidates that were looked at.
        tried: usize,
    },
}
