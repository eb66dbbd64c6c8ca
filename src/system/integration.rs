//! The coupled system as the integrator sees it.

use crate::hammer::chamber;
use crate::integrate::{GuardSample, Integrals, LinearPart, StiffBlock, StiffMatrices, Switching, System};
use crate::system::coupled::Coupled;
use crate::system::impulse_response;

/// Most bodies for which exponential steps are offered: those of one hammer and what it strikes, and one hammer more.
const STIFF_BODIES: usize = 10;

impl System for Coupled<'_> {
    fn dimension(&self) -> usize {
        self.model.layout.dimension()
    }

    fn scales(&self) -> &[f64] {
        &self.model.scales
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        self.rates(t, y, rate);
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
                        "the chamber at the {} of hammer `{}` is driven to a volume of {volume:.2e} m3 at t = {t:.6} s",
                        chamber::NAMES[i],
                        slot.name
                    );
                }
            }
        }
        format!("the step size fell below the resolution of time at t = {t:.6} s")
    }
}

impl Switching for Coupled<'_> {
    fn guard_count(&self) -> usize {
        self.closed.len()
    }

    fn guard_support(&self, guard: usize) -> &[usize] {
        &self.model.supports[guard]
    }

    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64 {
        let (d, rate) = self.penetration(guard, t, y);
        let law = &self.model.elements.contacts()[guard].law;
        if self.closed[guard] { law.release_indicator(d, rate) } else { law.onset_indicator(d, rate) }
    }

    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        // The motion of all points is at hand from the right-hand side.
        let elements = &self.model.elements;
        for (guard, sample) in samples.iter_mut().enumerate() {
            let (contact, row) = (&elements.contacts()[guard], elements.contact_row(guard));
            let law = &contact.law;
            let [d, speed] = elements.values(row, [&self.displacement, &self.velocity]);
            let d = d - contact.offset_m;
            *sample = if self.closed[guard] {
                let acceleration = self.relative_acceleration(row, t, y, rate);
                let (smooth, smooth_rate) = law.smooth_release(d, speed, acceleration);
                GuardSample { value: law.release_indicator(d, speed), smooth, smooth_rate }
            } else {
                GuardSample { value: law.onset_indicator(d, speed), smooth: d, smooth_rate: speed }
            };
        }
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        let (mut d, _) = self.penetration(guard, t, y);
        if self.following {
            // The state is that before the step in which the bodies met or parted: apart, they store nothing.
            d = d.max(0.0);
        }
        let stored = self.model.elements.contacts()[guard].law.stored_energy(d);
        self.closed[guard] = !self.closed[guard];
        self.list_acting();
        if self.closed[guard] {
            self.released_energy_j -= stored;
            self.refresh_gate(guard, t);
        } else {
            self.released_energy_j += stored;
        }
    }

    fn next_stop(&self) -> f64 {
        self.pending().map_or(f64::INFINITY, |(t, ..)| t)
    }

    fn pass_stop(&mut self) {
        match self.pending() {
            Some((time, hammer, true)) => self.switch_supply(hammer, time),
            Some((_, hammer, false)) => self.gate_open[hammer] = true,
            None => {}
        }
    }

    fn follow_state(&mut self, follow: bool) -> bool {
        self.following = follow;
        self.list_acting();
        follow
    }

    fn horizon(&self) -> f64 {
        match (&self.base, &self.model.condensation) {
            (Some(base), Some(condensation)) => base.time_s + condensation.horizon_s,
            _ => f64::INFINITY,
        }
    }

    fn rebase(&mut self, t: f64, y: &mut [f64], rate: &mut [f64]) {
        let layout = &self.model.layout;
        if let (Some(base), Some(condensation)) = (&mut self.base, &self.model.condensation) {
            let (z, rate) = (&mut y[layout.structure_displacements()], &mut rate[layout.structure_displacements()]);
            base.rebase(condensation, t, z);
            z.fill(0.0);
            // The rates of the first integrals are the forces: they stay.
            rate[self.acceleration.len()..].fill(0.0);
        }
    }
}

impl LinearPart for Coupled<'_> {
    fn stiff_block(&self) -> Option<StiffBlock> {
        let model = self.model;
        let (layout, contacts) = (&model.layout, model.elements.contacts());
        let linear = contacts.iter().all(|contact| contact.law.linear().is_some());
        // A guide on its spring is joined to the structure as stiffly as bodies are among each other: its step stays short.
        // Integrated modes would not feel the impulses that the bodies do.
        let integrals = match (&model.condensation, model.modes.phi.is_empty()) {
            (Some(_), _) => Integrals { from: 0, width: model.modes.phi.ncols(), depth: impulse_response::ORDER },
            (None, true) => Integrals { from: 0, width: 0, depth: 0 },
            (None, false) => return None,
        };
        let few = layout.bodies <= STIFF_BODIES && contacts.len() <= u64::BITS as usize;
        (linear && few && model.tied.is_some()).then_some(StiffBlock {
            positions: layout.position(0),
            velocities: layout.velocity(0),
            bodies: layout.bodies,
            integrals,
            relaxing: layout.pressures(0).start..layout.states(),
        })
    }

    fn discrete_state(&self) -> u64 {
        self.closed.iter().rev().fold(0, |bits, closed| bits << 1 | u64::from(*closed))
    }

    fn stiff_matrices(&mut self, matrices: &mut StiffMatrices) {
        let StiffMatrices { stiffness, damping, integrated_stiffness, integrated_damping } = matrices;
        for matrix in [&mut *stiffness, damping, integrated_stiffness, integrated_damping] {
            matrix.fill(0.0);
        }
        let model = self.model;
        let (elements, count) = (&model.elements, model.layout.bodies);
        let springs = elements.springs().iter().map(|spring| [spring.stiffness_n_per_m, spring.damping_n_s_per_m]);
        let closed = elements.contacts().iter().enumerate().filter(|(contact, _)| self.closed[*contact]);
        let contacts = closed.filter_map(|(at, contact)| Some((elements.contact_row(at), contact.law.linear()?)));
        for (row, [k, c]) in springs.enumerate().chain(contacts) {
            for (j, at_j) in elements.row(row).filter(|(point, _)| *point < count) {
                for (i, at_i) in elements.row(row) {
                    if i < count {
                        let share = at_i * at_j / model.body_mass[i];
                        stiffness[(i, j)] += k * share;
                        damping[(i, j)] += c * share;
                    } else if !integrated_stiffness.is_empty() {
                        integrated_stiffness[(i - count, j)] -= k * at_i * at_j;
                        integrated_damping[(i - count, j)] -= c * at_i * at_j;
                    }
                }
            }
        }
        if let (Some(condensation), Some(tied)) = (&model.condensation, &model.tied) {
            for matrix in [integrated_stiffness, integrated_damping] {
                for force in matrix.as_mut_slice().chunks_exact_mut(condensation.points()) {
                    self.acceleration.fill(0.0);
                    tied.share(force, &mut self.acceleration);
                }
            }
        }
    }

    fn relaxation(&self, t: f64, y: &[f64], lambda: &mut [f64]) {
        for (h, lambda) in lambda.chunks_exact_mut(chamber::COUNT).enumerate() {
            let state = self.hammer_state(h, t, y);
            lambda.copy_from_slice(&self.model.hammers[h].model.relaxation(&state));
        }
    }
}
