//! Coordinates for interface points that are several nodes.
//!
//! The mean `p = sum w_i u_i` of a point replaces the displacement u_k of one of its nodes,
//!
//! ```text
//! u = T v,    u_k = (p - sum_{i != k} w_i u_i) / w_k,    M, D, K become T' M T, T' D T, T' K T
//! ```
//!
//! p is then a row of the model like any other: the reduction keeps one interface DOF, however many nodes the point has, and its static
//! flexibility is exact. A force on p acts on the nodes with their weights.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use sprs::{CsMat, TriMat};

use super::error::StructureError;
use super::model::FeModel;
use super::partition::dof_rows;
use super::place::PlacedPoint;

/// Share of the largest weight below which a node cannot be replaced: the mean follows from other points.
const LEAST_SHARE: f64 = 1e-6;

/// A sum over rows.
type Sum = BTreeMap<usize, f64>;

/// Displacements that means replace.
#[derive(Default)]
struct Means {
    /// Each of them over the new coordinates.
    replaced: BTreeMap<usize, Sum>,
    /// Rows that cannot be replaced: means, and DOFs of points that are one node.
    taken: BTreeSet<usize>,
    /// Row of each mean.
    rows: HashMap<(String, usize), usize>,
}

/// The model in coordinates in which every DOF of the interface is a row; `None` if it is so already.
///
/// # Errors
/// An unknown point, a DOF that a node of a point does not have, a point whose mean follows from other points.
pub(super) fn with_means(model: &FeModel, interface: &[(String, usize)]) -> Result<Option<FeModel>, StructureError> {
    let mut means = Means::default();
    let mut several = Vec::new();
    for (point, dof) in interface {
        match dof_rows(model, point, *dof)?[..] {
            [(row, _)] => drop(means.taken.insert(row)),
            _ => several.push((point, *dof)),
        }
    }
    // Points that are the same nodes with the same weights share a row.
    let mut known: Vec<(Vec<(usize, f64)>, usize)> = Vec::new();
    for (point, dof) in several {
        let mut sum = dof_rows(model, point, dof)?;
        sum.sort_by_key(|(row, _)| *row);
        let row = match known.iter().find(|(other, _)| *other == sum) {
            Some((_, row)) => *row,
            None => {
                let row = means.add(&sum).ok_or_else(|| {
                    let name = format!("interface point {point}");
                    let expected = "nodes of which at least one may move freely while all other points are held";
                    StructureError::argument(
                        name,
                        expected,
                        "a mean that follows from other points: leave one of them out",
                    )
                })?;
                known.push((sum, row));
                row
            }
        };
        means.rows.insert((point.clone(), dof), row);
    }
    if means.replaced.is_empty() {
        return Ok(None);
    }
    let transform = means.transform(model.order());
    let transposed = transform.transpose_view().to_csr();
    let change = |matrix: &CsMat<f64>| symmetric(&(&(&transposed * &matrix.to_csr()) * &transform));
    Ok(Some(model.over(change, means.placed(model))))
}

impl Means {
    /// Adds a mean and returns its row; `None` if it follows from rows that are taken.
    fn add(&mut self, sum: &[(usize, f64)]) -> Option<usize> {
        let mut over = Sum::new();
        for (row, weight) in sum {
            match self.replaced.get(row) {
                Some(terms) => terms.iter().for_each(|(term, share)| *over.entry(*term).or_default() += weight * share),
                None => *over.entry(*row).or_default() += weight,
            }
        }
        let largest = over.values().fold(0.0_f64, |largest, share| largest.max(share.abs()));
        let free = over.iter().filter(|(row, _)| !self.taken.contains(row));
        let (&row, &share) = free.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        if share.abs() <= LEAST_SHARE * largest {
            return None;
        }
        let mut own: Sum = over.into_iter().map(|(term, of_term)| (term, -of_term / share)).collect();
        own.insert(row, share.recip());
        for terms in self.replaced.values_mut() {
            let Some(factor) = terms.remove(&row) else { continue };
            own.iter().for_each(|(term, share)| *terms.entry(*term).or_default() += factor * share);
        }
        self.replaced.insert(row, own);
        self.taken.insert(row);
        Some(row)
    }

    /// `T`, one row per displacement.
    fn transform(&self, order: usize) -> CsMat<f64> {
        let mut entries = TriMat::new((order, order));
        for row in 0..order {
            match self.replaced.get(&row) {
                Some(terms) => terms.iter().for_each(|(term, share)| entries.add_triplet(row, *term, *share)),
                None => entries.add_triplet(row, row, 1.0),
            }
        }
        entries.to_csr()
    }

    /// The points' rows over the new coordinates.
    fn placed(&self, model: &FeModel) -> Vec<PlacedPoint> {
        let points = model.points().iter().zip(model.placed());
        let placed = points.map(|(point, nodes)| {
            let row = |dof: usize| self.rows.get(&(point.name.clone(), dof)).copied();
            let rows = std::array::from_fn(row);
            if nodes.len() > 1 && rows != [None; 6] { vec![(rows, 1.0)] } else { nodes.clone() }
        });
        placed.collect()
    }
}

/// The symmetric part of a matrix, which differs from it by rounding.
fn symmetric(matrix: &CsMat<f64>) -> CsMat<f64> {
    let mut mean = matrix + &matrix.transpose_view().to_csr();
    mean.data_mut().iter_mut().for_each(|value| *value *= 0.5);
    mean
}
