//! The coupled model with its discrete state: contacts, supplies, gates.

use crate::system::impulse_response::Base;
use crate::system::model::CoupledModel;

/// A coupled model being integrated: which contacts are closed, which supplies and gates are open, and scratch memory.
#[derive(Debug, Clone)]
pub struct Coupled<'a> {
    pub(super) model: &'a CoupledModel,
    /// The condensed modes at their last rebase; `None` if modes are integrated.
    pub(super) base: Option<Base>,
    pub(super) closed: Vec<bool>,
    /// Whether forces of contacts follow the state alone, see [`crate::integrate::Switching::follow_state`].
    pub(super) following: bool,
    /// Contacts that may exert a force: the closed ones, or all where forces follow the state.
    pub(super) acting: Vec<usize>,
    /// How often each supply has been switched: it is on after an odd number of times.
    pub(super) supply_switched: Vec<usize>,
    pub(super) gate_open: Vec<bool>,
    /// When each gate opens; infinite until the hammer's first contact.
    gate_time_s: Vec<f64>,
    /// Energy that springs of contacts held when these opened under compression, J.
    pub(super) released_energy_j: f64,
    pub(super) displacement: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) force: Vec<f64>,
    /// Accelerations of interface points without what forces on them cause at once; changed when guides take their share.
    pub(super) acceleration: Vec<f64>,
    /// Accelerations of integrated modes without forces, and the power that they dissipate, W.
    pub(super) free: Vec<f64>,
    pub(super) modal_loss: f64,
}

impl<'a> Coupled<'a> {
    /// The model at rest.
    pub fn new(model: &'a CoupledModel) -> Self {
        let hammers = model.hammers.len();
        let points = model.layout.bodies + model.modes.phi.ncols();
        let mut system = Self {
            model,
            base: model.condensation.as_ref().map(Base::at_rest),
            closed: vec![false; model.elements.contacts().len()],
            following: false,
            acting: Vec::with_capacity(model.elements.contacts().len()),
            supply_switched: vec![0; hammers],
            gate_open: vec![false; hammers],
            gate_time_s: vec![f64::INFINITY; hammers],
            released_energy_j: 0.0,
            displacement: vec![0.0; points],
            velocity: vec![0.0; points],
            force: vec![0.0; points],
            acceleration: vec![0.0; model.modes.phi.ncols()],
            free: vec![0.0; model.layout.structure[1]],
            modal_loss: 0.0,
        };
        // At rest interface points stand still at zero.
        let positions = &model.initial[model.layout.position(0)..model.layout.velocities()];
        system.displacement[..model.layout.bodies].copy_from_slice(positions);
        for (at, contact) in model.elements.contacts().iter().enumerate() {
            let motion = [&system.displacement[..], &system.velocity];
            let [d, rate] = model.elements.values(model.elements.contact_row(at), motion);
            system.closed[at] = contact.law.onset_indicator(d - contact.offset_m, rate) > 0.0;
        }
        system.list_acting();
        system
    }

    /// The constants.
    pub fn model(&self) -> &'a CoupledModel {
        self.model
    }

    /// Whether a contact is closed.
    pub fn is_closed(&self, contact: usize) -> bool {
        self.closed[contact]
    }

    /// How often a hammer's supply has been switched on so far: the number of its strokes.
    pub fn strokes(&self, hammer: usize) -> usize {
        self.supply_switched[hammer].div_ceil(2)
    }

    /// Whether a hammer's percussion gate is open.
    pub fn gate_open(&self, hammer: usize) -> bool {
        self.gate_open[hammer]
    }

    /// Lists the contacts that may exert a force.
    pub(super) fn list_acting(&mut self) {
        self.acting.clear();
        let (closed, following) = (&self.closed, self.following);
        self.acting.extend((0..closed.len()).filter(|&contact| following || closed[contact]));
    }

    pub(super) fn refresh_gate(&mut self, contact: usize, t: f64) {
        let hammer = self.model.elements.contacts()[contact].hammer;
        let first = self.gate_time_s[hammer].is_infinite();
        if first && !self.vented(hammer) && self.model.hammers[hammer].strike == contact {
            self.gate_time_s[hammer] = t + self.model.hammers[hammer].gate_delay_s;
        }
    }

    /// Whether a hammer's supply has been switched off.
    pub(super) fn vented(&self, hammer: usize) -> bool {
        self.supply_switched[hammer] > 0 && self.supply_switched[hammer].is_multiple_of(2)
    }

    /// Switches a supply over. Off ends the percussion; on starts the hammer anew: the gate waits for the next contact,
    /// or from now where the chisel rests on the casting.
    pub(super) fn switch_supply(&mut self, hammer: usize, time_s: f64) {
        let slot = &self.model.hammers[hammer];
        self.supply_switched[hammer] += 1;
        if self.vented(hammer) {
            self.gate_open[hammer] = false;
            self.gate_time_s[hammer] = f64::INFINITY;
        } else if self.supply_switched[hammer] > 1 && self.closed[slot.strike] {
            self.gate_time_s[hammer] = time_s + slot.gate_delay_s;
        }
    }

    /// The pending stop that is due first: its time, its hammer, and whether it is the supply's.
    pub(super) fn pending(&self) -> Option<(f64, usize, bool)> {
        let hammers = 0..self.model.hammers.len();
        let supplies = hammers.clone().filter_map(|h| {
            let time = self.model.hammers[h].supply_times_s.get(self.supply_switched[h])?;
            Some((*time, h, true))
        });
        let gates = hammers
            .filter(|&h| !self.gate_open[h] && self.gate_time_s[h].is_finite())
            .map(|h| (self.gate_time_s[h], h, false));
        supplies.chain(gates).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
