//! Pads of a known material: stiffness and damping of a fixture from its area and thickness.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::parameter::{Choice, parameters};
use decore_quantity::named;

/// Declares the materials: the enum with the figures in its documentation, and [`PadMaterial::figures`].
macro_rules! materials {
    ($(
        $(#[$attribute:meta])?
        $value:ident = $name:literal {
            modulus_pa: $modulus:literal $modulus_source:literal,
            surface_n_per_m3: $surface:expr, $surface_text:literal,
            loss_factor: $loss:literal at $hertz:literal $loss_source:literal,
        }
    )+) => {
        named! {
            /// Material of a pad of area A and thickness t. Stiffness `k_T = A / (t / E + 1 / s)`, damping `c_T = k_T eta / (2 pi f)`, with the
            /// modulus E, the stiffness s of the surfaces per area and the loss factor eta at the frequency f.
            #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
            pub enum PadMaterial {
                $(
                    #[doc = concat!(
                        "E = ", $modulus, " Pa (", $modulus_source, "); ", $surface_text, "; eta = ", $loss, " at ", $hertz, " Hz (",
                        $loss_source, ")."
                    )]
                    $(#[$attribute])?
                    $value = $name,
                )+
            }
        }

        impl PadMaterial {
            /// Figures of the material.
            pub const fn figures(self) -> PadFigures {
                match self { $(Self::$value => PadFigures {
                    modulus_pa: $modulus,
                    surface_n_per_m3: $surface,
                    loss_factor: $loss,
                    loss_hz: $hertz,
                },)+ }
            }
        }
    };
}

materials! {
    Steel = "steel" {
        modulus_pa: 2.1e11 "handbooks",
        surface_n_per_m3: 1e11, "s = 1e11 N/m3 (guess: casting skin; machined joints have about 1e12)",
        loss_factor: 0.04 at 1000.0 "guess",
    }
    Aluminium = "aluminium" {
        modulus_pa: 7.0e10 "handbooks",
        surface_n_per_m3: 1e11, "s = 1e11 N/m3 (guess, as for steel)",
        loss_factor: 0.04 at 1000.0 "guess",
    }
    #[default]
    Polyurethane = "polyurethane" {
        modulus_pa: 2.2e7 "the paper, Table 1",
        surface_n_per_m3: f64::INFINITY, "surfaces do not count",
        loss_factor: 0.2 at 100.0 "guess",
    }
    Rubber = "rubber" {
        modulus_pa: 3.6e6 "60 Shore A, by Gent's relation",
        surface_n_per_m3: f64::INFINITY, "surfaces do not count",
        loss_factor: 0.1 at 100.0 "guess",
    }
}

impl Choice for PadMaterial {}

/// Figures of a material of pads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PadFigures {
    /// Young's modulus, Pa.
    pub modulus_pa: f64,
    /// Stiffness of the rough surfaces between pad and casting per area, N/m3; infinite where the pad is softer by far.
    pub surface_n_per_m3: f64,
    /// Loss factor of pad and surfaces at `loss_hz`.
    pub loss_factor: f64,
    /// Frequency of the loss factor, Hz.
    pub loss_hz: f64,
}

parameters! {
    /// A pad of a known material, from which stiffness and damping of a fixture follow. It bulges freely: thin bonded pads are stiffer.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize)]
    pub struct Pad {
        /// Material of the pad. It takes the place of `stiffness_n_per_m` and `damping_n_s_per_m`.
        pub material: PadMaterial, "", [choice], "none";
        /// Area of the pad; needed with `material`.
        pub pad_area_m2: f64, "m2", [> 0] usual [1e-5, 0.3], "only with `material`";
        /// Thickness of the pad; needed with `material`.
        pub pad_thickness_m: f64, "m", [> 0] usual [5e-4, 0.3], "only with `material`";
    }
}

impl Pad {
    /// Stiffness in N/m and damping in N s/m.
    pub fn spring(&self) -> [f64; 2] {
        let figures = self.material.figures();
        let per_area = 1.0 / (self.pad_thickness_m / figures.modulus_pa + 1.0 / figures.surface_n_per_m3);
        let stiffness_n_per_m = self.pad_area_m2 * per_area;
        [stiffness_n_per_m, stiffness_n_per_m * figures.loss_factor / (TAU * figures.loss_hz)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gent (1958): E in MPa from the hardness S in Shore A, `0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S))`.
    #[test]
    fn rubber_follows_its_hardness() {
        let hardness = 60.0;
        let modulus = 0.0981e6 * (56.0 + 7.62336 * hardness) / (0.137505 * (254.0 - 2.54 * hardness));
        assert!((PadMaterial::Rubber.figures().modulus_pa / modulus - 1.0).abs() < 0.01, "{modulus:e}");
    }
}
