//! Runs the rows of a study on several threads and hands the outcomes over in row order.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;

use super::outcome::{RowOutcome, RowStatus};
use super::threads::{ThreadCountError, thread_count};

/// Default of [`BatchSettings::window`].
pub const DEFAULT_WINDOW: u64 = 1024;
/// Largest number of ready rows before the calling thread is woken.
const MOST_READY: u64 = 64;
/// Longest time between two wake-ups of the calling thread while rows end.
const LONGEST_WAIT: Duration = Duration::from_millis(20);
/// Time between two calls of [`BatchSettings::tick`].
const TICK: Duration = Duration::from_millis(250);

/// Settings of a batch.
#[derive(Clone, Copy)]
pub struct BatchSettings<'a> {
    /// Number of threads that run rows; 0: see [`thread_count`]. The outcomes do not depend on it.
    pub threads: usize,
    /// Reorder window: at most this many rows are started beyond the oldest one that is not yet handed over (at least 1).
    ///
    /// It bounds the memory (outcomes held) and the time for which a single long row can continue without the other
    /// threads running dry: `window` times a usual row's time, divided by the other threads. Default
    /// [`DEFAULT_WINDOW`]: some ten megabytes of outcomes.
    pub window: u64,
    /// Set from outside (another thread, a signal handler) to start no more rows.
    pub stop: &'a AtomicBool,
    /// Called on the calling thread every quarter of a second while it waits for rows or hands them over.
    pub tick: &'a dyn Fn(),
}

/// Result of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BatchSummary {
    /// Rows handed to the sink.
    pub rows: u64,
    /// Of these, rows with another status than done.
    pub failed: u64,
    /// Whether the stop flag left rows that were not started.
    pub stopped: bool,
}

/// Reason why a batch ended early.
#[derive(Debug, thiserror::Error)]
pub enum BatchError<E: std::error::Error + 'static> {
    /// The number of threads is out of range.
    #[error("{0}")]
    ThreadCount(#[from] ThreadCountError),
    /// The threads could not be started.
    #[error(
        "failed to start {threads} threads: {source} (ask for fewer threads, or raise the limits on memory and processes: \
         `ulimit -v`, `ulimit -u`)"
    )]
    Threads {
        /// Requested number.
        threads: usize,
        /// Cause.
        #[source]
        source: rayon::ThreadPoolBuildError,
    },
    /// The sink refused a row; rows that were running have ended, their outcomes are dropped.
    #[error("failed to store row {row}: {source}")]
    Sink {
        /// The row.
        row: u64,
        /// Cause.
        #[source]
        source: E,
    },
}

/// Source of rows for a thread, and destination of their outcomes.
pub trait RowSource {
    /// Starts the next row; `None` if there is none. While no row may be started because the window is full, it waits if `wait` is
    /// set, which asks for all rows of this thread to have ended; otherwise there is none now, and none either once this thread runs
    /// its share of the last rows.
    fn next(&mut self, wait: bool) -> Option<u64>;

    /// A row has ended.
    fn ended(&mut self, row: u64, outcome: RowOutcome);
}

/// Work on rows, on the threads that run them.
pub trait RowTask: Sync {
    /// Kept part of an outcome.
    type Kept: Send;

    /// Runs rows on one thread until there are no more. The result of a row must depend only on the row.
    fn run(&self, rows: &mut dyn RowSource);

    /// Makes the kept result as soon as the row has ended, before the order is restored. Store it here.
    fn keep(&self, row: u64, outcome: RowOutcome) -> Self::Kept;
}

impl<F: Fn(u64) -> RowOutcome + Sync> RowTask for F {
    type Kept = RowOutcome;

    fn run(&self, rows: &mut dyn RowSource) {
        run_one_by_one(rows, self);
    }

    fn keep(&self, _: u64, outcome: RowOutcome) -> RowOutcome {
        outcome
    }
}

/// Runs rows one after the other; a panic becomes a failed row.
pub fn run_one_by_one(rows: &mut dyn RowSource, run: impl Fn(u64) -> RowOutcome) {
    while let Some(row) = rows.next(true) {
        let start = Instant::now();
        // A pure function leaves nothing behind that a panic could have broken.
        let outcome = catch_unwind(AssertUnwindSafe(|| run(row))).unwrap_or_else(|payload| RowOutcome {
            wall_time_s: start.elapsed().as_secs_f64(),
            ..RowOutcome::panicked(payload.as_ref())
        });
        rows.ended(row, outcome);
    }
}

/// Runs `task` for every row and passes the kept results to `sink` in the order of `rows`.
///
/// Rows are given out one at a time, so long ones hold up no others (within the window). As running a row is pure, the
/// outcomes (wall times apart) are the same for any number of threads. `sink` runs on the calling thread.
///
/// After a stop no more rows are started; running rows end and are passed on. Rows are started in order, so `sink` always receives the
/// first rows without a gap.
///
/// # Errors
/// [`BatchError::ThreadCount`]; [`BatchError::Threads`]; [`BatchError::Sink`] with the sink's first error, after which no more rows are
/// started.
pub fn run_batch<T: RowTask, E: std::error::Error + 'static>(
    rows: impl Iterator<Item = u64> + Send,
    settings: &BatchSettings<'_>,
    task: &T,
    sink: impl FnMut(u64, T::Kept) -> Result<(), E>,
) -> Result<BatchSummary, BatchError<E>> {
    let threads = thread_count(settings.threads)?;
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|index| format!("row-{index}"))
        .build()
        .map_err(|source| BatchError::Threads { threads, source })?;
    let queue = Queue::new(rows, pool.current_num_threads(), settings);
    let result = pool.in_place_scope(|scope| {
        // Closes the queue on every way out, a panic of the sink included; otherwise the threads would wait for ever.
        let _closed = CloseOnDrop(&queue);
        // A broadcast, because a row that waits for nested parallel work could else pick up another thread's loop.
        scope.spawn_broadcast(|_, _| queue.run_rows(task));
        queue.deliver(sink, &mut Ticker { tick: settings.tick, last: Instant::now() })
    });
    let (rows, failed) = result?;
    Ok(BatchSummary { rows, failed, stopped: queue.has_rows_left() })
}

/// Rows to start and outcomes to hand over, shared by the threads.
struct Queue<'a, I, K> {
    state: Mutex<State<I, K>>,
    /// An outcome arrived or a thread ended.
    arrived: Condvar,
    /// The window moved or the queue was closed.
    moved: Condvar,
    window: u64,
    stop: &'a AtomicBool,
}

struct State<I, K> {
    rows: I,
    /// Rows started so far; a row's number in this order is its ticket.
    started: u64,
    /// Outcomes that the sink has taken.
    delivered: u64,
    /// Kept results, by ticket.
    ready: BTreeMap<u64, Ready<K>>,
    /// Time of the last wake-up of the calling thread.
    told: Instant,
    /// Rows that have been started and have not ended.
    running: usize,
    /// Threads that have not ended.
    threads: usize,
    /// Number of threads that wait for the window to move. Waking nobody would still be a system call.
    waiting: usize,
    closed: bool,
}

struct Ready<K> {
    row: u64,
    failed: bool,
    kept: K,
}

impl<'a, I: Iterator<Item = u64>, K> Queue<'a, I, K> {
    fn new(rows: I, threads: usize, settings: &BatchSettings<'a>) -> Self {
        Self {
            state: Mutex::new(State {
                rows,
                started: 0,
                delivered: 0,
                ready: BTreeMap::new(),
                told: Instant::now(),
                running: 0,
                threads,
                waiting: 0,
                closed: false,
            }),
            arrived: Condvar::new(),
            moved: Condvar::new(),
            window: settings.window.max(1),
            stop: settings.stop,
        }
    }

    /// The state stays consistent even if a thread panicked with the lock: every change is a single assignment.
    fn lock(&self) -> MutexGuard<'_, State<I, K>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One thread's loop.
    fn run_rows<T: RowTask<Kept = K>>(&self, task: &T) {
        let _ended = EndThreadOnDrop(self);
        task.run(&mut ThreadRows { queue: self, task, started: Vec::new() });
    }

    /// Stores the result of a row, and wakes the calling thread only now and then: for short rows each wake-up would be too expensive.
    fn hand_in(&self, ticket: u64, ready: Ready<K>) {
        let mut state = self.lock();
        state.running -= 1;
        state.ready.insert(ticket, ready);
        let many = state.ready.len() as u64 >= (self.window / 4).clamp(1, MOST_READY);
        if many || state.told.elapsed() >= LONGEST_WAIT {
            state.told = Instant::now();
            drop(state);
            self.arrived.notify_one();
        }
    }

    /// The next row and its ticket; while the window is full it waits, or there is none.
    ///
    /// Without waiting there is none either for a thread that runs `own` rows already if these are its share of those that are
    /// left: at the end of a batch no thread should run many rows side by side while another has none.
    fn next_row(&self, wait: bool, own: usize) -> Option<(u64, u64)> {
        let mut state = self.lock();
        if let (false, (_, Some(left))) = (wait, state.rows.size_hint()) {
            let share = (left + state.running).div_ceil(state.threads.max(1));
            if own >= share {
                return None;
            }
        }
        loop {
            if state.closed || self.stop.load(Ordering::Relaxed) {
                return None;
            }
            if state.started - state.delivered < self.window {
                break;
            }
            if !wait {
                return None;
            }
            state.waiting += 1;
            state = self.moved.wait(state).unwrap_or_else(PoisonError::into_inner);
            state.waiting -= 1;
        }
        let row = state.rows.next()?;
        let ticket = state.started;
        state.started += 1;
        state.running += 1;
        Some((ticket, row))
    }

    /// Hands the outcomes to the sink until all threads have ended; returns rows and failed rows.
    fn deliver<E: std::error::Error + 'static>(
        &self,
        mut sink: impl FnMut(u64, K) -> Result<(), E>,
        ticker: &mut Ticker<'_>,
    ) -> Result<(u64, u64), BatchError<E>> {
        let (mut rows, mut failed) = (0, 0);
        while let Some(ready) = self.next_outcome(rows, ticker) {
            failed += u64::from(ready.failed);
            let row = ready.row;
            sink(row, ready.kept).map_err(|source| BatchError::Sink { row, source })?;
            rows += 1;
            let mut state = self.lock();
            state.delivered = rows;
            let wanted = state.waiting > 0;
            drop(state);
            if wanted {
                self.moved.notify_all();
            }
        }
        Ok((rows, failed))
    }

    /// Waits for the outcome with this ticket; `None` when all threads have ended without it.
    fn next_outcome(&self, ticket: u64, ticker: &mut Ticker<'_>) -> Option<Ready<K>> {
        loop {
            ticker.look();
            let mut state = self.lock();
            if let Some(outcome) = state.ready.remove(&ticket) {
                return Some(outcome);
            }
            if state.threads == 0 {
                return None;
            }
            drop(self.arrived.wait_timeout(state, TICK).unwrap_or_else(PoisonError::into_inner));
        }
    }

    /// Whether the stop flag left rows. Requests the next row, so call it only after the batch.
    fn has_rows_left(&self) -> bool {
        self.lock().rows.next().is_some()
    }
}

/// Reports elapsed time.
struct Ticker<'t> {
    tick: &'t dyn Fn(),
    last: Instant,
}

impl Ticker<'_> {
    fn look(&mut self) {
        if self.last.elapsed() >= TICK {
            (self.tick)();
            self.last = Instant::now();
        }
    }
}

struct CloseOnDrop<'q, 'a, I: Iterator<Item = u64>, K>(&'q Queue<'a, I, K>);

impl<I: Iterator<Item = u64>, K> Drop for CloseOnDrop<'_, '_, I, K> {
    fn drop(&mut self) {
        self.0.lock().closed = true;
        self.0.moved.notify_all();
    }
}

struct EndThreadOnDrop<'q, 'a, I: Iterator<Item = u64>, K>(&'q Queue<'a, I, K>);

impl<I: Iterator<Item = u64>, K> Drop for EndThreadOnDrop<'_, '_, I, K> {
    fn drop(&mut self) {
        self.0.lock().threads -= 1;
        self.0.arrived.notify_one();
    }
}

/// The rows of one thread.
struct ThreadRows<'r, 'a, T: RowTask, I> {
    queue: &'r Queue<'a, I, T::Kept>,
    task: &'r T,
    /// Rows that have not ended, with their tickets.
    started: Vec<(u64, u64)>,
}

impl<T: RowTask, I: Iterator<Item = u64>> RowSource for ThreadRows<'_, '_, T, I> {
    fn next(&mut self, wait: bool) -> Option<u64> {
        let (ticket, row) = self.queue.next_row(wait, self.started.len())?;
        self.started.push((row, ticket));
        Some(row)
    }

    fn ended(&mut self, row: u64, outcome: RowOutcome) {
        let Some(at) = self.started.iter().position(|started| started.0 == row) else { return };
        let (_, ticket) = self.started.swap_remove(at);
        let status = outcome.status;
        let kept = self.task.keep(row, outcome);
        self.queue.hand_in(ticket, Ready { row, failed: status != RowStatus::Done, kept });
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::Barrier;
    use std::sync::atomic::AtomicU64;
    use std::thread::sleep;

    use super::*;
    use crate::integrate::Counters;

    static NEVER: AtomicBool = AtomicBool::new(false);

    fn settings(threads: usize) -> BatchSettings<'static> {
        BatchSettings { threads, window: DEFAULT_WINDOW, stop: &NEVER, tick: &|| () }
    }

    fn outcome(row: u64) -> RowOutcome {
        RowOutcome {
            status: if row % 10 == 3 { RowStatus::Invalid } else { RowStatus::Done },
            reason: format!("row {row}"),
            time_reached_s: (row as f64).sqrt(),
            modes: 0,
            states: 0,
            metrics: None,
            counters: Counters::default(),
            wall_time_s: 0.0,
            numerical_twin_wall_time_s: None,
        }
    }

    type Delivered = Vec<(u64, RowOutcome)>;

    fn collect(
        rows: impl Iterator<Item = u64> + Send,
        settings: &BatchSettings<'_>,
        work: impl Fn(u64) -> RowOutcome + Sync,
    ) -> (BatchSummary, Delivered) {
        let mut delivered = Vec::new();
        let summary = run_batch(rows, settings, &work, |row, outcome| {
            delivered.push((row, outcome));
            Ok::<(), io::Error>(())
        });
        (summary.expect("the sink never fails"), delivered)
    }

    #[test]
    fn rows_arrive_in_order_whatever_their_durations() {
        let uneven = |row: u64| {
            sleep(Duration::from_micros(row * 7919 % 1500));
            outcome(row)
        };
        let (summary, delivered) = collect(5..205, &settings(4), uneven);
        assert_eq!((summary.rows, summary.failed, summary.stopped), (200, 20, false));
        let rows: Vec<u64> = delivered.iter().map(|(row, _)| *row).collect();
        assert_eq!(rows, (5..205).collect::<Vec<_>>());
    }

    #[test]
    fn one_and_two_threads_deliver_the_same() {
        let one = collect(0..100, &settings(1), outcome);
        let two = collect(0..100, &settings(2), outcome);
        assert_eq!(one, two);
    }

    #[test]
    fn time_is_told_of_while_a_row_runs_and_between_many() {
        for row_ms in [1000, 1] {
            let ticks = AtomicU64::new(0);
            let tick = || _ = ticks.fetch_add(1, Ordering::SeqCst);
            let work = |row| {
                sleep(Duration::from_millis(row_ms));
                outcome(row)
            };
            collect(0..1000 / row_ms, &BatchSettings { tick: &tick, ..settings(1) }, work);
            assert!(ticks.into_inner() >= 2, "rows of {row_ms} ms");
        }
    }

    #[test]
    fn no_rows_are_no_problem() {
        let (summary, delivered) = collect(std::iter::empty(), &settings(2), outcome);
        assert_eq!((summary.rows, summary.stopped, delivered.len()), (0, false, 0));
    }

    #[test]
    fn a_panic_is_a_failed_row() {
        let work = |row| {
            assert!(row != 4, "no luck with row {row}");
            outcome(row)
        };
        let (summary, delivered) = collect(0..10, &settings(2), work);
        assert_eq!((summary.rows, summary.failed), (10, 2));
        let (_, panicked) = &delivered[4];
        assert_eq!(panicked.status, RowStatus::Diverged);
        assert!(panicked.reason.contains("no luck with row 4"), "{}", panicked.reason);
        assert_eq!(delivered[5].1, outcome(5));
    }

    #[test]
    fn a_long_row_does_not_stall_the_others() {
        // Row 0 ends only when row 99 has been run: with two threads this needs the others to pass it.
        let passed = Barrier::new(2);
        let work = |row| {
            if row == 0 || row == 99 {
                passed.wait();
            }
            outcome(row)
        };
        let (summary, delivered) = collect(0..200, &settings(2), work);
        assert_eq!((summary.rows, delivered[0].0), (200, 0));
    }

    #[test]
    fn the_window_bounds_the_rows_in_flight() {
        let started = AtomicU64::new(0);
        let delivered = AtomicU64::new(0);
        let most = AtomicU64::new(0);
        let narrow = BatchSettings { window: 8, ..settings(3) };
        let work = |row| {
            let started = 1 + started.fetch_add(1, Ordering::SeqCst);
            let in_flight = started.saturating_sub(delivered.load(Ordering::SeqCst));
            most.fetch_max(in_flight, Ordering::SeqCst);
            if row % 20 == 0 {
                sleep(Duration::from_millis(5));
            }
            outcome(row)
        };
        let sink = |_, _| {
            delivered.fetch_add(1, Ordering::SeqCst);
            Ok::<(), io::Error>(())
        };
        run_batch(0..100, &narrow, &work, sink).expect("the sink never fails");
        let most = most.into_inner();
        // The sink counts before the runner moves the window, so no row can be seen beyond it.
        assert!((2..=8).contains(&most), "{most} rows in flight");
    }

    #[test]
    fn an_error_of_the_sink_stops_cleanly() {
        let run = AtomicU64::new(0);
        let work = |row| {
            run.fetch_add(1, Ordering::SeqCst);
            sleep(Duration::from_micros(200));
            outcome(row)
        };
        let mut taken = Vec::new();
        let result = run_batch(0..1_000_000, &settings(2), &work, |row, _| {
            if row == 20 {
                return Err(io::Error::other("disk full"));
            }
            taken.push(row);
            Ok(())
        });
        match result {
            Err(BatchError::Sink { row: 20, source }) => {
                assert_eq!(source.to_string(), "disk full")
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(taken, (0..20).collect::<Vec<_>>());
        assert!(run.into_inner() < 20 + 2 * DEFAULT_WINDOW);
    }

    #[test]
    fn a_panic_of_the_sink_does_not_hang() {
        let result = catch_unwind(|| {
            run_batch(0..1_000_000, &settings(2), &outcome, |row, _| {
                assert!(row < 5, "sink broke");
                Ok::<(), io::Error>(())
            })
        });
        assert!(result.is_err());
    }

    #[test]
    fn stop_delivers_a_beginning_without_gap() {
        let stop = AtomicBool::new(false);
        let stoppable = BatchSettings { stop: &stop, ..settings(3) };
        let run = AtomicU64::new(0);
        let work = |row| {
            if row == 30 {
                stop.store(true, Ordering::Relaxed);
            }
            sleep(Duration::from_micros(300));
            run.fetch_add(1, Ordering::SeqCst);
            outcome(row)
        };
        let (summary, delivered) = collect(0..1_000_000, &stoppable, work);
        assert!(summary.stopped);
        assert!((31..100).contains(&summary.rows), "{} rows", summary.rows);
        assert_eq!(summary.rows, run.into_inner(), "every row that was started is delivered");
        let rows: Vec<u64> = delivered.iter().map(|(row, _)| *row).collect();
        assert_eq!(rows, (0..summary.rows).collect::<Vec<_>>());
    }

    /// A thread that takes several rows at a time takes no more than its share of the last ones.
    #[test]
    fn the_last_rows_are_shared() {
        struct Greedy(Mutex<Vec<usize>>);
        impl RowTask for Greedy {
            type Kept = RowOutcome;

            fn run(&self, rows: &mut dyn RowSource) {
                while let Some(first) = rows.next(true) {
                    let mut taken = vec![first];
                    while let Some(row) = rows.next(false) {
                        taken.push(row);
                    }
                    self.0.lock().unwrap().push(taken.len());
                    taken.into_iter().for_each(|row| rows.ended(row, outcome(row)));
                }
            }

            fn keep(&self, _: u64, outcome: RowOutcome) -> RowOutcome {
                outcome
            }
        }
        for (threads, most) in [(1, 10), (2, 5), (3, 4)] {
            let task = Greedy(Mutex::new(Vec::new()));
            let summary = run_batch(0..10, &settings(threads), &task, |_, _| Ok::<(), io::Error>(())).unwrap();
            assert_eq!(summary.rows, 10);
            let taken = task.0.into_inner().unwrap();
            assert_eq!(taken.iter().max(), Some(&most), "{threads} threads: {taken:?}");
        }
    }
}
