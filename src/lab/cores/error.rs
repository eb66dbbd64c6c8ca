//! Why tests give no dose.

use decore_dataset::DatasetError;
use decore_statistics::lifetime::LifetimeError;
use decore_study::StudyError;

/// Why tests give no dose.
#[derive(Debug, thiserror::Error)]
pub enum CoresError {
    /// The tables cannot be read or lack a column.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// The text of the study in the dataset cannot be read.
    #[error("the study that the dataset holds cannot be read by this decore: {0}")]
    Study(#[from] StudyError),
    /// A dataset without doses of core points.
    #[error(
        "the dataset has no doses of core points: add [casting.NAME.core.NAME] to the study, set `core_spectra = true` and \
         `core_dose_reference_m_s` in [outputs], and run it again"
    )]
    NoDoses,
    /// Doses whose definition changes from row to row.
    #[error(
        "factor `{factor}` drives `outputs.{key}`, so doses of two rows cannot be compared: use one value for all rows"
    )]
    Definition {
        /// Name of the factor.
        factor: String,
        /// The key that it drives.
        key: &'static str,
    },
    /// A table of tests that cannot be read, or a test that does not fit the dataset.
    #[error("{0}")]
    Table(String),
    /// Tests without a law.
    #[error("{file}: {source}")]
    Law {
        /// The table of tests.
        file: String,
        /// Why there is none.
        source: LifetimeError,
    },
}
