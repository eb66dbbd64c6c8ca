//! Counts finished rows of a sweep, informs the caller, and updates the dataset's status file.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::event::{Listener, SweepEvent};
use decore_dataset::{DatasetDir, RowError, SweepState, SweepStatus, host_name};
use decore_model::run::{RowOutcome, RowStatus};
use decore_model::structure::peak_memory_bytes;

/// Time between two writings of the status file.
const INTERVAL: Duration = Duration::from_secs(2);
/// Largest number of failed rows in the status.
const LAST_ERRORS: usize = 10;

/// State at the start of a sweep.
pub(super) struct Beginning<'a> {
    pub place: DatasetDir,
    /// Rows that the dataset is to hold.
    pub rows: u64,
    /// Existing rows, and those that are not done.
    pub recovered: (u64, u64),
    pub threads: u64,
    pub listener: &'a Listener<'a>,
}

/// Sees every row end.
pub(super) struct Monitor<'a> {
    beginning: Beginning<'a>,
    started: Instant,
    started_unix_s: u64,
    tally: Mutex<Tally>,
}

#[derive(Default)]
struct Tally {
    done: u64,
    failed: u64,
    row_time_s: f64,
    last_errors: VecDeque<RowError>,
    written: Duration,
}

impl<'a> Monitor<'a> {
    pub fn new(beginning: Beginning<'a>) -> Self {
        let monitor = Self {
            beginning,
            started: Instant::now(),
            started_unix_s: SweepStatus::now_unix_s(),
            tally: Mutex::default(),
        };
        monitor.write(&monitor.status(SweepState::Running, String::new()));
        monitor
    }

    /// Records the outcome of a row and reports it; returns the number of rows that are not done, including earlier runs.
    pub fn note(&self, row: u64, outcome: &RowOutcome) -> u64 {
        (self.beginning.listener)(SweepEvent::RowEnded(outcome.status));
        let mut tally = self.tally.lock().unwrap_or_else(PoisonError::into_inner);
        tally.done += 1;
        tally.row_time_s += outcome.wall_time_s;
        if outcome.status != RowStatus::Done {
            tally.failed += 1;
            if tally.last_errors.len() == LAST_ERRORS {
                tally.last_errors.pop_front();
            }
            let status = outcome.status.name().to_owned();
            tally.last_errors.push_back(RowError { row, status, reason: outcome.reason.clone() });
        }
        self.beginning.recovered.1 + tally.failed
    }

    /// The status now.
    pub fn status(&self, state: SweepState, message: String) -> SweepStatus {
        let tally = self.tally.lock().unwrap_or_else(PoisonError::into_inner);
        let wall_time_s = self.started.elapsed().as_secs_f64();
        let rows_per_s = tally.done as f64 / wall_time_s.max(1e-9);
        let rows_done = self.beginning.recovered.0 + tally.done;
        let left = self.beginning.rows.saturating_sub(rows_done);
        SweepStatus {
            state,
            message,
            process: std::process::id(),
            host: host_name(),
            started_unix_s: self.started_unix_s,
            updated_unix_s: SweepStatus::now_unix_s(),
            rows: self.beginning.rows,
            rows_done,
            rows_recovered: self.beginning.recovered.0,
            rows_failed: self.beginning.recovered.1 + tally.failed,
            threads: self.beginning.threads,
            wall_time_s,
            row_time_s: tally.row_time_s,
            rows_per_s,
            seconds_left: (tally.done > 0).then(|| left as f64 / rows_per_s),
            peak_memory_bytes: peak_memory_bytes(),
            last_errors: tally.last_errors.iter().cloned().collect(),
        }
    }

    /// Writes the last status and, if asked for, the completion file.
    pub fn finish(&self, status: &SweepStatus, completion: Option<&Path>) {
        self.write(status);
        let Some(path) = completion else {
            return;
        };
        if status.write_as(path).is_err() {
            (self.beginning.listener)(SweepEvent::SummaryNotWritten(path));
        }
    }

    fn write(&self, status: &SweepStatus) {
        // Results do not depend on it; a full disk is reported by those who write results.
        // A folder rebuilt meanwhile is another writer's.
        if self.beginning.place.is_there() {
            let _ = status.write(self.beginning.place.path());
        }
    }

    /// Reports elapsed time, and updates the status file.
    pub fn tick(&self) {
        (self.beginning.listener)(SweepEvent::Tick);
        let elapsed = self.started.elapsed();
        {
            let mut tally = self.tally.lock().unwrap_or_else(PoisonError::into_inner);
            if elapsed.saturating_sub(tally.written) < INTERVAL {
                return;
            }
            tally.written = elapsed;
        }
        self.write(&self.status(SweepState::Running, String::new()));
    }
}
