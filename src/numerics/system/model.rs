//! Constants of the coupled system.

use crate::hammer::{HammerModel, body};
use crate::system::block::{Block, Part};
use crate::system::elements::{Contact, ContactKind, Elements, Spring};
use crate::system::layout::Layout;
use crate::system::points::{Owner, PartId, PointId, Points, Row};

/// One hammer within the coupled system.
#[derive(Debug, Clone)]
pub struct HammerSlot {
    /// Its name.
    pub name: String,
    /// Its constants.
    pub model: HammerModel,
    /// Columns of its bodies; a tied guide has the column of its mount.
    pub points: [usize; body::COUNT],
    /// Column of its mount.
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
    /// Column of its heave; its rotations follow.
    pub heave: usize,
    /// Columns of its rotations about x and y; `None` where the scene does not need one.
    pub rotations: [Option<usize>; 2],
    /// Components of the state that are its velocities.
    pub velocities: Vec<usize>,
    /// Points whose velocity is watched: those that are struck, those that are held, the measuring point if one is chosen; of
    /// a casting that does not rotate, all of whose points move alike, the first and the measuring point.
    pub points: Vec<CastingPoint>,
}

/// A point of a casting.
#[derive(Debug, Clone, PartialEq)]
pub struct CastingPoint {
    /// Id.
    pub id: PointId,
    /// `hammer.NAME` for a strike point, `fixture.NAME`, or `measuring_point`.
    pub name: String,
    /// Row over the casting's coordinates.
    pub row: Row,
}

/// Books that record an element's work and loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Books {
    /// No books of their own: an element within a hammer.
    Inner,
    /// Books of a hammer and of the casting that it strikes.
    Strike {
        hammer: usize,
        casting: usize,
        /// Column of the hammer's chisel.
        chisel: usize,
    },
    /// Books of the casting that a fixture holds.
    Fixture {
        casting: usize,
        /// Column of the machine's point that carries the fixture.
        support: usize,
    },
}

/// Two sums of components of the state, each with its coefficient.
pub(super) type Sums = [Vec<(usize, f64)>; 2];

/// The coupled system: constant while it is integrated.
#[derive(Debug, Clone)]
pub struct CoupledModel {
    pub(super) layout: Layout,
    /// Parts: machine, hammers, castings.
    pub(super) parts: Vec<Part>,
    /// Points of the parts.
    pub(super) points: Points,
    pub(super) elements: Elements,
    pub(super) hammers: Vec<HammerSlot>,
    pub(super) castings: Vec<CastingSlot>,
    pub(super) scales: Vec<f64>,
    /// Components of the state that each contact's guard depends on.
    pub(super) supports: Vec<Vec<usize>>,
    /// Penetration (its offset not subtracted) and rate of each contact as sums of components; `None` where a point of a flexible
    /// part takes part.
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

    /// Number of modes of all flexible parts.
    pub fn modes(&self) -> usize {
        self.parts.iter().filter_map(|part| part.block.modes()).map(|modes| modes.omega_squared.len()).sum()
    }

    /// Points of the parts.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Masses and inertias of a part's coordinates; none of a flexible one.
    fn rigid(&self, id: PartId) -> &[f64] {
        let part = self.parts.iter().find(|part| part.id == id);
        part.map_or(&[], |part| if let Block::Rigid(rigid) = &part.block { &rigid.mass } else { &[] })
    }

    /// Masses and inertias of the rigid coordinates of all parts.
    pub(super) fn masses(&self) -> impl Iterator<Item = &f64> {
        let rigid =
            self.parts.iter().filter_map(|part| if let Block::Rigid(rigid) = &part.block { Some(rigid) } else { None });
        rigid.flat_map(|rigid| &rigid.mass)
    }

    /// Books of a spring.
    pub(super) fn books_of_spring(&self, spring: &Spring) -> Books {
        self.books(spring.owner, None)
    }

    /// Books of a contact.
    pub(super) fn books_of_contact(&self, contact: &Contact) -> Books {
        self.books(contact.owner, Some(contact.kind))
    }

    fn books(&self, owner: Owner, kind: Option<ContactKind>) -> Books {
        match owner {
            Owner::Hammer(hammer) if kind == Some(ContactKind::ChiselCasting) => {
                let slot = &self.hammers[hammer];
                Books::Strike { hammer, casting: slot.casting, chisel: slot.points[body::CHISEL] }
            }
            Owner::Hammer(_) => Books::Inner,
            Owner::Fixture(fixture) => match self.points.row(PointId::Support(fixture)) {
                [(support, _)] => Books::Fixture { casting: fixture.casting, support: *support },
                _ => Books::Inner,
            },
        }
    }

    /// Penetration of a contact, its offset not subtracted, and its rate as sums of components of the state; `None` where a point of a
    /// flexible part takes part.
    pub fn contact_sums(&self, contact: usize) -> Option<&[Vec<(usize, f64)>; 2]> {
        self.sums[contact].as_ref()
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
        let mount = self.hammers[hammer].mount;
        let carries = |part: &&Part| part.columns.contains(&mount);
        let carrier = self.parts.iter().find(carries).and_then(|part| Some((part, part.block.modes()?)));
        let Some((part, modes)) = carrier else { return f64::INFINITY };
        let shapes = modes.phi.column(mount - part.columns.start);
        let strongest = shapes.iter().fold(0.0_f64, |strongest, phi| strongest.max(phi * phi));
        let modes = shapes.iter().zip(&modes.damping);
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
        let masses = self.rigid(PartId::Casting(casting));
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
