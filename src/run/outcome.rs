//! How one row ended: a failed row is data, not an error.

use serde::Serialize;

use crate::metrics::RunMetrics;

/// How a row ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RowStatus {
    /// Simulated to its end.
    Done,
    /// The row's parameters describe no scene that can be simulated.
    Invalid,
    /// The integration failed.
    Diverged,
    /// The budget of steps or wall time was used up.
    BudgetExhausted,
}

/// Work counters of one run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct SolverCounters {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected_steps: u64,
    /// Right-hand sides evaluated.
    pub rhs_evaluations: u64,
    /// Contact onsets and releases.
    pub located_events: u64,
    /// Factorisations of a matrix (implicit methods).
    pub factorisations: u64,
    /// Times the run was repeated with a stricter tolerance; the other counters are of the last time.
    pub retries: u64,
}

/// Result of one row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RowOutcome {
    /// How it ended.
    pub status: RowStatus,
    /// Why, in words; empty for `Done`, unless the energy audit makes the outputs doubtful.
    pub reason: String,
    /// Simulated time reached in s.
    pub time_reached_s: f64,
    /// Modes of the structure that were kept.
    pub modes: usize,
    /// States of the coupled system.
    pub states: usize,
    /// Outputs; `None` unless the row is `Done`.
    pub metrics: Option<RunMetrics>,
    /// Work counters.
    pub counters: SolverCounters,
    /// Wall time of the row in s (the only figure that depends on the machine).
    pub wall_time_s: f64,
}

impl RowOutcome {
    /// A row whose parameters describe no scene that can be simulated.
    pub fn invalid(reason: String) -> Self {
        Self {
            status: RowStatus::Invalid,
            reason,
            time_reached_s: 0.0,
            modes: 0,
            states: 0,
            metrics: None,
            counters: SolverCounters::default(),
            wall_time_s: 0.0,
        }
    }
}
