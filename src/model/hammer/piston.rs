//! The percussion piston in the cylinder: parameters, gas, friction and exhaust ports. `p = x_p - x_cb`.

use super::chambers::{ChamberFlows, Chambers, GasConstants, bore_area};
use super::flow::smooth_step;
use super::state::{HammerRates, HammerState, body, chamber};
use crate::contact::{ContactParameters, kelvin_voigt};
use crate::parameter::parameters;
use decore_math::number::{Number, per_lane};

parameters! { file
    /// Percussion piston and its chambers.
    #[derive(Copy)]
    pub struct PistonParameters {
        /// Mass `m_p`.
        pub mass_kg: f64 = 0.4546, "kg", [> 0] usual [0.01, 20], "Table 2";
        /// Bore diameter; `A3 = pi D^2 / 4`.
        pub bore_m: f64 = 0.029, "m", [> 0] usual [0.005, 0.3], "calibrated";
        /// Front area over rear area, `A4 / A3`.
        pub front_area_ratio: f64 = 0.9, "1", [> 0] usual [0.2, 1.5], "calibrated";
        /// Stroke: piston position at which it hits the chisel's head if the chisel rests at the nose.
        pub stroke_m: f64 = 0.126, "m", [> 0] usual [0.005, 1], "calibrated";
        /// Length `L_p` of the percussion chamber.
        pub chamber_length_m: f64 = 0.146, "m", [> 0] usual [0.01, 1], "calibrated";
        /// Clearance of the rear chamber: `V30 = clearance A3`.
        pub rear_clearance_m: f64 = 0.012, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Clearance of the front chamber, along the rear bore: `V40 = clearance A3`.
        pub front_clearance_m: f64 = 0.012, "m", [> 0] usual [1e-4, 0.2], "assumed";
        /// Piston position `p_rear` at which the rear exhaust port begins to open.
        pub rear_port_m: f64 = 0.0780, "m", [>= 0] usual [0, 1], "assumed";
        /// Piston position `p_front` below which the front exhaust port opens.
        pub front_port_m: f64 = 0.0530, "m", [>= 0] usual [0, 1], "assumed";
        /// Width `w` of the exhaust ports.
        pub port_width_m: f64 = 0.004, "m", [> 0] usual [1e-4, 0.1], "assumed";
        /// Effective exhaust area `A_xr` of the rear chamber.
        pub rear_exhaust_area_m2: f64 = 6e-5, "m2", [> 0] usual [1e-7, 0.01], "calibrated";
        /// Effective exhaust area `A_xf` of the front chamber.
        pub front_exhaust_area_m2: f64 = 6e-5, "m2", [> 0] usual [1e-7, 0.01], "calibrated";
        /// Viscous friction `f_p`.
        pub friction_viscous_n_s_per_m: f64 = 2.0, "N s/m", [>= 0] usual [0, 1000], "assumed";
        /// Rear wall of the cylinder `k_p_cb`, `c_p_cb`.
        pub rear_wall: ContactParameters = kelvin_voigt(2e7, 2000.0), "N/m, N s/m", [group], "Table 2";
        /// Piston on chisel `k_p_h`, `c_p_h`.
        pub chisel_contact: ContactParameters = kelvin_voigt(5.971e8, 1500.0), "N/m, N s/m", [group], "Table 2";
    }
}

per_lane! {
    /// Constants of one piston, or of one in each lane.
    pub(super) struct PistonConstants<R> {
        /// Areas `A3`, `A4` in m2.
        area_m2: [R; 2],
        /// Volumes `V30`, `V40` in m3.
        volume_m3: [R; 2],
        chamber_length_m: R,
        rear_port_m: R,
        front_port_m: R,
        inverse_port_width_per_m: R,
        /// Effective areas of the exhausts, rear and front, in m2.
        exhaust_area_m2: [R; 2],
        friction_viscous_n_s_per_m: R,
    }
}

impl PistonConstants<f64> {
    pub(super) fn new(parameters: &PistonParameters) -> Self {
        let p = parameters;
        let rear = bore_area(p.bore_m);
        Self {
            area_m2: [rear, p.front_area_ratio * rear],
            volume_m3: [p.rear_clearance_m * rear, p.front_clearance_m * rear],
            chamber_length_m: p.chamber_length_m,
            rear_port_m: p.rear_port_m,
            front_port_m: p.front_port_m,
            inverse_port_width_per_m: 1.0 / p.port_width_m,
            exhaust_area_m2: [p.rear_exhaust_area_m2, p.front_exhaust_area_m2],
            friction_viscous_n_s_per_m: p.friction_viscous_n_s_per_m,
        }
    }
}

/// Position of the piston in the cylinder: in m if `of` holds positions, its rate in m/s if `of` holds velocities.
#[inline(always)]
fn in_cylinder<R: Number>(of: &[R; body::COUNT]) -> R {
    of[body::PISTON] - of[body::CYLINDER]
}

impl<R: Number> PistonConstants<R> {
    /// Adds gas and friction on the piston, which react on the cylinder.
    #[inline(always)]
    pub(super) fn add_forces(&self, state: &HammerState<R>, ambient_pa: R, rates: &mut HammerRates<R>) {
        let rate = in_cylinder(&state.velocity);
        let gas = (state.pressure[chamber::REAR] - ambient_pa) * self.area_m2[0]
            - (state.pressure[chamber::FRONT] - ambient_pa) * self.area_m2[1];
        let friction = self.friction_viscous_n_s_per_m * rate;
        rates.push(body::PISTON, body::CYLINDER, gas - friction);
        rates.power_in_w += gas * rate;
        rates.dissipation_w += friction * rate;
    }

    /// Volumes behind and before the piston in m3.
    #[inline(always)]
    pub(super) fn volumes(&self, position: &[R; body::COUNT]) -> [R; 2] {
        let p = in_cylinder(position);
        [self.volume_m3[0] + self.area_m2[0] * p, self.volume_m3[1] + self.area_m2[1] * (self.chamber_length_m - p)]
    }

    /// Rates of the volumes behind and before the piston in m3/s.
    #[inline(always)]
    pub(super) fn volume_rates(&self, velocity: &[R; body::COUNT]) -> [R; 2] {
        let rate = in_cylinder(velocity);
        [self.area_m2[0] * rate, -self.area_m2[1] * rate]
    }

    /// Flows of the chambers behind and before the piston, which the valve feeds through effective areas `feed_area_m2`.
    #[inline(always)]
    pub(super) fn flows(
        &self,
        gas: &GasConstants<R>,
        chambers: &Chambers<'_, R>,
        feed_area_m2: [R; 2],
    ) -> [ChamberFlows<R>; 2] {
        let [rear, front] = [chambers.pressure[chamber::REAR], chambers.pressure[chamber::FRONT]];
        let [rear_feed, front_feed] = [
            gas.flow.mass_flow(chambers.supply, rear, feed_area_m2[0]),
            gas.flow.mass_flow(chambers.supply, front, feed_area_m2[1]),
        ];
        let exhaust_area = self.exhaust_areas(&chambers.state.position);
        let [rear_exhaust, front_exhaust] = [
            gas.flow.mass_flow(rear, gas.ambient, exhaust_area[0]),
            gas.flow.mass_flow(front, gas.ambient, exhaust_area[1]),
        ];
        [
            ChamberFlows { supply_kg_s: rear_feed, energy_w: gas.energy(rear_feed) + gas.energy(-rear_exhaust) },
            ChamberFlows { supply_kg_s: front_feed, energy_w: gas.energy(front_feed) + gas.energy(-front_exhaust) },
        ]
    }

    /// Effective areas of the exhausts that the piston leaves open, rear and front, in m2.
    #[inline(always)]
    fn exhaust_areas(&self, position: &[R; body::COUNT]) -> [R; 2] {
        let p = in_cylinder(position);
        let rear_port = smooth_step((p - self.rear_port_m) * self.inverse_port_width_per_m);
        let front_port = smooth_step((self.front_port_m - p) * self.inverse_port_width_per_m);
        [self.exhaust_area_m2[0] * rear_port, self.exhaust_area_m2[1] * front_port]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ports at both ends of the piston's way, and half open.
    #[test]
    fn analytic_exhaust_areas() {
        let constants = PistonConstants::new(&PistonParameters::default());
        let at = |piston: f64| constants.exhaust_areas(&[0.0, 0.0, 0.0, piston, 0.0]);
        assert_eq!(at(0.0), [0.0, 6e-5]);
        assert_eq!(at(0.1), [6e-5, 0.0]);
        assert!((at(0.078 + 0.002)[0] - 3e-5).abs() < 1e-15);
    }
}
