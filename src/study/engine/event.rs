//! Events of a sweep.

use std::path::Path;

use decore_dataset::{DatasetError, Growth};
use decore_model::run::RowStatus;

/// Listener of all events of a sweep; rows end on several threads.
pub type Listener<'a> = dyn Fn(SweepEvent<'_>) + Sync + 'a;

/// Something that happens in a sweep. The library prints none of it.
#[derive(Debug, Clone, Copy)]
pub enum SweepEvent<'a> {
    /// The study has more rows than the dataset was made for: those that are done are kept.
    Grown {
        /// Rows that are kept, and damaged ones.
        growth: &'a Growth,
        /// Rows of the study now.
        rows: u64,
    },
    /// Damaged parts in the folder; their rows are computed again.
    Found {
        /// The faults.
        damaged: &'a [DatasetError],
        /// Further findings and repairs, in words.
        notes: &'a [String],
    },
    /// The remaining rows begin.
    Begins {
        /// Rows that the dataset is to hold.
        rows: u64,
        /// Existing rows from earlier runs.
        done: u64,
        /// Of these, rows with another status than done.
        failed: u64,
    },
    /// So many of the rows that are left have the same factors as another one of these: they get its outcome.
    Repeats {
        /// Number of rows.
        rows: u64,
    },
    /// A row ended; called on the thread that ran it, which waits for the listener.
    RowEnded(RowStatus),
    /// Time passed: called four times a second while rows run, on the thread that began the sweep.
    Tick,
    /// No more rows are run.
    Ends,
    /// The summary could not be written to this file.
    SummaryNotWritten(&'a Path),
    /// Rows or tables could not be written. Stored rows are kept; the same sweep continues.
    Failed,
}
