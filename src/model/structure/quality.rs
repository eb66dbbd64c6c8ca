//! Quality of a reduction: comparison with the full model.
//!
//! The full model's modes below the cut-off come from the same solver, on all rows, with the same proof that none is missing;
//! its static flexibility from unit loads on the interface. Its receptances are the sum over those modes plus what all others bring, from
//! solutions of the full equations at the frequencies of the curves ([`super::reference`]). The reduced structure's are the sum over all its
//! modes. Modes below the cut-off are damped, others are not, in both.

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::Serialize;

use super::error::{Step, StructureError};
use super::fixed_interface::{Inner, InnerProblem, Wanted, solve_inner_and};
use super::model::FeModel;
use super::motions::RigidMotions;
use super::observe::{Observer, StepRecord};
use super::own::RIGID_BODY_HZ;
use super::partition::{inner_rows, sparse_times};
use super::plausibility::{Shown, of_modes};
use super::points::DOF_NAMES;
use super::reduction::{Reduction, ReductionFacts, ReductionSettings, reduce_in_parts};
use super::reference::{Known, Vectors, beyond_modes};
use super::symmetric::congruence;
use decore_math::linalg::{
    SymmetricPencil, cholesky, multiply_transposed, solve_lower_transposed, symmetric_eigen, symmetric_eigenvalues,
};

/// Curves of mobility end at this share of the cut-off.
pub const MOBILITY_SHARE: f64 = 0.6;
/// Frequencies of a curve.
const CURVE_POINTS: usize = 400;
/// Most curves of one kind.
const MOST_CURVES: usize = 16;
const ADVICE: &str = "check signs and units of mass and stiffness";

/// Settings of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct QualitySettings {
    /// The reduction.
    pub reduction: ReductionSettings,
    /// Modes of the machine are compared up to this frequency in Hz.
    pub cutoff_hz: f64,
    /// Damping ratio of all modes in the curves of mobility.
    pub damping_ratio: f64,
}

/// A mode of the full model with its counterpart.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ModePair {
    /// Frequency of the full model in Hz.
    pub full_hz: f64,
    /// Frequency of the reduced structure in Hz.
    pub reduced_hz: f64,
    /// `reduced / full - 1`; none for rigid-body motions.
    pub relative_error: Option<f64>,
    /// Modal assurance criterion of the two shapes over all rows, weighted by mass: 1 for the same shape.
    pub mac: f64,
    /// Share of the total mass that moves along x, y, z with the mode, full model; none if the directions of the rows are
    /// not known.
    pub effective_mass_full: Option<[f64; 3]>,
    /// The same of the reduced structure.
    pub effective_mass_reduced: Option<[f64; 3]>,
}

/// Static stiffness of an interface DOF, all others free.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StaticStiffness {
    /// Point and direction, `R5.z`.
    pub dof: String,
    /// Full model, N/m or N m/rad.
    pub full: f64,
    /// Reduced structure.
    pub reduced: f64,
    /// `reduced / full - 1`.
    pub relative_error: f64,
}

/// Velocity at one DOF per force at another, over frequency.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MobilityCurve {
    /// Point of the velocity.
    pub response: String,
    /// Point of the force.
    pub force: String,
    /// Magnitude in m/(s N), full model.
    pub full: Vec<f64>,
    /// The same of the reduced structure.
    pub reduced: Vec<f64>,
    /// Largest distance of the complex curves, relative to the full one's largest magnitude.
    pub largest_relative_difference: f64,
}

/// Condition numbers: of sparse matrices in the 1-norm (estimated), of reduced ones in the 2-norm.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Conditions {
    /// Stiffness of all rows (with the shift where it is singular).
    pub full_stiffness: Option<f64>,
    /// Stiffness of the inner rows.
    pub inner_stiffness: Option<f64>,
    /// Reduced stiffness; none for a structure that floats.
    pub reduced_stiffness: Option<f64>,
    /// Reduced mass.
    pub reduced_mass: Option<f64>,
}

/// The report.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct QualityReport {
    /// Facts from the reduction.
    pub facts: ReductionFacts,
    /// Modes below the cut-off in rising order.
    pub modes: Vec<ModePair>,
    /// Total mass along x, y, z in kg, where the directions of the rows are known.
    pub total_mass_kg: Option<[f64; 3]>,
    /// Centre of mass in m, where every node with mass has a known place.
    pub centre_of_mass_m: Option<[f64; 3]>,
    /// Nodes with mass whose place is not known, and all nodes with mass, where there is no centre of mass and the directions of the
    /// rows are known; the first is 0 if there is no mass along x or y.
    pub nodes_without_place: Option<[usize; 2]>,
    /// Doubtful properties: units, labels, exchanged matrices, directions without mass.
    pub remarks: Vec<String>,
    /// Changes to the matrices (eliminated multipliers, held rows left out), and a note if the machine floats.
    pub notes: Vec<String>,
    /// Static stiffness of every interface DOF; empty for a structure that floats.
    pub static_stiffness: Vec<StaticStiffness>,
    /// Frequencies of the curves in Hz.
    pub frequency_hz: Vec<f64>,
    /// Drive-point and cross mobilities of translations.
    pub mobility: Vec<MobilityCurve>,
    /// Condition numbers.
    pub conditions: Conditions,
    /// Time and memory of the steps; the only part that is not the same in every run.
    pub steps: Vec<StepRecord>,
}

impl QualityReport {
    /// Largest relative error of a frequency below a limit in Hz.
    pub fn largest_frequency_error(&self, below_hz: f64) -> f64 {
        let errors = self.modes.iter().filter(|mode| mode.full_hz < below_hz).filter_map(|mode| mode.relative_error);
        errors.map(f64::abs).fold(0.0, f64::max)
    }
}

/// Modes over some rows: squared circular frequencies and mass-normalised shapes at the interface and at all rows.
struct Shapes {
    omega_squared: Vec<f64>,
    interface: DMatrix<f64>,
    all: DMatrix<f64>,
    /// Contribution of all modes from the cut-off on to receptances at the interface.
    beyond: Vectors,
}

/// Compares a reduction with its model.
///
/// # Errors
/// As for [`super::reduce`].
pub fn assess(model: &FeModel, settings: &QualitySettings) -> Result<QualityReport, StructureError> {
    assess_telling(model, settings, |_| ())
}

/// As [`assess`]. `tell` receives doubtful properties of the matrices before the work, which takes a minute for large models.
///
/// # Errors
/// As for [`super::reduce`].
pub fn assess_telling(
    model: &FeModel,
    settings: &QualitySettings,
    tell: impl FnOnce(&[String]),
) -> Result<QualityReport, StructureError> {
    let mut observer = Observer::active();
    let reduction = reduce_in_parts(model, &settings.reduction, &mut observer, tell)?;
    compare(model, settings, &reduction, observer).map_err(|error| error.with_causes(&reduction.remarks))
}

fn compare(
    model: &FeModel,
    settings: &QualitySettings,
    reduction: &Reduction,
    mut observer: Observer,
) -> Result<QualityReport, StructureError> {
    let model = reduction.with_means.as_ref().unwrap_or(model);
    let names = dof_names(reduction);
    let curves = Curves { pairs: curve_pairs(&names), frequency_hz: curve_frequencies(settings.cutoff_hz) };
    let Full { inner: full, shapes, flexibility } =
        full_model(model, settings.cutoff_hz, (reduction, &curves), &mut observer)?;
    let reduced = reduced_modes(reduction, shapes.omega_squared.len())?;
    let rigid = reduction.rigid.as_ref();
    let compared = Compared { full: &shapes, reduced: &reduced };
    let modes = pair_modes(model, rigid, compared)?;
    let shown = Shown {
        rigid: shapes.omega_squared.iter().filter(|value| hz(**value) == 0.0).count(),
        lowest_hz: shapes.omega_squared.iter().map(|value| hz(*value)).find(|hz| *hz > 0.0),
        // With a shift it tells of the rigid-body motions.
        condition: full.condition.filter(|_| full.shift == 0.0).map(|condition| condition.scaled),
        none_below_hz: shapes.omega_squared.is_empty().then_some(settings.cutoff_hz),
    };
    let centre = rigid.map(|rigid| rigid.centre_m);
    let mobility = mobilities(&names, compared, &curves, settings.damping_ratio);
    Ok(QualityReport {
        modes,
        total_mass_kg: rigid.map(|rigid| rigid.mass_kg),
        centre_of_mass_m: centre.and_then(Result::ok),
        nodes_without_place: centre.and_then(Result::err).map(|(unknown, all)| [unknown, all]),
        remarks: reduction.remarks.iter().cloned().chain(of_modes(shown)).collect(),
        notes: model.changes().iter().cloned().chain(floating(shown.rigid)).collect(),
        static_stiffness: static_stiffness(&names, flexibility.as_ref(), reduction.structure.static_flexibility()),
        frequency_hz: curves.frequency_hz,
        mobility,
        conditions: conditions(reduction, &full)?,
        steps: observer.records().to_vec(),
        facts: reduction.facts.clone(),
    })
}

/// Note for a machine without supports.
fn floating(rigid: usize) -> Option<String> {
    (rigid > 0).then(|| {
        format!(
            "the machine floats: {rigid} rigid-body {} at 0 Hz; a machine on mounts needs their stiffness in the matrices",
            if rigid == 1 { "motion" } else { "motions" }
        )
    })
}

fn unit_loads(pencil: &SymmetricPencil, rows: &[usize]) -> DMatrix<f64> {
    let mut loads = DMatrix::zeros(pencil.order(), rows.len());
    for (position, &row) in pencil.rows().iter().enumerate() {
        if let Some(column) = rows.iter().position(|other| *other == row as usize) {
            loads[(position, column)] = 1.0;
        }
    }
    loads
}

/// The loads on rows that curves need; 0 in the other columns.
fn loads_of(loads: &DMatrix<f64>, pairs: &[CurveRows]) -> DMatrix<f64> {
    let mut out = loads.clone();
    for column in 0..out.ncols() {
        if !pairs.iter().any(|(i, j)| [*i, *j].contains(&column)) {
            out.column_mut(column).fill(0.0);
        }
    }
    out
}

/// The modes that are compared.
#[derive(Clone, Copy)]
struct Compared<'a> {
    /// Of the full model, below the cut-off.
    full: &'a Shapes,
    /// Of the reduced structure.
    reduced: &'a Shapes,
}

/// Known properties of the full model.
struct Full {
    inner: Inner,
    shapes: Shapes,
    /// Static flexibility `B' K^-1 B` at the interface; none for a model that floats.
    flexibility: Option<DMatrix<f64>>,
}

/// The full model's modes below the cut-off, and its receptances.
fn full_model(
    model: &FeModel,
    cutoff_hz: f64,
    (reduction, curves): (&Reduction, &Curves),
    observer: &mut Observer,
) -> Result<Full, StructureError> {
    let (kept, _) = inner_rows(model, &[]);
    let pencil = observer
        .step("full model: order and symbolic factorisation", || {
            SymmetricPencil::new(model.stiffness(), model.mass(), &kept)
        })
        .step("order of the full model", "see whether it fits into memory")?;
    let loads = unit_loads(&pencil, &reduction.rows);
    let wanted = Wanted { limit: (TAU * cutoff_hz).powi(2), suspect: false };
    let problem = InnerProblem { pencil: &pencil, k_ob: &-&loads, wanted };
    let loads = loads_of(&loads, &curves.pairs);
    let highest = curves.frequency_hz.last().map_or(0.0, |hz| (TAU * hz).powi(2));
    let mut steps = Observer::active();
    let (inner, beyond) = solve_inner_and(&problem, &mut steps, |factor, full, observer| {
        let known = Known { pencil: &pencil, factor, full };
        observer.step("receptances beyond the modes (block Krylov)", || beyond_modes(&known, &loads, highest))
    })?;
    observer.add("full model: ", steps.records());
    let place = |row: &usize| pencil.rows().iter().position(|other| *other as usize == *row);
    let places: Vec<usize> = reduction.rows.iter().filter_map(place).collect();
    let interface = inner.psi.select_rows(&places);
    let mut all = DMatrix::zeros(reduction.facts.order, inner.psi.ncols());
    for (position, &row) in pencil.rows().iter().enumerate() {
        all.row_mut(row as usize).copy_from(&inner.psi.row(position));
    }
    let free = (TAU * RIGID_BODY_HZ).powi(2);
    let stands = inner.omega_squared.first().is_none_or(|lowest| *lowest > free);
    let flexibility = stands.then(|| inner.constraint.select_rows(&places));
    let shapes = Shapes { omega_squared: inner.omega_squared.clone(), interface, all, beyond };
    Ok(Full { inner, shapes, flexibility })
}

/// Modes of the reduced structure that have a finite frequency; all except the first `damped` bring their receptance undamped.
fn reduced_modes(reduction: &Reduction, damped: usize) -> Result<Shapes, StructureError> {
    const STEP: &str = "modes of the reduced structure";
    let shift = TAU * TAU;
    let (m_zz, k_zz) = (reduction.structure.m_zz(), reduction.structure.k_zz());
    let l = cholesky(k_zz + m_zz * shift).step(STEP, ADVICE)?;
    let c = congruence(&l, m_zz.clone())?;
    let eigen = symmetric_eigen(&c).step(STEP, ADVICE)?;
    let largest = eigen.values.last().copied().unwrap_or(0.0);
    let falling: Vec<usize> = (0..eigen.values.len()).rev().collect();
    let mut z = eigen.vectors.select_columns(&falling);
    solve_lower_transposed(&l, &mut z).step(STEP, ADVICE)?;
    let (_, others) = falling.split_at(damped.min(falling.len()));
    let beyond = Vectors {
        shift,
        nu: others.iter().map(|at| eigen.values[*at]).collect(),
        rows: reduction.structure.transfer() * z.columns(falling.len() - others.len(), others.len()),
    };
    let finite = falling.iter().take_while(|at| eigen.values[**at] > 1e-14 * largest).count();
    let mut z = z.columns(0, finite).into_owned();
    for (mut column, &index) in z.column_iter_mut().zip(&falling) {
        column.unscale_mut(eigen.values[index].sqrt());
    }
    let omega_squared = falling[..finite].iter().map(|&at| (eigen.values[at].recip() - shift).max(0.0)).collect();
    let interface = reduction.structure.transfer() * &z;
    Ok(Shapes { omega_squared, interface, all: reduction.recover(&z)?, beyond })
}

fn hz(omega_squared: f64) -> f64 {
    let hz = omega_squared.max(0.0).sqrt() / TAU;
    if hz < RIGID_BODY_HZ { 0.0 } else { hz }
}

/// Modes in rising order. Within a cluster of equal frequencies shapes may mix: the MAC of a mode is summed over the reduced
/// modes within 1e-4 of its frequency.
fn pair_modes(
    model: &FeModel,
    rigid: Option<&RigidMotions>,
    Compared { full, reduced, .. }: Compared<'_>,
) -> Result<Vec<ModePair>, StructureError> {
    const STEP: &str = "comparison of modes";
    let inertia = sparse_times(model.mass(), &full.all);
    let coupling = multiply_transposed(&inertia, &reduced.all).step(STEP, ADVICE)?;
    let share = |shapes: &Shapes, mode: usize| -> Option<[f64; 3]> {
        let (rigid, total) = (&rigid?.translations, rigid?.mass_kg);
        let product = sparse_times(model.mass(), &shapes.all.columns(mode, 1).into_owned());
        Some([0, 1, 2].map(|axis| {
            if total[axis] > 0.0 { product.column(0).dot(&rigid.column(axis)).powi(2) / total[axis] } else { 0.0 }
        }))
    };
    let count = full.omega_squared.len().min(reduced.omega_squared.len());
    let pair = |mode: usize| {
        let (full_hz, reduced_hz) = (hz(full.omega_squared[mode]), hz(reduced.omega_squared[mode]));
        let near = |other: &usize| (hz(reduced.omega_squared[*other]) - reduced_hz).abs() <= 1e-4 * reduced_hz;
        let mac: f64 = (0..reduced.omega_squared.len()).filter(near).map(|other| coupling[(mode, other)].powi(2)).sum();
        ModePair {
            full_hz,
            reduced_hz,
            relative_error: (full_hz > 0.0).then(|| reduced_hz / full_hz - 1.0),
            mac: mac.min(1.0),
            effective_mass_full: share(full, mode),
            effective_mass_reduced: share(reduced, mode),
        }
    };
    Ok((0..count).map(pair).collect())
}

/// Names of the rows of the interface displacement, with their directions; the first name of a row that several points share.
fn dof_names(reduction: &Reduction) -> Vec<(String, usize)> {
    let mut names: Vec<Option<(String, usize)>> = vec![None; reduction.rows.len()];
    for (dof, row) in reduction.structure.interface().dofs() {
        let name = format!("{}.{}", dof.point, DOF_NAMES.get(dof.dof).copied().unwrap_or_default());
        if let Some(slot) = names.get_mut(row) {
            slot.get_or_insert((name, dof.dof));
        }
    }
    names.into_iter().flatten().collect()
}

fn static_stiffness(
    names: &[(String, usize)],
    full: Option<&DMatrix<f64>>,
    reduced: Option<&DMatrix<f64>>,
) -> Vec<StaticStiffness> {
    let Some((full, reduced)) = full.zip(reduced) else { return Vec::new() };
    let of_dof = |(row, (name, _)): (usize, &(String, usize))| {
        let (full, reduced) = (full[(row, row)].recip(), reduced[(row, row)].recip());
        StaticStiffness { dof: name.clone(), full, reduced, relative_error: reduced / full - 1.0 }
    };
    names.iter().enumerate().map(of_dof).collect()
}

fn curve_frequencies(cutoff_hz: f64) -> Vec<f64> {
    let (low, high) = (libm::log(MOBILITY_SHARE * cutoff_hz / 600.0), libm::log(MOBILITY_SHARE * cutoff_hz));
    (0..CURVE_POINTS).map(|i| libm::exp(low + (high - low) * i as f64 / (CURVE_POINTS - 1) as f64)).collect()
}

/// A complex value of the full model and of the reduced structure.
type FullAndReduced = ([f64; 2], [f64; 2]);

/// Rows of response and force of a curve.
type CurveRows = (usize, usize);

/// Curves of mobility.
struct Curves {
    pairs: Vec<CurveRows>,
    frequency_hz: Vec<f64>,
}

/// Rows of every curve: drive points, then pairs in the same direction.
fn curve_pairs(names: &[(String, usize)]) -> Vec<CurveRows> {
    let translations: Vec<usize> = (0..names.len()).filter(|row| names[*row].1 < 3).collect();
    let drive = translations.iter().map(|row| (*row, *row));
    let same_direction = |i: &usize, j: &usize| j < i && names[*i].1 == names[*j].1;
    let cross = translations
        .iter()
        .flat_map(|i| translations.iter().filter(move |j| same_direction(i, j)).map(move |j| (*i, *j)));
    drive.take(MOST_CURVES).chain(cross.take(MOST_CURVES)).collect()
}

fn mobilities(
    names: &[(String, usize)],
    Compared { full, reduced }: Compared<'_>,
    Curves { pairs, frequency_hz }: &Curves,
    damping_ratio: f64,
) -> Vec<MobilityCurve> {
    let damped = full.omega_squared.len();
    let curve = |&(i, j): &CurveRows| {
        let at = |hz: &f64| {
            let excitation = Excitation { omega: TAU * hz, damping_ratio, damped };
            (receptance(full, (i, j), &excitation), receptance(reduced, (i, j), &excitation))
        };
        let values: Vec<FullAndReduced> = frequency_hz.iter().map(at).collect();
        let magnitudes = |pick: fn(&FullAndReduced) -> [f64; 2]| -> Vec<f64> {
            values.iter().map(pick).zip(frequency_hz).map(|([re, im], hz)| TAU * hz * libm::hypot(re, im)).collect()
        };
        let (full, reduced) = (magnitudes(|pair| pair.0), magnitudes(|pair| pair.1));
        let largest = full.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let distance =
            values.iter().zip(frequency_hz).map(|((a, b), hz)| TAU * hz * libm::hypot(a[0] - b[0], a[1] - b[1]));
        MobilityCurve {
            response: names[i].0.clone(),
            force: names[j].0.clone(),
            largest_relative_difference: distance.fold(0.0, f64::max) / largest,
            full,
            reduced,
        }
    };
    pairs.iter().map(curve).collect()
}

/// A harmonic force on modes of which the first ones are damped alike.
struct Excitation {
    omega: f64,
    damping_ratio: f64,
    damped: usize,
}

/// `sum phi_i phi_j / (omega_s^2 - omega^2 + 2 i xi omega_s omega)` and the contribution of the other modes, real and imaginary part.
fn receptance(shapes: &Shapes, (i, j): (usize, usize), at: &Excitation) -> [f64; 2] {
    let Excitation { omega, damping_ratio: xi, damped } = *at;
    let mut sum = [shapes.beyond.receptance((i, j), omega), 0.0];
    for (mode, &omega_squared) in shapes.omega_squared.iter().enumerate().take(damped) {
        let own = TAU * hz(omega_squared);
        let (re, im) = (own * own - omega * omega, 2.0 * xi * own * omega);
        let scale = shapes.interface[(i, mode)] * shapes.interface[(j, mode)] / (re * re + im * im);
        sum[0] += scale * re;
        sum[1] -= scale * im;
    }
    sum
}

fn conditions(reduction: &Reduction, full: &Inner) -> Result<Conditions, StructureError> {
    let condition = |matrix: &DMatrix<f64>| -> Result<Option<f64>, StructureError> {
        let values = symmetric_eigenvalues(matrix).step("condition numbers", ADVICE)?;
        let (low, high) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
        Ok((low > 0.0).then(|| high / low))
    };
    let stands = reduction.structure.static_flexibility().is_some();
    Ok(Conditions {
        full_stiffness: full.condition.map(|condition| condition.plain),
        inner_stiffness: reduction.facts.inner_condition,
        reduced_stiffness: if stands { condition(reduction.structure.k_zz())? } else { None },
        reduced_mass: condition(reduction.structure.m_zz())?,
    })
}
