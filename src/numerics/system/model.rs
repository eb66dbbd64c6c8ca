//! Constants of the coupled system.

use std::sync::Arc;

use crate::hammer::{HammerModel, body};
use crate::system::dissipation::Damping;
use crate::system::elements::Elements;
use crate::system::impulse_response::Condensation;
use crate::system::layout::Layout;
use crate::system::modal::{Modes, TiedGuides};

/// One hammer within the coupled system.
#[derive(Debug, Clone)]
pub struct HammerSlot {
    /// Its name.
    pub name: String,
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
    /// Body index of its heave; its rotations follow.
    pub heave: usize,
    /// Components of the state that are its velocities.
    pub velocities: Vec<usize>,
    /// Points whose velocity is watched: those that are struck, those that are held, the measuring point if one is chosen; of
    /// a casting that does not rotate, all of whose points move alike, the first and the measuring point.
    pub points: Vec<CastingPoint>,
}

/// A point of a casting.
#[derive(Debug, Clone, PartialEq)]
pub struct CastingPoint {
    /// `hammer.NAME` for a strike point, `fixture.NAME`, or [`MEASURING_POINT`].
    pub name: String,
    /// Its motion as (body, coefficient) pairs.
    pub row: Vec<(usize, f64)>,
}

/// Name of a casting's measuring point among its points.
pub const MEASURING_POINT: &str = "measuring_point";

/// Two sums of components of the state, each with its coefficient.
pub(super) type Sums = [Vec<(usize, f64)>; 2];

/// The coupled system: constant while it is integrated.
#[derive(Debug, Clone)]
pub struct CoupledModel {
    pub(super) layout: Layout,
    pub(super) modes: Arc<Modes>,
    /// The modes condensed to the interface points; `None` if they are integrated.
    pub(super) condensation: Option<Arc<Condensation>>,
    /// What these dissipate follows from; `None` if modes are integrated.
    pub(super) damping: Option<Arc<Damping>>,
    pub(super) elements: Elements,
    pub(super) hammers: Vec<HammerSlot>,
    pub(super) castings: Vec<CastingSlot>,
    /// Mass or inertia of each body.
    pub(super) body_mass: Vec<f64>,
    pub(super) tied: Option<TiedGuides>,
    pub(super) scales: Vec<f64>,
    /// Components of the state that each contact's guard depends on.
    pub(super) supports: Vec<Vec<usize>>,
    /// Penetration (its offset not subtracted) and rate of each contact as sums of components; `None` where a point of the structure
    /// takes part.
    pub(super) sums: Vec<Option<Sums>>,
    pub(super) ambient_pressure_pa: f64,
    pub(super) gas_constant_j_per_kg_k: f64,
    pub(super) initial: Vec<f64>,
}

/// Share of the strongest mode's answer to an impulse on a mount from which on a mode counts as moving it.
const LEAST_ANSWER: f64 = 0.01;

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

    /// Specific gas constant in J/(kg K).
    pub fn gas_constant_j_per_kg_k(&self) -> f64 {
        self.gas_constant_j_per_kg_k
    }

    /// Rate at which the energy of the slowest mode decays that moves a hammer's mount, 1/s; infinite without modes.
    ///
    /// A mode counts if it answers an impulse on the mount with at least a share (`LEAST_ANSWER`) of the velocity of the strongest mode.
    pub fn decay_per_s(&self, hammer: usize) -> f64 {
        let shapes = self.modes.phi.column(self.hammers[hammer].mount);
        let strongest = shapes.iter().fold(0.0_f64, |strongest, phi| strongest.max(phi * phi));
        let modes = shapes.iter().zip(&self.modes.damping);
        modes
            .filter(|(phi, _)| *phi * *phi >= LEAST_ANSWER * strongest)
            .map(|(_, damping)| *damping)
            .fold(f64::INFINITY, f64::min)
    }

    /// State at rest, quadratures zero.
    pub fn initial_state(&self) -> &[f64] {
        &self.initial
    }

    /// Kinetic energy of a casting, J.
    pub fn casting_energy(&self, casting: usize, y: &[f64]) -> f64 {
        self.casting_energy_by(casting, |velocity| y[velocity])
    }

    /// The same with the casting's velocities given by their component of the state: of bounds, a bound.
    pub fn casting_energy_by(&self, casting: usize, velocity: impl Fn(usize) -> f64) -> f64 {
        let slot = &self.castings[casting];
        let masses = &self.body_mass[slot.heave..];
        let squares = slot.velocities.iter().map(|component| velocity(*component).powi(2));
        squares.zip(masses).fold(0.0, |sum, (square, mass)| sum + 0.5 * mass * square)
    }

    /// Kinetic energy of cylinder, spool, piston and chisel of a hammer in J: the impact energy of a blow at its start.
    pub fn impact_energy(&self, hammer: usize, y: &[f64]) -> f64 {
        let slot = &self.hammers[hammer];
        let bodies = (body::CYLINDER..body::COUNT).map(|i| (slot.model.mass()[i], slot.points[i]));
        bodies.map(|(mass, point)| 0.5 * mass * y[self.layout.velocity(point)].powi(2)).sum()
    }
}
