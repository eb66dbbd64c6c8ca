//! Reasons why a dataset has no indices.

use decore_dataset::DatasetError;
use decore_study::StudyError;

/// Reason why a dataset has no indices.
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
    /// Rows that do not belong to the design.
    #[error(
        "rows {first} to {last} are not a {unit} of the study's design (factor `{factor}` differs); run `decore verify` \
         to find damaged files"
    )]
    Layout {
        /// The first row.
        first: u64,
        /// The last row.
        last: u64,
        /// Expected unit.
        unit: &'static str,
        /// The factor that differs.
        factor: String,
    },
    /// Other indices than elementary effects were requested for trajectories.
    #[error(
        "the rows of a `morris` design serve elementary effects only, as they lie on trajectories: other indices need another \
         kind of design"
    )]
    Trajectories,
    /// `given` was set for a design that always has these indices.
    #[error(
        "`given` is for `saltelli` designs only; the rows of this design always have these indices: leave `given` out"
    )]
    Given,
    /// An estimator of Sobol' indices for rows that have none.
    #[error(
        "the estimator `{estimator}` is one of Sobol' indices, which these rows do not have: {why}; leave the estimator out, or run a \
         `saltelli` design without constraints"
    )]
    Estimator {
        /// Name of the estimator.
        estimator: &'static str,
        /// Reason why there are no Sobol' indices.
        why: &'static str,
    },
}
