//! The coupled system as a system for the integrator.

use std::ops::Range;

use crate::hammer::chamber;
use crate::integrate::{GuardSample, Rebasing, Switching, System, Taken};
use crate::system::block::Block;
use crate::system::coupled::Coupled;
use crate::system::impulse_response::SCALED_INTEGRALS;

impl System for Coupled {
    fn dimension(&self) -> usize {
        self.model.layout.dimension()
    }

    fn scales(&self) -> &[f64] {
        &self.model.scales
    }

    fn without_scale(&self) -> Range<usize> {
        // Of several condensed blocks one is passed over; what the others add is zero.
        let condensed = self.model.parts.iter().find(|part| part.block.condensed().is_some());
        condensed.map_or(0..0, |part| {
            let states = &part.states[0];
            states.start + SCALED_INTEGRALS * part.columns.len()..states.end
        })
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        self.rates.evaluate(t, y, rate);
    }

    fn diagnose(&self, t: f64, y: &[f64]) -> String {
        if y.iter().any(|value| !value.is_finite()) {
            return format!("the state is no longer finite at t = {t:.6} s");
        }
        for (h, slot) in self.model.hammers.iter().enumerate() {
            let state = self.hammer_state(h, t, y);
            for (i, volume) in slot.model.volumes(&state.position).into_iter().enumerate() {
                if volume < 1e-9 {
                    return format!(
                        "the chamber at the {} of hammer `{}` is driven to a volume of {volume:.2e} m3 at t = {t:.6} s: nothing holds it there; a larger {} would",
                        chamber::NAMES[i],
                        slot.name,
                        chamber::KEPT_BY[i]
                    );
                }
            }
        }
        format!("the step size fell below the resolution of time at t = {t:.6} s")
    }
}

impl Switching for Coupled {
    fn guard_count(&self) -> usize {
        self.discrete.closed.len()
    }

    fn guard_support(&self, guard: usize) -> &[usize] {
        &self.model.supports[guard]
    }

    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64 {
        let (d, rate) = self.penetration(guard, t, y);
        self.indicator(guard, d, rate)
    }

    fn guard_sums(&self, guard: usize) -> Option<&[Vec<(usize, f64)>; 2]> {
        self.model.sums[guard].as_ref()
    }

    fn guard_of(&self, guard: usize, [d, rate]: [f64; 2]) -> f64 {
        let contact = &self.model.elements.contacts()[guard];
        self.indicator(guard, d - contact.offset_m, rate)
    }

    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        self.rates.sample(t, y, rate, samples);
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        let (mut d, _) = self.penetration(guard, t, y);
        if self.following {
            // The state is that before the step in which the bodies met or parted: apart, they store nothing.
            d = d.max(0.0);
        }
        let stored = self.model.elements.contacts()[guard].law.stored_energy(d);
        self.discrete.closed[guard] = !self.discrete.closed[guard];
        if self.discrete.closed[guard] {
            self.released_energy_j -= stored;
            self.refresh_gate(guard, t);
        } else {
            self.released_energy_j += stored;
        }
        self.rates.put_discrete(0, &self.model, &self.discrete);
    }

    fn next_stop(&self) -> f64 {
        self.pending().map_or(f64::INFINITY, |(t, ..)| t)
    }

    fn pass_stop(&mut self) {
        match self.pending() {
            Some((time, hammer, true)) => self.switch_supply(hammer, time),
            Some((_, hammer, false)) => self.discrete.gate_open[hammer] = true,
            None => {}
        }
        self.rates.put_discrete(0, &self.model, &self.discrete);
    }

    fn follow_state(&mut self, follow: bool) -> bool {
        self.following = follow;
        self.rates.follow(follow);
        follow
    }
}

impl Rebasing for Coupled {
    fn horizon(&self) -> f64 {
        self.blocks.iter().map(Block::horizon_s).fold(f64::INFINITY, f64::min)
    }

    fn rebased_components(&self) -> Range<usize> {
        self.model.layout.flexible_displacements()
    }

    fn rebase(&mut self, t: f64, y: &mut [f64], rate: &mut [f64]) {
        for (part, block) in self.model.parts.iter().zip(&mut self.blocks) {
            if let Some(condensed) = block.condensed_mut() {
                let states = &part.states[0];
                condensed.rebase(t, &mut y[states.clone()], &mut rate[states.clone()]);
            }
        }
        self.rates.put_outside(0, &self.blocks);
    }

    fn stepped(&mut self, taken: &Taken<'_>) {
        self.blocks.iter_mut().filter_map(Block::condensed_mut).for_each(|condensed| condensed.stepped(taken));
    }
}

impl Coupled {
    /// Positive when a contact must switch.
    fn indicator(&self, contact: usize, penetration_m: f64, rate_m_s: f64) -> f64 {
        let law = &self.model.elements.contacts()[contact].law;
        if self.discrete.closed[contact] {
            law.release_indicator(penetration_m, rate_m_s)
        } else {
            law.onset_indicator(penetration_m, rate_m_s)
        }
    }
}
