//! Modes of a flexible part, condensed to its points. The block carries the modes outside the state.

use std::sync::Arc;

use crate::integrate::Taken;
use crate::system::dissipation::{Damping, Dissipation};
use crate::system::force_integrals::ForceIntegrals;
use crate::system::impulse_response::Condensation;
use crate::system::modal::Modes;
use crate::system::modal_state::{ModalState, Since};

/// Constants of condensed modes for runs of one duration.
#[derive(Debug, Clone)]
pub(in crate::system) struct CondensedConstants {
    pub modes: Arc<Modes>,
    pub condensation: Arc<Condensation>,
    /// Constants of the dissipated energy.
    pub damping: Arc<Damping>,
}

/// Condensed modes of a row.
#[derive(Debug, Clone)]
pub(in crate::system) struct Condensed {
    pub constants: CondensedConstants,
    /// The modes at their last rebase.
    pub base: ModalState,
    /// Energy dissipated so far.
    pub dissipation: Dissipation,
    moments: ForceIntegrals<f64>,
}

impl Condensed {
    /// Modes at rest; `first` is the component of the state that is the first integral of their first point's force.
    pub fn at_rest(constants: CondensedConstants, first: usize) -> Self {
        let mut moments = ForceIntegrals::new(constants.condensation.points(), first);
        moments.begin(0, &constants.damping);
        Self {
            base: ModalState::at_rest(&constants.condensation),
            dissipation: Dissipation::at_rest(&constants.damping),
            moments,
            constants,
        }
    }

    /// Displacement and velocity of point `n` at time `t`; `z` are the integrals.
    pub fn motion(&self, t: f64, z: &[f64], n: usize) -> [f64; 2] {
        let since = Since { tau: t - self.base.time_s, z };
        let [w, v, _] = self.base.point(&self.constants.condensation, since, n);
        [w, v]
    }

    /// Shows displacement and velocity of each mode at time `t` by its number.
    pub fn each_mode(&self, t: f64, z: &[f64], see: &mut dyn FnMut(usize, [f64; 2])) {
        self.base.each_mode(&self.constants.condensation, Since { tau: t - self.base.time_s, z }, see);
    }

    /// Strain and kinetic energy at time `t`, J.
    pub fn energy(&self, t: f64, z: &[f64]) -> f64 {
        self.base.energy(&self.constants.condensation, t, z)
    }

    /// Energy dissipated up to a time within or at the end of the last step, J.
    pub fn dissipated(&self, t: f64, z: &[f64]) -> f64 {
        let power_w = self.base.dissipation_w(&self.constants.condensation, t, z);
        self.dissipation.up_to_j(&self.constants.damping, t, power_w)
    }

    /// Time of the next rebase at the latest, s.
    pub fn horizon_s(&self) -> f64 {
        self.base.time_s + self.constants.condensation.horizon_s
    }

    /// Rebases at time `t`: the integrals begin again at zero. The rates of the first of them are the forces: they stay.
    pub fn rebase(&mut self, t: f64, z: &mut [f64], rate: &mut [f64]) {
        self.base.rebase(&self.constants.condensation, t, z);
        z.fill(0.0);
        rate[self.constants.condensation.points()..].fill(0.0);
    }

    /// Follows an accepted step.
    pub fn stepped(&mut self, taken: &Taken<'_>) {
        let Self { constants, dissipation, moments, .. } = self;
        moments.follow(taken, |_, own| advance(dissipation, &constants.damping, own));
    }

    /// Advances the dissipated energy to its next node, see [`ForceIntegrals::follow`]. Returns the time of the node after it, s.
    pub fn at_node(&mut self, moments: &[f64]) -> f64 {
        advance(&mut self.dissipation, &self.constants.damping, moments)
    }
}

/// Advances the dissipated energy to its next node. Returns the time of the node after it, s.
fn advance(dissipation: &mut Dissipation, damping: &Damping, moments: &[f64]) -> f64 {
    dissipation.advance(damping, moments);
    dissipation.next_s(damping)
}
