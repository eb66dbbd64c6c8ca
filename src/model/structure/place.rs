//! Rows of the matrices for each direction of an interface point.
//!
//! If rows have labels (a list of rows, or a number of DOFs per node), the labels decide: the rows of a point must belong to one node,
//! starting with its x displacement.

use std::collections::HashMap;

use super::label::{DofLabel, SCALAR};
use super::points::{DOF_NAMES, InterfacePoint, InterfacePoints, PointPlace};

/// Rows of the six DOFs of a point or a node; `None` for DOFs that the model does not have.
pub(super) type PointRows = [Option<usize>; 6];

/// Rows of the nodes of a point with their weights; a point that is no set of nodes has one entry of weight 1.
pub(super) type PlacedPoint = Vec<(PointRows, f64)>;

/// Returns an error if a node of a point has a direction twice. Other labels may repeat: CalculiX gives the nodes that it makes of shells
/// and beams the labels of the original nodes.
///
/// # Errors
/// A node of a point with two rows for a direction.
pub(super) fn require_distinct(labels: &[DofLabel], points: &InterfacePoints) -> Result<(), String> {
    let mut named: HashMap<i64, &str> = HashMap::new();
    for point in points.iter() {
        let nodes: Vec<i64> = match &point.place {
            PointPlace::Node { node, rotation_node } => [Some(*node), *rotation_node].into_iter().flatten().collect(),
            PointPlace::Nodes(nodes) => nodes.iter().map(|(node, _)| node).collect(),
            PointPlace::Rows { .. } | PointPlace::None => Vec::new(),
        };
        named.extend(nodes.into_iter().map(|node| (node, point.name.as_str())));
    }
    let mut seen: HashMap<DofLabel, usize> = HashMap::new();
    for (row, label) in labels.iter().enumerate() {
        let Some(name) = named.get(&label.node) else { continue };
        if let Some(other) = seen.insert(*label, row) {
            return Err(format!(
                "rows {} and {} (counted from 1) both are {}, the place of point {name}, so the point is ambiguous. \
                 CalculiX repeats the nodes of shells and beams: give the reference node of a *RIGID BODY there \
                 instead, or first_row_0based for node",
                other + 1,
                row + 1,
                describe(*label)
            ));
        }
    }
    Ok(())
}

/// The rows of every point, in the order of the table. Nodes of points have every direction once, see [`require_distinct`].
///
/// # Errors
/// A point without a place, rows that do not exist or belong to another node, a node without rows, two points that take a row
/// for different directions.
pub(super) fn place(labels: &[DofLabel], order: usize, points: &InterfacePoints) -> Result<Vec<PlacedPoint>, String> {
    let mut by_label: HashMap<DofLabel, usize> = HashMap::new();
    if points.iter().any(|point| matches!(point.place, PointPlace::Node { .. } | PointPlace::Nodes(_))) {
        by_label.extend(labels.iter().copied().zip(0..));
    }
    let place = |point: &InterfacePoint| match &point.place {
        PointPlace::None => Err(format!(
            "column first_row_0based or node is missing: point {} has no place in the matrices",
            point.name
        )),
        PointPlace::Rows { first, dofs } => {
            Ok(vec![(rows_from(&point.name, *first, *dofs, &RowLabels { labels, order })?, 1.0)])
        }
        PointPlace::Node { .. } | PointPlace::Nodes(_) if labels.is_empty() => Err(format!(
            "point {} is given by its node, but the rows of the matrices have no labels: name a dof_file, or give first_row_0based",
            point.name
        )),
        PointPlace::Node { node, rotation_node } => {
            Ok(vec![(rows_of_node(&point.name, (*node, *rotation_node), &by_label)?, 1.0)])
        }
        PointPlace::Nodes(nodes) => {
            let of_node = |(node, weight)| Ok((rows_of_node(&point.name, (node, None), &by_label)?, weight));
            nodes.iter().map(of_node).collect()
        }
    };
    let rows = points.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    require_one_direction(points, &rows)?;
    Ok(rows)
}

fn rows_of_node(
    name: &str,
    (node, rotation_node): (i64, Option<i64>),
    by_label: &HashMap<DofLabel, usize>,
) -> Result<PointRows, String> {
    let row_of = |node: i64, dof: usize| by_label.get(&DofLabel { node, dof }).copied();
    let mut rows: PointRows = std::array::from_fn(|dof| row_of(node, dof));
    for dof in 0..3 {
        let rotation = rotation_node.and_then(|node| row_of(node, dof));
        rows[dof + 3] = rotation.or(rows[dof + 3]);
    }
    if rows == [None; 6] {
        return Err(format!(
            "point {name}: no row of the matrices belongs to node {node} (fixed, condensed, or a wrong number)"
        ));
    }
    Ok(rows)
}

/// The rows of the matrices: their labels, none if there are no labels, and their number.
struct RowLabels<'a> {
    labels: &'a [DofLabel],
    order: usize,
}

/// Consecutive rows from `first` on: as many as were requested, all of one node; or all that the node has.
fn rows_from(
    name: &str,
    first: usize,
    dofs: Option<usize>,
    RowLabels { labels, order }: &RowLabels<'_>,
) -> Result<PointRows, String> {
    let Some(asked) = dofs.or((!labels.is_empty()).then_some(1)) else {
        return Err(format!(
            "point {name}: column dofs (3 or 6) is missing; without a dof_file or dofs_per_node nothing else gives the \
             number of rows of the point"
        ));
    };
    let last = first.saturating_add(asked.saturating_sub(1));
    if last >= *order {
        return Err(format!("point {name}: rows {first} to {last} exceed the matrices' {order}"));
    }
    let mut rows = [None; 6];
    let Some(start) = labels.get(first) else {
        rows.iter_mut().zip(first..=last).for_each(|(slot, row)| *slot = Some(row));
        return Ok(rows);
    };
    if start.dof != 0 {
        return Err(format!(
            "point {name}: row {first} (counted from 0) is {}, but a point begins with the x displacement of its node; give its node instead",
            describe(*start)
        ));
    }
    let own = |offset: usize| labels.get(first + offset) == Some(&DofLabel { node: start.node, dof: offset });
    let count = (0..rows.len()).take_while(|offset| own(*offset)).count();
    if let Some(dofs) = dofs
        && dofs > count
    {
        let next = labels.get(first + count).map_or_else(|| "past the end".to_owned(), |label| describe(*label));
        return Err(format!(
            "point {name}: rows {first} to {last} (counted from 0, dofs = {dofs}) do not belong to one node: row {first} is {}, but row {} is {next}; give dofs = 3 for nodes without rotations, or leave dofs empty",
            describe(*start),
            first + count
        ));
    }
    let count = dofs.unwrap_or(count);
    rows.iter_mut().zip(first..first + count).for_each(|(slot, row)| *slot = Some(row));
    Ok(rows)
}

/// Several points may be on one node, but a row cannot be different directions of two points.
fn require_one_direction(points: &InterfacePoints, placed: &[PlacedPoint]) -> Result<(), String> {
    let mut taken: HashMap<usize, (usize, &str)> = HashMap::new();
    let of_points = points.iter().zip(placed);
    for (point, rows) in of_points.flat_map(|(point, nodes)| nodes.iter().map(move |(rows, _)| (point, rows))) {
        for (dof, row) in rows.iter().enumerate().filter_map(|(dof, row)| Some((dof, (*row)?))) {
            let (other, name) = *taken.entry(row).or_insert((dof, &point.name));
            if other != dof {
                return Err(format!(
                    "row {row} (counted from 0) is direction {} of point {name} and {} of point {}: the matrices have one of them there",
                    DOF_NAMES[other], DOF_NAMES[dof], point.name
                ));
            }
        }
    }
    Ok(())
}

fn describe(label: DofLabel) -> String {
    match DOF_NAMES.get(label.dof) {
        Some(name) => format!("node {} {name}", label.node),
        None if label.dof == SCALAR => format!("modal coordinate {}", label.node),
        None => format!("node {} direction {}", label.node, label.dof),
    }
}
