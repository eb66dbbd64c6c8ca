//! Constants of the coupled system.

use nalgebra::{DMatrix, DVector};

use crate::hammer::{HammerModel, body};
use crate::system::condensed::Condensation;
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
    /// Supply pressure while the supply is on, absolute, Pa.
    pub supply_pressure_pa: f64,
    /// Times at which the supply is switched on, off, on, and so on, s.
    pub supply_times_s: Vec<f64>,
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

/// The structure's modes.
#[derive(Debug, Clone)]
pub(super) struct Modes {
    pub omega_squared: DVector<f64>,
    /// `2 xi omega` per mode.
    pub damping: DVector<f64>,
    /// Mode shapes at the interface points: modes x points of the structure.
    pub phi: DMatrix<f64>,
}

/// The coupled system: constant while it is integrated.
#[derive(Debug, Clone)]
pub struct CoupledModel {
    pub(super) layout: Layout,
    pub(super) modes: Modes,
    /// The modes condensed to the interface points; `None` if they are integrated.
    pub(super) condensation: Option<Condensation>,
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

    /// Kinetic energy of cylinder, spool, piston and chisel of a hammer in J: the impact energy of a blow at its start.
    pub fn impact_energy(&self, hammer: usize, y: &[f64]) -> f64 {
        let slot = &self.hammers[hammer];
        let bodies = (body::CYLINDER..body::COUNT).map(|i| (slot.model.mass()[i], slot.points[i]));
        bodies.map(|(mass, point)| 0.5 * mass * y[self.layout.velocity(point)].powi(2)).sum()
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
