//! Reasons why there is no table of features.

use std::path::PathBuf;

use parquet::errors::ParquetError;

use decore_dataset::DatasetError;
use decore_study::StudyError;

/// Reason why there is no table of features.
#[derive(Debug, thiserror::Error)]
pub enum FeaturesError {
    /// The dataset cannot be read.
    #[error("{0}")]
    Dataset(#[from] DatasetError),
    /// The text of the study in the dataset cannot be read.
    #[error("the study that the dataset holds cannot be read by this decore: {0}")]
    Study(#[from] StudyError),
    /// A hammer of the dataset strikes a casting that the dataset does not have.
    #[error(
        "hammer `{hammer}` strikes the casting `{casting}` in row {row}, but the dataset has no such casting; run \
         `decore verify` to find damaged files"
    )]
    Casting {
        /// The hammer.
        hammer: String,
        /// The casting as named.
        casting: String,
        /// The row.
        row: u64,
    },
    /// A dataset without rows.
    #[error("the dataset has no row yet: a table of features needs one")]
    NoRows,
    /// A dataset without groups of its design's rows.
    #[error(
        "the dataset has no groups of dependent rows, because an earlier decore wrote it: run its study again to get \
         splits by groups"
    )]
    NoGroups,
    /// Shares that are none.
    #[error(
        "the shares {given:?} of the splits are not two or three positive numbers that add up to 1, as in 0.7,0.15,0.15"
    )]
    Shares {
        /// As given.
        given: Vec<f64>,
    },
    /// A part of the splits that no group is in.
    #[error(
        "no group is in the part `{part}`: of {groups} groups that a split keeps together, chance put none there; give another \
         --seed, larger shares, or bind fewer rows by --group-by"
    )]
    EmptyPart {
        /// The part.
        part: &'static str,
        /// Number of groups.
        groups: usize,
    },
    /// Two columns of one name.
    #[error("the column `{column}` is there twice: rename the factor, hammer or casting that it has its name from")]
    Twice {
        /// The name.
        column: String,
    },
    /// The table cannot be written as Parquet.
    #[error("the table cannot be written as Parquet: {0}")]
    Parquet(#[from] ParquetError),
    /// An existing file.
    #[error("{} exists and was not changed: choose another folder, or add `--replace` to replace it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A file that cannot be written.
    #[error("failed to write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}
