//! Outcome of one row. A failed row is data, not an error.

use std::any::Any;

use schemars::JsonSchema;
use serde::Serialize;

use crate::integrate::Counters;
use crate::metrics::RunMetrics;
use decore_quantity::{named, quantities};

named! {
    /// Status of a row at its end.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, JsonSchema)]
    pub enum RowStatus {
        /// Simulated to its end, and the audits hold.
        Done = "done",
        /// Simulated to its end, but the audit of energies or chambers fails. The outputs exist, but are doubtful.
        AuditFailed = "audit_failed",
        /// The row's parameters describe no scene that can be simulated.
        Invalid = "invalid",
        /// The integration failed.
        Diverged = "diverged",
        /// The budget of steps or wall time was used up.
        BudgetExhausted = "budget_exhausted",
    }
}

quantities! {
    /// Result of one row.
    #[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
    pub struct RowOutcome {
        /// Status of the row: done, audit_failed, invalid, diverged, budget_exhausted.
        pub status: RowStatus => "",
        /// Reason why the row is not done, in words; empty if it is.
        pub reason: String => "",
        /// Simulated time reached.
        pub time_reached_s: f64 => "s",
        /// Modes of the structure that were kept.
        pub modes: usize => "1",
        /// States of the coupled system.
        pub states: usize => "1",
        /// Outputs; `None` unless the row was simulated to its end.
        pub metrics: Option<RunMetrics>,
        /// Work counters.
        pub counters: Counters,
        /// Wall time that the row took; depends on the machine and its load.
        pub wall_time_s: f64 => "s",
        /// Part of the wall time that the row's numerical twin took; null without one.
        pub numerical_twin_wall_time_s: Option<f64> => "s",
    }
}

impl RowOutcome {
    /// Outcome of a row in which the program panicked, with its message.
    pub fn panicked(payload: &(dyn Any + Send)) -> Self {
        let said = match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
            (Some(message), _) => message,
            (None, Some(message)) => message.as_str(),
            (None, None) => "no message",
        };
        let reason = format!(
            "the program panicked in this row: {said} (a defect of the program: please report it with the study)"
        );
        Self { status: RowStatus::Diverged, ..Self::invalid(reason) }
    }

    /// A row whose parameters describe no scene that can be simulated.
    pub fn invalid(reason: String) -> Self {
        Self {
            status: RowStatus::Invalid,
            reason,
            time_reached_s: 0.0,
            modes: 0,
            states: 0,
            metrics: None,
            counters: Counters::default(),
            wall_time_s: 0.0,
            numerical_twin_wall_time_s: None,
        }
    }
}
