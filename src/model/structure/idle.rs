//! Rotations of interface points without effect.
//!
//! A rigid body of nodes on one line turns about this line without stiffness and without mass. The rotation of its reference node, together
//! with displacements of a reference node beside the line, is then a null vector of stiffness and mass, and no factorisation exists. The
//! motion of all nodes is the same with this rotation at 0, so its row is left out.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use sprs::CsMat;

use super::constraints::{for_each, without};
use super::matrices::ModelMatrices;
use super::place::PointRows;
use super::points::DOF_NAMES;
use decore_math::linalg::symmetric_eigen;

/// A motion is idle if it has less than this share of the stiffness and mass of the rotations alone.
const IDLE: f64 = 1e-12;

/// Empties the rows of idle rotations. Returns the changes, in sentences. `points`: name and rows of each point.
pub(super) fn leave_out(matrices: &mut ModelMatrices, points: &[(String, PointRows)]) -> Vec<String> {
    let mut said = Vec::new();
    for (name, rows) in points {
        // A straight line has one rotation of this kind, a single node three.
        for _ in 0..3 {
            let Some((row, dof)) = idle(matrices, rows) else { break };
            let gone = BTreeSet::from([row]);
            for_each(matrices, |matrix| *matrix = without(matrix, &gone));
            said.push(format!(
                "rotation {dof} of point {name} moves neither mass nor stiffness (do the nodes of its rigid body lie on one line?): left out"
            ));
        }
    }
    said
}

/// Row and name of a rotation that moves nothing, alone or together with other directions of the point.
fn idle(matrices: &ModelMatrices, rows: &PointRows) -> Option<(usize, &'static str)> {
    let entry = |matrix: &CsMat<f64>, row: usize, column: usize| matrix.get(row, column).copied().unwrap_or(0.0);
    let carries = |row: usize| {
        [&matrices.stiffness, &matrices.mass]
            .iter()
            .any(|matrix| matrix.outer_view(row).is_some_and(|view| view.nnz() > 0))
    };
    let present: Vec<(usize, usize)> =
        rows.iter().enumerate().filter_map(|(dof, row)| Some((dof, row.filter(|row| carries(*row))?))).collect();
    let turns = |dof: usize| dof >= 3;
    let largest = |matrix: &CsMat<f64>| {
        let rotations = present.iter().filter(|(dof, _)| turns(*dof));
        rotations.map(|(_, row)| entry(matrix, *row, *row)).fold(0.0, f64::max)
    };
    let (stiffest, heaviest) = (largest(&matrices.stiffness), largest(&matrices.mass));
    if stiffest <= 0.0 {
        return None;
    }
    let block = |matrix: &CsMat<f64>| {
        DMatrix::from_fn(present.len(), present.len(), |i, j| entry(matrix, present[i].1, present[j].1))
    };
    let (stiffness, mass) = (block(&matrices.stiffness), block(&matrices.mass));
    // Scaled to a diagonal of 1, so that rounding errors of the stiffest rotation stay small.
    let scale: Vec<f64> = stiffness.diagonal().iter().map(|value| value.max(IDLE * stiffest).sqrt().recip()).collect();
    let scaled = DMatrix::from_fn(present.len(), present.len(), |i, j| stiffness[(i, j)] * scale[i] * scale[j]);
    let lowest = symmetric_eigen(&scaled).ok()?.vectors.column(0).into_owned();
    let (at, share) = (0..present.len())
        .filter(|at| turns(present[*at].0))
        .map(|at| (at, lowest[at] * scale[at]))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let motion = DVector::from_fn(present.len(), |i, _| lowest[i] * scale[i] / share);
    let is_free = |matrix: &DMatrix<f64>, largest: f64| {
        let magnitude = motion.abs().dot(&(matrix.abs() * motion.abs()));
        motion.dot(&(matrix * &motion)).abs() <= IDLE * magnitude.max(largest)
    };
    let is_idle = is_free(&stiffness, stiffest) && is_free(&mass, heaviest);
    is_idle.then(|| (present[at].1, DOF_NAMES[present[at].0]))
}
