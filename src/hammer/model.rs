//! Smooth forces and gas rates of one hammer: everything but its one-sided contacts.
//!
//! Positions run along the strike axis. Relative coordinates: `e = x_cb - x_Gh`, `p = x_p - x_cb`, `s = x_sv - x_cb`,
//! `c = x_h - x_cb`.

use crate::contact::ContactParameters;
use crate::hammer::flow::{FlowFunction, Gas};
use crate::hammer::parameters::HammerParameters;

/// Indices of the bodies within a hammer's state.
pub mod body {
    /// Housing guide (`Gh`).
    pub const GUIDE: usize = 0;
    /// Cylinder (`cb`).
    pub const CYLINDER: usize = 1;
    /// Spool valve (`sv`).
    pub const SPOOL: usize = 2;
    /// Piston (`p`).
    pub const PISTON: usize = 3;
    /// Chisel (`h`).
    pub const CHISEL: usize = 4;
    /// Number of bodies.
    pub const COUNT: usize = 5;
}

/// Indices of the gas chambers within a hammer's state.
pub mod chamber {
    /// Telescope top (`P1`).
    pub const TOP: usize = 0;
    /// Telescope annulus (`P2`).
    pub const ANNULUS: usize = 1;
    /// Behind the piston (`P3`).
    pub const REAR: usize = 2;
    /// Before the piston (`P4`).
    pub const FRONT: usize = 3;
    /// Number of chambers.
    pub const COUNT: usize = 4;
    /// What they are called.
    pub const NAMES: [&str; COUNT] =
        ["top of the telescope", "annulus of the telescope", "rear of the piston", "front of the piston"];
}

/// State of one hammer as the model sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HammerState {
    /// Positions of the bodies in m.
    pub position: [f64; body::COUNT],
    /// Velocities of the bodies in m/s.
    pub velocity: [f64; body::COUNT],
    /// Absolute chamber pressures in Pa.
    pub pressure: [f64; chamber::COUNT],
    /// Absolute supply pressure at this time in Pa (ambient before the start).
    pub supply_pa: f64,
    /// Whether the percussion gate is open.
    pub gate_open: bool,
}

/// Forces and rates at one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HammerRates {
    /// Forces on the bodies in N, contacts excluded, gravity included.
    pub force: [f64; body::COUNT],
    /// Pressure rates in Pa/s.
    pub pressure_rate: [f64; chamber::COUNT],
    /// Power put in by gas and gravity in W.
    pub power_in_w: f64,
    /// Power dissipated by friction and damping in W.
    pub dissipation_w: f64,
    /// Mass flow drawn from the supply in kg/s.
    pub supply_flow_kg_s: f64,
    /// What each chamber's own equation says of `d(P V)/dt`, in W: see [`ChamberBalance`].
    pub balance: [ChamberBalance; chamber::COUNT],
}

/// Terms of a chamber's energy equation, from its flows and its walls and not from the rate of its pressure:
/// `d(P V)/dt = R T (a_in m_in - a_out m_out) - (a - 1) P dV/dt`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ChamberBalance {
    /// The right-hand side, W.
    pub supplied_w: f64,
    /// `|P dV/dt|`, W: the size that the balance is measured by.
    pub expansion_w: f64,
}

/// Constants of one hammer, prepared for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct HammerModel {
    parameters: HammerParameters,
    gas: Gas,
    flow: FlowFunction,
    /// Areas `A1` to `A4` in m2.
    area: [f64; chamber::COUNT],
    /// Volumes `V10` to `V40` in m3.
    volume: [f64; chamber::COUNT],
    /// Weights of the bodies in N; the guide carries minus the sum of the others (its static reaction).
    weight: [f64; body::COUNT],
    mass: [f64; body::COUNT],
}

/// Smooth step `q^2 (3 - 2 q)`, `q` clamped to [0, 1].
#[inline]
fn smooth_step(x: f64) -> f64 {
    let q = x.clamp(0.0, 1.0);
    q * q * (3.0 - 2.0 * q)
}

/// Mass flows of one chamber: what comes from the supply and what goes to the surroundings, in kg/s.
struct ChamberFlows {
    supply: f64,
    exhaust: f64,
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
        Self {
            parameters: *parameters,
            gas,
            flow: FlowFunction::new(&gas),
            area: [a1, a2, a3, p.front_area_ratio * a3],
            volume: [
                t.top_clearance_m * a1 + t.top_dead_volume_m3,
                t.annulus_length_m * a2,
                p.rear_clearance_m * a3,
                p.front_clearance_m * a3,
            ],
            weight,
            mass,
        }
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
        let (held, stiffness) = (t.spring_preload_n + self.weight[body::GUIDE], t.spring_stiffness_n_per_m);
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
    #[inline(always)]
    pub fn volumes(&self, position: &[f64; body::COUNT]) -> [f64; chamber::COUNT] {
        let extension = position[body::CYLINDER] - position[body::GUIDE];
        let piston = position[body::PISTON] - position[body::CYLINDER];
        [
            self.volume[0] + self.area[0] * extension,
            self.volume[1] - self.area[1] * extension,
            self.volume[2] + self.area[2] * piston,
            self.volume[3] + self.area[3] * (self.parameters.piston.chamber_length_m - piston),
        ]
    }

    /// Energy stored in the return spring at extension `extension_m`, in J: `F0 e + k_l e^2 / 2`.
    pub fn return_spring_energy(&self, extension_m: f64) -> f64 {
        let t = &self.parameters.telescope;
        (t.spring_preload_n + 0.5 * t.spring_stiffness_n_per_m * extension_m) * extension_m
    }

    /// Forces, pressure rates, power and flows at a state.
    #[inline(always)]
    pub fn evaluate(&self, state: &HammerState) -> HammerRates {
        let mut rates = HammerRates {
            force: self.weight,
            pressure_rate: [0.0; chamber::COUNT],
            power_in_w: 0.0,
            dissipation_w: 0.0,
            supply_flow_kg_s: 0.0,
            balance: [ChamberBalance::default(); chamber::COUNT],
        };
        for i in 0..body::COUNT {
            rates.power_in_w += self.weight[i] * state.velocity[i];
        }
        self.telescope_forces(state, &mut rates);
        self.cylinder_forces(state, &mut rates);
        self.pressure_rates(state, &mut rates);
        rates
    }

    /// Gas, return spring and friction of the telescope: acts on the cylinder, reacts on the guide.
    #[inline(always)]
    fn telescope_forces(&self, state: &HammerState, rates: &mut HammerRates) {
        let t = &self.parameters.telescope;
        let e = state.position[body::CYLINDER] - state.position[body::GUIDE];
        let rate = state.velocity[body::CYLINDER] - state.velocity[body::GUIDE];
        let ambient = self.gas.ambient_pressure_pa;
        let gas = (state.pressure[chamber::TOP] - ambient) * self.area[0]
            - (state.pressure[chamber::ANNULUS] - ambient) * self.area[1];
        let share = if rate <= 0.0 { t.retracting_share } else { t.extending_share };
        let friction = t.friction_static_n * (rate / t.friction_velocity_m_s).tanh()
            + (t.friction_viscous_n_s_per_m + t.friction_directional_n_s_per_m * share) * rate
            + t.spring_damping_n_s_per_m * rate;
        let force = gas - (t.spring_preload_n + t.spring_stiffness_n_per_m * e) - friction;
        rates.force[body::CYLINDER] += force;
        rates.force[body::GUIDE] -= force;
        rates.power_in_w += gas * rate;
        rates.dissipation_w += friction * rate;
    }

    /// Gas and viscous forces on piston, spool and chisel, with their reactions on the cylinder.
    #[inline(always)]
    fn cylinder_forces(&self, state: &HammerState, rates: &mut HammerRates) {
        let (p, v) = (&self.parameters.piston, &self.parameters.valve);
        let ambient = self.gas.ambient_pressure_pa;
        let rear = state.pressure[chamber::REAR] - ambient;
        let gas_piston = rear * self.area[2] - (state.pressure[chamber::FRONT] - ambient) * self.area[3];
        let gas_spool = v.area_m2 * (v.supply_share * (state.supply_pa - ambient) - rear);
        let terms = [
            (body::PISTON, gas_piston, p.friction_viscous_n_s_per_m),
            (body::SPOOL, gas_spool, v.friction_viscous_n_s_per_m),
            (body::CHISEL, 0.0, self.parameters.chisel.friction_viscous_n_s_per_m),
        ];
        for (index, gas, friction) in terms {
            let rate = state.velocity[index] - state.velocity[body::CYLINDER];
            let force = gas - friction * rate;
            rates.force[index] += force;
            rates.force[body::CYLINDER] -= force;
            rates.power_in_w += gas * rate;
            rates.dissipation_w += friction * rate * rate;
        }
    }

    /// Pressure rates of the four chambers.
    #[inline(always)]
    fn pressure_rates(&self, state: &HammerState, rates: &mut HammerRates) {
        let t = &self.parameters.telescope;
        let pressure = &state.pressure;
        let ambient = self.gas.ambient_pressure_pa;
        let none = 0.0;
        let exhaust = |i: usize, area: f64| {
            if area > 0.0 { self.flow.mass_flow(pressure[i], ambient, area) } else { none }
        };
        let feed = |i: usize, area: f64| {
            if area > 0.0 { self.flow.mass_flow(state.supply_pa, pressure[i], area) } else { none }
        };
        let [rear_feed, front_feed, rear_exhaust, front_exhaust] = self.valve_areas(state);
        let flows = [
            ChamberFlows { supply: feed(chamber::TOP, t.inlet_area_m2), exhaust: none },
            ChamberFlows { supply: none, exhaust: exhaust(chamber::ANNULUS, t.vent_area_m2) },
            ChamberFlows { supply: feed(chamber::REAR, rear_feed), exhaust: exhaust(chamber::REAR, rear_exhaust) },
            ChamberFlows { supply: feed(chamber::FRONT, front_feed), exhaust: exhaust(chamber::FRONT, front_exhaust) },
        ];
        let extension_rate = state.velocity[body::CYLINDER] - state.velocity[body::GUIDE];
        let piston_rate = state.velocity[body::PISTON] - state.velocity[body::CYLINDER];
        let volume_rate = [
            self.area[0] * extension_rate,
            -self.area[1] * extension_rate,
            self.area[2] * piston_rate,
            -self.area[3] * piston_rate,
        ];
        let volume = self.volumes(&state.position);
        for i in 0..chamber::COUNT {
            let (energy_flow, expansion) = (self.energy_flow(&flows[i]), pressure[i] * volume_rate[i]);
            rates.pressure_rate[i] = self.pressure_rate(energy_flow, expansion, volume[i]);
            rates.supply_flow_kg_s += flows[i].supply;
            rates.balance[i] = ChamberBalance {
                supplied_w: energy_flow - (self.gas.expansion_exponent - 1.0) * expansion,
                expansion_w: expansion.abs(),
            };
        }
    }

    /// Rates in 1/s at which the chambers' pressures relax to the ambient one where their exhaust is linear; 0 elsewhere.
    pub fn relaxation(&self, state: &HammerState) -> [f64; chamber::COUNT] {
        let [_, _, rear, front] = self.valve_areas(state);
        let areas = [0.0, self.parameters.telescope.vent_area_m2, rear, front];
        let (volume, ambient) = (self.volumes(&state.position), self.gas.ambient_pressure_pa);
        std::array::from_fn(|i| {
            let pressure = state.pressure[i];
            let exponent = if pressure > ambient { self.gas.outflow_exponent } else { self.gas.inflow_exponent };
            let conductance = self.flow.linear_conductance(pressure, ambient, areas[i]);
            self.gas.specific_energy_j_per_kg * exponent * conductance / volume[i]
        })
    }

    /// Effective areas of the percussion: rear feed, front feed, rear exhaust, front exhaust, in m2.
    #[inline(always)]
    fn valve_areas(&self, state: &HammerState) -> [f64; 4] {
        let (p, v) = (&self.parameters.piston, &self.parameters.valve);
        let piston = state.position[body::PISTON] - state.position[body::CYLINDER];
        let rear_port = smooth_step((piston - p.rear_port_m) / p.port_width_m);
        let front_port = smooth_step((p.front_port_m - piston) / p.port_width_m);
        let (mut rear_feed, mut front_feed) = (0.0, 0.0);
        if state.gate_open {
            let spool = state.position[body::SPOOL] - state.position[body::CYLINDER];
            let front_share = smooth_step(spool / v.travel_m);
            rear_feed = v.rear_feed_area_m2 * (1.0 - front_share);
            front_feed = v.front_feed_area_m2 * front_share;
        }
        [rear_feed, front_feed, p.rear_exhaust_area_m2 * rear_port, p.front_exhaust_area_m2 * front_port]
    }

    /// `R T (a_in m_in - a_out m_out)` of a chamber in W; a flow that reverses swaps its exponent.
    #[inline(always)]
    fn energy_flow(&self, flows: &ChamberFlows) -> f64 {
        let weighted = |inward: f64| {
            if inward >= 0.0 { self.gas.inflow_exponent * inward } else { self.gas.outflow_exponent * inward }
        };
        self.gas.specific_energy_j_per_kg * (weighted(flows.supply) + weighted(-flows.exhaust))
    }

    /// `P' = (R T (a_in m_in - a_out m_out) - a P V') / V`; a volume that is not positive gives NaN, which an
    /// integrator rejects.
    #[inline(always)]
    fn pressure_rate(&self, energy_flow: f64, pressure_volume_rate: f64, volume: f64) -> f64 {
        let rate = (energy_flow - self.gas.expansion_exponent * pressure_volume_rate) / volume;
        if volume > 0.0 { rate } else { f64::NAN }
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

    /// The step is smooth: 0, 1/2, 1 with zero slope at both ends.
    #[test]
    fn analytic_smooth_step() {
        assert_eq!([-3.0, 0.0, 0.5, 1.0, 7.0].map(smooth_step), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert!(smooth_step(1e-4) < 3.1e-8 && 1.0 - smooth_step(1.0 - 1e-4) < 3.1e-8);
    }

    /// Ports and feeds at both ends of spool and piston; the gate shuts both feeds and no exhaust.
    #[test]
    fn analytic_valve_areas() {
        let model = model(9.80665);
        let at = |piston: f64, spool: f64, gate_open: bool| {
            let state = HammerState { position: [0.0, 0.0, spool, piston, 0.0], gate_open, ..model.rest() };
            model.valve_areas(&state)
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
