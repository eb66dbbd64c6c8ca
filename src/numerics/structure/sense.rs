//! What a model weighs, where, and what about it looks wrong: units, files exchanged, directions that have no mass.

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use sprs::CsMat;

use super::label::SCALAR;
use super::model::{FeModel, Misplaced};
use super::partition::sparse_times;
use super::points::DOF_NAMES;

/// Masses of machines in kg.
const MASS_KG: [f64; 2] = [1.0, 1e6];
/// Frequencies in Hz between which the lowest elastic mode of a machine lies.
const LOWEST_HZ: [f64; 2] = [0.01, 2e4];
/// Directions may differ by this share of the mass without a remark: rows that are held are left out by most programs.
const MASS_SPREAD: f64 = 0.05;
/// A finite element model has modes far beyond this frequency in Hz.
const LEAST_HIGHEST_HZ: f64 = 1.0;
/// A stiffness may lose all but this share of its digits by its condition.
const LEAST_DIGITS: f64 = 1e-3;
/// A machine that floats has so many modes at 0 Hz.
const MOST_RIGID: usize = 6;
/// Entries of a mass matrix add up, those of a stiffness cancel.
const LEAST_SUM: f64 = 1e-3;

/// Unit motions of a rigid machine and the mass that goes with them.
pub(super) struct RigidMotions {
    /// Translations along x, y, z.
    pub translations: DMatrix<f64>,
    /// Mass along x, y, z in kg.
    pub mass_kg: [f64; 3],
    /// Centre of mass in m, or how many of the nodes with mass have no known place, and of how many.
    pub centre_m: Result<[f64; 3], (usize, usize)>,
}

impl RigidMotions {
    /// By the labels of the rows; `None` where there are none.
    pub fn new(model: &FeModel) -> Option<Self> {
        if model.labels().is_empty() {
            return None;
        }
        let directions = directions(model);
        let mut translations = DMatrix::zeros(model.order(), 3);
        for (row, dof) in directions.iter().enumerate() {
            if let Some(axis @ 0..3) = *dof {
                translations[(row, axis)] = 1.0;
            }
        }
        let inertia = sparse_times(model.mass(), &translations);
        let mass_kg = [0, 1, 2].map(|axis| translations.column(axis).dot(&inertia.column(axis)));
        let centre_m = centre(model, &directions, (&inertia, mass_kg));
        Some(Self { translations, mass_kg, centre_m })
    }
}

/// What each row is: displacement 0 to 2, rotation 3 to 5, or neither. Interface points know of rotations that labels call
/// displacements (rotation nodes).
fn directions(model: &FeModel) -> Vec<Option<usize>> {
    let mut directions: Vec<Option<usize>> =
        model.labels().iter().map(|label| Some(label.dof).filter(|dof| *dof < SCALAR)).collect();
    for rows in model.points().iter().filter_map(|point| model.rows_of(&point.name).ok()) {
        for (dof, row) in rows.iter().enumerate().skip(3) {
            if let Some(slot) = row.and_then(|row| directions.get_mut(row)) {
                *slot = Some(dof);
            }
        }
    }
    directions
}

/// From the coupling of translations t and rotations r about the origin: `t_y' M r_z = m x`, `t_x' M r_z = -m y`,
/// `t_y' M r_x = -m z`.
fn centre(
    model: &FeModel,
    directions: &[Option<usize>],
    (inertia, [m_x, m_y, _]): (&DMatrix<f64>, [f64; 3]),
) -> Result<[f64; 3], (usize, usize)> {
    let mut rotations: DMatrix<f64> = DMatrix::zeros(model.order(), 3);
    let mut nodes = std::collections::BTreeMap::new();
    for (row, (label, direction)) in model.labels().iter().zip(directions).enumerate() {
        match *direction {
            Some(axis @ 3..) => rotations[(row, axis - 3)] = 1.0,
            Some(axis) if model.mass().outer_view(row).is_some_and(|view| view.nnz() > 0) => {
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
    let coupling = |translation: usize, rotation: usize| inertia.column(translation).dot(&rotations.column(rotation));
    Ok([coupling(1, 2) / m_y, -coupling(0, 2) / m_x, -coupling(1, 0) / m_y])
}

/// What the modes of a model have shown.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shown {
    /// Number of rigid-body motions.
    pub rigid: usize,
    /// Frequency of the lowest elastic mode in Hz, where that was looked for.
    pub lowest_hz: Option<f64>,
    /// Frequency in Hz below which modes were looked for, where there is none.
    pub none_below_hz: Option<f64>,
    /// Condition number of the stiffness scaled to a diagonal of 1, where it is known.
    pub condition: Option<f64>,
}

/// What looks wrong, one sentence each.
pub(super) fn remarks(model: &FeModel, rigid: Option<&RigidMotions>, shown: Shown) -> Vec<String> {
    let mut out = model.doubts().to_vec();
    let highest_hz = highest_ratio(model).sqrt() / TAU;
    if highest_hz < LEAST_HIGHEST_HZ || rigid.is_some_and(|rigid| !adds_up(model.mass(), rigid)) {
        out.push(format!(
            "stiffness and mass look exchanged: stiffness over mass reaches {highest_hz:.1e} Hz only, or the entries of the mass cancel"
        ));
    }
    if let Some(rigid) = rigid {
        let known: Vec<(f64, &str)> =
            rigid.mass_kg.into_iter().zip(DOF_NAMES).filter(|(mass, _)| *mass > 0.0).collect();
        let [least, most] = MASS_KG;
        if let Some((mass, axis)) = known.iter().find(|(mass, _)| !(least..=most).contains(mass)) {
            out.push(format!(
                "a mass of {mass:.3e} kg (along {axis}): machines have {least} to {most:e} kg; is `units` that of the matrices (mm, t, s are \"mm_t_s\"), or is it another matrix?"
            ));
        }
        let smallest = known.iter().map(|(mass, _)| *mass).fold(f64::INFINITY, f64::min);
        let largest = known.iter().map(|(mass, _)| *mass).fold(0.0, f64::max);
        if smallest < (1.0 - MASS_SPREAD) * largest {
            let axes: Vec<String> = known.iter().map(|(mass, axis)| format!("{axis} {mass:.4e}")).collect();
            out.push(format!(
                "the mass is not the same in all directions ({} kg): rows are held, or labels are wrong",
                axes.join(", ")
            ));
        }
    }
    if let Some(Misplaced { node, by_points_m, by_rows_m }) = model.misplaced().first() {
        out.push(format!(
            "node {node} lies at {by_points_m:?} m by the table of points, but at {by_rows_m:?} m by the list of rows: is the unit of the model another one?"
        ));
    }
    out.extend(loose_mass(model));
    if shown.rigid > MOST_RIGID {
        out.push(format!(
            "{} modes at 0 Hz: a machine that floats has {MOST_RIGID}; parts hang loose, move as a mechanism, or their stiffness is missing (is a file cut short?)",
            shown.rigid
        ));
    }
    out.extend(shown.condition.and_then(few_digits));
    if let Some(hz) = shown.none_below_hz {
        out.push(format!(
            "no mode below {hz} Hz (cutoff_hz): stiffness and mass may be in different units, or the cut-off is too low for this machine"
        ));
    }
    if let Some(hz) = shown.lowest_hz.filter(|hz| !(LOWEST_HZ[0]..=LOWEST_HZ[1]).contains(hz)) {
        out.push(format!("the lowest elastic mode lies at {hz:.3e} Hz: stiffness and mass may be in different units"));
    }
    out
}

/// A stiffness of which rounding leaves few digits.
fn few_digits(condition: f64) -> Option<String> {
    (condition * f64::EPSILON > LEAST_DIGITS).then(|| {
        format!(
            "the stiffness is ill-conditioned ({condition:.1e} when scaled to a diagonal of 1, by the rounding of double precision {:.0e}): fewer than three digits of the lowest frequencies may be right; are springs between nodes far stiffer than what is around them (1e3 to 1e6 times is enough), or is it nearly a mechanism?",
            condition * f64::EPSILON
        )
    })
}

/// Rows with mass that nothing holds; modal coordinates may be like that.
fn loose_mass(model: &FeModel) -> Option<String> {
    let diagonal = |matrix: &CsMat<f64>, row: usize| matrix.get(row, row).copied().unwrap_or(0.0);
    let modal = |row: usize| model.labels().get(row).is_some_and(|label| label.dof == SCALAR);
    let is_loose =
        |row: &usize| diagonal(model.mass(), *row) > 0.0 && diagonal(model.stiffness(), *row) == 0.0 && !modal(*row);
    let loose: Vec<usize> = (0..model.order()).filter(is_loose).collect();
    let first = *loose.first()?;
    let place = match model.labels().get(first).and_then(|label| Some((label.node, DOF_NAMES.get(label.dof)?))) {
        Some((node, dof)) => format!("node {node} {dof}"),
        None => format!("row {}", first + 1),
    };
    Some(format!(
        "{} with mass but no stiffness, the first {place}: nothing holds them; are they to be left out, or is the stiffness cut short?",
        if loose.len() == 1 { "1 row".to_owned() } else { format!("{} rows", loose.len()) }
    ))
}

/// Largest `K_ii / M_ii`: not above the largest squared circular frequency.
fn highest_ratio(model: &FeModel) -> f64 {
    let diagonal = |matrix: &CsMat<f64>, row: usize| matrix.get(row, row).copied().unwrap_or(0.0);
    let ratio = |row: usize| Some(diagonal(model.mass(), row)).filter(|m| *m > 0.0).map(|m| (row, m));
    let ratios = (0..model.order()).filter_map(ratio).map(|(row, mass)| diagonal(model.stiffness(), row) / mass);
    ratios.fold(0.0, f64::max)
}

/// Whether the entries between displacements along one axis sum to a fair share of their magnitudes.
fn adds_up(mass: &CsMat<f64>, rigid: &RigidMotions) -> bool {
    (0..3).all(|axis| {
        let along = rigid.translations.column(axis);
        let entries = mass.iter().filter(|(_, (row, column))| along[*row] != 0.0 && along[*column] != 0.0);
        let magnitude: f64 = entries.map(|(value, _)| value.abs()).sum();
        rigid.mass_kg[axis] >= LEAST_SUM * magnitude
    })
}
