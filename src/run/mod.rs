//! Runs rows: one row (pure), the batch.

mod batch;
mod outcome;
mod retry;
mod row;
mod twins;

pub use batch::{BatchError, BatchProgress, BatchSettings, BatchSummary, DEFAULT_WINDOW, RowTask, run_batch};
pub use outcome::{RowOutcome, RowStatus};
pub use retry::{DEFAULT_RETRIES, TIGHTENING, run_row_with_retries, run_row_with_retries_observed};
pub use row::{RESIDUAL_LIMIT, run_row, run_row_observed};
pub use twins::{PERTURBATION, amplifies, perturbed, twin};
