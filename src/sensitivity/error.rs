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
    /// Blocks of a Saltelli design that constraints chose.
    #[error(
        "the rows of this `saltelli` design meet constraints ({}), which make the factors depend on each other: shares of the \
         variance by Sobol' belong to independent factors, and would be wrong; a `latin_hypercube`, `sobol`, `halton` or \
         `random` design with these constraints, or `morris`, suits them",
        .constraints.join("; ")
    )]
    Dependent {
        /// The constraints, as written.
        constraints: Vec<String>,
    },
    /// A kind of design from which nothing is known here.
    #[error("a design of kind `{kind}` has no indices yet: expected `saltelli` or `morris`")]
    Design {
        /// The kind, as in a study.
        kind: String,
    },
}
