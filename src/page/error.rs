//! Reasons why pages cannot be made.

use decore_dataset::DatasetError;

/// Reason why a page could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The dataset could not be read.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// The page's metadata could not be written as JSON.
    #[error("failed to write the page's data as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The signals could not be packed.
    #[error("failed to pack the page's signals: {0}")]
    Pack(#[from] std::io::Error),
}
