//! Gas in a hammer's chambers: rates of the pressures from volumes, their rates, and flows.

use super::flow::{FlowFunction, Gas, Pressure};
use super::state::{ChamberBalance, HammerRates, HammerState, chamber};
use decore_math::number::{Number, per_lane};

/// Area of a bore in m2, of its diameter in m.
pub(super) fn bore_area(diameter_m: f64) -> f64 {
    0.25 * std::f64::consts::PI * diameter_m * diameter_m
}

per_lane! {
    /// Constants of the gas and its surroundings, of one hammer or of one in each lane.
    pub(super) struct GasConstants<R> {
        pub ambient: Pressure<R>,
        pub flow: FlowFunction<R>,
        /// `R T a` of the inflow and outflow, J/kg.
        inflow_energy_j_per_kg: R,
        outflow_energy_j_per_kg: R,
        expansion_exponent: R,
    }
}

/// The chambers at a state.
pub(super) struct Chambers<'s, R: Number> {
    pub state: &'s HammerState<R>,
    pub supply: Pressure<R>,
    pub pressure: [Pressure<R>; chamber::COUNT],
    /// Volumes in m3 and their inverses.
    volume: [R; chamber::COUNT],
    inverse_volume: [R; chamber::COUNT],
}

/// Flows into one chamber.
pub(super) struct ChamberFlows<R> {
    /// Flow from the supply, kg/s.
    pub supply_kg_s: R,
    /// Energy that all flows bring, W: the sum of [`GasConstants::energy`] over them.
    pub energy_w: R,
}

impl GasConstants<f64> {
    pub(super) fn new(gas: &Gas) -> Self {
        Self {
            ambient: Pressure { pa: gas.ambient_pressure_pa, inverse: 1.0 / gas.ambient_pressure_pa },
            flow: FlowFunction::new(gas),
            inflow_energy_j_per_kg: gas.specific_energy_j_per_kg * gas.inflow_exponent,
            outflow_energy_j_per_kg: gas.specific_energy_j_per_kg * gas.outflow_exponent,
            expansion_exponent: gas.expansion_exponent,
        }
    }
}

impl<R: Number> GasConstants<R> {
    /// Chambers of volumes `volume` in m3.
    #[inline(always)]
    pub(super) fn chambers<'s>(&self, state: &'s HammerState<R>, volume: [R; chamber::COUNT]) -> Chambers<'s, R> {
        let one = R::splat(1.0);
        let supply = Pressure { pa: state.supply_pa, inverse: one / state.supply_pa };
        // One division gives the inverses of a chamber's pressure and volume.
        let mut inverse_volume = [R::splat(0.0); chamber::COUNT];
        let mut pressure = [self.ambient; chamber::COUNT];
        for i in 0..chamber::COUNT {
            let both = one / (state.pressure[i] * volume[i]);
            inverse_volume[i] = state.pressure[i] * both;
            pressure[i] = Pressure { pa: state.pressure[i], inverse: volume[i] * both };
        }
        Chambers { state, supply, pressure, volume, inverse_volume }
    }

    /// Energy that a mass flow in kg/s into a chamber brings, in W: `R T a_in m`. Of one that leaves, `m < 0`, it is
    /// `R T a_out m`, so that a flow that reverses swaps its exponent.
    #[inline(always)]
    pub(super) fn energy(&self, inward: R) -> R {
        let inwards = inward.greater_equal(R::splat(0.0));
        R::select(inwards, self.inflow_energy_j_per_kg, self.outflow_energy_j_per_kg) * inward
    }

    /// Adds the pressure rates of the chambers, whose volumes change at `volume_rate` in m3/s.
    #[inline(always)]
    pub(super) fn add_pressure_rates(
        &self,
        chambers: &Chambers<'_, R>,
        volume_rate: &[R; chamber::COUNT],
        flows: &[ChamberFlows<R>; chamber::COUNT],
        rates: &mut HammerRates<R>,
    ) {
        let (none, one) = (R::splat(0.0), R::splat(1.0));
        for i in 0..chamber::COUNT {
            let (energy_flow, expansion) = (flows[i].energy_w, chambers.pressure[i].pa * volume_rate[i]);
            // `P' = (R T (a_in m_in - a_out m_out) - a P V') / V`; a volume that is not positive gives NaN, which an
            // integrator rejects.
            let rate = (energy_flow - self.expansion_exponent * expansion) * chambers.inverse_volume[i];
            rates.pressure_rate[i] = R::select(chambers.volume[i].greater(none), rate, R::splat(f64::NAN));
            rates.supply_flow_kg_s += flows[i].supply_kg_s;
            rates.balance[i] = ChamberBalance {
                supplied_w: energy_flow - (self.expansion_exponent - one) * expansion,
                expansion_w: expansion.abs(),
            };
        }
    }
}
