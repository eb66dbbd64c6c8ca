//! Counters of an integration.

use schemars::JsonSchema;
use serde::Serialize;

use decore_quantity::quantities;

quantities! {
    /// Work done.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
    pub struct Counters {
        /// Accepted steps.
        pub steps: u64 => "1" [less],
        /// Rejected steps.
        pub rejected_steps: u64 => "1" [less],
        /// Right-hand sides evaluated.
        pub rhs_evaluations: u64 => "1" [less],
        /// Contact onsets and releases.
        pub located_events: u64 => "1" [less],
        /// Factorisations of a matrix (implicit methods).
        pub factorisations: u64 => "1" [less],
        /// Times the run was repeated with a stricter tolerance; the other counters are of the last time.
        pub retries: u64 => "1" [less],
    }
}
