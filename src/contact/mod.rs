//! Force laws of one-sided contacts.
//!
//! A contact acts along one relative coordinate: the penetration `d` (m, positive when the bodies overlap) and its rate
//! `d'` (m/s). The laws are pure functions; which contact is closed, and when, is the business of `system`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Stiffness and damping of a one-sided Kelvin-Voigt contact.
///
/// `N(d, d') = max(0, k d + c d')` for `d > 0`, else 0: the contact pushes and never pulls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactParameters {
    /// Contact stiffness `k` in N/m; must be positive.
    pub stiffness_n_per_m: f64,
    /// Contact damping `c` in N s/m; zero or positive.
    pub damping_n_s_per_m: f64,
}
