//! Contacts of a chisel with its casting: their number, the deepest penetration, the largest force at touch.

use super::instant::Instant;
use super::peak::{Probe, peak, reach, terms};
use super::warning::Warning;
use crate::integrate::{Step, Switching};
use crate::scene::{DEEP_SHARE, JUMP_RATIO};
use crate::system::Coupled;

/// Contacts of one hammer's chisel with its casting.
pub(super) struct ContactTrack {
    /// Index of the contact in the system.
    strike: usize,
    /// Least time in s between two contacts.
    separation_s: f64,
    /// Free travel of the chisel in m, with which penetrations are compared.
    travel_m: f64,
    released_s: f64,
    pub count: u64,
    pub largest_penetration_m: f64,
    pub largest_jump_force_n: f64,
}

impl ContactTrack {
    pub fn new(strike: usize, separation_s: f64, travel_m: f64) -> Self {
        Self {
            strike,
            separation_s,
            travel_m,
            released_s: f64::NEG_INFINITY,
            count: 0,
            largest_penetration_m: 0.0,
            largest_jump_force_n: 0.0,
        }
    }

    /// The force becomes positive.
    pub fn begins(&mut self, system: &Coupled, Instant { t, y }: Instant<'_>) {
        self.count += u64::from(t - self.released_s >= self.separation_s);
        let (_, rate) = system.penetration(self.strike, t, y);
        let law = &system.model().elements().contacts()[self.strike].law;
        self.largest_jump_force_n = self.largest_jump_force_n.max(law.jump(rate));
    }

    /// The force becomes zero.
    pub fn ends(&mut self, t: f64) {
        self.released_s = t;
    }

    /// Follows a step.
    pub fn step(&mut self, system: &Coupled, step: &Step<'_>, scratch: &mut [f64]) {
        if !system.is_closed(self.strike) {
            return;
        }
        let model = system.model();
        let offset_m = model.elements().contacts()[self.strike].offset_m;
        let bound = model.contact_sums(self.strike).map(|[penetration, _]| reach(step, terms(penetration), offset_m));
        if bound.is_none_or(|bound| bound > self.largest_penetration_m) {
            let support = system.guard_support(self.strike);
            let depth = |t: f64, y: &[f64]| system.penetration(self.strike, t, y).0.max(0.0);
            let (depth_m, _) = peak(step, step.theta_end, Probe { support, scratch }, depth);
            self.largest_penetration_m = self.largest_penetration_m.max(depth_m);
        }
    }

    /// Reasons to doubt the run.
    pub fn warnings(&self, system: &Coupled) -> impl Iterator<Item = Warning> {
        let law = &system.model().elements().contacts()[self.strike].law;
        let elastic_n = law.closed_force(self.largest_penetration_m, 0.0);
        let deep = self.largest_penetration_m > DEEP_SHARE * self.travel_m;
        let jumps = self.largest_jump_force_n > JUMP_RATIO * elastic_n;
        [(deep, Warning::DeepContact), (jumps, Warning::DamperJump)]
            .into_iter()
            .filter_map(|(is, one)| is.then_some(one))
    }
}
