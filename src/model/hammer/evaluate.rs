//! Forces and gas rates of all components at a state, for one hammer or one in each lane.
//!
//! Positions run along the strike axis.

use super::chambers::GasConstants;
use super::chisel::ChiselConstants;
use super::flow::Gas;
use super::parameters::HammerParameters;
use super::piston::PistonConstants;
use super::state::{ChamberBalance, HammerRates, HammerState, body, chamber};
use super::telescope::TelescopeConstants;
use super::valve::ValveConstants;
use decore_math::number::{Number, per_lane};

per_lane! {
    /// Constants of one hammer, or of one in each lane, as its equations use them.
    pub struct HammerConstants<R> {
        /// Weights of the bodies in N; the guide carries minus the sum of the others (its static reaction).
        pub(super) weight: [R; body::COUNT],
        gas: GasConstants<R>,
        telescope: TelescopeConstants<R>,
        piston: PistonConstants<R>,
        valve: ValveConstants<R>,
        chisel: ChiselConstants<R>,
    }
}

impl HammerConstants<f64> {
    /// Prepares the constants of a hammer whose bodies weigh `weight` in N.
    pub(super) fn new(parameters: &HammerParameters, gas: &Gas, weight: [f64; body::COUNT]) -> Self {
        Self {
            weight,
            gas: GasConstants::new(gas),
            telescope: TelescopeConstants::new(&parameters.telescope),
            piston: PistonConstants::new(&parameters.piston),
            valve: ValveConstants::new(&parameters.valve),
            chisel: ChiselConstants::new(&parameters.chisel),
        }
    }
}

impl<R: Number> HammerConstants<R> {
    /// Current chamber volumes in m3.
    #[inline(always)]
    pub fn volumes(&self, position: &[R; body::COUNT]) -> [R; chamber::COUNT] {
        in_order(self.telescope.volumes(position), self.piston.volumes(position))
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
        let ambient = self.gas.ambient.pa;
        self.telescope.add_forces(state, ambient, &mut rates);
        self.piston.add_forces(state, ambient, &mut rates);
        self.valve.add_forces(state, ambient, &mut rates);
        self.chisel.add_forces(state, &mut rates);
        let chambers = self.gas.chambers(state, self.volumes(&state.position));
        let feed_area = self.valve.feed_areas(state);
        let flows =
            in_order(self.telescope.flows(&self.gas, &chambers), self.piston.flows(&self.gas, &chambers, feed_area));
        let volume_rate =
            in_order(self.telescope.volume_rates(&state.velocity), self.piston.volume_rates(&state.velocity));
        self.gas.add_pressure_rates(&chambers, &volume_rate, &flows, &mut rates);
        rates
    }
}

/// Figures of the telescope's chambers and of the piston's, in the order of [`chamber`].
#[inline(always)]
fn in_order<T>([top, annulus]: [T; 2], [rear, front]: [T; 2]) -> [T; chamber::COUNT] {
    [top, annulus, rear, front]
}
