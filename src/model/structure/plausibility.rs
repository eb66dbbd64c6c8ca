//! Mass properties of a model, and signs of mistakes: units, exchanged files, directions without mass.

use sprs::CsMat;

use super::digits;
use super::label::SCALAR;
use super::model::{FeModel, Misplaced};
use super::motions::{MOST_ROTATED, MOST_STRAIN, MOST_TRANSLATED, RigidMotions};
use super::points::DOF_NAMES;
use super::suspects;

/// Masses of machines in kg.
const MASS_KG: [f64; 2] = [1.0, 1e6];
/// Frequencies in Hz between which the lowest elastic mode of a machine lies.
const LOWEST_HZ: [f64; 2] = [0.01, 2e4];
/// Directions may differ by this share of the mass without a remark: rows that are held are left out by most programs.
const MASS_SPREAD: f64 = 0.05;
/// A stiffness may lose all but this share of its digits by its condition.
const LEAST_DIGITS: f64 = 1e-3;
/// A machine that floats has so many modes at 0 Hz.
const MOST_RIGID: usize = 6;
/// Entries of a mass matrix add up, entries of a stiffness matrix cancel.
const LEAST_SUM: f64 = 1e-3;

/// Properties that a model's modes show.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shown {
    /// Number of rigid-body motions.
    pub rigid: usize,
    /// Frequency of the lowest elastic mode in Hz, where that was looked for.
    pub lowest_hz: Option<f64>,
    /// Frequency in Hz below which modes were looked for, if there is none.
    pub none_below_hz: Option<f64>,
    /// Condition number of the stiffness scaled to a diagonal of 1, if it is known.
    pub condition: Option<f64>,
}

/// Doubtful properties of the matrices before the reduction, one sentence each.
pub(super) fn of_matrices(model: &FeModel, rigid: Option<&RigidMotions>) -> Vec<String> {
    let mut out = model.doubts().to_vec();
    if rigid.is_some_and(|rigid| !adds_up(model.mass(), rigid)) {
        out.push("entries of the mass cancel: are stiffness and mass exchanged, or is it another matrix?".to_owned());
    }
    out.extend(suspects::remarks(model, rigid.map(|rigid| rigid.mass_kg)));
    out.extend(rigid.and_then(|rigid| out_of_balance(model, rigid)));
    out.extend(digits::remark(model.stiffness()));
    if let Some(rigid) = rigid {
        let known: Vec<(f64, &str)> =
            rigid.mass_kg.into_iter().zip(DOF_NAMES).filter(|(mass, _)| *mass > 0.0).collect();
        let [least, most] = MASS_KG;
        if let Some((mass, axis)) = known.iter().find(|(mass, _)| !(least..=most).contains(mass)) {
            out.push(format!(
                "a mass of {mass:.3e} kg (along {axis}): machines have {least} to {most:e} kg; does `units` match the \
                 matrices (mm, t, s are \"mm_t_s\"), or is it another matrix?"
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
    if let Some(Misplaced { name, by_points_m, by_rows_m }) = model.misplaced().first() {
        out.push(format!(
            "{name} lies at {by_points_m:?} m by the table of points, but at {by_rows_m:?} m by the list of rows: is the unit of the model another one?"
        ));
    }
    out.extend(loose_mass(model));
    out
}

/// Doubtful properties of the modes, one sentence each.
pub(super) fn of_modes(shown: Shown) -> Vec<String> {
    let mut out = Vec::new();
    if shown.rigid > MOST_RIGID {
        out.push(format!(
            "{} modes at 0 Hz: a machine that floats has {MOST_RIGID}; parts hang loose, move as a mechanism, or their stiffness is missing (is a file truncated?)",
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
            "the stiffness is ill-conditioned ({condition:.1e} when scaled to a diagonal of 1, by the rounding of \
             double precision {:.0e}): fewer than three digits of the lowest frequencies may be right; are \
             springs between nodes far stiffer than their surroundings (1e3 to 1e6 times is enough), or is it \
             nearly a mechanism?",
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
    let place = place_of(model, first);
    Some(format!(
        "{} with mass but no stiffness, the first {place}: nothing holds them; are they to be left out, or is the stiffness truncated?",
        if loose.len() == 1 { "1 row".to_owned() } else { format!("{} rows", loose.len()) }
    ))
}

/// Rigid motions that strain the model: its labels or places are wrong.
fn out_of_balance(model: &FeModel, rigid: &RigidMotions) -> Option<String> {
    let translated = rigid.translated.as_ref().filter(|balance| balance.share() > MOST_TRANSLATED);
    let turned = rigid.rotated.as_ref();
    let turned = turned.filter(|turned| turned.balance.share() > MOST_ROTATED || turned.strain > MOST_STRAIN);
    let (balance, motion, cause) = match (translated, turned) {
        (Some(balance), _) => (
            balance,
            "a translation",
            "are the labels of the rows (dof_file, dofs_per_node) in another order than the rows, or is another model's list named?",
        ),
        (None, Some(turned)) => (
            &turned.balance,
            "a rotation",
            "are directions permuted, rows in another order (field by field), coordinates in another unit than the matrices (key units), or displacements along axes of their own?",
        ),
        (None, None) => return None,
    };
    Some(format!(
        "{motion} as a rigid body strains {:.0} % of the rows, the first {}; in a right model these are a few rows at supports: {cause}",
        100.0 * balance.share(),
        place_of(model, balance.first()?)
    ))
}

/// Node and direction of a row, or its number.
fn place_of(model: &FeModel, row: usize) -> String {
    match model.labels().get(row).and_then(|label| Some((label.node, DOF_NAMES.get(label.dof)?))) {
        Some((node, dof)) => format!("node {node} {dof}"),
        None => format!("row {}", row + 1),
    }
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
