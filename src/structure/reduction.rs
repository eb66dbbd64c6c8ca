//! Craig-Bampton reduction of a finite element model.

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use sprs::CsMat;

use super::error::{Step, StructureError};
use super::matrix_market::assemble;
use super::model::FeModel;
use super::points::{DOF_NAMES, Interface, InterfaceDof};
use super::reduced::ReducedStructure;
use super::symmetric::{congruence, symmetric_part};
use crate::linalg::{SparseCholesky, cholesky, multiply, multiply_transposed, solve_lower_transposed, symmetric_eigen};

/// Most inner DOFs for the dense solver of the fixed-interface modes: about 10 s and 150 MB.
const DENSE_LIMIT: usize = 2000;

const SINGULAR_INNER: &str =
    "with the interface held the machine still moves freely, or the stiffness is wrong: keep more interface DOFs";

/// What a reduction keeps.
#[derive(Debug, Clone, PartialEq)]
pub struct ReductionSettings {
    /// Interface DOFs: name of the point and direction 0 to 5 ([`DOF_NAMES`]). The order is the order of the rows; a DOF
    /// named twice, or two points on the same node, share a row.
    pub interface: Vec<(String, usize)>,
    /// Fixed-interface modes below this frequency are kept, in Hz. On the station with the whole rail and table as
    /// interface, 3000 Hz leaves relative errors of 4e-6 in the frequencies below 300 Hz and 5e-4 below 1000 Hz; 1500 Hz
    /// 7e-5 and 8e-3.
    pub fixed_interface_cutoff_hz: f64,
}

/// The model split into interface DOFs b and inner DOFs o.
struct Partition {
    k_oo: CsMat<f64>,
    m_oo: CsMat<f64>,
    k_ob: DMatrix<f64>,
    m_ob: DMatrix<f64>,
    k_bb: DMatrix<f64>,
    m_bb: DMatrix<f64>,
}

/// Craig-Bampton reduction: `T = [Psi G; 0 I]`, `M_zz = T' M T`, `K_zz = T' K T`, coordinates z = (modal q, interface u_b).
///
/// `G = -K_oo^-1 K_ob` are the constraint modes (`K_oo` is factorised once, sparse), `Psi` the mass-normalised
/// fixed-interface modes of `(K_oo, M_oo)` below the cut-off.
///
/// # Errors
/// Unknown points or directions, a cut-off that is not positive, an inner stiffness `K_oo` that is not positive definite,
/// more than 2000 inner DOFs.
pub fn reduce(model: &FeModel, settings: &ReductionSettings) -> Result<ReducedStructure, StructureError> {
    let cutoff_hz = settings.fixed_interface_cutoff_hz;
    if !(cutoff_hz.is_finite() && cutoff_hz > 0.0) {
        let expected = "a positive, finite frequency in Hz";
        return Err(StructureError::argument("fixed_interface_cutoff_hz", expected, cutoff_hz));
    }
    let (rows, dofs) = interface_rows(model, settings)?;
    let inner = model.order() - rows.len();
    if inner > DENSE_LIMIT {
        return Err(StructureError::TooLarge { inner, limit: DENSE_LIMIT });
    }
    let parts = Partition::new(model, &rows)?;
    let mut g = -&parts.k_ob;
    if inner > 0 {
        SparseCholesky::new(&parts.k_oo)
            .and_then(|factor| factor.solve(&mut g))
            .step("static solution with the interface held", SINGULAR_INNER)?;
    }
    let (omega_squared, psi) = fixed_interface_modes(&parts, TAU * cutoff_hz)?;
    let (m_zz, k_zz) = project(&parts, &g, &psi, &omega_squared)?;
    let modes = omega_squared.len();
    let transfer =
        DMatrix::from_fn(rows.len(), modes + rows.len(), |row, column| if column == modes + row { 1.0 } else { 0.0 });
    ReducedStructure::new(m_zz, k_zz, transfer, Interface::new(model.points().clone(), &dofs))
}

type NamedRows = Vec<(InterfaceDof, usize)>;

/// The distinct matrix rows of the interface in order, and which of them each named DOF uses.
fn interface_rows(model: &FeModel, settings: &ReductionSettings) -> Result<(Vec<usize>, NamedRows), StructureError> {
    let mut place: Vec<Option<usize>> = vec![None; model.order()];
    let (mut rows, mut dofs) = (Vec::new(), Vec::new());
    for (point, dof) in &settings.interface {
        let first = model.points().get(point)?.first_row;
        let row = first.filter(|_| *dof < DOF_NAMES.len()).map(|first| first + dof);
        let Some(slot) = row.and_then(|row| place.get_mut(row)) else {
            let name = format!("direction of interface point {point}");
            return Err(StructureError::argument(name, "0 to 5 (x, y, z, rx, ry, rz)", dof));
        };
        let position = *slot.get_or_insert_with(|| {
            rows.extend(row);
            rows.len() - 1
        });
        dofs.push((InterfaceDof { point: point.clone(), dof: *dof }, position));
    }
    if rows.is_empty() {
        return Err(StructureError::argument("interface", "at least one interface DOF", "none"));
    }
    Ok((rows, dofs))
}

impl Partition {
    fn new(model: &FeModel, rows: &[usize]) -> Result<Self, StructureError> {
        let order = model.order();
        // Ok(i): inner DOF i; Err(i): interface DOF i.
        let mut place = vec![Ok(0); order];
        for (position, &row) in rows.iter().enumerate() {
            place[row] = Err(position);
        }
        let mut inner = 0;
        for slot in place.iter_mut().filter(|slot| slot.is_ok()) {
            *slot = Ok(inner);
            inner += 1;
        }
        let split = |name: &str, matrix: &CsMat<f64>| {
            let mut ob = DMatrix::zeros(inner, rows.len());
            let mut bb = DMatrix::zeros(rows.len(), rows.len());
            let mut oo = Vec::with_capacity(matrix.nnz());
            for (&value, (row, column)) in matrix {
                match (place[row], place[column]) {
                    (Ok(i), Ok(j)) => oo.push((i, j, value)),
                    (Ok(i), Err(j)) => ob[(i, j)] = value,
                    (Err(i), Err(j)) => bb[(i, j)] = value,
                    (Err(_), Ok(_)) => {}
                }
            }
            assemble(name, inner, oo).map(|oo| (oo, ob, bb))
        };
        let (k_oo, k_ob, k_bb) = split("stiffness", model.stiffness())?;
        let (m_oo, m_ob, m_bb) = split("mass", model.mass())?;
        Ok(Self { k_oo, m_oo, k_ob, m_ob, k_bb, m_bb })
    }
}

fn dense(matrix: &CsMat<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(matrix.rows(), matrix.cols());
    for (&value, (row, column)) in matrix {
        out[(row, column)] = value;
    }
    out
}

/// `A X` for a sparse A.
fn sparse_times(a: &CsMat<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.rows(), x.ncols());
    for (source, mut target) in x.column_iter().zip(out.column_iter_mut()) {
        for (&value, (row, column)) in a {
            target[row] += value * source[column];
        }
    }
    out
}

/// Squared circular frequencies (rising) and mass-normalised modes of `(K_oo, M_oo)` below `cutoff_rad_s`.
///
/// Solved as `L^-1 M_oo L^-T y = mu y` with `K_oo = L L'` and `omega^2 = 1/mu`: the wanted modes are the largest mu, so
/// they keep full relative accuracy however stiff the model is.
fn fixed_interface_modes(parts: &Partition, cutoff_rad_s: f64) -> Result<(Vec<f64>, DMatrix<f64>), StructureError> {
    const STEP: &str = "fixed-interface modes";
    let l = cholesky(dense(&parts.k_oo)).step(STEP, SINGULAR_INNER)?;
    let c = congruence(&l, dense(&parts.m_oo))?;
    let eigen = symmetric_eigen(&c).step(STEP, "check the matrices for extreme values")?;
    let least = cutoff_rad_s.powi(-2);
    let kept: Vec<usize> = (0..eigen.values.len()).rev().take_while(|&i| eigen.values[i] > least).collect();
    let mut psi = eigen.vectors.select_columns(&kept);
    for (mut column, &i) in psi.column_iter_mut().zip(&kept) {
        column.unscale_mut(eigen.values[i].sqrt());
    }
    solve_lower_transposed(&l, &mut psi).step(STEP, SINGULAR_INNER)?;
    Ok((kept.iter().map(|&i| eigen.values[i].recip()).collect(), psi))
}

/// `M_zz` and `K_zz`. `K_qb = 0` because constraint modes are static solutions; `M_qq = I` by normalisation.
fn project(
    parts: &Partition,
    g: &DMatrix<f64>,
    psi: &DMatrix<f64>,
    omega_squared: &[f64],
) -> Result<(DMatrix<f64>, DMatrix<f64>), StructureError> {
    const STEP: &str = "projection on the Craig-Bampton basis";
    const ADVICE: &str = "check the sizes of mass and stiffness";
    let (q, b) = (omega_squared.len(), g.ncols());
    let inertia = sparse_times(&parts.m_oo, g) + &parts.m_ob;
    let coupling = multiply_transposed(psi, &inertia).step(STEP, ADVICE)?;
    let m_bb = multiply_transposed(g, &inertia).step(STEP, ADVICE)?
        + multiply_transposed(&parts.m_ob, g).step(STEP, ADVICE)?
        + &parts.m_bb;
    let k_bb = multiply(&parts.k_ob.transpose(), g).step(STEP, ADVICE)? + &parts.k_bb;
    let (mut m_zz, mut k_zz) = (DMatrix::identity(q + b, q + b), DMatrix::zeros(q + b, q + b));
    for (i, &value) in omega_squared.iter().enumerate() {
        k_zz[(i, i)] = value;
    }
    m_zz.view_mut((0, q), (q, b)).copy_from(&coupling);
    m_zz.view_mut((q, 0), (b, q)).copy_from(&coupling.transpose());
    m_zz.view_mut((q, q), (b, b)).copy_from(&symmetric_part(m_bb));
    k_zz.view_mut((q, q), (b, b)).copy_from(&symmetric_part(k_bb));
    Ok((m_zz, k_zz))
}
