//! Coordinates of the rigid parts of a scene: bodies of hammers, heave and rotations of castings, side by side.

use std::ops::Range;

use crate::hammer::body;
use crate::scene::Scene;
use crate::system::points::{PartId, Row};
use crate::workpiece::WorkpieceError;

/// Columns of the rigid parts' coordinates.
pub(super) struct Columns {
    /// Number of columns.
    pub bodies: usize,
    /// First column of each hammer.
    hammers: Vec<usize>,
    /// Guides are tied to their mounts. A tied guide has no column.
    pub tied: bool,
    pub castings: Vec<CastingColumns>,
}

/// Coordinates of a rigid casting: its heave and the rotations that the scene needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct CastingColumns {
    pub heave: usize,
    /// About x and y.
    pub rotations: [Option<usize>; 2],
}

impl CastingColumns {
    /// Range of all its columns.
    pub fn all(&self) -> Range<usize> {
        self.heave..self.heave + 1 + self.rotations.iter().flatten().count()
    }

    /// Row of a point at (x, y) from the centre: `z + y tx - x ty`.
    pub fn point(&self, at_m: [f64; 2]) -> Row {
        let levers = [at_m[1], -at_m[0]];
        let rotations = self.rotations.iter().zip(levers).filter_map(|(column, lever)| Some(((*column)?, lever)));
        std::iter::once((self.heave, 1.0)).chain(rotations).collect()
    }
}

impl Columns {
    /// Numbers the coordinates of a scene.
    ///
    /// # Errors
    /// A casting that is not held, or rotates and lacks its inertia.
    pub fn new(scene: &Scene) -> Result<Self, WorkpieceError> {
        let tied = scene.ties(scene.solver.guide);
        let per_hammer = if tied { body::COUNT - 1 } else { body::COUNT };
        let hammers = (0..scene.hammers.len()).map(|h| h * per_hammer).collect();
        let mut bodies = per_hammer * scene.hammers.len();
        let mut castings = Vec::with_capacity(scene.castings.len());
        for (index, casting) in scene.castings.iter().enumerate() {
            let active = casting.active_rotations(&scene.strike_points(index));
            casting.check_restraint(active)?;
            let heave = bodies;
            bodies += 1;
            let rotations = active.map(|active| {
                let column = active.then_some(bodies);
                bodies += usize::from(active);
                column
            });
            castings.push(CastingColumns { heave, rotations });
        }
        Ok(Self { bodies, hammers, tied, castings })
    }

    /// Column of a hammer's body; `None` for a tied guide.
    pub fn body(&self, hammer: usize, body: usize) -> Option<usize> {
        let within = if self.tied { body.checked_sub(1)? } else { body };
        Some(self.hammers[hammer] + within)
    }

    /// Masses and inertias of each rigid part's coordinates.
    pub fn masses(&self, scene: &Scene) -> Vec<(PartId, Vec<f64>)> {
        let of_hammer = |h: usize| {
            let mass = scene.hammers[h].parameters.masses_kg();
            (PartId::Hammer(h), mass[usize::from(self.tied)..].to_vec())
        };
        let of_casting = |c: usize| {
            let casting = &scene.castings[c];
            // `check_restraint` has made sure that a casting that rotates has its inertia.
            let inertia = casting.inertia_kg_m2.unwrap_or([0.0; 2]);
            let rotations = self.castings[c].rotations.iter().zip(inertia).filter(|(column, _)| column.is_some());
            let masses = std::iter::once(casting.mass_kg).chain(rotations.map(|(_, inertia)| inertia));
            (PartId::Casting(c), masses.collect())
        };
        let hammers = (0..scene.hammers.len()).map(of_hammer);
        hammers.chain((0..scene.castings.len()).map(of_casting)).collect()
    }
}
