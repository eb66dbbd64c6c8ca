//! Reasons why two datasets cannot be compared.

use std::path::PathBuf;

use decore_dataset::DatasetError;

/// Reason why two datasets could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// One of them could not be read, or has no such column.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// One of them was changed during the comparison.
    #[error("{} changed while it was read: compare again when nothing writes to it", folder.display())]
    Changed {
        /// The dataset.
        folder: PathBuf,
    },
    /// The datasets have different factors, so their rows cannot be matched.
    #[error(
        "the datasets have different factors, so their rows cannot be matched: {}; compare datasets with the same \
         factors, names and units",
        differences.join(", ")
    )]
    Factors {
        /// Differences, in words.
        differences: Vec<String>,
    },
}
