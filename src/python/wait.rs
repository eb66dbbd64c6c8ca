//! Runs long work without the interpreter, so that other Python threads run, and Ctrl-C works.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::error::Error;

/// Time between two looks for an interrupt.
const TICK: Duration = Duration::from_millis(50);
/// Time for stopped work to end before the call returns without it.
const GRACE: Duration = Duration::from_millis(350);

/// The process that imported the package.
static IMPORTED_BY: OnceLock<u32> = OnceLock::new();
/// Threads of the process that was forked from it.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Work that a flag can stop.
pub struct Work<T, F: FnOnce(&Arc<AtomicBool>) -> T> {
    /// The work; long work looks at the flag.
    pub run: F,
    /// Called with the interpreter at least every 50 ms.
    pub tick: Box<dyn FnMut(Python<'_>) -> PyResult<()>>,
}

impl<T: Send + 'static, F: FnOnce(&Arc<AtomicBool>) -> T + Send + 'static> Work<T, F> {
    /// Work that nobody watches.
    pub fn new(run: F) -> Self {
        Self { run, tick: Box::new(|_| Ok(())) }
    }

    /// Does the work on a thread of its own without holding the interpreter.
    ///
    /// After an interrupt (or an exception of `tick`) the work is stopped. If it has not ended 0.35 s later, it continues in the
    /// background, and its result is dropped.
    ///
    /// # Errors
    /// What a signal handler or `tick` raised; [`Error`] if the work panicked or has no thread.
    pub fn wait(mut self, py: Python<'_>) -> PyResult<T> {
        let stop = Arc::new(AtomicBool::new(false));
        let (tell, mut told) = sync_channel(1);
        let (run, flag, pool) = (self.run, Arc::clone(&stop), forked_pool()?);
        // Nobody listens any more after an interrupt.
        let work = move || match pool {
            Some(pool) => pool.install(|| run(&flag)),
            None => run(&flag),
        };
        let started = Builder::new().name("decore".to_owned()).spawn(move || drop(tell.send(work())));
        started.map_err(|error| Error::new_err(format!("failed to start a thread: {error}")))?;
        loop {
            match hear(py, &mut told, TICK) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Disconnected) => {
                    let message = "the program panicked (a defect of decore: please report it with the study)";
                    return Err(Error::new_err(message));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Err(raised) = py.check_signals().and_then(|()| (self.tick)(py)) {
                stop.store(true, Ordering::SeqCst);
                // Ended or not, the result is no longer wanted.
                drop(hear(py, &mut told, GRACE));
                return Err(raised);
            }
        }
    }
}

/// Threads of analyses in a process that was forked: its parent's threads, which rayon would wait for, are not there.
///
/// # Errors
/// [`Error`] if there are no threads.
fn forked_pool() -> PyResult<Option<Arc<ThreadPool>>> {
    let process = std::process::id();
    if *IMPORTED_BY.get_or_init(|| process) == process {
        return Ok(None);
    }
    let mut own = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, pool)) = own.as_ref().filter(|(owner, _)| *owner == process) {
        return Ok(Some(Arc::clone(pool)));
    }
    let pool = ThreadPoolBuilder::new().build();
    let pool = Arc::new(pool.map_err(|error| Error::new_err(format!("failed to start threads: {error}")))?);
    // A pool of the parent is left alone: to end it is to wait for its threads.
    std::mem::forget(own.replace((process, Arc::clone(&pool))));
    Ok(Some(pool))
}

/// Notes the process that imports the package.
pub fn imported() {
    IMPORTED_BY.get_or_init(std::process::id);
}

/// Items that are made objects, or read from them, before other Python threads get their turn: some 5 ms, the interpreter's own
/// interval.
const ROUND: usize = 1 << 14;

/// After every round of items, by their index: lets other Python threads run and hears Ctrl-C.
///
/// # Errors
/// What a signal handler raised.
pub fn give_way(py: Python<'_>, item: usize) -> PyResult<()> {
    if item % ROUND < ROUND - 1 {
        return Ok(());
    }
    py.detach(std::thread::yield_now);
    py.check_signals()
}

fn hear<T: Send>(py: Python<'_>, told: &mut Receiver<T>, time: Duration) -> Result<T, RecvTimeoutError> {
    py.detach(move || told.recv_timeout(time))
}
