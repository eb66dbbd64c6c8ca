//! Motion of points and elements, forces and energies at a state.

use crate::hammer::{HammerState, body};
use crate::system::base::Since;
use crate::system::coupled::Coupled;
use crate::system::dissipation::Dissipation;

impl Coupled {
    /// Displacement and velocity of interface point `node` of the structure at time `t`.
    pub fn interface_motion(&self, node: usize, t: f64, y: &[f64]) -> (f64, f64) {
        let model = &self.model;
        match (&self.base, &model.condensation) {
            (Some(base), Some(condensation)) => {
                let [w, v, _] = base.point(
                    condensation,
                    Since { tau: t - base.time_s, z: &y[model.layout.structure_displacements()] },
                    node,
                );
                (w, v)
            }
            _ => {
                let layout = &model.layout;
                let at = |modal: &[f64]| model.modes.at(node, modal);
                (at(&y[layout.structure_displacements()]), at(&y[layout.structure_velocities()]))
            }
        }
    }

    /// Relative displacement and velocity along an element's row, offset not subtracted.
    pub fn relative_motion(&self, row: usize, t: f64, y: &[f64]) -> (f64, f64) {
        let layout = &self.model.layout;
        let (mut d, mut rate) = (0.0, 0.0);
        for (point, c) in self.model.elements.row(row) {
            let (position, velocity) = match point.checked_sub(layout.bodies) {
                None => (y[layout.position(point)], y[layout.velocity(point)]),
                Some(node) => self.interface_motion(node, t, y),
            };
            d += c * position;
            rate += c * velocity;
        }
        (d, rate)
    }

    /// Penetration and its rate of a contact.
    pub fn penetration(&self, contact: usize, t: f64, y: &[f64]) -> (f64, f64) {
        let elements = &self.model.elements;
        let (d, rate) = self.relative_motion(elements.contact_row(contact), t, y);
        (d - elements.contacts()[contact].offset_m, rate)
    }

    /// Force of a contact at a state in N; 0 while it is open.
    pub fn contact_force(&self, contact: usize, t: f64, y: &[f64]) -> f64 {
        if !self.discrete.closed[contact] {
            return 0.0;
        }
        let (d, rate) = self.penetration(contact, t, y);
        self.model.elements.contacts()[contact].law.closed_force(d, rate)
    }

    /// One hammer's bodies and chambers at a state; supply and gate are left as at rest.
    pub fn hammer_state(&self, hammer: usize, t: f64, y: &[f64]) -> HammerState {
        let (slot, layout) = (&self.model.hammers[hammer], &self.model.layout);
        let (mut position, mut velocity) = ([0.0; body::COUNT], [0.0; body::COUNT]);
        for (i, &point) in slot.points.iter().enumerate() {
            (position[i], velocity[i]) = match point.checked_sub(layout.bodies) {
                None => (y[layout.position(point)], y[layout.velocity(point)]),
                Some(node) => self.interface_motion(node, t, y),
            };
        }
        let mut pressure = [0.0; 4];
        pressure.copy_from_slice(&y[layout.pressures(hammer)]);
        HammerState { position, velocity, pressure, supply_pa: self.model.ambient_pressure_pa, gate_open: false }
    }

    /// Energy stored at a state in J: kinetic, modal strain, springs, return springs, and the closed contacts.
    pub fn stored_energy(&self, t: f64, y: &[f64]) -> f64 {
        let model = &self.model;
        let layout = &model.layout;
        let mut energy = self.modal_energy(t, y);
        for (body, mass) in model.body_mass.iter().enumerate() {
            let v = y[layout.velocity(body)];
            energy += 0.5 * mass * v * v;
        }
        if let Some(tied) = &model.tied {
            for (mount, mass) in tied.mass.iter().enumerate() {
                let (_, v) = self.interface_motion(mount, t, y);
                energy += 0.5 * mass * v * v;
            }
        }
        for row in 0..model.elements.springs().len() {
            energy += self.spring_energy(row, t, y);
        }
        for hammer in 0..layout.hammers {
            let state = self.hammer_state(hammer, t, y);
            let extension = state.position[body::CYLINDER] - state.position[body::GUIDE];
            energy += model.hammers[hammer].model.return_spring_energy(extension);
        }
        for contact in 0..self.discrete.closed.len() {
            energy += self.contact_energy(contact, t, y);
        }
        energy
    }

    /// Energy stored in the springs of a casting's fixtures at a state, J.
    pub fn fixture_energy(&self, casting: usize, t: f64, y: &[f64]) -> f64 {
        let springs = self.model.elements.springs().iter().enumerate();
        let held = springs.filter(|(_, spring)| spring.casting == Some(casting));
        held.fold(0.0, |sum, (row, _)| sum + self.spring_energy(row, t, y))
    }

    fn spring_energy(&self, row: usize, t: f64, y: &[f64]) -> f64 {
        let (d, _) = self.relative_motion(row, t, y);
        0.5 * self.model.elements.springs()[row].stiffness_n_per_m * d * d
    }

    /// Energy stored in a contact at a state, J; 0 while it is open.
    pub fn contact_energy(&self, contact: usize, t: f64, y: &[f64]) -> f64 {
        if !self.discrete.closed[contact] {
            return 0.0;
        }
        let (d, _) = self.penetration(contact, t, y);
        self.model.elements.contacts()[contact].law.stored_energy(d)
    }

    fn modal_energy(&self, t: f64, y: &[f64]) -> f64 {
        let model = &self.model;
        match (&self.base, &model.condensation) {
            (Some(base), Some(condensation)) => {
                base.energy(condensation, t, &y[model.layout.structure_displacements()])
            }
            _ => {
                let (x, v) = (&y[model.layout.structure_displacements()], &y[model.layout.structure_velocities()]);
                let squares = model.modes.omega_squared.iter().zip(x).zip(v);
                squares.map(|((omega_squared, x), v)| 0.5 * (omega_squared * x * x + v * v)).sum()
            }
        }
    }

    /// Energy dissipated up to a state within or at the end of the last step, J, what opening contacts released included.
    pub fn dissipated_energy(&self, t: f64, y: &[f64]) -> f64 {
        let model = &self.model;
        let own = y[model.layout.dissipated()] + self.released_energy_j;
        let condensed = (&self.base, &model.condensation, &self.dissipation, &model.damping);
        let (Some(base), Some(condensation), Some(dissipation), Some(damping)) = condensed else { return own };
        let power_w = base.dissipation_w(condensation, t, &y[model.layout.structure_displacements()]);
        own + dissipation.up_to_j(damping, t, power_w)
    }

    /// Energy dissipated up to the end of a run, where its last interval ends too, J.
    pub fn dissipated_to_the_end(&self, y: &[f64]) -> f64 {
        let condensed = self.dissipation.as_ref().map_or(0.0, Dissipation::whole_j);
        y[self.model.layout.dissipated()] + self.released_energy_j + condensed
    }
}
