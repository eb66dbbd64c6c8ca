//! Runs rows of a study: one row (pure), the batch, its progress.

mod batch;
mod machine;
mod outcome;
mod progress;
mod row;

pub use batch::{BatchError, BatchProgress, BatchSettings, BatchSummary, DEFAULT_WINDOW, run_batch};
pub use machine::{Machine, SourceModel};
pub use outcome::{RowOutcome, RowStatus, SolverCounters};
pub use progress::{DEFAULT_INTERVAL, Progress};
pub use row::{run_row, run_row_observed};
