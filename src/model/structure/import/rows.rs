//! Meaning of the rows of matrices.

use std::collections::BTreeMap;

use crate::structure::label::{DofLabel, SCALAR};

/// Axes (columns) of the basic system.
pub(super) const BASIC_AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Meaning of the rows of matrices, and further statements of a list about its nodes.
#[derive(Debug, Default)]
pub(super) struct MatrixRows {
    pub labels: Vec<DofLabel>,
    pub nodes: Nodes,
    /// Whether the directions of nodes were not listed but taken to be all six.
    pub assumed: bool,
}

/// Statements of files about nodes.
#[derive(Debug, Clone, Default)]
pub(super) struct Nodes {
    /// Axes (columns, in the basic system) of the displacements of nodes, as far as they are stated; all others have the basic ones.
    pub axes: BTreeMap<i64, [[f64; 3]; 3]>,
    /// Positions of nodes, in the unit of the file.
    pub positions: BTreeMap<i64, [f64; 3]>,
}

/// Direction 1 to 6 as a DOF from 0, and 0 as a modal coordinate.
pub(super) fn direction(text: &str) -> Option<usize> {
    match text.trim().parse::<usize>().ok()? {
        0 => Some(SCALAR),
        number @ 1..=6 => Some(number - 1),
        _ => None,
    }
}

/// The number that stands for a DOF in exchange formats: 1 to 6, 0 for a modal coordinate.
pub(super) fn number(dof: usize) -> usize {
    if dof == SCALAR { 0 } else { dof + 1 }
}
