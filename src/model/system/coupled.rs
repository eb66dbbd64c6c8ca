//! The coupled model with its discrete state: contacts, supplies, gates.

use std::sync::Arc;

use crate::scene::Owner;
use crate::system::block::Block;
use crate::system::discrete::Discrete;
use crate::system::model::CoupledModel;
use crate::system::rates::Rates;

/// A coupled model being integrated: which contacts are closed, which supplies and gates are open, and scratch memory.
#[derive(Debug, Clone)]
pub struct Coupled {
    pub(super) model: Arc<CoupledModel>,
    /// Blocks of the model's parts, with the modes that are outside the state.
    pub(super) blocks: Vec<Block>,
    pub(super) discrete: Discrete,
    /// Whether forces of contacts follow the state alone, see [`crate::integrate::Switching::follow_state`].
    pub(super) following: bool,
    /// Energy that springs of contacts held when these opened under compression, J.
    pub(super) released_energy_j: f64,
    pub(super) rates: Rates<f64>,
}

impl Coupled {
    /// The model at rest.
    pub fn new(model: &Arc<CoupledModel>) -> Self {
        let discrete = Discrete::at_rest(model);
        Self {
            blocks: model.parts.iter().map(|part| part.block.clone()).collect(),
            following: false,
            released_energy_j: 0.0,
            rates: Rates::new(model, &discrete),
            discrete,
            model: Arc::clone(model),
        }
    }

    /// The same model at rest.
    pub fn at_rest(&self) -> Self {
        Self::new(&self.model)
    }

    /// The constants.
    pub fn model(&self) -> &CoupledModel {
        &self.model
    }

    /// Whether a contact is closed.
    pub fn is_closed(&self, contact: usize) -> bool {
        self.discrete.closed[contact]
    }

    /// Number of times that a hammer's supply has been switched on: the number of its strokes.
    pub fn strokes(&self, hammer: usize) -> usize {
        self.discrete.supply_switched[hammer].div_ceil(2)
    }

    /// Whether a hammer's percussion gate is open.
    pub fn gate_open(&self, hammer: usize) -> bool {
        self.discrete.gate_open[hammer]
    }

    /// A contact has closed: the first of a stroke between chisel and casting sets the time at which the gate opens.
    pub(super) fn refresh_gate(&mut self, contact: usize, t: f64) {
        let Owner::Hammer { hammer, .. } = self.model.elements.contacts()[contact].owner else { return };
        let first = self.discrete.gate_time_s[hammer].is_infinite();
        if first && !self.discrete.vented(hammer) && self.model.hammers[hammer].strike == contact {
            self.discrete.gate_time_s[hammer] = t + self.model.hammers[hammer].gate_delay_s;
        }
    }

    /// Switches a supply over. Off ends the percussion; on starts the hammer anew: the gate waits for the next contact,
    /// or from now where the chisel rests on the casting.
    pub(super) fn switch_supply(&mut self, hammer: usize, time_s: f64) {
        let slot = &self.model.hammers[hammer];
        self.discrete.supply_switched[hammer] += 1;
        if self.discrete.vented(hammer) {
            self.discrete.gate_open[hammer] = false;
            self.discrete.gate_time_s[hammer] = f64::INFINITY;
        } else if self.discrete.supply_switched[hammer] > 1 && self.discrete.closed[slot.strike] {
            self.discrete.gate_time_s[hammer] = time_s + slot.gate_delay_s;
        }
    }

    /// The pending stop that is due first: its time, its hammer, and whether it is the supply's.
    pub(super) fn pending(&self) -> Option<(f64, usize, bool)> {
        let hammers = 0..self.model.hammers.len();
        let supplies = hammers.clone().filter_map(|h| {
            let time = self.model.hammers[h].supply_times_s.get(self.discrete.supply_switched[h])?;
            Some((*time, h, true))
        });
        let gates = hammers
            .filter(|&h| !self.discrete.gate_open[h] && self.discrete.gate_time_s[h].is_finite())
            .map(|h| (self.discrete.gate_time_s[h], h, false));
        supplies.chain(gates).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
