//! One hammer, without its one-sided contacts: prepared parameters and state of rest.

use super::evaluate::HammerConstants;
use super::flow::Gas;
use super::parameters::HammerParameters;
use super::state::{HammerRates, HammerState, body, chamber};

/// Constants of one hammer, prepared for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct HammerModel {
    parameters: HammerParameters,
    gas: Gas,
    constants: HammerConstants<f64>,
    mass: [f64; body::COUNT],
}

impl HammerModel {
    /// Prepares a hammer for gas `gas`. `gravity_m_s2`: the share of gravity along its strikes, negative for upward strikes.
    pub fn new(parameters: &HammerParameters, gas: Gas, gravity_m_s2: f64) -> Self {
        let mass = parameters.masses_kg();
        let mut weight = mass.map(|m| m * gravity_m_s2);
        weight[body::GUIDE] = -weight[body::CYLINDER..].iter().sum::<f64>();
        let constants = HammerConstants::new(parameters, &gas, weight);
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

    /// State of rest before the start: all chambers at ambient pressure, the telescope in equilibrium, `s = 0`, `c = c_ret`,
    /// `p = c_ret + stroke`. A hammer that strikes upwards has its chisel on the nose and its piston on the rear wall, `c = p = 0`.
    pub fn rest(&self) -> HammerState {
        let below = -self.constants.weight[body::GUIDE];
        let cylinder = self.parameters.telescope.rest_extension(below);
        let travel = self.parameters.chisel.travel_m;
        let [chisel, piston] = if below < 0.0 {
            [cylinder; 2]
        } else {
            [cylinder + travel, cylinder + travel + self.parameters.piston.stroke_m]
        };
        HammerState {
            position: [0.0, cylinder, cylinder, piston, chisel],
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
        self.parameters.telescope.return_spring_energy(extension_m)
    }

    /// Forces, pressure rates, power and flows at a state.
    pub fn evaluate(&self, state: &HammerState) -> HammerRates {
        self.constants.evaluate(state)
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

    /// Power is force times velocity for every term: the bodies' forces take the gas's power, except the friction.
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
