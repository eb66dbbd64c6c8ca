//! Runs rows of a study: one row (pure), the batch, its progress.

mod batch;
mod machine;
mod outcome;
mod progress;
mod retry;
mod row;
mod stub;

pub use batch::{BatchError, BatchProgress, BatchSettings, BatchSummary, DEFAULT_WINDOW, RowTask, run_batch};
pub use machine::{Machine, SourceModel, model_files, reduction_settings};
pub use outcome::{RowOutcome, RowStatus, SolverCounters};
pub use progress::{DEFAULT_INTERVAL, Progress, clock};
pub use retry::{DEFAULT_RETRIES, TIGHTENING, run_row_with_retries};
pub use row::{run_row, run_row_observed};
pub use stub::StubRows;
