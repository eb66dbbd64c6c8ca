//! Craig-Bampton reduction of a finite element model.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::error::{Step, StructureError};
use super::fixed_interface::{Inner, Wanted, require_few, solve_inner};
use super::means::with_means;
use super::model::FeModel;
use super::motions::RigidMotions;
use super::observe::Observer;
use super::partition::{Blocks, blocks, inner_rows, interface_rows, sparse_times};
use super::plausibility::{Shown, of_matrices, of_modes};
use super::points::Interface;
use super::reduced::{ReducedMatrices, ReducedStructure};
use super::suspects;
use super::symmetric::symmetric_part;
use decore_math::linalg::{SymmetricPencil, multiply, multiply_transposed};

/// Settings of a reduction.
#[derive(Debug, Clone, PartialEq)]
pub struct ReductionSettings {
    /// Interface DOFs: name of the point and direction 0 to 5 ([`super::DOF_NAMES`]). The order is the order of the rows; a
    /// DOF named twice, or two points on the same node, share a row. A DOF of a point that is several nodes is their mean.
    pub interface: Vec<(String, usize)>,
    /// Fixed-interface modes below this frequency are kept, in Hz. On the station with the whole rail and table as
    /// interface, 3000 Hz leaves relative errors of 4e-6 in the frequencies below 300 Hz and 5e-4 below 1000 Hz; 1500 Hz
    /// 7e-5 and 8e-3.
    pub fixed_interface_cutoff_hz: f64,
}

/// Facts from the reduction.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ReductionFacts {
    /// Rows of the model's matrices.
    pub order: usize,
    /// Distinct interface rows.
    pub interface: usize,
    /// Inner rows.
    pub inner: usize,
    /// Rows without mass and stiffness, left out.
    pub empty_rows: usize,
    /// Frequencies of the fixed-interface modes that were kept, in Hz, rising.
    pub fixed_interface_hz: Vec<f64>,
    /// Numbers in the factor of the inner stiffness, 8 bytes each.
    pub factor_len: usize,
    /// Columns of the Lanczos basis.
    pub lanczos_basis: usize,
    /// Frequency of the shift in Hz that made the inner stiffness regular; 0 if none was needed.
    pub shift_hz: f64,
    /// Estimated condition number of the inner stiffness in the 1-norm, where asked for.
    pub inner_condition: Option<f64>,
}

/// Craig-Bampton reduction: `T = [Psi G; 0 I]`, `M_zz = T' M T`, `K_zz = T' K T`, coordinates z = (modal q, interface u_b).
///
/// `G = -K_oo^-1 K_ob` are the constraint modes (`K_oo` is factorised once, sparse), `Psi` the mass-normalised
/// fixed-interface modes of `(K_oo, M_oo)` below the cut-off, complete by a count of the negative pivots of
/// `K_oo - omega_c^2 M_oo`. A damping matrix is reduced with the same T.
///
/// # Errors
/// Unknown points or directions, directions that the model does not have, a cut-off that is not positive, a stiffness that is
/// not positive semidefinite, a part without mass that moves freely, not enough memory.
pub fn reduce(model: &FeModel, settings: &ReductionSettings) -> Result<ReducedStructure, StructureError> {
    reduce_observed(model, settings, &mut Observer::none()).map(|(structure, _)| structure)
}

/// As [`reduce`], with facts from the reduction; time and memory of the steps go to the observer.
///
/// # Errors
/// As for [`reduce`].
pub fn reduce_observed(
    model: &FeModel,
    settings: &ReductionSettings,
    observer: &mut Observer,
) -> Result<(ReducedStructure, ReductionFacts), StructureError> {
    reduce_in_parts(model, settings, observer, |_| ()).map(|parts| (parts.structure, parts.facts))
}

/// A reduction with its basis.
pub(super) struct Reduction {
    pub structure: ReducedStructure,
    pub facts: ReductionFacts,
    /// Interface rows of the model, in the order of the interface displacement.
    pub rows: Vec<usize>,
    /// Inner rows of the model, in the order of the inner basis.
    pub inner_rows: Vec<u32>,
    pub inner: Inner,
    /// Rigid motions of the model, where its rows have labels.
    pub rigid: Option<RigidMotions>,
    /// The model over the coordinates of the reduction, if points are means of nodes. All rows here are its rows.
    pub with_means: Option<FeModel>,
    /// Doubtful properties of the matrices, one sentence each.
    pub remarks: Vec<String>,
}

impl Reduction {
    /// Adds doubtful properties of the matrices. The structure adds those of its modes.
    fn with_remarks(self, remarks: Vec<String>) -> Self {
        let shown = Shown { rigid: self.structure.rigid_motions(), ..Shown::default() };
        let structure = self.structure.with_remarks(remarks.iter().cloned().chain(of_modes(shown)).collect());
        Self { structure, remarks, ..self }
    }

    /// Displacements `T z` of all rows of the model, over the coordinates of the reduction.
    pub fn recover(&self, z: &DMatrix<f64>) -> Result<DMatrix<f64>, StructureError> {
        let q = self.inner.omega_squared.len();
        let (modal, interface) = (z.rows(0, q).into_owned(), z.rows(q, self.rows.len()).into_owned());
        let inner = multiply(&self.inner.psi, &modal).step(STEP, ADVICE)?
            + multiply(&self.inner.constraint, &interface).step(STEP, ADVICE)?;
        let mut out = DMatrix::zeros(self.facts.order, z.ncols());
        for (position, &row) in self.inner_rows.iter().enumerate() {
            out.row_mut(row as usize).copy_from(&inner.row(position));
        }
        for (position, &row) in self.rows.iter().enumerate() {
            out.row_mut(row).copy_from(&interface.row(position));
        }
        Ok(out)
    }
}

/// Reduces a model. `tell` receives doubtful properties of the matrices before the work.
pub(super) fn reduce_in_parts(
    model: &FeModel,
    settings: &ReductionSettings,
    observer: &mut Observer,
    tell: impl FnOnce(&[String]),
) -> Result<Reduction, StructureError> {
    let cutoff_hz = settings.fixed_interface_cutoff_hz;
    if !(cutoff_hz.is_finite() && cutoff_hz > 0.0) {
        let expected = "a positive, finite frequency in Hz";
        return Err(StructureError::argument("fixed_interface_cutoff_hz", expected, cutoff_hz));
    }
    suspects::require_order(model)?;
    let rigid = RigidMotions::new(model);
    let remarks = of_matrices(model, rigid.as_ref());
    tell(&remarks);
    match reduce_known(model, settings, rigid, observer) {
        Ok(reduction) => Ok(reduction.with_remarks(remarks)),
        Err(error) => Err(error.with_causes(&remarks)),
    }
}

/// Reduces a model whose rigid motions are known.
fn reduce_known(
    model: &FeModel,
    settings: &ReductionSettings,
    rigid: Option<RigidMotions>,
    observer: &mut Observer,
) -> Result<Reduction, StructureError> {
    let suspect = suspects::mixed_units(model, rigid.as_ref().map(|rigid| rigid.mass_kg));
    let with_means = with_means(model, &settings.interface)?;
    let model = with_means.as_ref().unwrap_or(model);
    let (rows, dofs) = interface_rows(model, &settings.interface)?;
    let (kept, empty_rows) = inner_rows(model, &rows);
    let wanted = Wanted { limit: (TAU * settings.fixed_interface_cutoff_hz).powi(2), suspect };
    if suspect {
        require_few(model, &kept, wanted)?;
    }
    let pencil = observer
        .step("order and symbolic factorisation", || SymmetricPencil::new(model.stiffness(), model.mass(), &kept))
        .step("order of the inner degrees of freedom", "see whether the model fits into memory")?;
    let stiffness = blocks(model.stiffness(), pencil.rows(), &rows);
    let inner = solve_inner(&pencil, &stiffness.ob, wanted, observer)?;
    let matrices = observer.step("projection", || {
        let mut matrices = project(&pencil, &inner, stiffness, blocks(model.mass(), pencil.rows(), &rows))?;
        matrices.d_zz = damping(model, &pencil, &inner, &rows)?;
        Ok::<_, StructureError>(matrices)
    })?;
    let facts = ReductionFacts {
        order: model.order(),
        interface: rows.len(),
        inner: pencil.order(),
        empty_rows,
        fixed_interface_hz: inner.omega_squared.iter().map(|value| value.sqrt() / TAU).collect(),
        factor_len: pencil.factor_len(),
        lanczos_basis: inner.basis,
        shift_hz: inner.shift.sqrt() / TAU,
        inner_condition: inner.condition.map(|condition| condition.plain),
    };
    let interface = Interface::new(model.points().clone(), &dofs);
    let structure = observer.step("second eigenproblem", || ReducedStructure::new(matrices, interface))?;
    let inner_rows = pencil.rows().to_vec();
    Ok(Reduction { structure, facts, rows, inner_rows, inner, rigid, with_means, remarks: Vec::new() })
}

const STEP: &str = "projection on the Craig-Bampton basis";
const ADVICE: &str = "check the sizes of mass and stiffness";

/// `M_zz` and `K_zz`. `K_qb = 0` because constraint modes are static solutions; `M_qq = I` by normalisation.
fn project(
    pencil: &SymmetricPencil,
    inner: &Inner,
    stiffness: Blocks,
    mass: Blocks,
) -> Result<ReducedMatrices, StructureError> {
    let Inner { omega_squared, psi, constraint: g, .. } = inner;
    let (q, b) = (omega_squared.len(), g.ncols());
    let inertia = pencil.mass_times(g).step(STEP, ADVICE)? + &mass.ob;
    let coupling = multiply_transposed(psi, &inertia).step(STEP, ADVICE)?;
    let carried = multiply_transposed(&mass.ob, g).step(STEP, ADVICE)?;
    let m_bb = multiply_transposed(g, &inertia).step(STEP, ADVICE)? + carried + mass.bb;
    let k_bb = multiply_transposed(&stiffness.ob, g).step(STEP, ADVICE)? + stiffness.bb;
    let (mut m_zz, mut k_zz) = (DMatrix::identity(q + b, q + b), DMatrix::zeros(q + b, q + b));
    for (i, &value) in omega_squared.iter().enumerate() {
        k_zz[(i, i)] = value;
    }
    m_zz.view_mut((0, q), (q, b)).copy_from(&coupling);
    m_zz.view_mut((q, 0), (b, q)).copy_from(&coupling.transpose());
    m_zz.view_mut((q, q), (b, b)).copy_from(&symmetric_part(m_bb));
    k_zz.view_mut((q, q), (b, b)).copy_from(&symmetric_part(k_bb));
    let transfer = DMatrix::from_fn(b, q + b, |row, column| if column == q + row { 1.0 } else { 0.0 });
    Ok(ReducedMatrices { m_zz, k_zz, d_zz: None, transfer })
}

/// `D_zz = T' D T`, if the model has a damping matrix.
fn damping(
    model: &FeModel,
    pencil: &SymmetricPencil,
    inner: &Inner,
    interface: &[usize],
) -> Result<Option<DMatrix<f64>>, StructureError> {
    let Some(damping) = model.damping() else { return Ok(None) };
    let (q, b) = (inner.omega_squared.len(), interface.len());
    let mut basis = DMatrix::zeros(model.order(), q + b);
    for (position, &row) in pencil.rows().iter().enumerate() {
        basis.view_mut((row as usize, 0), (1, q)).copy_from(&inner.psi.row(position));
        basis.view_mut((row as usize, q), (1, b)).copy_from(&inner.constraint.row(position));
    }
    for (column, &row) in interface.iter().enumerate() {
        basis[(row, q + column)] = 1.0;
    }
    let d_zz = multiply_transposed(&basis, &sparse_times(damping, &basis)).step(STEP, ADVICE)?;
    Ok(Some(symmetric_part(d_zz)))
}
