//! Errors of datasets, each with its remedy.

use std::io;
use std::path::PathBuf;

use arrow_schema::ArrowError;
use parquet::errors::ParquetError;

use decore_quantity::words::{did_you_mean, nearest};

/// Reason why a dataset could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The operating system refused.
    #[error("failed to {action} {}: {source} (check free space, permissions and that the path is right)", path.display())]
    Io {
        /// Failed action.
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// The system's words.
        #[source]
        source: io::Error,
    },
    /// The folder already holds a dataset.
    #[error(
        "{} already holds a dataset: study `{study}`, {rows_done} of {rows} rows; \
         choose another folder, or replace it",
        path.display()
    )]
    Exists {
        /// The dataset's folder.
        path: PathBuf,
        /// Name of its study.
        study: String,
        /// Rows that it holds.
        rows_done: u64,
        /// Rows of its design.
        rows: u64,
    },
    /// The folder holds a dataset of another study.
    #[error(
        "{} contains {rows_done} of {rows} rows of a different study. Nothing was changed. Differences:\n  {}\nundo the \
         change to continue, choose another folder, or replace the dataset",
        path.display(), differences.join("\n  ")
    )]
    Changed {
        /// The dataset's folder.
        path: PathBuf,
        /// Rows that it holds.
        rows_done: u64,
        /// Rows of its design.
        rows: u64,
        /// Differences, a sentence each.
        differences: Vec<String>,
    },
    /// The file system cannot lock files.
    #[error(
        "failed to lock {}: {source}: this file system has no file locks, which keep a second decore from the dataset (some network \
         and shared folders have none, or their lock service is off); write to another file system, such as a local disk, and copy \
         the result when it is complete",
        path.display()
    )]
    NoLocks {
        /// The lock's file.
        path: PathBuf,
        /// The system's words.
        #[source]
        source: io::Error,
    },
    /// Another process writes to the dataset, or adds to the file of rows.
    #[error("{} is being written by another decore ({owner}); wait for it, or stop it first", path.display())]
    InUse {
        /// The dataset's folder, or the file.
        path: PathBuf,
        /// Owner of the lock, if known.
        owner: String,
    },
    /// The dataset's folder was taken away while it was written to.
    #[error(
        "{} was removed, moved or replaced during the sweep, with its finished rows; run the command again to start \
         over, or to continue with the present folder",
        path.display()
    )]
    Gone {
        /// The dataset's folder.
        path: PathBuf,
    },
    /// The dataset is another one than that which was opened, or is being changed.
    #[error(
        "{} changed since it was opened: it was replaced or grown, or a sweep is replacing parts of it; open it again \
         (if this does not help, stop all sweeps and list damaged files with `decore verify`)",
        path.display()
    )]
    Replaced {
        /// The dataset's folder.
        path: PathBuf,
    },
    /// Shards that do not make a whole.
    #[error("failed to merge: {problem}; {advice}")]
    Shards {
        /// The fault, with the folders.
        problem: String,
        /// Remedy.
        advice: &'static str,
    },
    /// The folder holds something else.
    #[error(
        "{} is neither empty nor a dataset (it has no readable manifest.json), so nothing in it was touched; \
         choose another folder",
        path.display()
    )]
    Occupied {
        /// The folder.
        path: PathBuf,
    },
    /// No dataset there.
    #[error("{} is not a dataset: it has no manifest.json; give the output folder of `decore run`", path.display())]
    Missing {
        /// The folder.
        path: PathBuf,
    },
    /// The manifest was not written by this program.
    #[error(
        "{}, line {}, column {}: {source}; the file is damaged, or another program wrote it; run the sweep again to \
         rebuild it from the parts or the journal",
        path.display(), source.line(), source.column()
    )]
    Manifest {
        /// The manifest's path.
        path: PathBuf,
        /// Position and kind of the syntax error.
        #[source]
        source: serde_json::Error,
    },
    /// A manifest is not the one that was written.
    #[error(
        "{}: the checksum does not match, so the file was changed or damaged; run the sweep again to rebuild it from \
         the parts or the journal",
        path.display()
    )]
    Seal {
        /// The manifest's path.
        path: PathBuf,
    },
    /// A manifest is damaged, and nothing else in the folder describes the dataset.
    #[error(
        "{}; it cannot be rebuilt, because neither a part nor the journal in the folder contains the study: restore a \
         copy of the file, choose another folder, or replace the dataset",
        .damage.damage_of_manifest()
    )]
    Lost {
        /// Description of the damage.
        damage: Box<DatasetError>,
    },
    /// The dataset is of another format version.
    #[error(
        "{}: key `format_version` is {found}, expected {expected}; read it with the version that wrote it, or run the \
         study again",
        path.display()
    )]
    Version {
        /// The manifest's path.
        path: PathBuf,
        /// Version in the file.
        found: u32,
        /// Version that this program knows.
        expected: u32,
    },
    /// The program that wrote the dataset has other columns.
    #[error(
        "{}: the tables have the columns of another decore (version {written_by}); read them with the program that wrote them, or run \
         the study again with `--replace`",
        path.display()
    )]
    Columns {
        /// Path of the manifest.
        path: PathBuf,
        /// Version of the program that wrote the dataset.
        written_by: String,
    },
    /// Two names of the study give the same column.
    #[error(
        "column `{column}` would hold both {first} and {second} (column names keep letters, digits and \
         underscores, upper and lower case count as equal); rename one of the two in the study"
    )]
    DuplicateColumn {
        /// The column's name.
        column: String,
        /// Contents of the first dataset.
        first: String,
        /// Contents of the second dataset.
        second: String,
    },
    /// A setting of the dataset is outside its range.
    #[error("key `{key}` of the dataset is {found}, expected {expected}")]
    Setting {
        /// The setting.
        key: &'static str,
        /// Value that was found.
        found: u64,
        /// Permitted values.
        expected: &'static str,
    },
    /// A record does not have the shape that the dataset was created with.
    #[error("row {row}: {what}: found {found}, expected {expected}; create the dataset from the study of the row")]
    Record {
        /// The row.
        row: u64,
        /// Kind of mismatch.
        what: String,
        /// Value in the record.
        found: String,
        /// Value that the dataset needs.
        expected: String,
    },
    /// A row came twice, or is not of the dataset.
    #[error(
        "row {row} is unexpected: expected a missing row from {expected_from} up to, not including, {expected_end}; \
         write each row once"
    )]
    UnexpectedRow {
        /// The row.
        row: u64,
        /// First row that the dataset is to hold.
        expected_from: u64,
        /// One past the last row.
        expected_end: u64,
    },
    /// The thread that writes parts panicked. Libraries do so where memory runs out (zstd for a context, for example).
    #[error(
        "the thread that writes parts broke down: out of memory, or a defect of the program; give fewer --threads or raise \
         the limit on memory (`ulimit -v`), then run the same command again: rows that were written are kept"
    )]
    WriterLost,
    /// The Parquet library refused a part.
    #[error("{}: {source}; if the file is damaged, run the study again", path.display())]
    Parquet {
        /// The part.
        path: PathBuf,
        /// The library's words.
        #[source]
        source: ParquetError,
    },
    /// Columns that make no table.
    #[error("failed to put the columns of a table together: {0}")]
    Batch(#[from] ArrowError),
    /// A part is not the one that was written.
    #[error(
        "{}: {found}, expected {expected}; the file was changed or damaged: `decore verify` lists all faults, and the same \
         `decore run` computes the rows of damaged parts again",
        path.display()
    )]
    Damaged {
        /// The part.
        path: PathBuf,
        /// Value in the file.
        found: String,
        /// Value in the manifest.
        expected: String,
    },
    /// A foreign file in the folder of the parts.
    #[error(
        "{}: no part of the dataset, but readers that take all files of the folder read it too: move it elsewhere",
        path.display()
    )]
    Stray {
        /// The file.
        path: PathBuf,
    },
    /// A part without a checksum in any manifest.
    #[error("{}: no checksum is left to check this file: its rows are computed again", path.display())]
    Unvouched {
        /// The part.
        path: PathBuf,
    },
    /// A forbidden path, with the remedy.
    #[error("{0}")]
    Target(String),
    /// A column that is not there.
    #[error("table `{table}` has no column `{column}`{}", hint(.known, .column))]
    UnknownColumn {
        /// The table.
        table: &'static str,
        /// Requested column.
        column: String,
        /// The columns that it has.
        known: Vec<String>,
    },
    /// A column without numbers where numbers are needed.
    #[error("table `{table}`, column `{column}` holds text, expected numbers; choose a column with a unit")]
    NotANumber {
        /// The table.
        table: &'static str,
        /// Requested column.
        column: String,
    },
}

/// The known name that was most likely meant, as a hint.
fn hint(known: &[String], name: &str) -> String {
    did_you_mean(nearest(name, known.iter().map(String::as_str)))
}

impl DatasetError {
    /// Whether a manifest is lost or damaged, so that it must be rebuilt from the parts.
    pub(super) fn is_lost_manifest(&self) -> bool {
        matches!(self, Self::Missing { .. } | Self::Manifest { .. } | Self::Seal { .. })
    }

    /// Describes the damage of a manifest, without advice.
    fn damage_of_manifest(&self) -> String {
        match self {
            Self::Manifest { path, source } => {
                format!("{}, line {}, column {}: {source}", path.display(), source.line(), source.column())
            }
            Self::Seal { path } => format!("{}: its contents do not match its checksum", path.display()),
            other => other.to_string(),
        }
    }

    /// Whether files of a dataset are damaged, missing or foreign, so that it cannot be read.
    pub fn is_damage(&self) -> bool {
        matches!(
            self,
            Self::Damaged { .. }
                | Self::Stray { .. }
                | Self::Unvouched { .. }
                | Self::Manifest { .. }
                | Self::Seal { .. }
        )
    }

    /// Whether it is the request that is wrong (a folder in use, names that clash, a column that is not there), not the
    /// writing or reading that failed.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Exists { .. }
                | Self::Occupied { .. }
                | Self::Changed { .. }
                | Self::Shards { .. }
                | Self::Missing { .. }
                | Self::Lost { .. }
                | Self::Version { .. }
                | Self::Columns { .. }
                | Self::DuplicateColumn { .. }
                | Self::UnknownColumn { .. }
                | Self::NotANumber { .. }
                | Self::Target(_)
        )
    }
}
