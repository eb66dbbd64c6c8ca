//! Transformations that keep a matrix symmetric.

use nalgebra::DMatrix;

use super::error::{Step, StructureError};
use decore_math::linalg::solve_lower;

/// `L^-1 A L^-T` of a symmetric A.
pub(super) fn congruence(l: &DMatrix<f64>, mut a: DMatrix<f64>) -> Result<DMatrix<f64>, StructureError> {
    const STEP: &str = "congruence transformation";
    const ADVICE: &str = "check the sizes of mass and stiffness";
    solve_lower(l, &mut a).step(STEP, ADVICE)?;
    a.transpose_mut();
    solve_lower(l, &mut a).step(STEP, ADVICE)?;
    Ok(symmetric_part(a))
}

/// `(A + A') / 2`.
pub(super) fn symmetric_part(a: DMatrix<f64>) -> DMatrix<f64> {
    (&a + a.transpose()) * 0.5
}
