//! How one row ended: a failed row is data, not an error.

use serde::Serialize;

use crate::metrics::RunMetrics;

/// How a row ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RowStatus {
    /// Simulated to its end, and the audits hold.
    Done,
    /// Simulated to its end, but the audit of energies or of chambers fails: the outputs are there, and doubtful.
    AuditFailed,
    /// The row's parameters describe no scene that can be simulated.
    Invalid,
    /// The integration failed.
    Diverged,
    /// The budget of steps or wall time was used up.
    BudgetExhausted,
}

impl RowStatus {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Done, Self::AuditFailed, Self::Invalid, Self::Diverged, Self::BudgetExhausted];

    /// The status in tables, texts and JSON.
    pub fn text(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::AuditFailed => "audit_failed",
            Self::Invalid => "invalid",
            Self::Diverged => "diverged",
            Self::BudgetExhausted => "budget_exhausted",
        }
    }
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
    ///
    /// Twins do not count.
    pub retries: u64,
}

/// Result of one row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RowOutcome {
    /// How it ended.
    pub status: RowStatus,
    /// Why, in words; empty for `Done`.
    pub reason: String,
    /// Simulated time reached in s.
    pub time_reached_s: f64,
    /// Modes of the structure that were kept.
    pub modes: usize,
    /// States of the coupled system.
    pub states: usize,
    /// Outputs; `None` unless the row was simulated to its end.
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
