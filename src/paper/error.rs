//! Reasons why the paper's rig could not be compared.

use decore_statistics::signal::SignalError;
use decore_study::StudyError;
use decore_study::engine::EngineError;

/// Reason why the paper's rig could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The study that is compiled in.
    #[error("the paper's rig: {0}")]
    Study(#[from] StudyError),
    /// Error of its machine or its signals.
    #[error("the paper's rig: {0}")]
    Engine(#[from] EngineError),
    /// A run that did not reach its end.
    #[error("the paper's rig could not be simulated: {0}")]
    Row(String),
    /// An output that a run of the rig has.
    #[error("the paper's rig has no {0}")]
    Missing(&'static str),
    /// Filtering.
    #[error("{0}")]
    Signal(#[from] SignalError),
}
