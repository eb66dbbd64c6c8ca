//! Runs rows of a study: one row (pure), the batch, its progress.

mod batch;
mod outcome;
mod progress;

pub use batch::{
    BatchError, BatchProgress, BatchSettings, BatchSummary, DEFAULT_WINDOW, run_batch,
};
pub use outcome::{RowOutcome, RowStatus, SolverCounters};
pub use progress::{DEFAULT_INTERVAL, Progress};
