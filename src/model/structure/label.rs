//! Labels of the rows of matrices.

use std::collections::HashMap;

/// Meaning of a row of the matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DofLabel {
    /// Number of the node.
    pub node: i64,
    /// Direction 0 to 5, see [`super::DOF_NAMES`], or [`SCALAR`].
    pub dof: usize,
}

/// The direction of a coordinate that is not the motion of a point: a modal coordinate of an earlier reduction.
pub const SCALAR: usize = 6;

/// Labels of rows that are numbered node by node, `dofs` per node; nodes are counted from 1.
pub(super) fn regular_labels(order: usize, dofs: usize) -> Vec<DofLabel> {
    (0..order).map(|row| DofLabel { node: (row / dofs) as i64 + 1, dof: row % dofs }).collect()
}

/// The first label that two rows have, and these rows, counted from 1.
pub(super) fn repeated(labels: &[DofLabel]) -> Option<([usize; 2], DofLabel)> {
    let mut seen: HashMap<DofLabel, usize> = HashMap::new();
    let mut rows = labels.iter().zip(1..);
    rows.find_map(|(label, row)| seen.insert(*label, row).map(|first| ([first, row], *label)))
}
