//! Balance of forces under rigid motions.
//!
//! A rigid motion strains nothing, so `K r` is 0 except where springs hold the machine. Wrong labels, positions or units of rotations
//! make it large in most rows. Nastran's GROUNDCHECK computes the same product.
//!
//! A rotation is taken about each row's own node: a distant origin would cause large forces that cancel.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use sprs::CsMat;

use super::model::FeModel;

/// A row is out of balance if the forces of a motion leave this share of the sum of their magnitudes.
const OUT: f64 = 0.05;

/// Balance of the rows of a stiffness.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Balance {
    /// One entry per row: whether it is out of balance. `None` for a row that the motions do not load.
    pub out: Vec<Option<bool>>,
}

impl Balance {
    /// Share of the loaded rows that are out of balance, 0 to 1.
    pub fn share(&self) -> f64 {
        let loaded = self.loaded();
        let out = self.out.iter().filter(|out| **out == Some(true)).count();
        if loaded == 0 { 0.0 } else { out as f64 / loaded as f64 }
    }

    /// Number of rows that the motions load.
    pub fn loaded(&self) -> usize {
        self.out.iter().flatten().count()
    }

    /// First row that is out of balance.
    pub fn first(&self) -> Option<usize> {
        self.out.iter().position(|out| *out == Some(true))
    }
}

/// Balance under motions that are given for all rows (rows x motions).
pub(super) fn under_motions(stiffness: &CsMat<f64>, motions: &DMatrix<f64>) -> Balance {
    let count = motions.ncols();
    // By row, so that the values of a column of the stiffness lie side by side.
    let values = motions.transpose();
    let row = |(_, view): (usize, sprs::CsVecView<'_, f64>)| {
        let (mut force, mut size) = (vec![0.0; count], vec![0.0; count]);
        for (column, entry) in view.iter() {
            for (motion, value) in values.column(column).iter().enumerate() {
                force[motion] += entry * value;
                size[motion] += (entry * value).abs();
            }
        }
        verdict(&force, &size)
    };
    Balance { out: stiffness.outer_iterator().enumerate().map(row).collect() }
}

/// Motion of a row under a rigid rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rotated {
    /// Displacement along an axis of a node at this place in m.
    Place([f64; 3], usize),
    /// Rotation about an axis.
    Angle(usize),
    /// Nothing: a modal coordinate.
    Still,
    /// Not known.
    Unknown,
}

/// Motion of each row under rotation, from the directions of rows and the places of nodes.
pub(super) fn rotated(model: &FeModel, directions: &[Option<usize>], places: &BTreeMap<i64, [f64; 3]>) -> Vec<Rotated> {
    let row = |(row, direction): (usize, &Option<usize>)| match *direction {
        Some(axis @ 3..) => Rotated::Angle(axis - 3),
        None => Rotated::Still,
        Some(axis) => {
            let place = model.labels().get(row).and_then(|label| places.get(&label.node));
            place.map_or(Rotated::Unknown, |place| Rotated::Place(*place, axis))
        }
    };
    directions.iter().enumerate().map(row).collect()
}

/// Loads of the rows by rotations.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turned {
    pub balance: Balance,
    /// Forces of rotations over forces of stretches of the same size, summed over displacements. A model of one material and one size of
    /// elements balances every linear motion but at its surface, so that few rows of a large one are out of balance.
    pub strain: f64,
}

/// Balance under rotations about the nodes of the rows. Only rows that are coupled to known rows alone, have a place and are balanced under
/// translations are looked at: supports load the others. `node_places`: place of the node of each row.
pub(super) fn under_rotations(
    stiffness: &CsMat<f64>,
    rows: &[Rotated],
    node_places: &[Option<[f64; 3]>],
    translated: &Balance,
) -> Turned {
    let (mut turning, mut stretching) = (0.0, 0.0);
    let row = |(row, view): (usize, sprs::CsVecView<'_, f64>)| {
        let centre = node_places[row].filter(|_| translated.out[row] != Some(true))?;
        let (mut force, mut size, mut stretch) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for (column, entry) in view.iter().filter(|(_, entry)| **entry != 0.0) {
            let mut add = |axis: usize, value: f64| {
                force[axis] += entry * value;
                size[axis] += (entry * value).abs();
            };
            match rows[column] {
                Rotated::Angle(axis) => add(axis, 1.0),
                Rotated::Still => {}
                Rotated::Unknown => return None,
                Rotated::Place(place, direction) => {
                    let distance = [0, 1, 2].map(|axis| place[axis] - centre[axis]);
                    let [x, y, z] = distance;
                    let motions = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
                    (0..3).for_each(|axis| add(axis, motions[axis][direction]));
                    stretch[direction] += entry * distance[direction];
                }
            }
        }
        if matches!(rows[row], Rotated::Place(..)) {
            turning += length(force);
            stretching += length(stretch);
        }
        verdict(&force, &size)
    };
    let balance = Balance { out: stiffness.outer_iterator().enumerate().map(row).collect() };
    Turned { balance, strain: if stretching > 0.0 { turning / stretching } else { 0.0 } }
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// Forces are compared with the largest of all motions: one motion may load a row by rounding alone.
fn verdict(force: &[f64], size: &[f64]) -> Option<bool> {
    let largest = size.iter().copied().fold(0.0, f64::max);
    (largest > 0.0).then(|| force.iter().any(|force| force.abs() > OUT * largest))
}
