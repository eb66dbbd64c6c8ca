//! Constants of the coupled system, its state of rest and its energies.

use nalgebra::{DMatrix, DVector, DVectorView};

use crate::hammer::{HammerModel, HammerState, body};
use crate::system::elements::Elements;
use crate::system::layout::Layout;

/// One hammer within the coupled system.
#[derive(Debug, Clone)]
pub struct HammerSlot {
    /// Its constants.
    pub model: HammerModel,
    /// Points of its bodies; the guide's is the mount itself where it is tied.
    pub points: [usize; body::COUNT],
    /// Interface point of its mount.
    pub mount: usize,
    /// Its contact with the casting.
    pub strike: usize,
    /// Its contact of piston and chisel.
    pub percussion: usize,
    /// Casting that it strikes.
    pub casting: usize,
    /// Supply pressure after the start, absolute, Pa.
    pub supply_pressure_pa: f64,
    /// Start of the supply, s.
    pub start_time_s: f64,
    /// Delay of the percussion after the first contact, s.
    pub gate_delay_s: f64,
}

/// One casting within the coupled system.
#[derive(Debug, Clone, PartialEq)]
pub struct CastingSlot {
    /// Body index of its heave.
    pub heave: usize,
    /// Velocity of its measuring point as (body, coefficient) pairs; empty where none is chosen.
    pub measuring_point: Vec<(usize, f64)>,
}

/// Guides tied rigidly to their mounts: `(I + sum m phi phi') a = a0` solved by a low-rank update.
#[derive(Debug, Clone)]
pub(super) struct TiedGuides {
    /// Interface point of each guide.
    pub mounts: Vec<usize>,
    /// Mass of each guide, kg.
    pub mass: Vec<f64>,
    /// `(diag(1/m) + Phi' Phi)^-1`.
    pub update: DMatrix<f64>,
}

impl TiedGuides {
    /// Prepares the update for guides of mass `mass` on the columns `mounts` of `phi`.
    pub fn new(phi: &DMatrix<f64>, mounts: Vec<usize>, mass: Vec<f64>) -> Option<Self> {
        let columns = phi.select_columns(&mounts);
        let mut matrix = columns.tr_mul(&columns);
        for (at, mass) in mass.iter().enumerate() {
            matrix[(at, at)] += 1.0 / mass;
        }
        let update = matrix.cholesky()?.inverse();
        Some(Self { mounts, mass, update })
    }
}

/// The coupled system: constant while it is integrated.
#[derive(Debug, Clone)]
pub struct CoupledModel {
    pub(super) layout: Layout,
    pub(super) omega_squared: DVector<f64>,
    /// `2 xi omega` per mode.
    pub(super) modal_damping: DVector<f64>,
    /// Mode shapes at the interface points: modes x points of the structure.
    pub(super) phi: DMatrix<f64>,
    pub(super) elements: Elements,
    pub(super) hammers: Vec<HammerSlot>,
    pub(super) castings: Vec<CastingSlot>,
    /// Mass or inertia of each body.
    pub(super) body_mass: Vec<f64>,
    pub(super) tied: Option<TiedGuides>,
    pub(super) scales: Vec<f64>,
    /// Components of the state that each contact's guard depends on.
    pub(super) supports: Vec<Vec<usize>>,
    pub(super) ambient_pressure_pa: f64,
    pub(super) initial: Vec<f64>,
}

impl CoupledModel {
    /// Offsets of the state vector.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Springs and contacts.
    pub fn elements(&self) -> &Elements {
        &self.elements
    }

    /// The hammers.
    pub fn hammers(&self) -> &[HammerSlot] {
        &self.hammers
    }

    /// The castings.
    pub fn castings(&self) -> &[CastingSlot] {
        &self.castings
    }

    /// State at rest, quadratures zero.
    pub fn initial_state(&self) -> &[f64] {
        &self.initial
    }

    /// Displacement or velocity of a point, from the modal and body parts of the state.
    pub(super) fn point(&self, point: usize, modal: &[f64], bodies: &[f64]) -> f64 {
        match point.checked_sub(self.layout.bodies) {
            None => bodies[point],
            Some(node) => self.phi.column(node).dot(&DVectorView::from_slice(modal, modal.len())),
        }
    }

    /// Relative displacement and velocity along an element's row, offset not subtracted.
    pub fn relative_motion(&self, row: usize, y: &[f64]) -> (f64, f64) {
        let value = |state: &[f64]| -> f64 {
            let (modal, bodies) = state.split_at(self.layout.modes);
            self.elements.row(row).map(|(point, c)| c * self.point(point, modal, bodies)).sum()
        };
        let n = self.layout.mechanical();
        (value(&y[..n]), value(&y[n..2 * n]))
    }

    /// Penetration and its rate of a contact.
    pub fn penetration(&self, contact: usize, y: &[f64]) -> (f64, f64) {
        let (d, rate) = self.relative_motion(self.elements.contact_row(contact), y);
        (d - self.elements.contacts()[contact].offset_m, rate)
    }

    /// Velocity of interface point `node` of the structure.
    pub fn interface_velocity(&self, node: usize, y: &[f64]) -> f64 {
        let n = self.layout.mechanical();
        self.point(self.layout.bodies + node, &y[n..n + self.layout.modes], &[])
    }

    /// One hammer's bodies and chambers at a state; supply and gate are left as at rest.
    pub fn hammer_state(&self, hammer: usize, y: &[f64]) -> HammerState {
        let slot = &self.hammers[hammer];
        let n = self.layout.mechanical();
        let motion = |state: &[f64]| {
            let (modal, bodies) = state.split_at(self.layout.modes);
            slot.points.map(|point| self.point(point, modal, bodies))
        };
        let mut pressure = [0.0; 4];
        pressure.copy_from_slice(&y[self.layout.pressures(hammer)]);
        HammerState {
            position: motion(&y[..n]),
            velocity: motion(&y[n..2 * n]),
            pressure,
            supply_pa: self.ambient_pressure_pa,
            gate_open: false,
        }
    }

    /// Kinetic energy of cylinder, spool, piston and chisel of a hammer in J: the impact energy of a blow at its start.
    pub fn impact_energy(&self, hammer: usize, y: &[f64]) -> f64 {
        let state = self.hammer_state(hammer, y);
        let mass = self.hammers[hammer].model.mass();
        (body::CYLINDER..body::COUNT).map(|i| 0.5 * mass[i] * state.velocity[i] * state.velocity[i]).sum()
    }

    /// Energy stored at a state in J: kinetic, modal strain, springs, return springs, and the contacts in `closed`.
    pub fn stored_energy(&self, y: &[f64], closed: &[bool]) -> f64 {
        let (layout, n) = (&self.layout, self.layout.mechanical());
        let mut energy = 0.0;
        for s in 0..layout.modes {
            energy += 0.5 * (self.omega_squared[s] * y[s] * y[s] + y[n + s] * y[n + s]);
        }
        for (body, mass) in self.body_mass.iter().enumerate() {
            let v = y[layout.velocity(body)];
            energy += 0.5 * mass * v * v;
        }
        if let Some(tied) = &self.tied {
            for (&mount, mass) in tied.mounts.iter().zip(&tied.mass) {
                let v = self.interface_velocity(mount, y);
                energy += 0.5 * mass * v * v;
            }
        }
        for (row, spring) in self.elements.springs().iter().enumerate() {
            let (d, _) = self.relative_motion(row, y);
            energy += 0.5 * spring.stiffness_n_per_m * d * d;
        }
        for hammer in 0..layout.hammers {
            let state = self.hammer_state(hammer, y);
            let extension = state.position[body::CYLINDER] - state.position[body::GUIDE];
            energy += self.hammers[hammer].model.return_spring_energy(extension);
        }
        for (contact, _) in closed.iter().enumerate().filter(|(_, closed)| **closed) {
            let (d, _) = self.penetration(contact, y);
            energy += self.elements.contacts()[contact].law.stored_energy(d);
        }
        energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The low-rank update gives what the full matrix gives: `(I + sum m phi phi')^-1 a`.
    #[test]
    fn analytic_low_rank_update() {
        let phi = DMatrix::from_fn(5, 4, |i, j| ((3 * i + 7 * j) as f64 * 0.37).sin());
        let (mounts, mass) = (vec![0, 2, 3], vec![1.0, 0.3, 40.0]);
        let mut full = DMatrix::identity(5, 5);
        for (&mount, mass) in mounts.iter().zip(&mass) {
            full += *mass * phi.column(mount) * phi.column(mount).transpose();
        }
        let tied = TiedGuides::new(&phi, mounts.clone(), mass).unwrap();
        let load = DVector::from_fn(5, |i, _| 1.0 - 0.7 * i as f64);
        let expected = full.lu().solve(&load).unwrap();
        let columns = phi.select_columns(&mounts);
        let found = &load - &columns * (&tied.update * columns.tr_mul(&load));
        assert!((found - expected).amax() < 1e-13);
        // A mount that no mode moves is still positive definite; a negative mass is not.
        assert!(TiedGuides::new(&DMatrix::zeros(2, 1), vec![0], vec![1.0]).is_some());
        assert!(TiedGuides::new(&DMatrix::zeros(2, 1), vec![0], vec![-1.0]).is_none());
    }
}
