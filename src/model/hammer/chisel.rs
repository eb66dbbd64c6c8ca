//! The chisel in its bushing: parameters and friction. `c = x_h - x_cb`.

use super::state::{HammerRates, HammerState, body};
use crate::contact::{ContactParameters, kelvin_voigt};
use crate::parameter::parameters;
use decore_math::number::{Number, per_lane};

parameters! { file
    /// Chisel: bushing, nose, retainer, contact with the casting.
    #[derive(Copy)]
    pub struct ChiselParameters {
        /// Mass `m_h`.
        pub mass_kg: f64 = 1.8157, "kg", [> 0] usual [0.05, 50], "Table 2";
        /// Free travel `c_ret` between nose and retainer.
        pub travel_m: f64 = 0.012, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Bushing friction `f_h`.
        pub friction_viscous_n_s_per_m: f64 = 5.0, "N s/m", [>= 0] usual [0, 1e4], "assumed";
        /// Nose and retainer `k_cb_h`, `c_cb_h`.
        pub cylinder_contact: ContactParameters = kelvin_voigt(6.06e8, 1052.0), "N/m, N s/m", [group], "Table 2";
        /// Chisel on casting `k_h_g`, `c_h_g`.
        pub casting_contact: ContactParameters = kelvin_voigt(2.95e8, 500.0), "N/m, N s/m", [group], "Table 2";
    }
}

per_lane! {
    /// Constants of one chisel, or of one in each lane.
    pub(super) struct ChiselConstants<R> {
        friction_viscous_n_s_per_m: R,
    }
}

impl ChiselConstants<f64> {
    pub(super) fn new(parameters: &ChiselParameters) -> Self {
        Self { friction_viscous_n_s_per_m: parameters.friction_viscous_n_s_per_m }
    }
}

impl<R: Number> ChiselConstants<R> {
    /// Adds friction on the chisel, which reacts on the cylinder.
    #[inline(always)]
    pub(super) fn add_forces(&self, state: &HammerState<R>, rates: &mut HammerRates<R>) {
        let rate = state.velocity[body::CHISEL] - state.velocity[body::CYLINDER];
        let friction = self.friction_viscous_n_s_per_m * rate;
        rates.push(body::CHISEL, body::CYLINDER, -friction);
        rates.dissipation_w += friction * rate;
    }
}
