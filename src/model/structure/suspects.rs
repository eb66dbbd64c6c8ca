//! Signs of exchanged files and mixed units, in time proportional to the entries and before any work.
//!
//! In a mesh of size h a node vibrates alone with `omega^2 = K_ii / M_ii` of about `(2 c / h)^2`, where c is the speed of sound:
//! 3,000 to 6,000 m/s in metals. So `c = omega h / 2` tells stiffness and mass in different units apart.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use sprs::CsMat;

use super::error::StructureError;
use super::label::SCALAR;
use super::model::FeModel;
use super::motions::places_of_distinct;
use super::points::PointPlace;

/// A finite element model has modes far beyond this frequency in Hz.
const LEAST_HIGHEST_HZ: f64 = 1.0;
/// Speeds of sound in m/s of meshes in consistent units; stiffness in N/mm beside kg divides by 32.
const SOUND_M_S: [f64; 2] = [700.0, 4e4];
/// Most of such an estimate without coordinates, m/s.
const MOST_ROUGH_M_S: f64 = 2e5;
/// Sizes of elements in m, by the ratio of their stiffness against rotation and displacement.
const ELEMENT_M: [f64; 2] = [2e-4, 10.0];
/// Fewest nodes of a mesh.
const LEAST_NODES: usize = 30;
/// A matrix with a larger share of entries has no mesh.
const MOST_FULL: f64 = 0.6;
/// Density of steel in kg/m3; others count with the third root.
const DENSITY_KG_M3: f64 = 7850.0;

/// Diagonal of a matrix.
fn diagonal(matrix: &CsMat<f64>) -> Vec<f64> {
    matrix.outer_iterator().enumerate().map(|(row, view)| view.get(row).copied().unwrap_or(0.0)).collect()
}

/// Refuses matrices in which no row is stiff for its mass.
///
/// # Errors
/// Stiffness and mass that look exchanged.
pub(super) fn require_order(model: &FeModel) -> Result<(), StructureError> {
    let (stiffness, mass) = (diagonal(model.stiffness()), diagonal(model.mass()));
    let ratios = stiffness.iter().zip(&mass).filter(|(_, mass)| **mass > 0.0).map(|(stiffness, mass)| stiffness / mass);
    let Some(highest) = ratios.reduce(f64::max) else { return Ok(()) };
    let highest_hz = highest.sqrt() / TAU;
    if highest_hz >= LEAST_HIGHEST_HZ {
        return Ok(());
    }
    Err(StructureError::Exchanged { highest_hz })
}

/// Whether stiffness and mass look as if they were in different units.
pub(super) fn mixed_units(model: &FeModel, mass_kg: Option<[f64; 3]>) -> bool {
    !is_full(model) && Nodes::of(model).sound(model, mass_kg).is_some()
}

/// A reduced model is full.
fn is_full(model: &FeModel) -> bool {
    let order = model.order() as f64;
    model.stiffness().nnz() as f64 > MOST_FULL * order * order
}

/// Remarks on units from the sizes of stiffness and mass, one sentence each. `mass_kg`: along x, y, z, if known.
pub(super) fn remarks(model: &FeModel, mass_kg: Option<[f64; 3]>) -> Vec<String> {
    if is_full(model) {
        return Vec::new();
    }
    let nodes = Nodes::of(model);
    nodes.sound(model, mass_kg).into_iter().chain(nodes.rotations()).chain(rotation_nodes(model)).collect()
}

/// Diagonals of nodes.
struct Nodes {
    /// Stiffness and mass per node and direction; 0 if a node has none.
    nodes: Vec<(usize, [f64; 6], [f64; 6])>,
}

impl Nodes {
    /// Consecutive rows of one node; without labels three rows are one.
    fn of(model: &FeModel) -> Self {
        let (stiffness, mass) = (diagonal(model.stiffness()), diagonal(model.mass()));
        let mut nodes: Vec<(usize, [f64; 6], [f64; 6])> = Vec::new();
        let mut last = None;
        for row in 0..model.order() {
            let (node, dof) = match model.labels().get(row) {
                Some(label) => (label.node, label.dof),
                None => ((row / 3) as i64, row % 3),
            };
            if dof >= SCALAR {
                continue;
            }
            let begins = nodes.last().is_none_or(|(_, known, _)| known[dof] != 0.0);
            if last != Some(node) || begins {
                nodes.push((row, [0.0; 6], [0.0; 6]));
                last = Some(node);
            }
            if let Some((_, k, m)) = nodes.last_mut() {
                (k[dof], m[dof]) = (stiffness[row], mass[row]);
            }
        }
        Self { nodes }
    }

    /// Speed of sound from stiffness, mass and size of the mesh, if it is far from any metal's.
    fn sound(&self, model: &FeModel, mass_kg: Option<[f64; 3]>) -> Option<String> {
        let omega = |(row, k, m): &(usize, [f64; 6], [f64; 6])| {
            // A chain of masses that move one way is no mesh.
            if m[..3].iter().filter(|mass| **mass > 0.0).count() < 2 {
                return None;
            }
            let ratios = (0..3).filter(|axis| m[*axis] > 0.0).map(|axis| k[axis] / m[axis]);
            ratios.reduce(f64::max).map(|ratio| (*row, ratio.sqrt()))
        };
        let omegas: Vec<(usize, f64)> = self.nodes.iter().filter_map(omega).collect();
        if omegas.len() < LEAST_NODES {
            return None;
        }
        let places = places_of_distinct(model);
        let nearest = |row: usize| nearest_m(model, &places, row);
        let exact = omegas.iter().filter_map(|(row, omega)| Some(0.5 * omega * nearest(*row)?));
        let exact: Vec<f64> = exact.collect();
        let (c, range) = if exact.len() >= LEAST_NODES {
            (median(exact)?, SOUND_M_S)
        } else {
            let count = self.nodes.len() as f64;
            let omega = median(omegas.into_iter().map(|(_, omega)| omega).collect())?;
            let speed = |size_m: f64| 0.5 * omega * size_m;
            let by_length = speed(extent_m(model)? / libm::cbrt(count));
            let by_mass = speed(libm::cbrt(mass_kg?.into_iter().fold(0.0, f64::max) / DENSITY_KG_M3 / count));
            let [least, _] = SOUND_M_S;
            // Both err to one side for beams and plates, each to its own.
            let c = if by_length < least { by_length.max(by_mass) } else { by_length.min(by_mass) };
            (c, [least, MOST_ROUGH_M_S])
        };
        let [least, most] = range;
        (c > 0.0 && !(least..=most).contains(&c)).then(|| {
            format!(
                "{} look as if they were in different units: with this mesh sound would travel at {c:.0e} m/s, in \
                 metals at 3e3 to 6e3 ({}); does `units` match all files?",
                if c < least { "stiffness and mass" } else { "stiffness, mass and coordinates" },
                if c < least { "N/mm beside kg gives 1e2" } else { "coordinates in mm with matrices in m give 5e6" }
            )
        })
    }

    /// The size of elements by the ratio of stiffness against rotation to that against displacement.
    fn rotations(&self) -> Option<String> {
        let size = |(_, k, _): &(usize, [f64; 6], [f64; 6])| {
            let turning = median(k[3..].iter().copied().filter(|value| *value > 0.0).collect())?;
            let moving = k[..3].iter().copied().filter(|value| *value > 0.0).reduce(f64::min)?;
            Some((turning / moving).sqrt())
        };
        let sizes: Vec<f64> = self.nodes.iter().filter_map(size).collect();
        let telling = sizes.len() >= LEAST_NODES.min(self.nodes.len()) && sizes.len() > 7;
        let size_m = median(sizes).filter(|_| telling)?;
        let [least, most] = ELEMENT_M;
        (!(least..=most).contains(&size_m)).then(|| {
            format!(
                "stiffnesses against rotation and displacement are in the ratio of elements of {size_m:.0e} m: does \
                 `units` match the matrices (mm, kg, s are \"mm_kg_s\", mm, t, s \"mm_t_s\")?"
            )
        })
    }
}

/// Rotation nodes that are of another body than the node of their point.
fn rotation_nodes(model: &FeModel) -> Option<String> {
    let columns = |row: usize| -> Vec<usize> {
        let view = model.stiffness().outer_view(row);
        view.iter().flat_map(|view| view.iter()).filter(|(_, value)| **value != 0.0).map(|(column, _)| column).collect()
    };
    model.points().iter().find_map(|point| {
        let PointPlace::Node { node, rotation_node: Some(rotation) } = &point.place else { return None };
        let rows = model.rows_of(&point.name).ok()?;
        let of = |rows: &[Option<usize>]| rows.iter().flatten().flat_map(|row| columns(*row)).collect::<BTreeSet<_>>();
        let (moved, turned) = (of(&rows[..3]), of(&rows[3..]));
        let shared = moved.intersection(&turned).count();
        (node != rotation && !moved.is_empty() && !turned.is_empty() && 2 * shared < moved.len().min(turned.len())).then(|| {
            format!(
                "point {}: rotation_node {rotation} is joined to other rows than node {node} ({shared} in common): does \
                 it belong to another rigid body?",
                point.name
            )
        })
    })
}

/// Distance in m from the node of a row to the nearest node that it is coupled to; none if no places are known. The places of nodes that
/// CalculiX expands to shells and beams do not tell their distances, so `places` is without them.
fn nearest_m(model: &FeModel, places: &BTreeMap<i64, [f64; 3]>, row: usize) -> Option<f64> {
    let own = model.labels().get(row)?;
    let here = places.get(&own.node)?;
    let others = model.stiffness().outer_view(row)?;
    let mut nearest: Option<f64> = None;
    let mut last = own.node;
    for (column, _) in others.iter() {
        let node = model.labels().get(column)?.node;
        if node == last || node == own.node {
            continue;
        }
        last = node;
        let Some(there) = places.get(&node) else { continue };
        let distance = here.iter().zip(there).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        if distance > 0.0 && nearest.is_none_or(|nearest| distance < nearest) {
            nearest = Some(distance);
        }
    }
    nearest
}

/// Size in m of the model from known positions: the diagonal of the box around nodes and points, or the largest distance from the origin.
fn extent_m(model: &FeModel) -> Option<f64> {
    let points = model.points().iter().map(|point| point.position_m);
    let places: Vec<[f64; 3]> = model.positions_m().values().copied().chain(points).collect();
    let spread = |axis: usize| {
        let values = || places.iter().map(|place| place[axis]);
        values().fold(0.0, f64::max) - values().fold(0.0, f64::min)
    };
    let extent = (0..3).map(|axis| spread(axis) * spread(axis)).sum::<f64>().sqrt();
    (extent > 0.0).then_some(extent)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
