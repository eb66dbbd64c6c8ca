//! The books of a run: energy put in, stored and dissipated, each by itself, and the gas of each chamber by its own equation.

use super::instant::Instant;
use crate::hammer::chamber;
use crate::system::Coupled;

/// Work in J below which residuals are taken relative to this value: a hammer that never starts puts in next to nothing, and a
/// ratio of rounding errors says nothing.
const LEAST_WORK_J: f64 = 1.0;

/// `(work put in - stored - dissipated) / (work put in)` at the end of a run, stored energy relative to rest.
pub(super) fn energy_residual(system: &Coupled, Instant { t, y }: Instant<'_>) -> f64 {
    let model = system.model();
    let put_in = y[model.layout().work_in()];
    let at_rest = system.at_rest().stored_energy(0.0, model.initial_state());
    let stored = system.stored_energy(t, y) - at_rest;
    (put_in - stored - system.dissipated_to_the_end(y)) / put_in.abs().max(LEAST_WORK_J)
}

/// Largest over the chambers of `|D(P V) - int (R T (a_in m_in - a_out m_out) - (a - 1) P dV/dt) dt|` over `int |P dV|`; NaN if one
/// of them is.
pub(super) fn chamber_residual(system: &Coupled, Instant { t, y }: Instant<'_>) -> f64 {
    let model = system.model();
    let at_rest = system.at_rest();
    let mut largest = 0.0_f64;
    for hammer in 0..model.layout().hammers {
        let begin = chamber_energies(&at_rest, hammer, Instant { t: 0.0, y: model.initial_state() });
        let end = chamber_energies(system, hammer, Instant { t, y });
        let supplied = &y[model.layout().chambers_supplied(hammer)];
        let expansion = &y[model.layout().chambers_expansion(hammer)];
        for chamber in 0..chamber::COUNT {
            let change = end[chamber] - begin[chamber];
            let residual = (change - supplied[chamber]).abs() / expansion[chamber].max(LEAST_WORK_J);
            // A maximum alone would drop what is not a number.
            largest = if residual > largest || residual.is_nan() { residual } else { largest };
        }
    }
    largest
}

/// `P V` of a hammer's chambers in J.
fn chamber_energies(system: &Coupled, hammer: usize, Instant { t, y }: Instant<'_>) -> [f64; chamber::COUNT] {
    let state = system.hammer_state(hammer, t, y);
    let volumes = system.model().hammers()[hammer].model.volumes(&state.position);
    std::array::from_fn(|chamber| state.pressure[chamber] * volumes[chamber])
}
