//! Dense kernels on column-major `nalgebra` matrices.

use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::inverse::{inverse, inverse_scratch};
use faer::linalg::evd::{ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::{matmul, triangular_solve};
use faer::{Accum, Auto, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

use super::LinalgError;

/// Eigenvalues and eigenvectors of a symmetric matrix, `A = V diag(values) V'`, `V' V = I`.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// Eigenvalues, rising.
    pub values: Vec<f64>,
    /// Eigenvectors by column, in the order of the values.
    pub vectors: DMatrix<f64>,
}

/// Largest residual relative to the largest eigenvalue with which an eigensolution counts as exact to rounding, see
/// [`SymmetricEigen::residual`].
const RESIDUAL: f64 = 1e-11;

pub(super) fn view(a: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

pub(super) fn view_mut(a: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = a.shape();
    MatMut::from_column_major_slice_mut(a.as_mut_slice(), rows, columns)
}

fn require_square_and_finite(a: &DMatrix<f64>) -> Result<usize, LinalgError> {
    if a.nrows() != a.ncols() {
        return Err(LinalgError::Shape { left: a.shape(), right: (a.ncols(), a.nrows()) });
    }
    if a.as_slice().iter().any(|value| !value.is_finite()) {
        return Err(LinalgError::NotFinite { order: a.nrows() });
    }
    Ok(a.nrows())
}

fn require_rows(a: &DMatrix<f64>, rhs: &DMatrix<f64>) -> Result<(), LinalgError> {
    if a.nrows() == a.ncols() && a.ncols() == rhs.nrows() {
        return Ok(());
    }
    Err(LinalgError::Shape { left: a.shape(), right: rhs.shape() })
}

/// Lower Cholesky factor `L` with `A = L L'`; reads the lower triangle only, zeros above the diagonal.
///
/// # Errors
/// Not square, not finite, not positive definite.
pub fn cholesky(mut a: DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    let n = require_square_and_finite(&a)?;
    let mut memory = MemBuffer::try_new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()))
        .map_err(|_| LinalgError::OutOfMemory { order: n })?;
    cholesky_in_place(view_mut(&mut a), Default::default(), Par::Seq, MemStack::new(&mut memory), Default::default())
        .map_err(|_| LinalgError::NotPositiveDefinite { order: n })?;
    a.fill_upper_triangle(0.0, 1);
    Ok(a)
}

/// The inverse of `A = L L'`, whole, from its lower Cholesky factor.
///
/// # Errors
/// Not square, not finite.
pub fn cholesky_inverse(l: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    let n = require_square_and_finite(l)?;
    let mut memory =
        MemBuffer::try_new(inverse_scratch::<f64>(n, Par::Seq)).map_err(|_| LinalgError::OutOfMemory { order: n })?;
    let mut out = DMatrix::zeros(n, n);
    inverse(view_mut(&mut out), view(l), Par::Seq, MemStack::new(&mut memory));
    out.fill_upper_triangle_with_lower_triangle();
    Ok(out)
}

/// Solves `L X = B` in place for a lower triangular `L`.
///
/// # Errors
/// Sizes that do not match.
pub fn solve_lower(l: &DMatrix<f64>, rhs: &mut DMatrix<f64>) -> Result<(), LinalgError> {
    require_rows(l, rhs)?;
    triangular_solve::solve_lower_triangular_in_place(view(l), view_mut(rhs), Par::Seq);
    Ok(())
}

/// Solves `L' X = B` in place for a lower triangular `L`.
///
/// # Errors
/// Sizes that do not match.
pub fn solve_lower_transposed(l: &DMatrix<f64>, rhs: &mut DMatrix<f64>) -> Result<(), LinalgError> {
    require_rows(l, rhs)?;
    triangular_solve::solve_upper_triangular_in_place(view(l).transpose(), view_mut(rhs), Par::Seq);
    Ok(())
}

/// The product `A B`.
///
/// # Errors
/// Sizes that do not match.
pub fn multiply(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    product(view(a), view(b))
}

/// The product `A' B`.
///
/// # Errors
/// Sizes that do not match.
pub fn multiply_transposed(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    product(view(a).transpose(), view(b))
}

fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<DMatrix<f64>, LinalgError> {
    if a.ncols() != b.nrows() {
        return Err(LinalgError::Shape { left: (a.nrows(), a.ncols()), right: (b.nrows(), b.ncols()) });
    }
    let mut out = DMatrix::zeros(a.nrows(), b.ncols());
    matmul::matmul(view_mut(&mut out), Accum::Replace, a, b, 1.0, Par::Seq);
    Ok(out)
}

/// Eigenvalues and eigenvectors of a symmetric matrix; reads the lower triangle only.
///
/// Divide and conquer, which for some matrices (a block of equal bricks) errs by 3e-8 of the largest eigenvalue; then QR iterations.
///
/// # Errors
/// Not square, not finite, no convergence.
pub fn symmetric_eigen(a: &DMatrix<f64>) -> Result<SymmetricEigen, LinalgError> {
    let with = |params: SelfAdjointEvdParams| -> Result<SymmetricEigen, LinalgError> {
        let mut vectors = DMatrix::zeros(a.nrows(), a.nrows());
        let values = eigen(a, Some(&mut vectors), params)?;
        Ok(SymmetricEigen { values, vectors })
    };
    let fast = with(auto_params())?;
    if fast.residual(a) <= RESIDUAL {
        return Ok(fast);
    }
    with(SelfAdjointEvdParams { recursion_threshold: usize::MAX, ..auto_params() })
}

/// The parameters that faer takes by default.
fn auto_params() -> SelfAdjointEvdParams {
    <SelfAdjointEvdParams as Auto<f64>>::auto()
}

impl SymmetricEigen {
    /// Largest entry of `(A V - V diag(values)) x` over the largest eigenvalue, for two vectors x: the residual costs no product of matrices.
    fn residual(&self, a: &DMatrix<f64>) -> f64 {
        let n = a.nrows();
        let values = DVector::from_column_slice(&self.values);
        let of = |frequency: f64| {
            let x = DVector::from_fn(n, |row, _| libm::sin(frequency * (row + 1) as f64).signum());
            let mut residual = &self.vectors * x.component_mul(&values);
            // Reads the lower triangle, as the solver does.
            residual.sygemv(-1.0, a, &(&self.vectors * &x), 1.0);
            residual
                .iter()
                .fold(0.0, |most: f64, entry| if entry.is_finite() { most.max(entry.abs()) } else { f64::INFINITY })
        };
        let largest = values.iter().fold(f64::MIN_POSITIVE, |largest, value| largest.max(value.abs()));
        of(1.3).max(of(2.3)) / largest
    }
}

/// Eigenvalues of a symmetric matrix, rising; reads the lower triangle only.
///
/// # Errors
/// Not square, not finite, no convergence.
pub fn symmetric_eigenvalues(a: &DMatrix<f64>) -> Result<Vec<f64>, LinalgError> {
    eigen(a, None, auto_params())
}

fn eigen(
    a: &DMatrix<f64>,
    vectors: Option<&mut DMatrix<f64>>,
    params: SelfAdjointEvdParams,
) -> Result<Vec<f64>, LinalgError> {
    let n = require_square_and_finite(a)?;
    let mut values = vec![0.0; n];
    if n == 0 {
        return Ok(values);
    }
    let wanted = if vectors.is_some() { ComputeEigenvectors::Yes } else { ComputeEigenvectors::No };
    let mut memory = MemBuffer::try_new(self_adjoint_evd_scratch::<f64>(n, wanted, Par::Seq, params.into()))
        .map_err(|_| LinalgError::OutOfMemory { order: n })?;
    self_adjoint_evd(
        view(a),
        DiagMut::from_slice_mut(&mut values),
        vectors.map(view_mut),
        Par::Seq,
        MemStack::new(&mut memory),
        params.into(),
    )
    .map_err(|_| LinalgError::NoConvergence { order: n })?;
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spd(n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| 1.0 / (1.0 + i as f64 + j as f64) + if i == j { 2.0 } else { 0.0 })
    }

    #[test]
    fn cholesky_and_triangular_solves_invert_the_matrix() {
        let a = spd(40);
        let l = cholesky(a.clone()).expect("positive definite");
        let x = DMatrix::from_fn(40, 3, |i, j| (i as f64 * 0.3 + j as f64).sin());
        let mut rhs = multiply(&a, &x).expect("sizes");
        solve_lower(&l, &mut rhs).expect("sizes");
        solve_lower_transposed(&l, &mut rhs).expect("sizes");
        assert!((rhs - x).amax() < 1e-13);
        assert_eq!(l[(0, 39)], 0.0);
        let inverse = cholesky_inverse(&l).expect("sizes");
        assert!((multiply(&a, &inverse).expect("sizes") - DMatrix::identity(40, 40)).amax() < 1e-13);
    }

    #[test]
    fn products_of_all_shapes_are_those_of_plain_sums() {
        // Around the sizes of micro kernels and cache blocks: tall, wide, deep.
        for (m, k, n) in [(49, 2000, 1), (513, 513, 513), (4100, 20, 9), (9, 20, 4100), (700, 600, 40), (40, 1100, 700)]
        {
            let a = DMatrix::from_fn(m, k, |i, j| (i as f64 * 0.7 + j as f64 * 1.3).sin());
            let b = DMatrix::from_fn(k, n, |i, j| (i as f64 * 0.9 - j as f64 * 0.4).cos());
            let plain = &a * &b;
            let limit = 1e-15 * k as f64;
            assert!((multiply(&a, &b).expect("sizes") - &plain).amax() < limit, "{m} {k} {n}");
            assert!((multiply_transposed(&a.transpose(), &b).expect("sizes") - &plain).amax() < limit, "{m} {k} {n}'");
        }
    }

    #[test]
    fn eigenvectors_diagonalise_and_values_rise() {
        let a = spd(150);
        let eigen = symmetric_eigen(&a).expect("converges");
        let mut scaled = eigen.vectors.clone();
        for (mut column, value) in scaled.column_iter_mut().zip(&eigen.values) {
            column *= *value;
        }
        assert!((multiply(&a, &eigen.vectors).expect("sizes") - scaled).amax() < 1e-13);
        assert!(eigen.values.is_sorted());
        let values = symmetric_eigenvalues(&a).expect("converges");
        assert!(values.iter().zip(&eigen.values).all(|(p, q)| (p - q).abs() < 1e-13));
    }

    /// Entries above the diagonal are not read: wrong ones there do not count as a wrong solution.
    #[test]
    fn eigensolutions_are_verified_by_the_lower_triangle() {
        for order in [5, 150] {
            let (whole, lower) = (spd(order), spd(order).lower_triangle());
            let [all, half] = [&whole, &lower].map(|a| symmetric_eigen(a).expect("converges"));
            assert_eq!((all.values, &all.vectors), (half.values.clone(), &half.vectors));
            assert!(half.residual(&lower) < 1e-13, "{:e}", half.residual(&lower));
            let wrong =
                SymmetricEigen { values: half.values.iter().map(|value| value * (1.0 + 1e-8)).collect(), ..half };
            assert!(wrong.residual(&lower) > RESIDUAL);
        }
    }

    #[test]
    fn bad_matrices_are_errors() {
        let mut a = spd(5);
        a[(3, 3)] = -1.0;
        assert_eq!(cholesky(a.clone()), Err(LinalgError::NotPositiveDefinite { order: 5 }));
        a[(3, 3)] = f64::NAN;
        assert_eq!(cholesky(a.clone()), Err(LinalgError::NotFinite { order: 5 }));
        assert!(matches!(symmetric_eigen(&a), Err(LinalgError::NotFinite { .. })));
        assert!(matches!(symmetric_eigenvalues(&DMatrix::zeros(2, 3)), Err(LinalgError::Shape { .. })));
        assert!(matches!(multiply(&spd(3), &spd(4)), Err(LinalgError::Shape { .. })));
        assert_eq!(symmetric_eigenvalues(&DMatrix::zeros(0, 0)), Ok(vec![]));
    }
}
