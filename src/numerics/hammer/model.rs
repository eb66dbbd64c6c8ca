//! One hammer: its parameters made ready, its state of rest. All but its one-sided contacts.

use crate::contact::ContactParameters;
use crate::hammer::evaluate::{HammerConstants, HammerRates, HammerState, body, chamber};
use crate::hammer::flow::{FlowFunction, Gas};
use crate::hammer::parameters::HammerParameters;

/// Constants of one hammer, prepared for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct HammerModel {
    parameters: HammerParameters,
    gas: Gas,
    constants: HammerConstants<f64>,
    mass: [f64; body::COUNT],
}

impl HammerModel {
    /// Prepares a hammer for gas `gas` under gravity `gravity_m_s2`.
    pub fn new(parameters: &HammerParameters, gas: Gas, gravity_m_s2: f64) -> Self {
        let (t, p) = (&parameters.telescope, &parameters.piston);
        let circle = |d: f64| 0.25 * std::f64::consts::PI * d * d;
        let (a1, a3) = (circle(t.bore_m), circle(p.bore_m));
        let a2 = t.annulus_area_ratio * a1;
        let mass = [
            parameters.guide.mass_kg,
            t.cylinder_mass_kg,
            parameters.valve.mass_kg,
            p.mass_kg,
            parameters.chisel.mass_kg,
        ];
        let mut weight = mass.map(|m| m * gravity_m_s2);
        weight[body::GUIDE] = -weight[body::CYLINDER..].iter().sum::<f64>();
        let area = [a1, a2, a3, p.front_area_ratio * a3];
        let volume = [
            t.top_clearance_m * a1 + t.top_dead_volume_m3,
            t.annulus_length_m * a2,
            p.rear_clearance_m * a3,
            p.front_clearance_m * a3,
        ];
        let constants = HammerConstants { weight, area, volume, ..unplaced(parameters, &gas) };
        Self { parameters: *parameters, gas, constants, mass }
    }

    /// The constants of its equations.
    pub fn constants(&self) -> &HammerConstants<f64> {
        &self.constants
    }

    /// The parameters it was made from.
    pub fn parameters(&self) -> &HammerParameters {
        &self.parameters
    }

    /// Masses of the bodies in kg.
    pub fn mass(&self) -> &[f64; body::COUNT] {
        &self.mass
    }

    /// Extension `e0` of the telescope at rest in m: the root of `N_u(-e0) = N_end(e0 - L_tel) + F0 + k_l e0 - W`.
    ///
    /// A preload above the weight that hangs on the cylinder holds it against the top stop; a smaller one lets it hang on the
    /// return spring, or rest on the end stop where that lies higher. No stop pulls.
    fn rest_extension(&self) -> f64 {
        let t = &self.parameters.telescope;
        let (held, stiffness) = (t.spring_preload_n + self.constants.weight[body::GUIDE], t.spring_stiffness_n_per_m);
        let stop = |contact: &ContactParameters, force: f64| {
            contact.law(t.cylinder_mass_kg).static_penetration(force, stiffness)
        };
        let hanging = -held / stiffness;
        if held >= 0.0 {
            -stop(&t.top_stop, held)
        } else if hanging <= t.stroke_m {
            hanging
        } else {
            t.stroke_m + stop(&t.end_stop, -held - stiffness * t.stroke_m)
        }
    }

    /// State of rest before the start: all chambers at ambient pressure, the telescope in equilibrium, `s = 0`, `c = c_ret`,
    /// `p = c_ret + stroke`.
    pub fn rest(&self) -> HammerState {
        let cylinder = self.rest_extension();
        let travel = self.parameters.chisel.travel_m;
        HammerState {
            position: [0.0, cylinder, cylinder, cylinder + travel + self.parameters.piston.stroke_m, cylinder + travel],
            velocity: [0.0; body::COUNT],
            pressure: [self.gas.ambient_pressure_pa; chamber::COUNT],
            supply_pa: self.gas.ambient_pressure_pa,
            gate_open: false,
        }
    }

    /// Current chamber volumes in m3.
    pub fn volumes(&self, position: &[f64; body::COUNT]) -> [f64; chamber::COUNT] {
        self.constants.volumes(position)
    }

    /// Energy stored in the return spring at extension `extension_m`, in J: `F0 e + k_l e^2 / 2`.
    pub fn return_spring_energy(&self, extension_m: f64) -> f64 {
        let t = &self.parameters.telescope;
        (t.spring_preload_n + 0.5 * t.spring_stiffness_n_per_m * extension_m) * extension_m
    }

    /// Forces, pressure rates, power and flows at a state.
    pub fn evaluate(&self, state: &HammerState) -> HammerRates {
        self.constants.evaluate(state)
    }
}

/// The constants that follow from parameters and gas one by one; areas, volumes and weights are left at zero.
fn unplaced(parameters: &HammerParameters, gas: &Gas) -> HammerConstants<f64> {
    let HammerParameters { telescope: t, piston: p, valve: v, chisel, .. } = parameters;
    let resistance = |share: f64| {
        t.friction_viscous_n_s_per_m + t.friction_directional_n_s_per_m * share + t.spring_damping_n_s_per_m
    };
    HammerConstants {
        weight: [0.0; body::COUNT],
        area: [0.0; chamber::COUNT],
        volume: [0.0; chamber::COUNT],
        chamber_length_m: p.chamber_length_m,
        friction_static_n: t.friction_static_n,
        inverse_friction_velocity_s_per_m: 1.0 / t.friction_velocity_m_s,
        resistance_n_s_per_m: [resistance(t.retracting_share), resistance(t.extending_share)],
        spring_preload_n: t.spring_preload_n,
        spring_stiffness_n_per_m: t.spring_stiffness_n_per_m,
        friction_viscous_n_s_per_m: [
            p.friction_viscous_n_s_per_m,
            v.friction_viscous_n_s_per_m,
            chisel.friction_viscous_n_s_per_m,
        ],
        spool_area_m2: v.area_m2,
        supply_share: v.supply_share,
        inlet_area_m2: t.inlet_area_m2,
        vent_area_m2: t.vent_area_m2,
        rear_port_m: p.rear_port_m,
        front_port_m: p.front_port_m,
        inverse_port_width_per_m: 1.0 / p.port_width_m,
        inverse_travel_per_m: 1.0 / v.travel_m,
        feed_area_m2: [v.rear_feed_area_m2, v.front_feed_area_m2],
        exhaust_area_m2: [p.rear_exhaust_area_m2, p.front_exhaust_area_m2],
        ambient_pa: gas.ambient_pressure_pa,
        inverse_ambient_per_pa: 1.0 / gas.ambient_pressure_pa,
        inflow_energy_j_per_kg: gas.specific_energy_j_per_kg * gas.inflow_exponent,
        outflow_energy_j_per_kg: gas.specific_energy_j_per_kg * gas.outflow_exponent,
        expansion_exponent: gas.expansion_exponent,
        flow: FlowFunction::new(gas),
    }
}

#[cfg(test)]
mod tests {
    use super::super::flow::tests::air;
    use super::*;

    fn model(gravity: f64) -> HammerModel {
        HammerModel::new(&HammerParameters::default(), air(), gravity)
    }

    /// At rest the top stop's force balances spring and weight, on the guide as on all that hangs below it, and no pressure
    /// changes.
    #[test]
    fn analytic_rest_is_an_equilibrium() {
        let model = model(9.80665);
        let rest = model.rest();
        let rates = model.evaluate(&rest);
        let stop = -model.parameters.telescope.top_stop.stiffness_n_per_m * rest.position[body::CYLINDER];
        assert!(stop > 0.0);
        let hanging: f64 = rates.force[body::CYLINDER..].iter().sum();
        assert!((hanging + stop).abs() < 1e-9, "{hanging} and {stop}");
        assert!((rates.force[body::GUIDE] - stop).abs() < 1e-9);
        assert_eq!(rates.pressure_rate, [0.0; chamber::COUNT]);
        assert_eq!((rates.power_in_w, rates.dissipation_w, rates.supply_flow_kg_s), (0.0, 0.0, 0.0));
    }

    /// Ports and feeds at both ends of spool and piston; the gate shuts both feeds and no exhaust.
    #[test]
    fn analytic_valve_areas() {
        let model = model(9.80665);
        let at = |piston: f64, spool: f64, gate_open: bool| {
            let state = HammerState { position: [0.0, 0.0, spool, piston, 0.0], gate_open, ..model.rest() };
            model.constants.valve_areas(&state)
        };
        assert_eq!(at(0.0, 0.0, true), [8.35e-6, 0.0, 0.0, 6e-5]);
        assert_eq!(at(0.1, 0.004, true), [0.0, 2.8e-6, 6e-5, 0.0]);
        assert_eq!(at(0.1, 0.004, false), [0.0, 0.0, 6e-5, 0.0]);
        let half = at(0.078 + 0.002, 0.002, true);
        assert!((half[0] - 0.5 * 8.35e-6).abs() < 1e-18 && (half[2] - 3e-5).abs() < 1e-15);
    }

    /// Power is force times velocity for every term: the bodies' forces take from the gas what friction does not.
    #[test]
    fn analytic_power_balance() {
        let model = model(9.80665);
        let mut state = model.rest();
        state.position = [0.001, 0.03, 0.032, 0.10, 0.036];
        state.velocity = [0.1, 1.3, 1.1, -4.0, 1.9];
        state.pressure = [4e5, 1.2e5, 3e5, 2.2e5];
        let rates = model.evaluate(&state);
        let power: f64 = (0..body::COUNT).map(|i| rates.force[i] * state.velocity[i]).sum();
        let t = &model.parameters.telescope;
        let (extension, rate) = (0.03 - 0.001, 1.3 - 0.1);
        let spring = (t.spring_preload_n + t.spring_stiffness_n_per_m * extension) * rate;
        let balance = rates.power_in_w - rates.dissipation_w - spring;
        assert!((power - balance).abs() < 1e-9 * power.abs(), "{power} and {balance}");
        // The spring's power is the rate of its energy.
        let energy = |e: f64| model.return_spring_energy(e);
        let slope = (energy(extension + 1e-6) - energy(extension - 1e-6)) / 2e-6;
        assert!((slope * rate / spring - 1.0).abs() < 1e-8);
    }
}
