//! Runs rows of a study: one row (pure), the batch.

mod outcome;
mod row;

pub use outcome::{RowOutcome, RowStatus, SolverCounters};
pub use row::{run_row, run_row_observed};
