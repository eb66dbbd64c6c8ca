//! Motion of points and elements, forces and energies at a state.

use crate::hammer::{HammerState, body};
use crate::scene::{Owner, PartId, PointId};
use crate::system::block::Block;
use crate::system::coupled::Coupled;
use crate::system::elements::{Contact, ElementId, OwnResidual, Series};

impl Coupled {
    /// Displacement and velocity of a point at time `t`.
    pub fn motion(&self, point: PointId, t: f64, y: &[f64]) -> (f64, f64) {
        match self.model.watched(point) {
            Some((place, at)) => self.watched_motion(place, at, t, y),
            None => self.sum(self.model.points.row(point).iter().copied(), t, y),
        }
    }

    /// Displacement and velocity of watched point `at` of part number `place`.
    fn watched_motion(&self, place: usize, at: usize, t: f64, y: &[f64]) -> (f64, f64) {
        let part = &self.model.parts[place];
        let Some(watched) = &part.watched else { return (0.0, 0.0) };
        let shape = watched.shapes.column(at);
        let (mut displacement, mut velocity) = (0.0, 0.0);
        self.blocks[place].each_mode(part.states_of(t, y), |mode, [x, v]| {
            displacement += shape[mode] * x;
            velocity += shape[mode] * v;
        });
        (displacement, velocity)
    }

    /// Displacement and velocity of each watched point of the machine, in order.
    pub fn watched(&self, t: f64, y: &[f64], out: &mut [[f64; 2]]) {
        out.fill([0.0; 2]);
        let parts = self.model.parts.iter().zip(&self.blocks);
        for (part, block) in parts.filter(|(part, _)| part.id == PartId::Machine) {
            let Some(watched) = &part.watched else { continue };
            block.each_mode(part.states_of(t, y), |mode, [x, v]| {
                for ([displacement, velocity], shape) in out.iter_mut().zip(watched.shapes.row(mode).iter()) {
                    *displacement += shape * x;
                    *velocity += shape * v;
                }
            });
        }
    }

    /// Displacement and velocity of a column of the elements' rows.
    pub(super) fn column_motion(&self, column: usize, t: f64, y: &[f64]) -> [f64; 2] {
        let layout = &self.model.layout;
        if column < layout.bodies {
            return [y[layout.position(column)], y[layout.velocity(column)]];
        }
        let parts = self.model.parts.iter().zip(&self.blocks);
        let mut found = parts.filter(|(part, _)| part.columns.contains(&column));
        found.next().map_or([0.0; 2], |(part, block)| block.motion(part.states_of(t, y), column - part.columns.start))
    }

    /// Displacement and velocity along a row.
    fn sum(&self, row: impl Iterator<Item = (usize, f64)>, t: f64, y: &[f64]) -> (f64, f64) {
        let (mut d, mut rate) = (0.0, 0.0);
        for (column, c) in row {
            let [position, velocity] = self.column_motion(column, t, y);
            d += c * position;
            rate += c * velocity;
        }
        (d, rate)
    }

    /// Relative displacement and velocity along an element's row, offset not subtracted.
    pub fn relative_motion(&self, row: usize, t: f64, y: &[f64]) -> (f64, f64) {
        self.sum(self.model.elements.row(row), t, y)
    }

    /// Penetration and its rate of a contact.
    pub fn penetration(&self, contact: usize, t: f64, y: &[f64]) -> (f64, f64) {
        let elements = &self.model.elements;
        let (d, rate) = self.relative_motion(elements.contact_row(contact), t, y);
        (d - elements.contacts()[contact].offset_m, rate)
    }

    /// Force of a contact at a state in N, its force at rest included; 0 while it is open.
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
            [position[i], velocity[i]] = self.column_motion(point, t, y);
        }
        let mut pressure = [0.0; 4];
        pressure.copy_from_slice(&y[layout.pressures(hammer)]);
        HammerState { position, velocity, pressure, supply_pa: self.model.ambient_pressure_pa, gate_open: false }
    }

    /// Energy stored at a state in J: kinetic, modal strain, springs, return springs, and the closed contacts.
    pub fn stored_energy(&self, t: f64, y: &[f64]) -> f64 {
        let model = &self.model;
        let layout = &model.layout;
        let parts = || model.parts.iter().zip(&self.blocks);
        let mut energy = parts().fold(0.0, |sum, (part, block)| block.add_energy(sum, part.states_of(t, y)));
        for (part, block) in parts() {
            let masses = part.tied.iter().flat_map(|tied| tied.mass.iter().enumerate());
            for (point, mass) in masses {
                let [_, v] = block.motion(part.states_of(t, y), point);
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

    /// Strain energy of a part at a state beyond rest, J: `sum omega^2 x^2 / 2` over its modes, and `F' R F / 2` of its residual
    /// flexibility under the forces of its links; 0 for a rigid part. `forces` is scratch memory, a number per element.
    pub fn strain_energy(&self, part: PartId, (t, y): (f64, &[f64]), forces: &mut [f64]) -> f64 {
        let mut parts = self.model.parts.iter().zip(&self.blocks);
        let Some((part, block)) = parts.find(|(known, _)| known.id == part) else { return 0.0 };
        let Some(modes) = block.modes() else { return 0.0 };
        let mut energy = 0.0;
        block.each_mode(part.states_of(t, y), |mode, [x, _]| energy += 0.5 * modes.omega_squared[mode] * x * x);
        let own = self.model.elements.series().and_then(|series| series.own.get(&part.columns.start));
        let Some(OwnResidual { elements, flexibility }) = own else { return energy };
        for (force, element) in forces.iter_mut().zip(elements) {
            *force = self.element_force(*element, t, y);
        }
        for (column, force) in flexibility.column_iter().zip(&*forces) {
            let motion = column.iter().zip(&*forces).fold(0.0, |sum, (flexibility, other)| sum + flexibility * other);
            energy += 0.5 * motion * force;
        }
        energy
    }

    /// Rate of the strain energy of a part's modes, W: `sum omega^2 x x'`.
    pub fn strain_power(&self, part: PartId, (t, y): (f64, &[f64])) -> f64 {
        let mut power = 0.0;
        let parts = self.model.parts.iter().zip(&self.blocks);
        for (part, block) in parts.filter(|(known, _)| known.id == part) {
            let Some(modes) = block.modes() else { continue };
            block.each_mode(part.states_of(t, y), |mode, [x, v]| power += modes.omega_squared[mode] * x * v);
        }
        power
    }

    /// Energy stored in the springs of a casting's fixtures at a state, J.
    pub fn fixture_energy(&self, casting: usize, t: f64, y: &[f64]) -> f64 {
        let holds = |owner: Owner| matches!(owner, Owner::Fixture(fixture) if fixture.casting == casting);
        let elements = self.model.elements.owned(holds);
        elements.fold(0.0, |sum, element| sum + self.element_energy(element, t, y))
    }

    /// Force of an element at a state beyond that at rest, N.
    pub fn element_force(&self, element: ElementId, t: f64, y: &[f64]) -> f64 {
        match element {
            ElementId::Contact(contact) => {
                self.contact_force(contact, t, y) - self.model.elements.contacts()[contact].rest_force_n
            }
            ElementId::Spring(row) => {
                let (d, rate) = self.relative_motion(row, t, y);
                let spring = &self.model.elements.springs()[row];
                let Some(Series { stiffness, damping, contacts, .. }) = self.model.elements.series() else {
                    return spring.stiffness_n_per_m * d + spring.damping_n_s_per_m * rate;
                };
                let of_springs = (0..stiffness.ncols()).map(|other| {
                    let (d, rate) = self.relative_motion(other, t, y);
                    stiffness[(row, other)] * d + damping[(row, other)] * rate
                });
                let of_contacts = (0..contacts.ncols()).filter(|contact| contacts[(row, *contact)] != 0.0);
                let of_contacts = of_contacts
                    .map(|contact| contacts[(row, contact)] * self.element_force(ElementId::Contact(contact), t, y));
                of_springs.sum::<f64>() - of_contacts.sum::<f64>()
            }
        }
    }

    fn element_energy(&self, element: ElementId, t: f64, y: &[f64]) -> f64 {
        match element {
            ElementId::Contact(contact) => self.contact_energy(contact, t, y),
            ElementId::Spring(row) => self.spring_energy(row, t, y),
        }
    }

    fn spring_energy(&self, row: usize, t: f64, y: &[f64]) -> f64 {
        let (d, _) = self.relative_motion(row, t, y);
        let Some(Series { stiffness, .. }) = self.model.elements.series() else {
            return 0.5 * self.model.elements.springs()[row].stiffness_n_per_m * d * d;
        };
        let force = |other: usize| stiffness[(row, other)] * self.relative_motion(other, t, y).0;
        0.5 * d * (0..stiffness.ncols()).map(force).sum::<f64>()
    }

    /// Energy stored in a contact at a state, J, and in what loads it at rest, both beyond rest; without such a load 0 while it is open.
    pub fn contact_energy(&self, contact: usize, t: f64, y: &[f64]) -> f64 {
        let Contact { law, rest_force_n, .. } = self.model.elements.contacts()[contact];
        let closed = self.discrete.closed[contact];
        if !closed && rest_force_n == 0.0 {
            return 0.0;
        }
        let (d, _) = self.penetration(contact, t, y);
        let stored = if closed { law.stored_energy(d) } else { 0.0 };
        let at_rest = law.static_penetration(rest_force_n, 0.0);
        stored - law.stored_energy(at_rest) - rest_force_n * (d - at_rest)
    }

    /// Energy dissipated up to a state within or at the end of the last step, J, including energy released by opening contacts.
    pub fn dissipated_energy(&self, t: f64, y: &[f64]) -> f64 {
        let model = &self.model;
        let own = y[model.layout.dissipated()] + self.released_energy_j;
        let parts = model.parts.iter().zip(&self.blocks);
        parts.fold(own, |sum, (part, block)| sum + block.dissipated_outside(part.states_of(t, y)))
    }

    /// Energy dissipated up to the end of a run, where its last interval ends too, J.
    pub fn dissipated_to_the_end(&self, y: &[f64]) -> f64 {
        let own = y[self.model.layout.dissipated()] + self.released_energy_j;
        self.blocks.iter().map(Block::dissipated_to_the_end).fold(own, |sum, block| sum + block)
    }
}
