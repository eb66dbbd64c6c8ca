//! Rigid motions of a model from the labels of its rows, and the mass that they move.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use sprs::CsMat;

use super::balance::{Balance, Rotated, Turned, rotated, under_motions, under_rotations};
use super::label::SCALAR;
use super::model::FeModel;
use super::partition::sparse_times;
use super::seeming::Seeming;
use decore_math::linalg::{LinalgError, SymmetricPencil};

/// Up to this share of rows out of balance, labels are taken as they are.
const DOUBT: f64 = 0.1;
/// Above this share of rows out of balance under translations labels are wrong. In a slab of two layers on rigid ground half of the rows
/// are next to held ones.
pub(super) const MOST_TRANSLATED: f64 = 0.6;
/// The same under rotations, of the rows that are in balance under translations.
pub(super) const MOST_ROTATED: f64 = 0.4;
/// Above this [`Turned::strain`] labels or places are wrong. Right models of CalculiX stay below 0.06, wrong ones are above 0.8.
pub(super) const MOST_STRAIN: f64 = 0.3;
/// Fewest rows of which a share is telling: a small model may be held in most of its rows.
const LEAST_ROWS: usize = 48;
/// A reduced model is full, and its supports are spread over all rows.
const MOST_FULL: f64 = 0.6;

/// Unit motions of a rigid machine and the mass that goes with them.
pub(super) struct RigidMotions {
    /// Translations along x, y, z.
    pub translations: DMatrix<f64>,
    /// Mass along x, y, z in kg.
    pub mass_kg: [f64; 3],
    /// Centre of mass in m, or how many of the nodes with mass have no known place, and of how many.
    pub centre_m: Result<[f64; 3], (usize, usize)>,
    /// Balance under translations, where it is telling.
    pub translated: Option<Balance>,
    /// Loads by rotations, if positions of nodes are known and the loads are conclusive.
    pub rotated: Option<Turned>,
}

impl RigidMotions {
    /// By the labels of the rows; `None` if there are none.
    pub fn new(model: &FeModel) -> Option<Self> {
        if model.labels().is_empty() {
            return None;
        }
        let directions = directions(model);
        let mut translations = translations(&directions);
        let telling = is_telling(model.stiffness());
        let mut translated = under_motions(model.stiffness(), &translations);
        let mut seeming = vec![false; model.order()];
        if telling
            && translated.share() > DOUBT
            && let Some(found) = Seeming::find(model, &directions, &translated)
        {
            (seeming, translations, translated) = (found.rows, found.translations, found.balance);
        }
        let inertia = sparse_times(model.mass(), &translations);
        let mass_kg = [0, 1, 2].map(|axis| translations.column(axis).dot(&inertia.column(axis)));
        let rotated = telling.then(|| rotation_balance(model, (&directions, &seeming), &translated)).flatten();
        let centre_m = centre(model, (&directions, &seeming), (&inertia, mass_kg));
        let translated = Some(translated).filter(|balance| telling && balance.loaded() >= LEAST_ROWS);
        Some(Self { translations, mass_kg, centre_m, translated, rotated })
    }
}

/// Whether a share of rows out of balance is conclusive: many rows, sparse.
fn is_telling(stiffness: &CsMat<f64>) -> bool {
    let order = stiffness.rows() as f64;
    stiffness.rows() >= LEAST_ROWS && (stiffness.nnz() as f64) < MOST_FULL * order * order
}

/// Direction of each row: displacement 0 to 2, rotation 3 to 5, or neither. Interface points know of rotations that labels call
/// displacements (rotation nodes).
fn directions(model: &FeModel) -> Vec<Option<usize>> {
    let mut directions: Vec<Option<usize>> =
        model.labels().iter().map(|label| Some(label.dof).filter(|dof| *dof < SCALAR)).collect();
    for rows in model.rows_of_points() {
        for (dof, row) in rows.iter().enumerate().skip(3) {
            if let Some(slot) = row.and_then(|row| directions.get_mut(row)) {
                *slot = Some(dof);
            }
        }
    }
    directions
}

pub(super) fn translations(directions: &[Option<usize>]) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(directions.len(), 3);
    for (row, dof) in directions.iter().enumerate() {
        if let Some(axis @ 0..3) = *dof {
            out[(row, axis)] = 1.0;
        }
    }
    out
}

/// Gives the free rows of motions the values that strain the model least, the other rows as they are.
fn relax(stiffness: &CsMat<f64>, free: &[bool], motions: &mut DMatrix<f64>) -> Result<(), LinalgError> {
    if !free.contains(&true) {
        return Ok(());
    }
    for row in (0..free.len()).filter(|row| free[*row]) {
        motions.row_mut(row).fill(0.0);
    }
    let force = sparse_times(stiffness, motions);
    let pencil = SymmetricPencil::new(stiffness, stiffness, free)?;
    let mut values = DMatrix::zeros(pencil.order(), motions.ncols());
    for (position, &row) in pencil.rows().iter().enumerate() {
        values.row_mut(position).copy_from(&-force.row(row as usize));
    }
    pencil.cholesky(0.0)?.solve(&mut values)?;
    for (position, &row) in pencil.rows().iter().enumerate() {
        motions.row_mut(row as usize).copy_from(&values.row(position));
    }
    Ok(())
}

/// Places of nodes whose rows stand for one point each: CalculiX repeats the labels of nodes that it expands.
pub(super) fn places_of_distinct(model: &FeModel) -> BTreeMap<i64, [f64; 3]> {
    let mut counts: BTreeMap<(i64, usize), usize> = BTreeMap::new();
    model.labels().iter().for_each(|label| *counts.entry((label.node, label.dof)).or_default() += 1);
    let repeated: std::collections::BTreeSet<i64> =
        counts.iter().filter(|(_, count)| **count > 1).map(|((node, _), _)| *node).collect();
    let known = model.positions_m().iter().filter(|(node, _)| !repeated.contains(node));
    known.map(|(node, place)| (*node, *place)).collect()
}

/// Rows that supports already load under translations are not conclusive for rotations.
fn rotation_balance(
    model: &FeModel,
    (directions, seeming): (&[Option<usize>], &[bool]),
    translated: &Balance,
) -> Option<Turned> {
    let places = places_of_distinct(model);
    let mut rows = rotated(model, directions, &places);
    rows.iter_mut().zip(seeming).filter(|(_, seeming)| **seeming).for_each(|(row, _)| *row = Rotated::Unknown);
    let node_places: Vec<Option<[f64; 3]>> =
        model.labels().iter().map(|label| places.get(&label.node).copied()).collect();
    let turned = under_rotations(model.stiffness(), &rows, &node_places, translated);
    Some(turned).filter(|turned| turned.balance.loaded() >= LEAST_ROWS)
}

/// From the coupling of translations t and rotations r about the origin: `t_y' M r_z = m x`, `t_x' M r_z = -m y`,
/// `t_y' M r_x = -m z`.
fn centre(
    model: &FeModel,
    (directions, seeming): (&[Option<usize>], &[bool]),
    (inertia, [m_x, m_y, _]): (&DMatrix<f64>, [f64; 3]),
) -> Result<[f64; 3], (usize, usize)> {
    let mut rotations: DMatrix<f64> = DMatrix::zeros(model.order(), 3);
    let mut nodes = BTreeMap::new();
    for (row, (label, direction)) in model.labels().iter().zip(directions).enumerate() {
        match *direction {
            Some(axis @ 3..) => rotations[(row, axis - 3)] = 1.0,
            Some(axis) if !seeming[row] && model.mass().outer_view(row).is_some_and(|view| view.nnz() > 0) => {
                let place = model.positions_m().get(&label.node);
                nodes.insert(label.node, place.is_some());
                let Some(&[x, y, z]) = place else { continue };
                let [about_x, about_y, about_z] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]].map(|motion| motion[axis]);
                (rotations[(row, 0)], rotations[(row, 1)], rotations[(row, 2)]) = (about_x, about_y, about_z);
            }
            _ => {}
        }
    }
    let unknown = nodes.values().filter(|known| !**known).count();
    if unknown > 0 || m_x <= 0.0 || m_y <= 0.0 {
        return Err((unknown, nodes.len()));
    }
    // A rotation leaves inner shapes of elements at rest, but moves the rotations of rigid bodies.
    let loaded = under_motions(model.stiffness(), &rotations).out;
    let free: Vec<bool> = seeming.iter().zip(loaded).map(|(seeming, out)| *seeming && out == Some(true)).collect();
    if relax(model.stiffness(), &free, &mut rotations).is_err() {
        return Err((0, nodes.len()));
    }
    let coupling = |translation: usize, rotation: usize| inertia.column(translation).dot(&rotations.column(rotation));
    Ok([coupling(1, 2) / m_y, -coupling(0, 2) / m_x, -coupling(1, 0) / m_y])
}
