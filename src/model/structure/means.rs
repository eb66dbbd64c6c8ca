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

use std::collections::{BTreeMap, BTreeSet};

use sprs::CsMat;

use super::constraints::{Constraint, solve, transformation};
use super::error::StructureError;
use super::model::FeModel;
use super::partition::dof_rows;
use super::place::PlacedPoint;

/// Largest coefficient of a displacement that follows means. A larger one has lost its digits: the mean almost follows from other points.
const MOST_SHARE: f64 = 1e6;

/// A DOF of the interface: name of the point, and direction.
type PointDof = (String, usize);

/// The model in coordinates in which every DOF of the interface is a row; `None` if it is so already.
///
/// # Errors
/// An unknown point, a DOF that a node of a point does not have, a point whose mean follows from other points.
pub(super) fn with_means(model: &FeModel, interface: &[PointDof]) -> Result<Option<FeModel>, StructureError> {
    let mut kept = BTreeSet::new();
    let mut means: Vec<(Constraint, Vec<&PointDof>)> = Vec::new();
    for named in interface {
        let (point, dof) = named;
        let sum: Constraint = match dof_rows(model, point, *dof)?[..] {
            [(row, _)] => {
                kept.insert(row);
                continue;
            }
            ref rows => rows.iter().copied().collect(),
        };
        // Points that are the same nodes with the same weights share a row.
        match means.iter_mut().find(|(other, _)| *other == sum) {
            Some((_, names)) => names.push(named),
            None => means.push((sum, vec![named])),
        }
    }
    if means.is_empty() {
        return Ok(None);
    }
    let order = model.order();
    // Behind the rows stand the means, which the constraints `sum w_i u_i - p = 0` tie to them.
    let constraint = |(at, (sum, _)): (usize, &(Constraint, Vec<&PointDof>))| {
        sum.iter().map(|(row, weight)| (*row, *weight)).chain([(order + at, -1.0)]).collect()
    };
    let constraints: Vec<Constraint> = means.iter().enumerate().map(constraint).collect();
    kept.extend(order..order + means.len());
    let solved = |count: usize| {
        let following = solve(constraints[..count].to_vec(), &kept);
        let coefficients = || following.values().flat_map(BTreeMap::values);
        let sound = following.len() == count
            && following.keys().all(|row| !kept.contains(row))
            && coefficients().all(|one| one.abs() <= MOST_SHARE);
        sound.then_some(following)
    };
    let Some(following) = solved(means.len()) else {
        let at = (1..means.len()).find(|count| solved(*count).is_none()).unwrap_or(means.len()) - 1;
        let name = format!("interface point {}", means[at].1[0].0);
        let expected = "nodes of which at least one may move freely while all other points are held";
        let found = "a mean that follows from other points: leave one of them out";
        return Err(StructureError::argument(name, expected, found));
    };
    // Each mean takes the place of a displacement that follows, of one in its own direction: labels stay right.
    let mut free: Vec<usize> = following.keys().copied().collect();
    let is_along = |row: usize, dof: usize| model.labels().get(row).is_some_and(|label| label.dof == dof);
    let takes = |(_, names): &(Constraint, Vec<&PointDof>)| {
        free.remove(free.iter().position(|row| is_along(*row, names[0].1)).unwrap_or(0))
    };
    let places: Vec<usize> = means.iter().map(takes).collect();
    let place = |row: usize| row.checked_sub(order).map_or(row, |mean| places[mean]);
    let placed = |terms: &Constraint| terms.iter().map(|(row, share)| (place(*row), *share)).collect();
    let following = following.iter().map(|(row, terms)| (*row, placed(terms))).collect();
    let (forward, back) = transformation(order, &following);
    let names =
        means.into_iter().zip(places).flat_map(|((_, names), place)| names.into_iter().map(move |one| (one, place)));
    let rows = rows(model, &names.collect());
    Ok(Some(model.over(|matrix: &CsMat<f64>| &(&back * matrix) * &forward, rows)))
}

/// Rows of the points over the new coordinates.
fn rows(model: &FeModel, means: &BTreeMap<&PointDof, usize>) -> Vec<PlacedPoint> {
    let points = model.points().iter().zip(model.placed());
    let placed = points.map(|(point, nodes)| {
        let rows = std::array::from_fn(|dof| means.get(&(point.name.clone(), dof)).copied());
        if rows == [None; 6] { nodes.clone() } else { vec![(rows, 1.0)] }
    });
    placed.collect()
}
