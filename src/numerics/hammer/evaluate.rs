//! Forces and gas rates at a state, of one hammer or of one in each lane.
//!
//! Positions run along the strike axis. Relative coordinates: `e = x_cb - x_Gh`, `p = x_p - x_cb`, `s = x_sv - x_cb`,
//! `c = x_h - x_cb`.

use super::flow::{FlowFunction, Pressure};
use crate::number::{Number, per_lane, tanh};

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
    /// Parameters of a hammer that keep each from being driven empty: the stop before it and its room.
    pub const KEPT_BY: [&str; COUNT] = [
        "`telescope.top_stop.stiffness_n_per_m` or `telescope.top_clearance_m`",
        "`telescope.end_stop.stiffness_n_per_m` or `telescope.annulus_length_m`",
        "`piston.rear_wall.stiffness_n_per_m` or `piston.rear_clearance_m`",
        "`piston.front_clearance_m` or `piston.chamber_length_m`",
    ];
}

/// State of one hammer as the model sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HammerState<R: Number = f64> {
    /// Positions of the bodies in m.
    pub position: [R; body::COUNT],
    /// Velocities of the bodies in m/s.
    pub velocity: [R; body::COUNT],
    /// Absolute chamber pressures in Pa.
    pub pressure: [R; chamber::COUNT],
    /// Absolute supply pressure at this time in Pa (ambient before the start).
    pub supply_pa: R,
    /// Whether the percussion gate is open.
    pub gate_open: R::Mask,
}

/// Forces and rates at one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HammerRates<R = f64> {
    /// Forces on the bodies in N, contacts excluded, gravity included.
    pub force: [R; body::COUNT],
    /// Pressure rates in Pa/s.
    pub pressure_rate: [R; chamber::COUNT],
    /// Power put in by gas and gravity in W.
    pub power_in_w: R,
    /// Power dissipated by friction and damping in W.
    pub dissipation_w: R,
    /// Mass flow drawn from the supply in kg/s.
    pub supply_flow_kg_s: R,
    /// What each chamber's own equation says of `d(P V)/dt`, in W: see [`ChamberBalance`].
    pub balance: [ChamberBalance<R>; chamber::COUNT],
}

/// Terms of a chamber's energy equation, from its flows and its walls and not from the rate of its pressure:
/// `d(P V)/dt = R T (a_in m_in - a_out m_out) - (a - 1) P dV/dt`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ChamberBalance<R = f64> {
    /// The right-hand side, W.
    pub supplied_w: R,
    /// `|P dV/dt|`, W: the size that the balance is measured by.
    pub expansion_w: R,
}

per_lane! {
    /// Constants of one hammer, or of one in each lane, as its equations use them.
    pub struct HammerConstants<R> {
        /// Weights of the bodies in N; the guide carries minus the sum of the others (its static reaction).
        pub(super) weight: [R; body::COUNT],
        /// Areas `A1` to `A4` in m2.
        pub(super) area: [R; chamber::COUNT],
        /// Volumes `V10` to `V40` in m3.
        pub(super) volume: [R; chamber::COUNT],
        /// Length of the piston's chamber `L_p` in m.
        pub(super) chamber_length_m: R,
        /// Static friction of the telescope in N and inverse of its velocity in s/m.
        pub(super) friction_static_n: R,
        pub(super) inverse_friction_velocity_s_per_m: R,
        /// Viscous resistance of the telescope, that of its spring included, retracting and extending, N s/m.
        pub(super) resistance_n_s_per_m: [R; 2],
        pub(super) spring_preload_n: R,
        pub(super) spring_stiffness_n_per_m: R,
        /// Viscous friction of piston, spool and chisel in the cylinder, N s/m.
        pub(super) friction_viscous_n_s_per_m: [R; 3],
        pub(super) spool_area_m2: R,
        pub(super) supply_share: R,
        pub(super) inlet_area_m2: R,
        pub(super) vent_area_m2: R,
        pub(super) rear_port_m: R,
        pub(super) front_port_m: R,
        pub(super) inverse_port_width_per_m: R,
        pub(super) inverse_travel_per_m: R,
        /// Effective areas of feeds and exhausts, rear and front, m2.
        pub(super) feed_area_m2: [R; 2],
        pub(super) exhaust_area_m2: [R; 2],
        pub(super) ambient_pa: R,
        pub(super) inverse_ambient_per_pa: R,
        /// `R T a` of what flows in and out, J/kg.
        pub(super) inflow_energy_j_per_kg: R,
        pub(super) outflow_energy_j_per_kg: R,
        pub(super) expansion_exponent: R,
        pub(super) flow: FlowFunction<R>,
    }
}

/// Smooth step `q^2 (3 - 2 q)`, `q` clamped to [0, 1].
#[inline(always)]
fn smooth_step<R: Number>(x: R) -> R {
    // In this order of arguments a NaN remains one.
    let q = R::splat(0.0).greatest(R::splat(1.0).least(x));
    q * q * (R::splat(3.0) - R::splat(2.0) * q)
}

/// Mass flows of one chamber: what comes from the supply and what goes to the surroundings, in kg/s.
struct ChamberFlows<R> {
    supply: R,
    exhaust: R,
}

impl<R: Number> HammerConstants<R> {
    /// Current chamber volumes in m3.
    #[inline(always)]
    pub fn volumes(&self, position: &[R; body::COUNT]) -> [R; chamber::COUNT] {
        let extension = position[body::CYLINDER] - position[body::GUIDE];
        let piston = position[body::PISTON] - position[body::CYLINDER];
        [
            self.volume[0] + self.area[0] * extension,
            self.volume[1] - self.area[1] * extension,
            self.volume[2] + self.area[2] * piston,
            self.volume[3] + self.area[3] * (self.chamber_length_m - piston),
        ]
    }

    /// Forces, pressure rates, power and flows at a state.
    #[inline(always)]
    pub fn evaluate(&self, state: &HammerState<R>) -> HammerRates<R> {
        let mut rates = HammerRates {
            force: self.weight,
            pressure_rate: [R::splat(0.0); chamber::COUNT],
            power_in_w: R::splat(0.0),
            dissipation_w: R::splat(0.0),
            supply_flow_kg_s: R::splat(0.0),
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
    fn telescope_forces(&self, state: &HammerState<R>, rates: &mut HammerRates<R>) {
        let e = state.position[body::CYLINDER] - state.position[body::GUIDE];
        let rate = state.velocity[body::CYLINDER] - state.velocity[body::GUIDE];
        let gas = (state.pressure[chamber::TOP] - self.ambient_pa) * self.area[0]
            - (state.pressure[chamber::ANNULUS] - self.ambient_pa) * self.area[1];
        let [retracting, extending] = self.resistance_n_s_per_m;
        let resistance = R::select(rate.less_equal(R::splat(0.0)), retracting, extending);
        let friction = self.friction_static_n * tanh(rate * self.inverse_friction_velocity_s_per_m) + resistance * rate;
        let force = gas - (self.spring_preload_n + self.spring_stiffness_n_per_m * e) - friction;
        rates.force[body::CYLINDER] += force;
        rates.force[body::GUIDE] -= force;
        rates.power_in_w += gas * rate;
        rates.dissipation_w += friction * rate;
    }

    /// Gas and viscous forces on piston, spool and chisel, with their reactions on the cylinder.
    #[inline(always)]
    fn cylinder_forces(&self, state: &HammerState<R>, rates: &mut HammerRates<R>) {
        let ambient = self.ambient_pa;
        let rear = state.pressure[chamber::REAR] - ambient;
        let gas_piston = rear * self.area[2] - (state.pressure[chamber::FRONT] - ambient) * self.area[3];
        let gas_spool = self.spool_area_m2 * (self.supply_share * (state.supply_pa - ambient) - rear);
        let [piston, spool, chisel] = self.friction_viscous_n_s_per_m;
        let terms = [
            (body::PISTON, gas_piston, piston),
            (body::SPOOL, gas_spool, spool),
            (body::CHISEL, R::splat(0.0), chisel),
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
    fn pressure_rates(&self, state: &HammerState<R>, rates: &mut HammerRates<R>) {
        let (none, one) = (R::splat(0.0), R::splat(1.0));
        let volume = self.volumes(&state.position);
        let ambient = Pressure { pa: self.ambient_pa, inverse: self.inverse_ambient_per_pa };
        let supply = Pressure { pa: state.supply_pa, inverse: one / state.supply_pa };
        // One division gives the inverse of a chamber's pressure and that of its volume.
        let mut inverse_volume = [none; chamber::COUNT];
        let mut pressure = [ambient; chamber::COUNT];
        for i in 0..chamber::COUNT {
            let both = one / (state.pressure[i] * volume[i]);
            inverse_volume[i] = state.pressure[i] * both;
            pressure[i] = Pressure { pa: state.pressure[i], inverse: volume[i] * both };
        }
        let [top, annulus, rear, front] = pressure;
        let [rear_feed, front_feed, rear_exhaust, front_exhaust] = self.valve_areas(state);
        let flow = &self.flow;
        let flows = [
            ChamberFlows { supply: flow.mass_flow(supply, top, self.inlet_area_m2), exhaust: none },
            ChamberFlows { supply: none, exhaust: flow.mass_flow(annulus, ambient, self.vent_area_m2) },
            ChamberFlows {
                supply: flow.mass_flow(supply, rear, rear_feed),
                exhaust: flow.mass_flow(rear, ambient, rear_exhaust),
            },
            ChamberFlows {
                supply: flow.mass_flow(supply, front, front_feed),
                exhaust: flow.mass_flow(front, ambient, front_exhaust),
            },
        ];
        let extension_rate = state.velocity[body::CYLINDER] - state.velocity[body::GUIDE];
        let piston_rate = state.velocity[body::PISTON] - state.velocity[body::CYLINDER];
        let volume_rate = [
            self.area[0] * extension_rate,
            -self.area[1] * extension_rate,
            self.area[2] * piston_rate,
            -self.area[3] * piston_rate,
        ];
        for i in 0..chamber::COUNT {
            let (energy_flow, expansion) = (self.energy_flow(&flows[i]), state.pressure[i] * volume_rate[i]);
            // `P' = (R T (a_in m_in - a_out m_out) - a P V') / V`; a volume that is not positive gives NaN, which an
            // integrator rejects.
            let rate = (energy_flow - self.expansion_exponent * expansion) * inverse_volume[i];
            rates.pressure_rate[i] = R::select(volume[i].greater(none), rate, R::splat(f64::NAN));
            rates.supply_flow_kg_s += flows[i].supply;
            rates.balance[i] = ChamberBalance {
                supplied_w: energy_flow - (self.expansion_exponent - one) * expansion,
                expansion_w: expansion.abs(),
            };
        }
    }

    /// Effective areas of the percussion: rear feed, front feed, rear exhaust, front exhaust, in m2.
    #[inline(always)]
    pub(super) fn valve_areas(&self, state: &HammerState<R>) -> [R; 4] {
        let piston = state.position[body::PISTON] - state.position[body::CYLINDER];
        let rear_port = smooth_step((piston - self.rear_port_m) * self.inverse_port_width_per_m);
        let front_port = smooth_step((self.front_port_m - piston) * self.inverse_port_width_per_m);
        let spool = state.position[body::SPOOL] - state.position[body::CYLINDER];
        let front_share = smooth_step(spool * self.inverse_travel_per_m);
        let none = R::splat(0.0);
        let [rear_feed, front_feed] = self.feed_area_m2;
        let [rear_exhaust, front_exhaust] = self.exhaust_area_m2;
        [
            R::select(state.gate_open, rear_feed * (R::splat(1.0) - front_share), none),
            R::select(state.gate_open, front_feed * front_share, none),
            rear_exhaust * rear_port,
            front_exhaust * front_port,
        ]
    }

    /// `R T (a_in m_in - a_out m_out)` of a chamber in W; a flow that reverses swaps its exponent.
    #[inline(always)]
    fn energy_flow(&self, flows: &ChamberFlows<R>) -> R {
        self.weighted(flows.supply) + self.weighted(-flows.exhaust)
    }

    /// Energy that a flow into a chamber brings, W; negative of one that leaves it.
    #[inline(always)]
    fn weighted(&self, inward: R) -> R {
        let inwards = inward.greater_equal(R::splat(0.0));
        R::select(inwards, self.inflow_energy_j_per_kg, self.outflow_energy_j_per_kg) * inward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The step is smooth: 0, 1/2, 1 with zero slope at both ends.
    #[test]
    fn analytic_smooth_step() {
        assert_eq!([-3.0, 0.0, 0.5, 1.0, 7.0].map(smooth_step), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert!(smooth_step(1e-4) < 3.1e-8 && 1.0 - smooth_step(1.0 - 1e-4) < 3.1e-8);
    }
}
