//! Modes of a machine as rows ask for them: at some points, along some directions.

use std::f64::consts::TAU;

use decore_model::structure::{DirectedPoints, ModalOptions, ModesAt, ReducedStructure, RigidMass};

/// A weighted set of points that moves along a direction.
pub fn along(points: &[(&str, f64)], direction: [f64; 3]) -> DirectedPoints {
    (points.iter().map(|(name, weight)| ((*name).to_owned(), *weight)).collect(), direction)
}

/// Natural frequencies of a machine that carries rigid bodies, Hz.
pub fn hz(structure: &ReducedStructure, bodies: &[RigidMass], options: &ModalOptions) -> Vec<f64> {
    frequencies_hz(&structure.modes_at(bodies, options, &[]).expect("modes"))
}

/// Natural frequencies, Hz.
pub fn frequencies_hz(modes: &ModesAt) -> Vec<f64> {
    modes.omega_rad_s.iter().map(|omega| omega / TAU).collect()
}

/// A row of the shapes.
pub fn row(modes: &ModesAt, at: usize) -> Vec<f64> {
    modes.rows.row(at).iter().copied().collect()
}
