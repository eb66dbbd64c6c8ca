//! The laws as pure functions of penetration and rate.

use decore_math::number::{Lanes, Number, odd_power};

/// Exponent of the Hertz law.
pub(super) const HERTZ_EXPONENT: f64 = 1.5;

/// A contact law with its coefficients.
///
/// So that an integrator only ever sees a smooth right-hand side, every law is split at its two switching surfaces: a
/// closed contact applies [`Self::closed_force`] until [`Self::release_indicator`] turns positive, an open one applies
/// nothing until [`Self::onset_indicator`] does. Both indicators are continuous in `d` and `d'`; only their sign and
/// their zero mean something. For `d < 0`, which a step may touch before its switch is located, elastic forces are
/// continued as odd functions of `d`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactLaw<R = f64> {
    /// `N = max(0, k d + c d')` for `d > 0`: pushes and never pulls. Jumps by `c d'` at onset, continuous at release.
    KelvinVoigt {
        /// `k` in N/m.
        stiffness_n_per_m: R,
        /// `c` in N s/m.
        damping_n_s_per_m: R,
    },
    /// `N = k d + c d'` for `d > 0`: the bodies part at zero penetration and pull a little just before.
    KelvinVoigtSeparating {
        /// `k` in N/m.
        stiffness_n_per_m: R,
        /// `c` in N s/m.
        damping_n_s_per_m: R,
    },
    /// `N = max(0, K d^n (1 + a d'))` for `d > 0` (Hunt and Crossley 1975): continuous at onset and release.
    HuntCrossley {
        /// `K` in N/m^n.
        stiffness_n_per_m_n: R,
        /// `n`, at least 1.
        exponent: R,
        /// `a` in s/m.
        damping_s_per_m: R,
    },
    /// `N = max(0, K d^(3/2) + C d^(1/4) d')` for `d > 0`: Hertz with the damping of Tsuji, Tanaka and Ishida (1992),
    /// whose restitution does not depend on the speed.
    Hertz {
        /// `K` in N/m^(3/2).
        stiffness_n_per_m_1_5: R,
        /// `C` in N s/m^(5/4).
        damping_n_s_per_m_1_25: R,
    },
}

/// `|x|^(1/4)`.
#[inline(always)]
fn fourth_root<R: Number>(x: R) -> R {
    x.abs().sqrt().sqrt()
}

/// `K sign(d) |d|^(5/4) + C d'` with coefficients `(K, C)`: the Hertz force without its common factor `|d|^(1/4)`.
#[inline(always)]
fn reduced_hertz<R: Number>((stiffness, damping): (R, R), penetration: R, rate: R) -> R {
    stiffness * penetration * fourth_root(penetration) + damping * rate
}

/// Puts the coefficients of all laws into lanes. A law or coefficient that is not listed does not compile: with another row's it would
/// give plausible figures.
macro_rules! coefficients_in_lanes {
    ($($law:ident { $($coefficient:ident),+ })+) => {
        impl<R: Number> Lanes for ContactLaw<R> {
            type Alone = ContactLaw;

            /// Sets the coefficients of a lane: the laws of all lanes are of one kind, another law changes nothing.
            fn put(&mut self, lane: usize, alone: &ContactLaw) {
                match self { $(
                    Self::$law { $($coefficient),+ } => { $(
                        if let ContactLaw::$law { $coefficient: value, .. } = alone {
                            $coefficient.put(lane, value);
                        }
                    )+ }
                )+ }
            }
        }

        impl ContactLaw {
            /// The same law in all lanes.
            pub fn in_lanes<R: Number>(&self) -> ContactLaw<R> {
                match *self { $(
                    Self::$law { $($coefficient),+ } => ContactLaw::$law { $($coefficient: R::splat($coefficient)),+ },
                )+ }
            }
        }
    };
}

coefficients_in_lanes! {
    KelvinVoigt { stiffness_n_per_m, damping_n_s_per_m }
    KelvinVoigtSeparating { stiffness_n_per_m, damping_n_s_per_m }
    HuntCrossley { stiffness_n_per_m_n, exponent, damping_s_per_m }
    Hertz { stiffness_n_per_m_1_5, damping_n_s_per_m_1_25 }
}

impl<R: Number> ContactLaw<R> {
    /// Force of the closed contact in N; may be negative once the contact should have opened.
    #[inline(always)]
    pub fn closed_force(&self, penetration: R, rate: R) -> R {
        match *self {
            Self::KelvinVoigt { stiffness_n_per_m, damping_n_s_per_m }
            | Self::KelvinVoigtSeparating { stiffness_n_per_m, damping_n_s_per_m } => {
                stiffness_n_per_m * penetration + damping_n_s_per_m * rate
            }
            Self::HuntCrossley { stiffness_n_per_m_n, exponent, damping_s_per_m } => {
                stiffness_n_per_m_n * odd_power(penetration, exponent) * (R::splat(1.0) + damping_s_per_m * rate)
            }
            Self::Hertz { stiffness_n_per_m_1_5, damping_n_s_per_m_1_25 } => {
                stiffness_n_per_m_1_5 * odd_power(penetration, R::splat(HERTZ_EXPONENT))
                    + damping_n_s_per_m_1_25 * fourth_root(penetration) * rate
            }
        }
    }

    /// Force in N at the first moment of a contact, when the bodies approach at `rate`, m/s: the damper's, before anything is compressed.
    /// It is 0 for laws that are continuous at onset, and for a contact that begins while the bodies separate.
    #[inline(always)]
    pub fn jump(&self, rate: R) -> R {
        match *self {
            Self::KelvinVoigt { damping_n_s_per_m, .. } | Self::KelvinVoigtSeparating { damping_n_s_per_m, .. } => {
                damping_n_s_per_m * rate.greatest(R::splat(0.0))
            }
            Self::HuntCrossley { .. } | Self::Hertz { .. } => R::splat(0.0),
        }
    }

    /// Power dissipated by the closed contact in W: the closed force less the elastic one, times the rate.
    #[inline(always)]
    pub fn dissipated_power(&self, penetration: R, rate: R) -> R {
        match *self {
            Self::KelvinVoigt { damping_n_s_per_m, .. } | Self::KelvinVoigtSeparating { damping_n_s_per_m, .. } => {
                damping_n_s_per_m * rate * rate
            }
            Self::HuntCrossley { stiffness_n_per_m_n, exponent, damping_s_per_m } => {
                stiffness_n_per_m_n * odd_power(penetration, exponent) * damping_s_per_m * rate * rate
            }
            Self::Hertz { damping_n_s_per_m_1_25, .. } => {
                damping_n_s_per_m_1_25 * fourth_root(penetration) * rate * rate
            }
        }
    }

    /// Energy stored in the closed contact in J: `k d^2 / 2`, `K |d|^(n + 1) / (n + 1)`.
    #[inline(always)]
    pub fn stored_energy(&self, penetration: R) -> R {
        match *self {
            Self::KelvinVoigt { stiffness_n_per_m, .. } | Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => {
                R::splat(0.5) * stiffness_n_per_m * penetration * penetration
            }
            Self::HuntCrossley { stiffness_n_per_m_n, exponent, .. } => {
                stiffness_n_per_m_n * odd_power(penetration, exponent) * penetration / (exponent + R::splat(1.0))
            }
            Self::Hertz { stiffness_n_per_m_1_5, .. } => {
                stiffness_n_per_m_1_5 * odd_power(penetration, R::splat(HERTZ_EXPONENT)) * penetration
                    / R::splat(HERTZ_EXPONENT + 1.0)
            }
        }
    }

    /// Positive when an open contact must close: where the closed force would push.
    ///
    /// While the bodies approach it has the sign of the penetration; while they separate (a contact that opened with
    /// `d > 0` because it would have pulled) that of the force. Kelvin-Voigt: `k d + c min(d', 0)` in N; with
    /// separation: `k d`; Hunt-Crossley: the lesser of `d` and `1 + a d'`; Hertz: `K d^(5/4) + C min(d', 0)`, the force
    /// without its common factor `d^(1/4)`.
    #[inline(always)]
    pub fn onset_indicator(&self, penetration: R, rate: R) -> R {
        match *self {
            Self::KelvinVoigt { stiffness_n_per_m, damping_n_s_per_m } => {
                stiffness_n_per_m * penetration + damping_n_s_per_m * rate.least(R::splat(0.0))
            }
            Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => stiffness_n_per_m * penetration,
            Self::HuntCrossley { damping_s_per_m, .. } => penetration.least(R::splat(1.0) + damping_s_per_m * rate),
            Self::Hertz { stiffness_n_per_m_1_5, damping_n_s_per_m_1_25 } => {
                reduced_hertz((stiffness_n_per_m_1_5, damping_n_s_per_m_1_25), penetration, rate.least(R::splat(0.0)))
            }
        }
    }

    /// Positive when a closed contact must open: where it would pull, or for separation at zero penetration where the
    /// bodies part.
    #[inline(always)]
    pub fn release_indicator(&self, penetration: R, rate: R) -> R {
        match *self {
            Self::KelvinVoigt { .. } => -self.closed_force(penetration, rate),
            Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => -stiffness_n_per_m * penetration,
            Self::HuntCrossley { damping_s_per_m, .. } => {
                (-penetration).greatest(R::splat(-1.0) - damping_s_per_m * rate)
            }
            Self::Hertz { stiffness_n_per_m_1_5, damping_n_s_per_m_1_25 } => {
                -reduced_hertz((stiffness_n_per_m_1_5, damping_n_s_per_m_1_25), penetration, rate)
            }
        }
    }

    /// A smooth function that is positive only where [`Self::release_indicator`] is, and its rate along a motion of
    /// penetration `penetration`, rate `rate` and acceleration `acceleration`.
    #[inline(always)]
    pub fn smooth_release(&self, penetration: R, rate: R, acceleration: R) -> (R, R) {
        match *self {
            Self::KelvinVoigt { .. } => (-self.closed_force(penetration, rate), -self.closed_force(rate, acceleration)),
            Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => {
                (-stiffness_n_per_m * penetration, -stiffness_n_per_m * rate)
            }
            Self::HuntCrossley { .. } => (-penetration, -rate),
            Self::Hertz { stiffness_n_per_m_1_5, damping_n_s_per_m_1_25 } => {
                let elastic = R::splat(1.25) * stiffness_n_per_m_1_5 * fourth_root(penetration) * rate;
                let coefficients = (stiffness_n_per_m_1_5, damping_n_s_per_m_1_25);
                (-reduced_hertz(coefficients, penetration, rate), -(elastic + damping_n_s_per_m_1_25 * acceleration))
            }
        }
    }
}

impl ContactLaw {
    /// Stiffness in N/m of a linear law.
    pub fn stiffness_n_per_m(&self) -> Option<f64> {
        match *self {
            Self::KelvinVoigt { stiffness_n_per_m, .. } | Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => {
                Some(stiffness_n_per_m)
            }
            Self::HuntCrossley { .. } | Self::Hertz { .. } => None,
        }
    }

    /// Penetration in m at which the contact stores an energy in J: how deep an impact without loss goes.
    pub fn depth_of_energy(&self, energy_j: f64) -> f64 {
        let (stiffness, exponent) = match *self {
            Self::KelvinVoigt { stiffness_n_per_m, .. } | Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => {
                (stiffness_n_per_m, 1.0)
            }
            Self::HuntCrossley { stiffness_n_per_m_n, exponent, .. } => (stiffness_n_per_m_n, exponent),
            Self::Hertz { stiffness_n_per_m_1_5, .. } => (stiffness_n_per_m_1_5, HERTZ_EXPONENT),
        };
        libm::pow((exponent + 1.0) * energy_j / stiffness, 1.0 / (exponent + 1.0))
    }

    /// Penetration at which the contact, helped by a linear spring of stiffness `helper_n_per_m`, carries the static
    /// `force_n`, which is not negative: the zero of `N(d, 0) + k_helper d - F`.
    pub fn static_penetration(&self, force_n: f64, helper_n_per_m: f64) -> f64 {
        if force_n == 0.0 {
            return 0.0;
        }
        let (stiffness, exponent) = match *self {
            Self::KelvinVoigt { stiffness_n_per_m, .. } | Self::KelvinVoigtSeparating { stiffness_n_per_m, .. } => {
                return force_n / (stiffness_n_per_m + helper_n_per_m);
            }
            Self::HuntCrossley { stiffness_n_per_m_n, exponent, .. } => (stiffness_n_per_m_n, exponent),
            Self::Hertz { stiffness_n_per_m_1_5, .. } => (stiffness_n_per_m_1_5, HERTZ_EXPONENT),
        };
        // Convex and increasing: Newton's iterates fall monotonically from any start above the root, here the law alone.
        let mut d = libm::pow(force_n / stiffness, 1.0 / exponent);
        for _ in 0..100 {
            let excess = stiffness * libm::pow(d, exponent) + helper_n_per_m * d - force_n;
            let next = d - excess / (exponent * stiffness * libm::pow(d, exponent - 1.0) + helper_n_per_m);
            if next >= d {
                break;
            }
            d = next;
        }
        d
    }
}
