//! Runs rows of a study: one row (pure), the batch.

mod outcome;

pub use outcome::{RowOutcome, RowStatus, SolverCounters};
