//! Why a dataset has no indices.

use crate::dataset::DatasetError;
use crate::study::StudyError;

/// Why a dataset has no indices.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    /// The tables cannot be read, or lack a column.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// The text of the study in the dataset cannot be read.
    #[error("the study that the dataset holds cannot be read by this decore: {0}")]
    Study(#[from] StudyError),
    /// A study without factors.
    #[error("the study has no factors: an analysis needs a [design] with at least one [design.factor]")]
    NoFactors,
    /// Rows that are not those of the design.
    #[error(
        "rows {first} to {last} are no {unit} of the design that the study describes (factor `{factor}` differs); \
         `decore verify` says whether the dataset is damaged"
    )]
    Layout {
        /// The first row.
        first: u64,
        /// The last row.
        last: u64,
        /// What they should be.
        unit: &'static str,
        /// The factor that differs.
        factor: String,
    },
    /// Trajectories, of which other indices than elementary effects are asked for.
    #[error(
        "the rows of a `morris` design serve elementary effects only, as they lie on trajectories: other indices need another \
         kind of design"
    )]
    Trajectories,
}
