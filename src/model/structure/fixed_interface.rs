//! Fixed-interface modes and constraint modes: the contribution of the inner DOFs to the reduced structure.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::error::{Step, StructureError};
use super::model::FeModel;
use super::observe::Observer;
use super::own::RIGID_BODY_HZ;
use decore_math::linalg::{
    Below, LinalgError, PencilFactor, PencilModes, SymmetricPencil, modes_below, multiply, multiply_transposed,
};

/// Number of times that a limit at an eigenvalue is moved.
const NUDGES: usize = 4;
/// Relative step of such a move.
const NUDGE: f64 = 1e-6;
/// Shift of a singular inner stiffness relative to the squared cut-off.
const SHIFT_OF_LIMIT: f64 = 1e-6;
/// Refinements of constraint modes with a singular inner stiffness; each gains six digits.
const REFINEMENTS: usize = 6;

const INDEFINITE_INNER: &str = "with the interface held the stiffness is not positive semidefinite, or a part without mass moves freely: check signs, \
     and that nothing without mass hangs loose";
const COUNT: &str = "number of fixed-interface modes below the cut-off";
const INCOMPLETE: &str = "the matrices may be indefinite or badly scaled: check signs and units";

/// Contribution of the inner DOFs, in the order of their pencil.
pub(super) struct Inner {
    /// Squared circular frequencies of the fixed-interface modes, rising; 0 except for rounding for free motions.
    pub omega_squared: Vec<f64>,
    /// Mass-normalised fixed-interface modes.
    pub psi: DMatrix<f64>,
    /// Constraint modes `G = -K_oo^-1 K_ob`.
    pub constraint: DMatrix<f64>,
    /// Shift in 1/s2 that made the inner stiffness regular; 0 if none was needed.
    pub shift: f64,
    /// Columns of the Lanczos basis.
    pub basis: usize,
    /// Estimated condition number of `K_oo + shift M_oo`; only with an observer.
    pub condition: Option<Condition>,
}

/// Condition numbers in the 1-norm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Condition {
    /// Of the matrix as it is.
    pub plain: f64,
    /// Of the matrix scaled to a diagonal of 1.
    pub scaled: f64,
}

impl Inner {
    fn new(modes: PencilModes, constraint: DMatrix<f64>, shift: f64, condition: Option<Condition>) -> Self {
        let omega_squared = modes.values.iter().map(|value| value.max(0.0)).collect();
        Self { omega_squared, psi: modes.vectors, constraint, shift, basis: modes.basis, condition }
    }
}

/// Modes that are looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Squared circular frequency in rad2/s2 that they lie below.
    pub limit: f64,
    /// Whether stiffness and mass look as if they were in different units: then many modes are a mistake.
    pub suspect: bool,
}

/// Most modes that are looked for.
const MOST_MODES: usize = 5000;
/// The same where units are in doubt.
const MOST_SUSPECT_MODES: usize = 200;
/// All modes of so few rows are found in a second.
const SMALL: usize = 1000;

impl Wanted {
    pub(super) fn require(self, count: usize, order: usize) -> Result<(), StructureError> {
        let Self { limit, suspect } = self;
        if count <= if suspect && order > SMALL { MOST_SUSPECT_MODES } else { MOST_MODES } {
            return Ok(());
        }
        let cutoff_hz = (1e3 * limit.sqrt() / TAU).round() / 1e3;
        Err(StructureError::TooManyModes { count, cutoff_hz, order, suspect })
    }
}

/// Rows of the part that a suspect model is looked at by.
const PART: usize = 6000;

/// Refuses a suspect model by a part of it, in a fraction of the time that all its rows take: with all other rows held a part has no more
/// modes below a limit than the whole.
pub(super) fn require_few(model: &FeModel, kept: &[bool], wanted: Wanted) -> Result<(), StructureError> {
    let order = kept.iter().filter(|kept| **kept).count();
    if order <= PART {
        return Ok(());
    }
    let pencil =
        SymmetricPencil::new(model.stiffness(), model.mass(), &part(model, kept)).step(COUNT, INDEFINITE_INNER)?;
    wanted.require(count(&pencil, wanted.limit)?, order)
}

/// The rows around the first one, as they are coupled.
fn part(model: &FeModel, kept: &[bool]) -> Vec<bool> {
    let mut chosen = vec![false; kept.len()];
    let mut open: VecDeque<usize> = kept.iter().position(|kept| *kept).into_iter().collect();
    open.iter().for_each(|row| chosen[*row] = true);
    let mut count = open.len();
    while let Some(row) = open.pop_front() {
        for (column, value) in model.stiffness().outer_view(row).iter().flat_map(|view| view.iter()) {
            if *value != 0.0 && kept[column] && !chosen[column] && count < PART {
                chosen[column] = true;
                count += 1;
                open.push_back(column);
            }
        }
    }
    chosen
}

/// Solves the inner problem with modes below a limit.
///
/// The number of modes is counted first. A regular `K_oo` is factorised once for modes and constraint modes. Where `K_oo` is
/// singular (the interface does not hold a floating machine) or nearly so, `K_oo + shift M_oo` takes its place.
pub(super) fn solve_inner(
    pencil: &SymmetricPencil,
    k_ob: &DMatrix<f64>,
    wanted: Wanted,
    observer: &mut Observer,
) -> Result<Inner, StructureError> {
    let problem = InnerProblem { pencil, k_ob, wanted };
    solve_inner_and(&problem, observer, |_, _, _| Ok(())).map(|(inner, ())| inner)
}

/// An inner problem.
pub(super) struct InnerProblem<'a> {
    pub pencil: &'a SymmetricPencil<'a>,
    /// `K_ob`.
    pub k_ob: &'a DMatrix<f64>,
    pub wanted: Wanted,
}

/// As [`solve_inner`], with further results of the factor of `K_oo + shift M_oo`.
pub(super) fn solve_inner_and<T>(
    problem: &InnerProblem,
    observer: &mut Observer,
    further: impl FnOnce(&PencilFactor, &Inner, &mut Observer) -> Result<T, StructureError>,
) -> Result<(Inner, T), StructureError> {
    let InnerProblem { pencil, k_ob, wanted } = *problem;
    let limit = wanted.limit;
    let count = observer.step("count of fixed-interface modes (LDL')", || count(pencil, limit))?;
    wanted.require(count, pencil.order())?;
    let below = Below { limit, count };
    let (factor, shift) = factorise(pencil, limit, observer)?;
    let modes = observer.step("fixed-interface modes (block Lanczos)", || modes(pencil, &factor, shift, below))?;
    let free = (TAU * RIGID_BODY_HZ).powi(2);
    if let Some(&omega_squared) = modes.values.first().filter(|value| shift > 0.0 && **value < -free) {
        return Err(StructureError::Indefinite { omega_squared });
    }
    let constraint = observer.step("constraint modes", || match shift > 0.0 {
        true => deflated_constraint_modes(pencil, &factor, &modes, k_ob),
        false => {
            let mut g = -k_ob;
            factor.solve(&mut g).map(|()| g)
        }
    });
    let constraint = constraint.step("constraint modes", INDEFINITE_INNER)?;
    let condition = condition(pencil, &factor, shift, observer)?;
    let inner = Inner::new(modes, constraint, shift, condition);
    let more = further(&factor, &inner, observer)?;
    Ok((inner, more))
}

/// The factor of `K_oo`, or of `K_oo + shift M_oo` where it is singular, and the shift in 1/s2.
fn factorise(
    pencil: &SymmetricPencil,
    limit: f64,
    observer: &mut Observer,
) -> Result<(PencilFactor, f64), StructureError> {
    match observer.step("factorisation of the inner stiffness (LL')", || pencil.cholesky(0.0)) {
        Ok(factor) => {
            if !is_nearly_singular(pencil, &factor).step("lowest eigenvalue", INDEFINITE_INNER)? {
                return Ok((factor, 0.0));
            }
        }
        Err(LinalgError::NotPositiveDefinite { .. }) => {}
        Err(other) => return Err(other).step("factorisation of the inner stiffness", INDEFINITE_INNER),
    }
    let shift = SHIFT_OF_LIMIT * limit;
    observer
        .step("factorisation of the shifted inner stiffness (LL')", || pencil.cholesky(shift))
        .step("factorisation of the shifted inner stiffness", INDEFINITE_INNER)
        .map(|factor| (factor, shift))
}

/// Whether some motion has a frequency that counts as none: two steps of inverse iteration find it, as its eigenvalue
/// stands far apart from all others.
fn is_nearly_singular(pencil: &SymmetricPencil, factor: &PencilFactor) -> Result<bool, LinalgError> {
    // Any start with a share in every motion will do.
    let mut x = DMatrix::from_fn(pencil.order(), 1, |row, _| 1.0 + libm::sin(0.7 * row as f64));
    let mut lowest = f64::INFINITY;
    for _ in 0..2 {
        let inertia = pencil.mass_times(&x)?;
        let mut next = inertia.clone();
        factor.solve(&mut next)?;
        // With K y = M x the Rayleigh quotient of y is y'Mx / y'My.
        let (work, mass) = (next.dot(&inertia), next.dot(&pencil.mass_times(&next)?));
        let scale = mass.sqrt();
        if !(scale.is_finite() && scale > 0.0) {
            break;
        }
        lowest = work / mass;
        x = next / scale;
    }
    Ok(lowest <= (TAU * RIGID_BODY_HZ).powi(2))
}

/// Estimated condition number of `K_oo + shift M_oo`, where somebody looks on.
fn condition(
    pencil: &SymmetricPencil,
    factor: &PencilFactor,
    shift: f64,
    observer: &mut Observer,
) -> Result<Option<Condition>, StructureError> {
    if !observer.is_active() {
        return Ok(None);
    }
    let estimate = observer.step("condition estimate", || {
        let [plain, scaled] = [false, true].map(|scaled| pencil.condition(factor, shift, scaled));
        Ok(Condition { plain: plain?, scaled: scaled? })
    });
    estimate.step("condition estimate", INDEFINITE_INNER).map(Some)
}

/// Counts the modes below the limit; a limit that is an eigenvalue is moved up a little.
pub(super) fn count(pencil: &SymmetricPencil, limit: f64) -> Result<usize, StructureError> {
    let mut result = pencil.count_below(limit);
    for nudge in 1..=NUDGES {
        if !matches!(result, Err(LinalgError::ZeroPivot { .. })) {
            break;
        }
        result = pencil.count_below(limit * (1.0 + NUDGE * nudge as f64));
    }
    result.step(COUNT, INDEFINITE_INNER)
}

/// Modes below the limit. If their number differs from the count, the count is repeated at a slightly different limit, because an
/// eigenvalue at the limit or cancellation in the pivots may make it wrong.
pub(super) fn modes(
    pencil: &SymmetricPencil,
    factor: &PencilFactor,
    shift: f64,
    below: Below,
) -> Result<PencilModes, StructureError> {
    let mut result = modes_below(pencil, factor, shift, below);
    for nudge in 1..=NUDGES {
        if !matches!(result, Err(LinalgError::Incomplete { .. })) {
            break;
        }
        let limit = below.limit * (1.0 + 10.0 * NUDGE * nudge as f64);
        result = modes_below(pencil, factor, shift, Below { limit, count: count(pencil, limit)? });
    }
    result.step("fixed-interface modes", INCOMPLETE)
}

/// `G` with `K_oo G = -K_ob` for a singular, positive semidefinite `K_oo`. `K_ob` is in its range, because `K` as a whole is
/// positive semidefinite; the part along the free motions is left out, they are among the modes.
///
/// The modes are divided by their own stiffness; the rest, all above the cut-off, is refined with the shifted factor, which
/// errs by `shift / limit` there.
fn deflated_constraint_modes(
    pencil: &SymmetricPencil,
    factor: &PencilFactor,
    modes: &PencilModes,
    k_ob: &DMatrix<f64>,
) -> Result<DMatrix<f64>, LinalgError> {
    let free = (TAU * RIGID_BODY_HZ).powi(2);
    let inertia = pencil.mass_times(&modes.vectors)?;
    let mut g = DMatrix::zeros(k_ob.nrows(), k_ob.ncols());
    let mut residual = -k_ob;
    for _ in 0..REFINEMENTS {
        let mut along = multiply_transposed(&modes.vectors, &residual)?;
        let mut correction = residual - multiply(&inertia, &along)?;
        factor.solve(&mut correction)?;
        for (mut row, &omega_squared) in along.row_iter_mut().zip(&modes.values) {
            row *= if omega_squared > free { omega_squared.recip() } else { 0.0 };
        }
        // Remove components along the modes.
        let leak = multiply_transposed(&inertia, &correction)?;
        correction += multiply(&modes.vectors, &(along - leak))?;
        g += &correction;
        residual = -k_ob - pencil.stiffness_times(&g)?;
    }
    Ok(g)
}
