//! Blocks: the equations of motion of a scene's parts, one block per part.
//!
//! - `rigid`: coordinates with a mass each, integrated
//! - `modal`: modes of a flexible part, integrated, and masses tied to its points
//! - `condensed`: modes of a flexible part, condensed to its points
//! - `flexible`: the rates of a flexible part's block
//!
//! A block knows only its own states, and holds the modes that it carries outside the state.

mod condensed;
mod flexible;
mod rigid;

use std::ops::Range;
use std::sync::Arc;

pub(super) use condensed::{Condensed, CondensedConstants};
pub(super) use flexible::FlexibleRates;
pub(super) use rigid::Rigid;

use crate::scene::PartId;
use crate::system::modal::{Modes, TiedMasses};
use crate::system::placed::Watched;

/// Equations of motion of a part.
#[derive(Debug, Clone)]
pub(super) enum Block {
    /// Coordinates with a mass each.
    Rigid(Rigid),
    /// Modes, integrated.
    Modal(Arc<Modes>),
    /// Modes, condensed to the part's points.
    Condensed(Box<Condensed>),
}

/// Part of a model: its block at rest, its columns and states.
#[derive(Debug, Clone)]
pub(super) struct CoupledPart {
    pub id: PartId,
    pub block: Block,
    /// Columns in the elements' rows: rigid coordinates, or driven points.
    pub columns: Range<usize>,
    /// States in place of displacements and in place of velocities.
    pub states: [Range<usize>; 2],
    /// Masses tied to the first of its points.
    pub tied: Option<TiedMasses>,
    /// Watched points of an elastic part.
    pub watched: Option<Arc<Watched>>,
}

/// States of a block at a time.
#[derive(Clone, Copy)]
pub(super) struct BlockStates<'y> {
    pub t: f64,
    /// States in place of displacements and in place of velocities.
    pub y: [&'y [f64]; 2],
}

impl CoupledPart {
    /// Selects the part's states.
    pub fn states_of<'y>(&self, t: f64, y: &'y [f64]) -> BlockStates<'y> {
        BlockStates { t, y: self.states.each_ref().map(|states| &y[states.clone()]) }
    }
}

impl Block {
    /// Number of columns: of rigid coordinates, or of driven points.
    pub fn columns(&self) -> usize {
        match self {
            Self::Rigid(rigid) => rigid.mass.len(),
            Self::Modal(modes) => modes.phi.ncols(),
            Self::Condensed(condensed) => condensed.constants.condensation.points(),
        }
    }

    /// Numbers of states in place of displacements and in place of velocities.
    pub fn states(&self) -> [usize; 2] {
        match self {
            Self::Rigid(rigid) => [rigid.mass.len(); 2],
            Self::Modal(modes) => [modes.omega_squared.len(); 2],
            Self::Condensed(condensed) => [condensed.constants.condensation.states(), 0],
        }
    }

    /// The modes of a flexible part.
    pub fn modes(&self) -> Option<&Modes> {
        match self {
            Self::Rigid(_) => None,
            Self::Modal(modes) => Some(modes),
            Self::Condensed(condensed) => Some(&condensed.constants.modes),
        }
    }

    /// The condensed modes.
    pub fn condensed(&self) -> Option<&Condensed> {
        if let Self::Condensed(condensed) = self { Some(condensed) } else { None }
    }

    /// The condensed modes, mutable.
    pub fn condensed_mut(&mut self) -> Option<&mut Condensed> {
        if let Self::Condensed(condensed) = self { Some(condensed) } else { None }
    }

    /// Displacement and velocity of column `n` of the block.
    pub fn motion(&self, states: BlockStates<'_>, n: usize) -> [f64; 2] {
        match self {
            Self::Rigid(_) => states.y.map(|y| y[n]),
            Self::Modal(modes) => states.y.map(|y| modes.at(n, y)),
            Self::Condensed(condensed) => condensed.motion(states.t, states.y[0], n),
        }
    }

    /// Shows displacement and velocity of each mode by its number.
    pub fn each_mode(&self, states: BlockStates<'_>, mut see: impl FnMut(usize, [f64; 2])) {
        match self {
            Self::Rigid(_) => {}
            Self::Modal(_) => {
                let [x, v] = states.y;
                x.iter().zip(v).enumerate().for_each(|(mode, (x, v))| see(mode, [*x, *v]));
            }
            Self::Condensed(condensed) => condensed.each_mode(states.t, states.y[0], &mut see),
        }
    }

    /// Adds the kinetic and strain energy, J, to a sum.
    pub fn add_energy(&self, sum: f64, states: BlockStates<'_>) -> f64 {
        let [x, v] = states.y;
        match self {
            Self::Rigid(rigid) => rigid.add_energy(sum, v),
            Self::Modal(modes) => sum + modes.energy(x, v),
            Self::Condensed(condensed) => sum + condensed.energy(states.t, x),
        }
    }

    /// Energy that modes outside the state have dissipated up to a time within or at the end of the last step, J.
    pub fn dissipated_outside(&self, states: BlockStates<'_>) -> f64 {
        self.condensed().map_or(0.0, |condensed| condensed.dissipated(states.t, states.y[0]))
    }

    /// Energy that modes outside the state have dissipated up to the end of a run, J. The last interval ends there too.
    pub fn dissipated_to_the_end(&self) -> f64 {
        self.condensed().map_or(0.0, |condensed| condensed.dissipation.whole_j())
    }

    /// Time of the next rebase at the latest, s; infinite for a block without condensed modes.
    pub fn horizon_s(&self) -> f64 {
        self.condensed().map_or(f64::INFINITY, Condensed::horizon_s)
    }
}
