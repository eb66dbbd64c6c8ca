//! Runs all rows of a study, or a range of them, into its dataset. The same sweep again continues.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::EngineError;
use super::event::{Listener, SweepEvent};
use super::info::record;
use super::monitor::{Beginning, Monitor};
use super::prepared::{Engine, RowRunner};
use super::repeats::{Once, Repeats, Shared};
use decore_dataset::{
    DatasetError, DatasetWriter, Existing, Manifest, RerunSelection, RowRecorder, RowSpan, StoredRow, SweepState,
    SweepStatus, check_folder, grow,
};
use decore_model::run::{
    BatchError, BatchSettings, BatchSummary, DEFAULT_WINDOW, RowOutcome, RowSource, RowTask, run_batch, thread_count,
};

/// Settings of a sweep. The default runs all rows on all threads, continues an existing dataset, and reports to nobody.
#[derive(Clone, Copy)]
pub struct SweepSettings<'a> {
    /// Threads that run rows; 0 (default): see [`thread_count`]. Results do not depend on it.
    pub threads: usize,
    /// The range of rows that the dataset is to hold; `None` (default): all.
    pub rows: Option<RowSpan>,
    /// Action for an existing dataset. Default: continue it.
    pub existing: Existing,
    /// Rows to run again in place of those that are there, and no others; `None` (default): all that are missing are run.
    pub again: Option<&'a RerunSelection>,
    /// Stop if more rows than this are not done, including earlier runs; `None` (default): never.
    pub max_failed: Option<u64>,
    /// File for the final status (JSON). Default: `None`, only in the dataset.
    pub summary: Option<&'a Path>,
    /// Set from outside (another thread, a signal handler) to start no more rows; the sweep sets it when too many failed.
    pub stop: Option<&'a AtomicBool>,
    /// Receives rows as they end.
    pub listener: &'a Listener<'a>,
}

impl Default for SweepSettings<'_> {
    fn default() -> Self {
        Self {
            threads: 0,
            rows: None,
            existing: Existing::Resume,
            again: None,
            max_failed: None,
            summary: None,
            stop: None,
            listener: &|_| (),
        }
    }
}

impl Engine {
    /// Runs the study's rows into the dataset in `folder`, see [`sweep`].
    ///
    /// # Errors
    /// As for [`sweep`].
    pub fn run(&self, folder: &Path, settings: &SweepSettings<'_>) -> Result<SweepStatus, EngineError> {
        sweep(self, folder, settings)
    }
}

/// Runs the rows that the dataset in `folder` does not hold yet. Returns how that ended: complete, stopped by the flag, or too many
/// failed rows. Rows with the same factors are run once, see [`Repeats`].
///
/// # Errors
/// A folder that is in use, holds another study, lies in another dataset, would replace the study's files, or cannot be
/// written; a number of threads out of range, or threads that cannot be started.
pub fn sweep(rows: &dyn RowRunner, folder: &Path, settings: &SweepSettings<'_>) -> Result<SweepStatus, EngineError> {
    let threads = thread_count(settings.threads).map_err(BatchError::from)?;
    check_folder(folder, &rows.study().files())?;
    let (info, listener) = (rows.info(), settings.listener);
    let whole = RowSpan { first: 0, end: info.rows };
    let range = settings.rows.unwrap_or(whole);
    if settings.existing == Existing::Resume && settings.again.is_none() && range == whole {
        let growth = grow(folder, &info, &|first| rows.checked().rows_hash(first as usize))?;
        growth.iter().for_each(|growth| listener(SweepEvent::Grown { growth, rows: info.rows }));
    }
    let mut writer = match settings.again {
        Some(chosen) => DatasetWriter::again(folder, &info, range, chosen)?,
        None => DatasetWriter::open(folder, &info, range, settings.existing)?,
    };
    let (done, failed) = writer.recovered();
    let place = writer.place();
    listener(SweepEvent::Found { damaged: writer.damaged(), notes: writer.notes() });
    listener(SweepEvent::Begins { rows: range.len(), done, failed });
    let monitor = Monitor::new(Beginning {
        place: place.clone(),
        rows: range.len(),
        recovered: (done, failed),
        threads: threads as u64,
        listener,
    });
    let own = AtomicBool::new(false);
    let limit = StartLimit { most_failed: settings.max_failed, stop: settings.stop.unwrap_or(&own) };
    limit.hold(failed);
    let left = writer.rows_left();
    let left = || left.iter().flat_map(|span| span.first..span.end);
    // Signals are kept of rows, not of factors.
    let repeats = match rows.depends_on_factors_alone() && info.signals.is_empty() {
        true => Repeats::of(rows.checked(), left()),
        false => Repeats::default(),
    };
    listener(SweepEvent::Repeats { rows: repeats.count() as u64 });
    let shared = Shared::new(repeats);
    let task = SweepTask { rows, recorder: writer.recorder(), monitor: &monitor, limit, shared: &shared };
    // Waiting rows hold their signals; a part holds as many as permitted at a time.
    let window = if info.signals.is_empty() { DEFAULT_WINDOW } else { info.rows_per_part.max(2 * threads as u64) };
    let window = window.min(DEFAULT_WINDOW);
    let tick = || monitor.tick();
    let batch = BatchSettings { threads, window, stop: limit.stop, tick: &tick };
    let summary = run_batch(left(), &batch, &task, |_, row| writer.accept(row?));
    listener(SweepEvent::Ends);
    // Keep everything that was stored before a failure.
    let finished = writer.finish();
    let status = match (&summary, &finished) {
        (Ok(_), Err(error)) => monitor.status(SweepState::NotWritten, error.to_string()),
        (Ok(_), Ok(manifest)) if settings.again.is_some() => {
            whole_ending(ending(&monitor, &summary, limit.most_failed), manifest)
        }
        _ => ending(&monitor, &summary, limit.most_failed),
    };
    monitor.finish(&status, settings.summary);
    // Nothing is kept in a folder that is taken away, or is just being.
    if (summary.is_err() || finished.is_err()) && place.check().is_ok() {
        listener(SweepEvent::Failed);
    }
    summary?;
    finished?;
    Ok(status)
}

/// When no more rows are started.
#[derive(Clone, Copy)]
struct StartLimit<'a> {
    most_failed: Option<u64>,
    stop: &'a AtomicBool,
}

impl StartLimit<'_> {
    /// Stops if more rows failed than are allowed.
    fn hold(&self, failed: u64) {
        if self.most_failed.is_some_and(|most| failed > most) {
            self.stop.store(true, Ordering::SeqCst);
        }
    }
}

/// A row's way from its simulation into the journal.
struct SweepTask<'a> {
    rows: &'a dyn RowRunner,
    recorder: RowRecorder,
    monitor: &'a Monitor<'a>,
    limit: StartLimit<'a>,
    shared: &'a Shared,
}

impl RowTask for SweepTask<'_> {
    type Kept = Result<StoredRow, DatasetError>;

    fn run(&self, rows: &mut dyn RowSource) {
        self.rows.run(&mut Once::new(rows, self.shared));
    }

    fn keep(&self, row: u64, outcome: RowOutcome) -> Self::Kept {
        self.limit.hold(self.monitor.note(row, &outcome));
        self.recorder.record(&record(self.rows.checked(), row, outcome))
    }
}

/// End of a sweep.
fn ending(
    monitor: &Monitor<'_>,
    summary: &Result<BatchSummary, BatchError<DatasetError>>,
    most_failed: Option<u64>,
) -> SweepStatus {
    let failed = monitor.status(SweepState::Running, String::new()).rows_failed;
    let (state, message) = match (summary, most_failed) {
        (Err(error), _) => (SweepState::NotWritten, error.to_string()),
        (Ok(summary), Some(most)) if summary.stopped && failed > most => {
            (SweepState::TooManyFailed, format!("stopped: {failed} rows are not done, more than the {most} allowed"))
        }
        (Ok(summary), _) if summary.stopped => (SweepState::Interrupted, "interrupted".to_owned()),
        (Ok(_), _) => (SweepState::Complete, String::new()),
    };
    monitor.status(state, message)
}

/// End of re-runs: rows whose turn did not come are unchanged, and others may be missing.
fn whole_ending(status: SweepStatus, manifest: &Manifest) -> SweepStatus {
    let status = SweepStatus { rows_done: manifest.rows_done, rows_failed: manifest.rows_failed(), ..status };
    if status.state != SweepState::Complete || manifest.complete {
        return status;
    }
    let message = "the chosen rows have ended, but other rows are missing: run the command without a choice of rows";
    SweepStatus { state: SweepState::Interrupted, message: message.to_owned(), ..status }
}
