//! The discrete state of a coupled model: contacts, supplies, gates.

use crate::system::elements::Contact;
use crate::system::model::CoupledModel;

/// State that changes only at switches and stops.
#[derive(Debug, Clone)]
pub(super) struct Discrete {
    /// Closed contacts.
    pub closed: Vec<bool>,
    /// Number of switches of each supply: it is on after an odd number.
    pub supply_switched: Vec<usize>,
    /// Open gates.
    pub gate_open: Vec<bool>,
    /// When each gate opens; infinite until the hammer's first contact.
    pub gate_time_s: Vec<f64>,
}

impl Discrete {
    /// State of the model at rest.
    pub fn at_rest(model: &CoupledModel) -> Self {
        let hammers = model.hammers.len();
        // At rest points of flexible parts stand still at zero.
        let mut displacement = vec![0.0; model.elements.matrix().cols()];
        let positions = &model.initial[model.layout.position(0)..model.layout.velocities()];
        displacement[..model.layout.bodies].copy_from_slice(positions);
        let closed = |(at, contact): (usize, &Contact)| {
            let row = model.elements.row(model.elements.contact_row(at));
            let d: f64 = row.map(|(column, coefficient)| coefficient * displacement[column]).sum();
            contact.law.onset_indicator(d - contact.offset_m, 0.0) > 0.0
        };
        Self {
            closed: model.elements.contacts().iter().enumerate().map(closed).collect(),
            supply_switched: vec![0; hammers],
            gate_open: vec![false; hammers],
            gate_time_s: vec![f64::INFINITY; hammers],
        }
    }

    /// Whether a hammer's supply has been switched off.
    pub fn vented(&self, hammer: usize) -> bool {
        self.supply_switched[hammer] > 0 && self.supply_switched[hammer].is_multiple_of(2)
    }
}
