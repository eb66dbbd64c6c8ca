//! Constants of the coupled system.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::hammer::{HammerModel, body};
use crate::scene::{HammerLink, Owner, PartId, PointId};
use crate::system::block::{Block, CoupledPart};
use crate::system::elements::{Elements, WatchedResidual};
use crate::system::layout::Layout;
use crate::system::points::Points;

/// One hammer within the coupled system.
#[derive(Debug, Clone)]
pub struct HammerSlot {
    /// Name of the hammer.
    pub name: String,
    /// Constants of the hammer.
    pub model: HammerModel,
    /// Columns of its bodies; a tied guide has the column of its mount.
    pub points: [usize; body::COUNT],
    /// Column of its mount.
    pub mount: usize,
    /// Contact with the casting.
    pub strike: usize,
    /// Contact of piston and chisel.
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
pub(super) type WeightedPair = [Vec<(usize, f64)>; 2];

/// Motion in m that the residual flexibility of an elastic part adds at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualMotion {
    /// Per elongation of each spring.
    pub elongations: Vec<f64>,
    /// Per rate of each spring's elongation, s.
    pub rates_s: Vec<f64>,
    /// Per force of each contact, m/N.
    pub contacts_m_per_n: Vec<f64>,
}

/// The coupled system: constant while it is integrated.
#[derive(Debug, Clone)]
pub struct CoupledModel {
    pub(super) layout: Layout,
    /// Parts: machine, hammers, castings.
    pub(super) parts: Vec<CoupledPart>,
    /// Points of the parts.
    pub(super) points: Points,
    pub(super) elements: Elements,
    pub(super) hammers: Vec<HammerSlot>,
    pub(super) scales: Vec<f64>,
    /// Components of the state that each contact's guard depends on.
    pub(super) supports: Vec<Vec<usize>>,
    /// Penetration (its offset not subtracted) and rate of each contact as sums of components; `None` if a point of a flexible
    /// part takes part.
    pub(super) sums: Vec<Option<WeightedPair>>,
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

    /// Part and number of a watched point of an elastic part.
    pub(super) fn watched(&self, point: PointId) -> Option<(usize, usize)> {
        if !point.is_watched() || self.points.0.contains_key(&point) {
            return None;
        }
        let places = self.parts.iter().map(|part| part.watched.as_ref()).enumerate();
        places
            .filter_map(|(place, watched)| Some((place, watched?.points.iter().position(|known| *known == point)?)))
            .next()
    }

    /// A part.
    fn part(&self, id: PartId) -> Option<&CoupledPart> {
        self.parts.iter().find(|part| part.id == id)
    }

    /// Columns of a part.
    pub(super) fn columns(&self, part: PartId) -> Range<usize> {
        self.part(part).map_or(0..0, |part| part.columns.clone())
    }

    /// Masses and inertias of the rigid coordinates of all parts.
    pub(super) fn masses(&self) -> impl Iterator<Item = &f64> {
        let rigid =
            self.parts.iter().filter_map(|part| if let Block::Rigid(rigid) = &part.block { Some(rigid) } else { None });
        rigid.flat_map(|rigid| &rigid.mass)
    }

    /// Books of an element.
    pub(super) fn books(&self, owner: Owner) -> Books {
        match owner {
            Owner::Hammer { hammer, link: HammerLink::ChiselCasting } => {
                let slot = &self.hammers[hammer];
                Books::Strike { hammer, casting: slot.casting, chisel: slot.points[body::CHISEL] }
            }
            Owner::Hammer { .. } => Books::Inner,
            Owner::Fixture(fixture) => match self.points.row(PointId::Support(fixture)) {
                [(support, _)] => Books::Fixture { casting: fixture.casting, support: *support },
                _ => Books::Inner,
            },
        }
    }

    /// Penetration of a contact, its offset not subtracted, and its rate as sums of components of the state; `None` if a point of a
    /// flexible part takes part.
    pub fn contact_sums(&self, contact: usize) -> Option<&[Vec<(usize, f64)>; 2]> {
        self.sums[contact].as_ref()
    }

    /// The hammers.
    pub fn hammers(&self) -> &[HammerSlot] {
        &self.hammers
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
        let carries = |part: &&CoupledPart| part.columns.contains(&mount);
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

    /// Displacement and velocity of a point as sums of components of the state; `None` if it follows condensed modes.
    pub fn point_sums(&self, point: PointId) -> Option<[Vec<(usize, f64)>; 2]> {
        let mut sums: WeightedPair = Default::default();
        if let Some((place, at)) = self.watched(point) {
            let part = &self.parts[place];
            let Block::Modal(_) = &part.block else { return None };
            for (sum, states) in sums.iter_mut().zip(&part.states) {
                let Some(watched) = &part.watched else { continue };
                sum.extend(states.clone().zip(watched.shapes.column(at).iter().copied()));
            }
            return Some(sums);
        }
        for &(column, coefficient) in self.points.row(point) {
            let part = self.parts.iter().find(|part| part.columns.contains(&column))?;
            let at = column - part.columns.start;
            let mut add = |state: usize, share: f64| {
                sums.iter_mut().zip(&part.states).for_each(|(sum, states)| sum.push((states.start + state, share)));
            };
            match &part.block {
                Block::Rigid(_) => add(at, coefficient),
                Block::Modal(modes) => {
                    let shape = modes.phi.column(at);
                    shape.iter().enumerate().for_each(|(mode, phi)| add(mode, coefficient * phi));
                }
                Block::Condensed(_) => return None,
            }
        }
        Some(sums)
    }

    /// What the forces of elements add to the motion of a watched point of an elastic part; `None` without a residual flexibility.
    pub fn residual_motion(&self, point: PointId) -> Option<ResidualMotion> {
        let (place, at) = self.watched(point)?;
        let of_part = self.elements.series()?.watched.get(&self.parts[place].columns.start)?;
        let row = |of: &DMatrix<f64>| of.row(at).iter().copied().collect();
        let WatchedResidual { elongations, rates_s, contacts } = of_part;
        Some(ResidualMotion { elongations: row(elongations), rates_s: row(rates_s), contacts_m_per_n: row(contacts) })
    }

    /// Components of the state that are the velocities of a part: of its rigid coordinates, or of modes that are integrated.
    pub fn velocities(&self, part: PartId) -> Range<usize> {
        self.part(part).map_or(0..0, |part| part.states[1].clone())
    }

    /// Kinetic energy of a part, J, by its [`Self::velocities`]: of bounds, a bound.
    pub fn kinetic_energy(&self, part: PartId, velocity: impl Fn(usize) -> f64) -> f64 {
        let Some(part) = self.part(part) else { return 0.0 };
        // Modes are scaled to a mass of 1.
        let mass = |at: usize| if let Block::Rigid(rigid) = &part.block { rigid.mass[at] } else { 1.0 };
        let squares = part.states[1].clone().map(|component| velocity(component).powi(2));
        squares.enumerate().fold(0.0, |sum, (at, square)| sum + 0.5 * mass(at) * square)
    }

    /// Kinetic energy of cylinder, spool, piston and chisel of a hammer in J: the impact energy of a blow at its start.
    pub fn impact_energy(&self, hammer: usize, y: &[f64]) -> f64 {
        let slot = &self.hammers[hammer];
        let bodies = (body::CYLINDER..body::COUNT).map(|i| (slot.model.mass()[i], slot.points[i]));
        bodies.map(|(mass, point)| 0.5 * mass * y[self.layout.velocity(point)].powi(2)).sum()
    }
}
