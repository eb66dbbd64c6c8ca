//! Rotates matrices with rows along local axes to the basic system.

use std::collections::{BTreeMap, HashMap};

use sprs::{CsMat, TriMat};

use super::rows::{BASIC_AXES, Nodes};
use crate::structure::error::StructureError;
use crate::structure::label::DofLabel;
use crate::structure::matrices::ModelMatrices;

/// Axes whose components differ by more are not the same.
const SAME: f64 = 1e-6;

/// Adds another file's statements about nodes; `first`: the file before.
///
/// # Errors
/// Axes of a node that differ between the two.
pub(super) fn add(nodes: &mut Nodes, first: &str, other: &Nodes, file: &str) -> Result<(), StructureError> {
    for (node, axes) in &other.axes {
        let known = nodes.axes.entry(*node).or_insert(*axes);
        if known.iter().flatten().zip(axes.iter().flatten()).any(|(a, b)| (a - b).abs() > SAME) {
            let reason = format!(
                "the displacements of node {node} are along other axes here than in {first}: correct one of them"
            );
            return Err(StructureError::Matrix { file: file.to_owned(), reason });
        }
    }
    for (node, place) in &other.positions {
        nodes.positions.entry(*node).or_insert(*place);
    }
    Ok(())
}

/// `A -> T A T'`, where T turns displacements and rotations of the nodes in `axes` (columns: local axes in the basic system).
///
/// # Errors
/// A node of which some of the three displacements (or rotations) have no row: what is left cannot be turned.
pub(super) fn to_basic(
    matrices: &mut ModelMatrices,
    axes: &BTreeMap<i64, [[f64; 3]; 3]>,
    file: &str,
) -> Result<(), StructureError> {
    if axes.values().all(|axes| *axes == BASIC_AXES) {
        return Ok(());
    }
    let rows: HashMap<DofLabel, usize> = matrices.labels.iter().copied().zip(0..).collect();
    let order = matrices.labels.len();
    let (mut turn, mut back) = (TriMat::new((order, order)), TriMat::new((order, order)));
    let mut put = |row: usize, column: usize, value: f64| {
        turn.add_triplet(row, column, value);
        back.add_triplet(column, row, value);
    };
    let mut turned = vec![false; order];
    for (&node, axes) in axes.iter().filter(|(_, axes)| **axes != BASIC_AXES) {
        for first in [0, 3] {
            let places = [0, 1, 2].map(|dof| rows.get(&DofLabel { node, dof: first + dof }).copied());
            let [Some(x), Some(y), Some(z)] = places else {
                if places == [None; 3] {
                    continue;
                }
                let reason = format!(
                    "node {node} has displacements along axes of its own, but not all three of them are among the rows: they cannot be turned to x, y, z; retain all or use the basic system there"
                );
                return Err(StructureError::Matrix { file: file.to_owned(), reason });
            };
            for (column, axis) in [x, y, z].into_iter().zip(axes) {
                turned[column] = true;
                [x, y, z].into_iter().zip(axis).for_each(|(row, value)| put(row, column, *value));
            }
        }
    }
    (0..order).filter(|row| !turned[*row]).for_each(|row| put(row, row, 1.0));
    let (turn, back): (CsMat<f64>, CsMat<f64>) = (turn.to_csr(), back.to_csr());
    let ModelMatrices { mass, stiffness, damping, .. } = matrices;
    for matrix in [mass, stiffness].into_iter().chain(damping) {
        *matrix = &(&turn * &*matrix) * &back;
    }
    Ok(())
}
