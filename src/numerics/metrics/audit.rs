//! The books of a run: energy put in, stored and dissipated, each by itself, and the gas of each chamber by its own equation.

use std::ops::Range;

use super::at::At;
use crate::hammer::chamber;
use crate::integrate::Step;
use crate::system::{Coupled, CoupledModel};

/// Work in J below which residuals are taken relative to this value: a hammer that never starts puts in next to nothing, and a
/// ratio of rounding errors says nothing.
const LEAST_WORK_J: f64 = 1.0;
/// Longest time between two nodes in s: that of an impact, which bends the modes' velocities.
const LONGEST_INTERVAL_S: f64 = 1.25e-4;
/// Angle by which the fastest mode turns between two nodes at most, rad: its squared velocity by less than a whole period.
const INTERVAL_RAD: f64 = 3.0;

/// Follows what the state does not carry: the energy that condensed modes dissipate, `int sum 2 xi omega x'^2 dt`.
///
/// Their velocities are known at any time but integrated nowhere: they are read in the middles of equal intervals. Of an
/// oscillation that is read more than once in a period, equal weights give the mean exactly; what remains are the ends of the
/// run, where the modes hardly move.
pub(super) struct Audit {
    /// Time between two nodes in s; `None` where modes are integrated.
    interval_s: Option<f64>,
    /// Index of the next node, counted from the beginning.
    next: u64,
    dissipated_j: f64,
    /// Components of the state that condensed modes are read from.
    support: Range<usize>,
}

impl Audit {
    /// Prepares the books of a run of `duration_s`.
    pub fn new(model: &CoupledModel, duration_s: f64) -> Self {
        let interval = |fastest_rad_s: f64| {
            let longest_s = (INTERVAL_RAD / fastest_rad_s).min(LONGEST_INTERVAL_S);
            let count = (duration_s / longest_s).ceil().max(1.0);
            // A duration that no budget lets end may have more intervals than there are numbers.
            if count.is_finite() { duration_s / count } else { longest_s }
        };
        Self {
            interval_s: model.condensed_fastest_rad_s().map(interval),
            next: 0,
            dissipated_j: 0.0,
            support: model.layout().structure_displacements(),
        }
    }

    /// Follows a step.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        self.follow(system, step, step.t1(), scratch);
    }

    /// Follows a step up to `time_s`.
    pub fn follow(&mut self, system: &Coupled, step: &Step<'_>, time_s: f64, scratch: &mut [f64]) {
        let Some(interval_s) = self.interval_s else { return };
        loop {
            let t = (self.next as f64 + 0.5) * interval_s;
            if t > time_s {
                return;
            }
            step.range(self.support.clone(), step.fraction(t), scratch);
            self.dissipated_j += interval_s * system.condensed_dissipation_w(t, scratch);
            self.next += 1;
        }
    }

    /// Energy dissipated up to a state that has been followed to, J; between two nodes at the power of that state.
    pub fn dissipated_energy(&self, system: &Coupled, At { t, y }: At<'_>) -> f64 {
        let since_node_s = self.interval_s.map_or(0.0, |interval_s| t - self.next as f64 * interval_s);
        system.dissipated_energy(y) + self.dissipated_j + since_node_s * system.condensed_dissipation_w(t, y)
    }

    /// `(work put in - stored - dissipated) / (work put in)`, stored energy relative to rest.
    pub fn energy_residual(&self, system: &Coupled, At { t, y }: At<'_>) -> f64 {
        let model = system.model();
        let put_in = y[model.layout().work_in()];
        let at_rest = system.at_rest().stored_energy(0.0, model.initial_state());
        let stored = system.stored_energy(t, y) - at_rest;
        let dissipated = system.dissipated_energy(y) + self.dissipated_j;
        (put_in - stored - dissipated) / put_in.abs().max(LEAST_WORK_J)
    }
}

/// Largest over the chambers of `|D(P V) - int (R T (a_in m_in - a_out m_out) - (a - 1) P dV/dt) dt|` over `int |P dV|`; NaN if one
/// of them is.
pub(super) fn chamber_residual(system: &Coupled, At { t, y }: At<'_>) -> f64 {
    let model = system.model();
    let at_rest = system.at_rest();
    let mut largest = 0.0_f64;
    for hammer in 0..model.layout().hammers {
        let begin = chamber_energies(&at_rest, hammer, At { t: 0.0, y: model.initial_state() });
        let end = chamber_energies(system, hammer, At { t, y });
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
fn chamber_energies(system: &Coupled, hammer: usize, At { t, y }: At<'_>) -> [f64; chamber::COUNT] {
    let state = system.hammer_state(hammer, t, y);
    let volumes = system.model().hammers()[hammer].model.volumes(&state.position);
    std::array::from_fn(|chamber| state.pressure[chamber] * volumes[chamber])
}
