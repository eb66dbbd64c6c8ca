//! A finite element model: mass, stiffness and the points that other parts act on.

use std::collections::BTreeMap;

use sprs::CsMat;

use super::constraints::eliminate;
use super::error::StructureError;
use super::idle;
use super::import::symmetric;
use super::label::{DofLabel, SCALAR};
use super::matrices::ModelMatrices;
use super::place::{PlacedPoint, PointRows, place, require_distinct};
use super::points::{InterfacePoint, InterfacePoints, PointPlace};
use decore_math::linalg::lowest_eigenvalue;

/// A mass matrix whose lowest eigenvalue, relative to the diagonal, lies below this is not positive semidefinite: rounding
/// in exported matrices stays above it.
const LEAST_MASS_EIGENVALUE: f64 = -1e-8;

/// Entries below this share of a matrix' largest diagonal are rounding where there ought to be none: in rows without mass, and as the
/// stiffness of a motion that nothing holds.
const ROUNDING: f64 = 1e-12;

/// Places of a node may differ by this many metres, and this share.
const SAME_PLACE: f64 = 2e-3;

/// Finite element matrices of a machine with its interface points.
///
/// `M u'' + D u' + K u = F` in SI units; the matrices are symmetric and hold both triangles. M is positive semidefinite (DOFs
/// may have no mass), K may be singular. A value of this type has passed [`FeModel::new`].
#[derive(Debug, Clone)]
pub struct FeModel {
    matrices: ModelMatrices,
    points: InterfacePoints,
    /// Rows of the nodes of every point.
    rows: Vec<PlacedPoint>,
    /// Known positions of nodes in m: from the list of rows and the interface points.
    positions_m: BTreeMap<i64, [f64; 3]>,
    /// Nodes and points for which points and list of rows name different places.
    misplaced: Vec<Misplaced>,
    /// Doubts about the files, one sentence each.
    doubts: Vec<String>,
    /// Changes to the matrices, one sentence each.
    changes: Vec<String>,
}

/// A node, or a point that is the mean of nodes, for which two files name different places.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Misplaced {
    /// The node or the point in words.
    pub name: String,
    /// Position in m from the table of points.
    pub by_points_m: [f64; 3],
    /// Position in m from the list of rows.
    pub by_rows_m: [f64; 3],
}

/// The names that errors use for the sources.
#[derive(Debug, Clone)]
pub(super) struct Sources {
    pub mass: String,
    pub stiffness: String,
    pub damping: String,
    pub labels: String,
    pub points: String,
}

impl FeModel {
    /// A model from matrices in memory, both triangles stored, SI units.
    ///
    /// # Errors
    /// Sizes that differ, a matrix that is not square, not symmetric or not finite, a mass matrix that is not positive
    /// semidefinite, a negative diagonal of the stiffness, a point without a place in the matrices.
    pub fn new(matrices: ModelMatrices, points: InterfacePoints) -> Result<Self, StructureError> {
        let [mass, stiffness, damping, labels, points_name] =
            ["mass", "stiffness", "damping", "labels", "points"].map(str::to_owned);
        Self::validated(matrices, points, &Sources { mass, stiffness, damping, labels, points: points_name })
    }

    pub(super) fn validated(
        matrices: ModelMatrices,
        mut points: InterfacePoints,
        names: &Sources,
    ) -> Result<Self, StructureError> {
        let ModelMatrices { mass, stiffness, damping, labels } = matrices;
        let mut mass = sound(&names.mass, mass)?;
        clear_rounding(&mut mass);
        let stiffness = sound(&names.stiffness, stiffness)?;
        let damping = damping.map(|damping| sound(&names.damping, damping)).transpose()?;
        let mut matrices = ModelMatrices { mass, stiffness, damping, labels };
        let order = matrices.mass.rows();
        let others = [(&names.stiffness, Some(&matrices.stiffness)), (&names.damping, matrices.damping.as_ref())];
        for (name, matrix) in others.into_iter().filter_map(|(name, matrix)| Some((name, matrix?))) {
            if matrix.rows() != order {
                let reason =
                    format!("{} rows, but the mass {} has {order}: both must be equal", matrix.rows(), names.mass);
                return Err(fault(name, reason));
            }
        }
        let placed = place(&matrices.labels, order, &points).unwrap_or_default();
        let kept = placed.into_iter().flatten().flat_map(|(rows, _)| rows).flatten().collect();
        let mut changes = eliminate(&mut matrices, &kept).map_err(|reason| fault(&names.stiffness, reason))?;
        let others = [(&names.stiffness, Some(&matrices.stiffness)), (&names.damping, matrices.damping.as_ref())];
        for (name, matrix) in others.into_iter().filter_map(|(name, matrix)| Some((name, matrix?))) {
            if let Some((row, value)) = negative_diagonal(matrix) {
                return Err(fault(name, format!("diagonal {} is {value:e}: it must not be negative", row + 1)));
            }
        }
        require_entries(&names.mass, &matrices.mass)?;
        require_mass(&names.mass, &matrices.mass)?;
        require_entries(&names.stiffness, &matrices.stiffness)?;
        if !matrices.labels.is_empty() && matrices.labels.len() != order {
            let reason = format!("{order} rows, but {} labels of rows", matrices.labels.len());
            return Err(fault(&names.mass, reason));
        }
        require_distinct(&matrices.labels, &points).map_err(|reason| fault(&names.labels, reason))?;
        let rows = place(&matrices.labels, order, &points).map_err(|reason| fault(&names.points, reason))?;
        points.state_dofs(rows.iter().flat_map(|nodes| nodes.iter().take(1)).map(|(rows, _)| rows));
        let nodes_of = |(point, nodes): (&'_ InterfacePoint, &'_ PlacedPoint)| {
            nodes.iter().map(|(rows, _)| (point.name.clone(), *rows)).collect::<Vec<_>>()
        };
        let of_points: Vec<(String, PointRows)> = points.iter().zip(&rows).flat_map(nodes_of).collect();
        changes.extend(idle::leave_out(&mut matrices, &of_points));
        let node_of = |rows: &PointRows| rows[..3].iter().flatten().next().and_then(|row| matrices.labels.get(*row));
        let placed = rows.iter().zip(points.iter()).filter_map(|(nodes, point)| match nodes[..] {
            [(rows, _)] => Some((node_of(&rows)?, point)),
            _ => None,
        });
        let positions_m = placed.map(|(label, point)| (label.node, point.position_m)).collect();
        Ok(Self { matrices, points, rows, positions_m, misplaced: Vec::new(), doubts: Vec::new(), changes })
    }

    /// Adds positions of nodes, in the unit of the matrices' file. Positions of interface points have priority.
    pub(super) fn with_positions(mut self, positions: BTreeMap<i64, [f64; 3]>, metres: f64) -> Self {
        for (node, place) in positions {
            let place = place.map(|value| metres * value);
            let known = *self.positions_m.entry(node).or_insert(place);
            if are_apart(known, place) {
                self.misplaced.push(Misplaced { name: format!("node {node}"), by_points_m: known, by_rows_m: place });
            }
        }
        for point in self.points.iter() {
            let PointPlace::Nodes(nodes) = &point.place else { continue };
            let places: Option<Vec<_>> =
                nodes.iter().map(|(node, weight)| Some((self.positions_m.get(&node)?, weight))).collect();
            let Some(places) = places else { continue };
            let mean = |axis: usize| places.iter().map(|(place, weight)| weight * place[axis]).sum();
            let by_rows_m = [0, 1, 2].map(mean);
            if are_apart(point.position_m, by_rows_m) {
                let name = format!("point {} (the mean of its nodes)", point.name);
                self.misplaced.push(Misplaced { name, by_points_m: point.position_m, by_rows_m });
            }
        }
        self
    }

    /// The model over coordinates in which every matrix is `change` of what it was, and points have other rows.
    pub(super) fn over(&self, change: impl Fn(&CsMat<f64>) -> CsMat<f64>, rows: Vec<PlacedPoint>) -> Self {
        let ModelMatrices { mass, stiffness, damping, labels } = &self.matrices;
        let matrices = ModelMatrices {
            mass: change(mass),
            stiffness: change(stiffness),
            damping: damping.as_ref().map(change),
            labels: labels.clone(),
        };
        Self {
            matrices,
            rows,
            points: self.points.clone(),
            positions_m: self.positions_m.clone(),
            misplaced: self.misplaced.clone(),
            doubts: self.doubts.clone(),
            changes: self.changes.clone(),
        }
    }

    /// Adds doubts about the files.
    pub(super) fn with_doubts(mut self, doubts: impl IntoIterator<Item = String>) -> Self {
        self.doubts.extend(doubts);
        self
    }

    /// Changes to the matrices: eliminated multipliers, held rows left out.
    pub(super) fn changes(&self) -> &[String] {
        &self.changes
    }

    /// Doubts about the files.
    pub(super) fn doubts(&self) -> &[String] {
        &self.doubts
    }

    /// Nodes and points for which points and list of rows name different places.
    pub(super) fn misplaced(&self) -> &[Misplaced] {
        &self.misplaced
    }

    /// The mass matrix, both triangles.
    pub fn mass(&self) -> &CsMat<f64> {
        &self.matrices.mass
    }

    /// The stiffness matrix, both triangles.
    pub fn stiffness(&self) -> &CsMat<f64> {
        &self.matrices.stiffness
    }

    /// The damping matrix, both triangles, if the model has one.
    pub fn damping(&self) -> Option<&CsMat<f64>> {
        self.matrices.damping.as_ref()
    }

    /// Labels of the rows; empty if they are not known.
    pub fn labels(&self) -> &[DofLabel] {
        &self.matrices.labels
    }

    /// All matrices with the labels of their rows.
    pub fn matrices(&self) -> &ModelMatrices {
        &self.matrices
    }

    /// The interface points.
    pub fn points(&self) -> &InterfacePoints {
        &self.points
    }

    /// Rows of the six DOFs of a point; `None` for a DOF that the model does not have (an element type without rotations,
    /// a DOF that is fixed or was condensed). Of several nodes: rows of the first one, for DOFs that all of them have.
    ///
    /// # Errors
    /// An unknown point.
    pub fn rows_of(&self, point: &str) -> Result<[Option<usize>; 6], StructureError> {
        let nodes = self.nodes_of(point)?;
        let first = nodes.first().map(|(rows, _)| *rows).unwrap_or_default();
        let all = |dof: usize| nodes.iter().all(|(rows, _)| rows[dof].is_some());
        Ok(std::array::from_fn(|dof| first[dof].filter(|_| all(dof))))
    }

    /// Rows of the nodes of a point with their weights.
    pub(super) fn nodes_of(&self, point: &str) -> Result<&[(PointRows, f64)], StructureError> {
        self.points.get(point)?;
        let index = self.points.iter().position(|other| other.name == point);
        Ok(index.and_then(|index| self.rows.get(index)).map(Vec::as_slice).unwrap_or_default())
    }

    /// Rows of all nodes of all points, point by point.
    pub(super) fn placed(&self) -> &[PlacedPoint] {
        &self.rows
    }

    /// Rows of all nodes of all points.
    pub(super) fn rows_of_points(&self) -> impl Iterator<Item = &PointRows> {
        self.rows.iter().flatten().map(|(rows, _)| rows)
    }

    /// Whether a row carries mass or stiffness; programs leave empty rows for DOFs that they fixed themselves and for
    /// directions that no element has.
    pub fn carries(&self, row: usize) -> bool {
        let entries = |matrix: &CsMat<f64>| {
            matrix.outer_view(row).is_some_and(|view| view.data().iter().any(|value| *value != 0.0))
        };
        entries(&self.matrices.stiffness) || entries(&self.matrices.mass)
    }

    /// Known positions of nodes in m.
    pub(super) fn positions_m(&self) -> &BTreeMap<i64, [f64; 3]> {
        &self.positions_m
    }

    /// Rows that are rotations, by their label or by an interface point.
    pub(super) fn rotation_rows(&self) -> Vec<usize> {
        let rotation = |dof: usize| (3..SCALAR).contains(&dof);
        let labelled = self.labels().iter().enumerate().filter(|(_, label)| rotation(label.dof)).map(|(row, _)| row);
        labelled.chain(self.rows_of_points().flat_map(|rows| rows[3..].iter().copied().flatten())).collect()
    }

    /// Mass, stiffness and damping for changes; the model must stay valid.
    pub(super) fn matrices_mut(&mut self) -> [Option<&mut CsMat<f64>>; 3] {
        let ModelMatrices { mass, stiffness, damping, .. } = &mut self.matrices;
        [Some(mass), Some(stiffness), damping.as_mut()]
    }

    /// Number of degrees of freedom.
    pub fn order(&self) -> usize {
        self.matrices.mass.rows()
    }
}

fn fault(file: &str, reason: String) -> StructureError {
    StructureError::Matrix { file: file.to_owned(), reason }
}

/// Whether two places of a node in m contradict each other.
fn are_apart(known: [f64; 3], place: [f64; 3]) -> bool {
    let largest = |values: [f64; 3]| values.iter().map(|value| value.abs()).fold(0.0, f64::max);
    largest([0, 1, 2].map(|axis| known[axis] - place[axis])) > SAME_PLACE * (1.0 + largest(known))
}

/// Square, finite, symmetric except for rounding; the mean of mirrored entries is taken.
fn sound(file: &str, matrix: CsMat<f64>) -> Result<CsMat<f64>, StructureError> {
    if matrix.rows() != matrix.cols() {
        return Err(fault(file, format!("not square: {} rows, {} columns", matrix.rows(), matrix.cols())));
    }
    if matrix.data().iter().any(|value| !value.is_finite()) {
        return Err(fault(file, "an entry is not finite".to_owned()));
    }
    symmetric(file, matrix)
}

/// Sets the entries of rows without mass to 0 where rounding alone makes them other: elements with reduced integration leave 1e-19 there.
fn clear_rounding(mass: &mut CsMat<f64>) {
    let diagonal = diagonal(mass);
    let least = ROUNDING * largest(&diagonal);
    let is_rounding = |row: usize| {
        diagonal[row] <= 0.0
            && mass.outer_view(row).is_some_and(|view| view.iter().all(|(_, value)| value.abs() <= least))
    };
    let empty: Vec<bool> = (0..mass.rows()).map(is_rounding).collect();
    for (row, mut view) in mass.outer_iterator_mut().enumerate() {
        for (column, value) in view.iter_mut() {
            if empty[row] || empty[column] {
                *value = 0.0;
            }
        }
    }
}

fn diagonal(matrix: &CsMat<f64>) -> Vec<f64> {
    (0..matrix.rows()).map(|row| matrix.get(row, row).copied().unwrap_or(0.0)).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// The first diagonal below 0 by more than rounding.
fn negative_diagonal(matrix: &CsMat<f64>) -> Option<(usize, f64)> {
    let diagonal = diagonal(matrix);
    let least = -ROUNDING * largest(&diagonal);
    diagonal.into_iter().enumerate().find(|(_, value)| *value < least)
}

fn require_entries(file: &str, matrix: &CsMat<f64>) -> Result<(), StructureError> {
    if matrix.data().iter().all(|value| *value == 0.0) {
        return Err(fault(file, "every entry is 0: is this the file and the matrix that was meant?".to_owned()));
    }
    Ok(())
}

/// Positive semidefinite: no negative diagonal, no coupling of a DOF without mass, no negative eigenvalue that stands out.
fn require_mass(file: &str, mass: &CsMat<f64>) -> Result<(), StructureError> {
    if let Some((row, value)) = negative_diagonal(mass) {
        return Err(fault(file, format!("diagonal {} is {value:e}: a mass is not negative", row + 1)));
    }
    for (row, view) in mass.outer_iterator().enumerate() {
        if mass.get(row, row).copied().unwrap_or(0.0) == 0.0
            && let Some((column, value)) = view.iter().find(|(_, value)| **value != 0.0)
        {
            let reason = format!(
                "diagonal {0} is 0, but entry ({0}, {1}) is {value:e}: a DOF without mass must not be coupled",
                row + 1,
                column + 1
            );
            return Err(fault(file, reason));
        }
    }
    let lowest = lowest_eigenvalue(mass).map_err(|error| fault(file, error.to_string()))?;
    if lowest < LEAST_MASS_EIGENVALUE {
        let reason = format!(
            "the mass matrix is not positive semidefinite: scaled to a diagonal of 1 it has the eigenvalue {lowest:.3e}"
        );
        return Err(fault(file, reason));
    }
    Ok(())
}
