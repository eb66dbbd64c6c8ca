//! Runs rows from Python: progress goes to a callable, Ctrl-C stops.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use super::wait::Work;
use decore_model::run::RowStatus;
use decore_study::engine::SweepEvent;

/// Time between two calls of the callable.
const TOLD_EVERY: Duration = Duration::from_millis(200);

/// Sweeps that were interrupted and whose rows still run; a folder is theirs until they end.
static ENDING: Mutex<Ending> = Mutex::new(Ending { process: 0, sweeps: Vec::new() });

/// Sweeps that end by themselves.
struct Ending {
    /// The process whose threads run them: one that was forked has their channels and not their threads.
    process: u32,
    sweeps: Vec<Receiver<()>>,
}

impl Ending {
    /// Registers a new sweep; returns this process's sweeps that it must wait for.
    fn begin(&mut self, sweep: Receiver<()>) -> Vec<Receiver<()>> {
        let process = std::process::id();
        let earlier = std::mem::replace(self, Self { process, sweeps: vec![sweep] });
        if earlier.process == process { earlier.sweeps } else { Vec::new() }
    }
}

/// Progress of a sweep.
#[pyclass(module = "decore", frozen, get_all)]
pub struct Progress {
    /// Rows that the dataset is to hold.
    rows: u64,
    /// Existing rows, whatever their status.
    done: u64,
    /// Of these, rows with another status than done.
    failed: u64,
    /// Time since the rows began, in s.
    elapsed_s: f64,
    /// Time left at this rate in s; none before the first row.
    seconds_left: Option<f64>,
    /// Whether no more rows are run.
    ended: bool,
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        format!("<decore.Progress {} of {} rows, {} failed>", self.done, self.rows, self.failed)
    }
}

/// Counters of running rows, shared by all threads.
#[derive(Default)]
pub struct Counts {
    rows: AtomicU64,
    before: AtomicU64,
    done: AtomicU64,
    failed: AtomicU64,
}

impl Counts {
    /// Counts an event.
    pub fn hear(&self, event: SweepEvent<'_>) {
        match event {
            SweepEvent::Begins { rows, done, failed } => {
                self.before.store(done, Ordering::Relaxed);
                self.failed.store(failed, Ordering::Relaxed);
                self.done.store(done, Ordering::Relaxed);
                self.rows.store(rows, Ordering::Relaxed);
            }
            SweepEvent::RowEnded(status) => {
                self.failed.fetch_add(u64::from(status != RowStatus::Done), Ordering::Relaxed);
                self.done.fetch_add(1, Ordering::Relaxed);
            }
            // Reported at the end of the sweep, or in the dataset itself.
            SweepEvent::Grown { .. } | SweepEvent::Found { .. } | SweepEvent::Repeats { .. } => {}
            SweepEvent::Tick | SweepEvent::Ends => {}
            SweepEvent::SummaryNotWritten(_) | SweepEvent::Failed => {}
        }
    }

    /// `None` before the rows begin.
    fn progress(&self, elapsed: Duration, ended: bool) -> Option<Progress> {
        let [rows, before, done, failed] =
            [&self.rows, &self.before, &self.done, &self.failed].map(|count| count.load(Ordering::Relaxed));
        let elapsed_s = elapsed.as_secs_f64();
        let own = done.saturating_sub(before);
        let seconds_left = (own > 0).then(|| elapsed_s / own as f64 * rows.saturating_sub(done) as f64);
        (rows > 0).then_some(Progress { rows, done, failed, elapsed_s, seconds_left, ended })
    }
}

/// Runs work that runs rows, and calls `told` with their progress five times a second.
///
/// # Errors
/// What an interrupt or `told` raised; then rows that ended are kept, and rows that still run end by themselves, before work that
/// comes later begins.
pub fn watched<T: Send + 'static>(
    py: Python<'_>,
    told: Option<Py<PyAny>>,
    run: impl FnOnce(&Arc<AtomicBool>, &Arc<Counts>) -> T + Send + 'static,
) -> PyResult<T> {
    let counts = Arc::new(Counts::default());
    let (begin, own) = (Instant::now(), Arc::clone(&counts));
    let work = move |stop: &Arc<AtomicBool>| {
        let (ends, ended) = sync_channel::<()>(0);
        let earlier = ENDING.lock().unwrap_or_else(PoisonError::into_inner).begin(ended);
        // A sweep drops its end of the channel when it ends.
        for earlier in earlier {
            let _ = earlier.recv();
        }
        let done = run(stop, &own);
        drop(ends);
        done
    };
    let (seen, callable) = (Arc::clone(&counts), told.as_ref().map(|told| told.clone_ref(py)));
    let mut last = None::<Instant>;
    let tick = move |py: Python<'_>| {
        let Some(callable) = callable.as_ref().filter(|_| last.is_none_or(|last| last.elapsed() >= TOLD_EVERY)) else {
            return Ok(());
        };
        last = Some(Instant::now());
        seen.progress(begin.elapsed(), false).map_or(Ok(()), |progress| callable.call1(py, (progress,)).map(drop))
    };
    let done = Work { run: work, tick: Box::new(tick) }.wait(py)?;
    if let (Some(told), Some(progress)) = (told, counts.progress(begin.elapsed(), true)) {
        told.call1(py, (progress,))?;
    }
    Ok(done)
}
