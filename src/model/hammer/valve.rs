//! The spool valve in the cylinder: parameters, gas and friction on the spool, the feeds that it opens. `s = x_sv - x_cb`.

use super::flow::smooth_step;
use super::state::{HammerRates, HammerState, body, chamber};
use crate::contact::{ContactParameters, kelvin_voigt};
use crate::parameter::parameters;
use decore_math::number::{Number, per_lane};

parameters! { file
    /// Spool valve: at `s = 0` it feeds the rear chamber, at `s = s_max` the front one.
    #[derive(Copy)]
    pub struct ValveParameters {
        /// Mass `m_sv`.
        pub mass_kg: f64 = 0.074, "kg", [> 0] usual [0.001, 5], "Table 2";
        /// Control area `A_s`.
        pub area_m2: f64 = 1.5e-4, "m2", [> 0] usual [1e-6, 0.01], "assumed";
        /// Travel `s_max`.
        pub travel_m: f64 = 0.004, "m", [> 0] usual [1e-4, 0.1], "assumed";
        /// Share `phi` of the supply over-pressure that drives the spool.
        pub supply_share: f64 = 0.5, "1", [> 0] usual [0.01, 2], "assumed";
        /// Effective feed area `A_fr` of the rear chamber.
        pub rear_feed_area_m2: f64 = 8.35e-6, "m2", [> 0] usual [1e-8, 0.001], "calibrated";
        /// Effective feed area `A_ff` of the front chamber.
        pub front_feed_area_m2: f64 = 2.8e-6, "m2", [> 0] usual [1e-8, 0.001], "calibrated";
        /// Viscous friction `f_sv`.
        pub friction_viscous_n_s_per_m: f64 = 2.0, "N s/m", [>= 0] usual [0, 1000], "assumed";
        /// Both spool stops `k_sv_cb`, `c_sv_cb`.
        pub stop: ContactParameters = kelvin_voigt(1.0121e7, 1650.0), "N/m, N s/m", [group], "Table 2";
    }
}

per_lane! {
    /// Constants of one valve, or of one in each lane.
    pub(super) struct ValveConstants<R> {
        area_m2: R,
        supply_share: R,
        inverse_travel_per_m: R,
        /// Effective areas of the feeds, rear and front, in m2.
        feed_area_m2: [R; 2],
        friction_viscous_n_s_per_m: R,
    }
}

impl ValveConstants<f64> {
    pub(super) fn new(parameters: &ValveParameters) -> Self {
        Self {
            area_m2: parameters.area_m2,
            supply_share: parameters.supply_share,
            inverse_travel_per_m: 1.0 / parameters.travel_m,
            feed_area_m2: [parameters.rear_feed_area_m2, parameters.front_feed_area_m2],
            friction_viscous_n_s_per_m: parameters.friction_viscous_n_s_per_m,
        }
    }
}

impl<R: Number> ValveConstants<R> {
    /// Adds gas and friction on the spool, which react on the cylinder.
    #[inline(always)]
    pub(super) fn add_forces(&self, state: &HammerState<R>, ambient_pa: R, rates: &mut HammerRates<R>) {
        let rate = state.velocity[body::SPOOL] - state.velocity[body::CYLINDER];
        let rear = state.pressure[chamber::REAR] - ambient_pa;
        let gas = self.area_m2 * (self.supply_share * (state.supply_pa - ambient_pa) - rear);
        let friction = self.friction_viscous_n_s_per_m * rate;
        rates.push(body::SPOOL, body::CYLINDER, gas - friction);
        rates.power_in_w += gas * rate;
        rates.dissipation_w += friction * rate;
    }

    /// Effective areas of the feeds that the spool leaves open, rear and front, in m2; none while the gate is shut.
    #[inline(always)]
    pub(super) fn feed_areas(&self, state: &HammerState<R>) -> [R; 2] {
        let spool = state.position[body::SPOOL] - state.position[body::CYLINDER];
        let front_share = smooth_step(spool * self.inverse_travel_per_m);
        let none = R::splat(0.0);
        let [rear, front] = self.feed_area_m2;
        [
            R::select(state.gate_open, rear * (R::splat(1.0) - front_share), none),
            R::select(state.gate_open, front * front_share, none),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds at both ends of the spool's travel and half-way; the gate shuts both.
    #[test]
    fn analytic_feed_areas() {
        let constants = ValveConstants::new(&ValveParameters::default());
        let at = |spool: f64, gate_open: bool| {
            let mut position = [0.0; body::COUNT];
            position[body::SPOOL] = spool;
            let pressure = [1e5; chamber::COUNT];
            constants.feed_areas(&HammerState {
                position,
                velocity: [0.0; body::COUNT],
                pressure,
                supply_pa: 6e5,
                gate_open,
            })
        };
        assert_eq!(at(0.0, true), [8.35e-6, 0.0]);
        assert_eq!(at(0.004, true), [0.0, 2.8e-6]);
        assert_eq!(at(0.004, false), [0.0, 0.0]);
        assert_eq!(at(0.0, false), [0.0, 0.0]);
        assert!((at(0.002, true)[0] - 0.5 * 8.35e-6).abs() < 1e-18);
    }
}
