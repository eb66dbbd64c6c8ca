//! Why a study could not be made ready to run.

use std::path::PathBuf;

use crate::structure::StructureError;
use crate::study::StudyError;

/// Why there is no engine for a study.
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
        /// Why.
        source: std::io::Error,
    },
    /// A further machine lacks a point.
    #[error("[{table}] has no interface point `{point}`, which the study uses")]
    MissingPoint {
        /// Where the machine stands in the study.
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
        /// Where the machine stands in the study.
        table: String,
        /// The point.
        point: String,
        /// Where it is there, m.
        found: [f64; 3],
        /// Where the study's first machine has it, m.
        expected: [f64; 3],
    },
}
