//! Sparse Cholesky factorisation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};
use nalgebra::DMatrix;
use sprs::CsMat;

use super::LinalgError;
use super::dense::view_mut;

/// `P A P' = L L'` of a sparse symmetric positive definite matrix, rows ordered by approximate minimum degree.
#[derive(Debug)]
pub struct SparseCholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl SparseCholesky {
    /// Factorises a symmetric matrix given with both triangles.
    ///
    /// # Errors
    /// Not square, not finite, not positive definite, not enough memory.
    pub fn new(a: &CsMat<f64>) -> Result<Self, LinalgError> {
        let order = a.rows();
        if a.rows() != a.cols() {
            return Err(LinalgError::Shape { left: a.shape(), right: (a.cols(), a.rows()) });
        }
        if a.data().iter().any(|value| !value.is_finite()) {
            return Err(LinalgError::NotFinite { order });
        }
        // Both triangles are stored, so compressed rows and compressed columns hold the same matrix.
        let pointers = a.proper_indptr();
        let pattern = SymbolicSparseColMatRef::new_checked(order, order, &pointers, None, a.indices());
        let matrix = SparseColMatRef::new(pattern, a.data());
        let memory = |_| LinalgError::OutOfMemory { order };
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, Default::default(), Default::default())
            .map_err(memory)?;
        let mut values = Vec::new();
        values.try_reserve_exact(symbolic.len_val()).map_err(|_| LinalgError::OutOfMemory { order })?;
        values.resize(symbolic.len_val(), 0.0);
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| LinalgError::OutOfMemory { order })?;
        symbolic
            .factorize_numeric_llt(
                &mut values,
                matrix,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut buffer),
                Default::default(),
            )
            .map_err(|_| LinalgError::NotPositiveDefinite { order })?;
        Ok(Self { symbolic, values })
    }

    /// Number of rows of the matrix.
    pub fn order(&self) -> usize {
        self.symbolic.nrows()
    }

    /// Solves `A X = B` in place for all columns of `rhs`.
    ///
    /// # Errors
    /// Sizes that do not match, not enough memory.
    pub fn solve(&self, rhs: &mut DMatrix<f64>) -> Result<(), LinalgError> {
        let order = self.order();
        if rhs.nrows() != order {
            return Err(LinalgError::Shape { left: (order, order), right: rhs.shape() });
        }
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(rhs.ncols(), Par::Seq);
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| LinalgError::OutOfMemory { order })?;
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            view_mut(rhs),
            Par::Seq,
            MemStack::new(&mut buffer),
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprs::TriMat;

    /// Fixed-fixed chain of n unit masses and n + 1 unit springs.
    fn chain(n: usize) -> CsMat<f64> {
        let mut triplets = TriMat::new((n, n));
        for i in 0..n {
            triplets.add_triplet(i, i, 2.0);
            if i + 1 < n {
                triplets.add_triplet(i, i + 1, -1.0);
                triplets.add_triplet(i + 1, i, -1.0);
            }
        }
        triplets.to_csr()
    }

    #[test]
    fn chain_under_unit_load_takes_the_parabola() {
        let n = 300;
        let mut x = DMatrix::from_element(n, 2, 1.0);
        SparseCholesky::new(&chain(n)).expect("positive definite").solve(&mut x).expect("sizes");
        for i in 0..n {
            let exact = 0.5 * (i as f64 + 1.0) * (n as f64 - i as f64);
            assert!((x[(i, 1)] / exact - 1.0).abs() < 1e-11, "{i}: {} {exact}", x[(i, 1)]);
        }
    }

    #[test]
    fn free_chain_and_bad_shapes_are_errors() {
        let mut free = chain(10);
        free.data_mut()[0] = 0.0;
        let error = SparseCholesky::new(&free).err();
        assert_eq!(error, Some(LinalgError::NotPositiveDefinite { order: 10 }));
        free.data_mut()[0] = f64::NAN;
        assert_eq!(SparseCholesky::new(&free).err(), Some(LinalgError::NotFinite { order: 10 }));
        let wide: CsMat<f64> = CsMat::zero((2, 3));
        assert!(matches!(SparseCholesky::new(&wide), Err(LinalgError::Shape { .. })));
        let factor = SparseCholesky::new(&chain(10)).expect("positive definite");
        assert!(matches!(factor.solve(&mut DMatrix::zeros(9, 1)), Err(LinalgError::Shape { .. })));
    }
}
