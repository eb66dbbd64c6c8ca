//! Progress and end of a sweep: a small JSON file that other programs can read.

use std::fs;
use std::io;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::durable::failed_to;
use super::error::DatasetError;
use super::journal;
use super::lock::Lock;
use super::manifest::{Manifest, from_sealed_json, to_json, to_sealed_json};
use super::store::remove;
use decore_files::{Limit, Staged, is_passing_name, read};

/// Name of the status in the dataset's folder.
pub const STATUS_NAME: &str = "status.json";

/// State of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SweepState {
    /// Rows are run.
    Running,
    /// All rows exist.
    Complete,
    /// Stopped by a signal; the same command continues.
    Interrupted,
    /// Stopped at once by a second signal: finished rows are stored, running rows are lost. The same command continues.
    StoppedAtOnce,
    /// Stopped because more rows failed than were allowed.
    TooManyFailed,
    /// Results could not be written.
    NotWritten,
    /// The process ended without a word: killed, or its machine went down.
    Lost,
}

/// A row that is not done.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RowError {
    /// Index of the row.
    pub row: u64,
    /// Status of the row: audit_failed, invalid, diverged or budget_exhausted.
    pub status: String,
    /// Reason.
    pub reason: String,
}

/// `status.json` and the completion file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepStatus {
    /// State of the sweep.
    pub state: SweepState,
    /// Reason in words; may be empty.
    pub message: String,
    /// The process.
    pub process: u32,
    /// Host on which it runs.
    pub host: String,
    /// When it started, in s since 1970.
    pub started_unix_s: u64,
    /// When this was written, in s since 1970.
    pub updated_unix_s: u64,
    /// Rows that the dataset is to hold.
    pub rows: u64,
    /// Rows that are done with, whatever their status.
    pub rows_done: u64,
    /// Of these, rows from earlier runs.
    pub rows_recovered: u64,
    /// Number of ended rows with another status than done.
    pub rows_failed: u64,
    /// Threads that run rows.
    pub threads: u64,
    /// Wall time of this process in s.
    pub wall_time_s: f64,
    /// Sum of the wall times of the rows that this process ran, in s.
    pub row_time_s: f64,
    /// Rows per second of this process.
    pub rows_per_s: f64,
    /// Time left in s at this rate; `null` before the first row.
    pub seconds_left: Option<f64>,
    /// Largest resident memory of the process in bytes, if the system reports it.
    pub peak_memory_bytes: Option<u64>,
    /// The last rows that are not done, latest last.
    pub last_errors: Vec<RowError>,
}

impl SweepStatus {
    /// Seconds since 1970.
    pub fn now_unix_s() -> u64 {
        SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs())
    }

    /// Writes the status next to a dataset that is being written. It is not synced, because the dataset does not depend on it.
    ///
    /// # Errors
    /// The system's.
    pub fn write(&self, dataset: &Path) -> Result<(), DatasetError> {
        let target = dataset.join(STATUS_NAME);
        put(&target, &to_sealed_json(self, &target)?)
    }

    /// Writes the status as a file, which replaces an existing one as a whole.
    ///
    /// # Errors
    /// The system's.
    pub fn write_as(&self, target: &Path) -> Result<(), DatasetError> {
        put(target, &self.to_json(target)?)
    }

    /// Notes that the sweep that writes the dataset is stopped at once, for a process that ends without any more words.
    ///
    /// # Errors
    /// The system's; there is no status before the first row is run.
    pub fn note_stop(dataset: &Path) -> Result<(), DatasetError> {
        let path = dataset.join(STATUS_NAME);
        let text = read(&path, Limit::STATUS).map_err(failed_to("read", &path))?;
        let last: Self = from_sealed_json(&text, &path)?;
        let message = "stopped at once".to_owned();
        Self { state: SweepState::StoppedAtOnce, message, updated_unix_s: Self::now_unix_s(), ..last }.write(dataset)
    }

    /// The status as JSON.
    ///
    /// # Errors
    /// [`DatasetError::Manifest`], should a value not be writable as JSON.
    pub fn to_json(&self, path: &Path) -> Result<Vec<u8>, DatasetError> {
        to_json(self, path)
    }

    /// Status of the dataset in `dataset`: as its last writer left it, corrected from the files.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], those of the manifest, [`DatasetError::Seal`] for a status that is damaged, or the system's.
    pub fn read(dataset: &Path) -> Result<Self, DatasetError> {
        // Taken is looked at first: a sweep that ends in between is then reported by its last word.
        let running = Lock::is_taken(dataset);
        let manifest = Manifest::read(dataset)?;
        let path = dataset.join(STATUS_NAME);
        let mut status = match read(&path, Limit::STATUS) {
            Ok(text) => from_sealed_json(&text, &path)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Self::of_manifest(&manifest),
            Err(error) => return Err(failed_to("read", &path)(error)),
        };
        if running {
            status.state = SweepState::Running;
            return Ok(status);
        }
        // Rows of a block that has a part may be in the journal too.
        let (rows, failed) = journal::count(dataset, &|row| !manifest.has(row))?;
        if rows > 0 || matches!(status.state, SweepState::Running | SweepState::StoppedAtOnce) {
            status.rows_done = manifest.rows_done + rows;
            status.rows_failed = manifest.rows_failed() + failed;
        }
        if status.state == SweepState::Running {
            // Rows of a full block are in the journal too while they are run again.
            let waiting = journal::count(dataset, &|_| true)?.0;
            status.state = if manifest.complete && waiting == 0 { SweepState::Complete } else { SweepState::Lost };
        }
        Ok(status)
    }

    fn of_manifest(manifest: &Manifest) -> Self {
        Self {
            state: SweepState::Running,
            message: String::new(),
            process: 0,
            host: String::new(),
            started_unix_s: 0,
            updated_unix_s: 0,
            rows: manifest.range.len(),
            rows_done: manifest.rows_done,
            rows_recovered: 0,
            rows_failed: manifest.rows_failed(),
            threads: 0,
            wall_time_s: 0.0,
            row_time_s: 0.0,
            rows_per_s: 0.0,
            seconds_left: None,
            peak_memory_bytes: None,
            last_errors: Vec::new(),
        }
    }
}

/// Writes a file, which replaces an existing one as a whole.
fn put(target: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Staged::write(folder, target, bytes).and_then(Staged::put_in_place).map_err(failed_to("write", target))
}

/// Whether a file of a dataset's folder with this name is a status that is not yet in place.
pub fn is_staged(name: &Path) -> bool {
    is_passing_name(name, Path::new(STATUS_NAME))
}

/// Removes temporary files of a process that was killed while it wrote a status. Needs the dataset's lock.
///
/// # Errors
/// The system's.
pub fn remove_staged(dataset: &Path) -> Result<(), DatasetError> {
    for entry in fs::read_dir(dataset).map_err(failed_to("read the folder", dataset))? {
        let entry = entry.map_err(failed_to("read the folder", dataset))?;
        if is_staged(Path::new(&entry.file_name())) {
            remove(&entry.path())?;
        }
    }
    Ok(())
}
