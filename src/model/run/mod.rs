//! Runs rows: one row (pure), rows in lanes, the batch.

mod batch;
mod group;
mod job;
mod outcome;
mod row;
mod threads;
mod twins;

pub use batch::{
    BatchError, BatchSettings, BatchSummary, DEFAULT_WINDOW, RowSource, RowTask, run_batch, run_one_by_one,
};
pub use group::{JobSource, run_jobs, run_jobs_in, run_jobs_over};
pub use job::{DEFAULT_RETRIES, RowJob};
pub use outcome::{RowOutcome, RowStatus};
pub use row::{run_row, run_row_observed};
pub use threads::{MOST_THREADS, ThreadCountError, thread_count};
pub use twins::{PERTURBATION, amplifies, perturbed, twin};
