//! Reasons why there is no surrogate, or no prediction.

use std::path::PathBuf;

use decore_dataset::DatasetError;
use decore_statistics::regression::RegressionError;
use decore_study::StudyError;

/// Reason why there is no surrogate, or no prediction.
#[derive(Debug, thiserror::Error)]
pub enum SurrogateError {
    /// The tables cannot be read or written, or lack a column.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// The text of the study in the dataset cannot be read.
    #[error("the study that the dataset holds cannot be read by this decore: {0}")]
    Study(#[from] StudyError),
    /// A study without factors.
    #[error("the study has no factors: a surrogate needs a [design] with at least one [design.factor]")]
    NoFactors,
    /// Two columns with the same output.
    #[error("output `{output}` is given twice: give each once")]
    Twice {
        /// Column of the output.
        output: String,
    },
    /// No output has a model.
    #[error("no output has a model: {}; run more rows, or choose other outputs with --outputs", reasons.join("; "))]
    Empty {
        /// For each output its name and the reason.
        reasons: Vec<String>,
    },
    /// A file that is not a model.
    #[error(
        "{} is not a usable model: {reason}; write one with `decore surrogate DATASET --output FILE`",
        .path.display()
    )]
    Model {
        /// The file.
        path: PathBuf,
        /// The fault.
        reason: String,
    },
    /// A table whose rows cannot be predicted.
    #[error("{0}")]
    Table(String),
    /// A model that failed.
    #[error("the model of `{output}`: {source}")]
    Regression {
        /// Column of the output.
        output: String,
        /// Cause.
        source: RegressionError,
    },
    /// A file that the system or the Parquet library did not write.
    #[error("failed to write {}: {reason}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Message of the faults.
        reason: String,
    },
}
