//! Parameters of a contact, and the law that follows from them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::law::{ContactLaw, HERTZ_EXPONENT};
use super::restitution::{self, hunt_crossley_damping, kelvin_voigt_damping, separating_damping};
use crate::parameter::{Choice, describe, parameters};

/// Exponent `n` of the Hunt-Crossley law, unless stated.
const EXPONENT: f64 = 1.5;
/// Speed in m/s at which laws are matched, unless stated.
const REFERENCE_SPEED_M_S: f64 = 1.0;

/// Restitution above which slow bounces last long: at 0.99 the first impact of the paper's rig is sure to 4e-6 under the preset `standard`,
/// at 0.999 to 3e-5, at 1 to 6e-3.
const KEPT_RESTITUTION: f64 = 0.99;

/// Declares the laws, each by one entry: documentation, name, the parameters that it takes, and its coefficients for given ones and
/// a reduced mass.
macro_rules! laws {
    ($($(#[$attribute:meta])* $law:ident($name:literal, $first:literal $(, $option:literal)*) = $coefficients:expr;)+) => {
        /// Force law of a contact.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
        pub enum ContactLawName { $(
            $(#[$attribute])*
            #[doc = concat!("Takes `", $first, "`" $(, ", `", $option, "`")*, ".")]
            #[serde(rename = $name)]
            $law,
        )+ }

        impl ContactLawName {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$law),+];

            /// Name in files.
            pub fn name(self) -> &'static str {
                match self { $(Self::$law => $name,)+ }
            }

            /// The law with its coefficients, between two bodies of reduced mass `reduced_mass_kg`.
            fn coefficients(self, contact: &ContactParameters, reduced_mass_kg: f64) -> ContactLaw {
                let coefficients: fn(&ContactParameters, f64) -> ContactLaw = match self { $(Self::$law => $coefficients,)+ };
                coefficients(contact, reduced_mass_kg)
            }
        }
    };
}

laws! {
    /// `max(0, k d + c d')`: spring and damper that push and never pull.
    #[default]
    KelvinVoigt("kelvin_voigt", "stiffness_n_per_m", "damping_n_s_per_m", "restitution") =
        |contact, reduced_mass_kg| ContactLaw::KelvinVoigt {
            stiffness_n_per_m: contact.stiffness_n_per_m,
            damping_n_s_per_m: contact.linear_damping(reduced_mass_kg, kelvin_voigt_damping),
        };
    /// `k d + c d'` until the penetration is zero again: pulls a little just before the bodies part.
    KelvinVoigtSeparating("kelvin_voigt_separating", "stiffness_n_per_m", "damping_n_s_per_m", "restitution") =
        |contact, reduced_mass_kg| ContactLaw::KelvinVoigtSeparating {
            stiffness_n_per_m: contact.stiffness_n_per_m,
            damping_n_s_per_m: contact.linear_damping(reduced_mass_kg, separating_damping),
        };
    /// `max(0, K d^n (1 + a d'))`: no jump of the force at onset; a slow impact loses less than a fast one.
    HuntCrossley(
        "hunt_crossley", "power_stiffness_n_per_m_n", "exponent", "damping_s_per_m", "restitution", "reference_speed_m_s"
    ) = |contact, reduced_mass_kg| {
        let exponent = contact.exponent.unwrap_or(EXPONENT);
        let product = || hunt_crossley_damping(contact.restitution(reduced_mass_kg));
        ContactLaw::HuntCrossley {
            stiffness_n_per_m_n: contact.power_stiffness(reduced_mass_kg, exponent),
            exponent,
            damping_s_per_m: contact.damping_s_per_m.unwrap_or_else(|| product() / contact.reference_speed()),
        }
    };
    /// `max(0, K d^1.5 + C d^0.25 d')`: no jump of the force at onset; the restitution does not depend on the speed.
    Hertz("hertz", "power_stiffness_n_per_m_n", "restitution", "reference_speed_m_s") = |contact, reduced_mass_kg| {
        let stiffness = contact.power_stiffness(reduced_mass_kg, HERTZ_EXPONENT);
        let ratio = kelvin_voigt_damping(contact.restitution(reduced_mass_kg));
        ContactLaw::Hertz {
            stiffness_n_per_m_1_5: stiffness,
            damping_n_s_per_m_1_25: ratio * (5.0 * reduced_mass_kg * stiffness).sqrt(),
        }
    };
}

impl Choice for ContactLawName {}

parameters! {
    /// Law of a one-sided contact, with its stiffness and loss.
    ///
    /// Give the loss as damping or as `restitution`: the speed at which two free bodies part over the speed at which they meet. Their
    /// reduced mass counts only the two bodies (`1/mu = 1/m1 + 1/m2`): for the casting its effective mass at the strike point, `1/m = 1/m_g
    /// + y^2/J_x + x^2/J_y` with the rotations that it has; for the telescope's stops the cylinder's own mass, because the guide stands on
    /// its mount.
    ///
    /// Power laws need no values of their own. By default they get the stiffness with the same peak penetration as `stiffness_n_per_m` in
    /// an undamped impact at the reference speed, `K = (n + 1)/2 k d0^(1 - n)` with `d0 = v0 sqrt(mu/k)`, and the restitution that
    /// `stiffness_n_per_m` and `damping_n_s_per_m` have under the default law. So you can change only `law`, and vary it in a design.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    #[schemars(transform = describe::<ContactParameters>)]
    pub struct ContactParameters {
        /// Force law.
        #[serde(default, skip_serializing_if = "is_default")]
        pub law: ContactLawName, "", [choice], "`kelvin_voigt`";
        /// Contact stiffness `k`.
        pub stiffness_n_per_m: f64, "N/m", [> 0] usual [100, 1e11], "default: the contact's own";
        /// Contact damping `c`. Ignored if `restitution` or `damping_s_per_m` is given.
        pub damping_n_s_per_m: f64, "N s/m", [>= 0] usual [0, 1e6], "default: the contact's own";
        /// Coefficient of restitution; it replaces a damping. For `hunt_crossley` it applies at the reference speed.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub restitution: Option<f64>, "1", [> 0, <= 1], "default: from the damping";
        /// Stiffness `K` of `hunt_crossley`, and of `hertz` with n = 1.5. It replaces `stiffness_n_per_m` there.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub power_stiffness_n_per_m_n: Option<f64>, "N/m^n", [> 0], "default: as deep as the linear stiffness";
        /// Damping `a` of `hunt_crossley`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub damping_s_per_m: Option<f64>, "s/m", [>= 0] usual [0, 10], "default: from the restitution";
        /// Exponent `n` of `hunt_crossley`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub exponent: Option<f64>, "1", [>= 1] usual [1, 3], "default 1.5";
        /// Impact speed `v0` at which `hunt_crossley` and `hertz` are matched to `stiffness_n_per_m`, and `hunt_crossley` to
        /// the restitution.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub reference_speed_m_s: Option<f64>, "m/s", [> 0] usual [0.01, 50], "default 1";
    }
}

fn is_default(law: &ContactLawName) -> bool {
    *law == ContactLawName::default()
}

/// The default law with its stiffness and damping.
pub const fn kelvin_voigt(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> ContactParameters {
    ContactParameters {
        law: ContactLawName::KelvinVoigt,
        stiffness_n_per_m,
        damping_n_s_per_m,
        restitution: None,
        power_stiffness_n_per_m_n: None,
        damping_s_per_m: None,
        exponent: None,
        reference_speed_m_s: None,
    }
}

impl ContactParameters {
    /// The law between two bodies of reduced mass `reduced_mass_kg`.
    pub fn law(&self, reduced_mass_kg: f64) -> ContactLaw {
        self.law.coefficients(self, reduced_mass_kg)
    }

    /// Whether slow bounces of two bodies of reduced mass `reduced_mass_kg` last long: Hunt-Crossley loses the less the slower they are,
    /// any law next to nothing at a restitution close to 1.
    pub fn keeps_slow_bounces(&self, reduced_mass_kg: f64) -> bool {
        self.law == ContactLawName::HuntCrossley || self.restitution(reduced_mass_kg) > KEPT_RESTITUTION
    }

    /// Damping of a linear law whose damping ratio follows from a restitution by `ratio`.
    fn linear_damping(&self, reduced_mass_kg: f64, ratio: impl Fn(f64) -> f64) -> f64 {
        let critical = || 2.0 * (self.stiffness_n_per_m * reduced_mass_kg).sqrt();
        self.restitution.map_or(self.damping_n_s_per_m, |e| ratio(e) * critical())
    }

    /// Given restitution, or the restitution of stiffness and damping with the default law.
    fn restitution(&self, reduced_mass_kg: f64) -> f64 {
        let critical = 2.0 * (self.stiffness_n_per_m * reduced_mass_kg).sqrt();
        self.restitution.unwrap_or_else(|| restitution::kelvin_voigt(self.damping_n_s_per_m / critical))
    }

    /// Given `K`, or the `K` with the same peak penetration as the linear stiffness at the reference speed.
    fn power_stiffness(&self, reduced_mass_kg: f64, exponent: f64) -> f64 {
        let linear = self.stiffness_n_per_m;
        let peak = self.reference_speed() * (reduced_mass_kg / linear).sqrt();
        self.power_stiffness_n_per_m_n
            .unwrap_or_else(|| 0.5 * (exponent + 1.0) * linear * libm::pow(peak, 1.0 - exponent))
    }

    fn reference_speed(&self) -> f64 {
        self.reference_speed_m_s.unwrap_or(REFERENCE_SPEED_M_S)
    }
}
