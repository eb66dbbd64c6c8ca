//! Force law of one-sided contacts.
//!
//! A contact acts along one relative coordinate: the penetration `d` (m, positive when the bodies overlap) and its rate
//! `d'` (m/s). The law is a pure function; which contact is closed, and when, is the business of `system`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Stiffness and damping of a one-sided Kelvin-Voigt contact.
///
/// `N(d, d') = max(0, k d + c d')` for `d > 0`, else 0: the contact pushes and never pulls.
///
/// The force jumps by `c d'` at onset and is continuous at release. So that an integrator only ever sees a smooth
/// right-hand side, the law is split at its two switching surfaces: a closed contact applies [`Self::closed_force`]
/// until it would pull, an open one applies nothing until [`Self::onset_indicator`] turns positive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactParameters {
    /// Contact stiffness `k` in N/m; must be positive.
    pub stiffness_n_per_m: f64,
    /// Contact damping `c` in N s/m; zero or positive.
    pub damping_n_s_per_m: f64,
}

impl ContactParameters {
    /// Force of the closed contact in N, `k d + c d'`; negative once the contact should have opened.
    #[inline]
    pub fn closed_force(&self, penetration: f64, rate: f64) -> f64 {
        self.stiffness_n_per_m * penetration + self.damping_n_s_per_m * rate
    }

    /// Positive when an open contact must close: `k d + c min(d', 0)` in N.
    ///
    /// While the bodies approach it is the penetration's sign; while they separate (a contact that opened with `d > 0`
    /// because it would have pulled) it is the sign of the force. It is continuous in `d` and `d'`, so its zero can be
    /// located.
    #[inline]
    pub fn onset_indicator(&self, penetration: f64, rate: f64) -> f64 {
        self.stiffness_n_per_m * penetration + self.damping_n_s_per_m * rate.min(0.0)
    }

    /// Energy stored in the spring in J, `k d^2 / 2`.
    #[inline]
    pub fn stored_energy(&self, penetration: f64) -> f64 {
        0.5 * self.stiffness_n_per_m * penetration * penetration
    }
}
