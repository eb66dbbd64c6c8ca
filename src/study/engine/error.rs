//! Reasons why a study could not be prepared to run.

use std::path::PathBuf;

use crate::StudyError;
use decore_dataset::DatasetError;
use decore_model::run::BatchError;
use decore_model::structure::StructureError;

/// Memory in bytes that the signals of a row may take.
pub(super) const MOST_SIGNAL_BYTES: f64 = 1e9;

/// Reason why there is no engine for a study.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The study is wrong.
    #[error("{0}")]
    Study(#[from] StudyError),
    /// A machine cannot be read or reduced.
    #[error("failed to prepare the machine: {0}")]
    Structure(#[from] StructureError),
    /// A file that the study names cannot be read.
    #[error("failed to read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The tables.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// Rows could not be run or stored.
    #[error("{0}")]
    Batch(#[from] BatchError<DatasetError>),
    /// Signals of a row that are too many.
    #[error(
        "the signals of {duration_s} s would take {:.2} GB of memory, more than {:.0} GB; expected at least \
         {least_interval_s:.1e} s",
        bytes / 1e9,
        MOST_SIGNAL_BYTES / 1e9
    )]
    Signals {
        /// Simulated time, s.
        duration_s: f64,
        /// Memory that they would take, bytes.
        bytes: f64,
        /// The least interval that is possible, s.
        least_interval_s: f64,
    },
    /// Signals to be kept that cannot be.
    #[error("outputs.{key}: {message}")]
    Outputs {
        /// The key of the study's table `outputs`.
        key: &'static str,
        /// The fault.
        message: String,
    },
    /// A further machine lacks a point.
    #[error("[{table}] has no interface point `{point}`, which the study uses")]
    MissingPoint {
        /// Table of the machine in the study.
        table: String,
        /// The point.
        point: String,
    },
    /// A further machine has a point elsewhere.
    #[error(
        "interface point `{point}` of [{table}] is at {found:?}, that of [structure] at {expected:?}: the machines of a study \
         have the points that it uses at the same places"
    )]
    MovedPoint {
        /// Table of the machine in the study.
        table: String,
        /// The point.
        point: String,
        /// Position on this machine, m.
        found: [f64; 3],
        /// Position on the study's first machine, m.
        expected: [f64; 3],
    },
}
