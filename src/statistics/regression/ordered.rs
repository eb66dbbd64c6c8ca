//! Cholesky factors and forward substitution in one order of operations.
//!
//! The variance at a place is a small difference of large numbers. Another program gets the same digits only with the same operations, each
//! rounded separately. Every entry is computed by subtracting one product after the other, starting with the first column; the order in
//! which entries are processed changes nothing.

use nalgebra::DMatrix;
use pulp::Arch;

use decore_math::linalg::LinalgError;

/// Columns that are finished together, so that those before them are read once for all of them.
const BLOCK: usize = 32;

/// Lower Cholesky factor `L` of `A = L L'`; reads the lower triangle only, zeros above the diagonal.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`].
pub(super) fn ordered_cholesky(mut a: DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    let order = a.nrows();
    for first in (0..order).step_by(BLOCK) {
        let last = (first + BLOCK).min(order);
        let (before, rest) = a.as_mut_slice().split_at_mut(first * order);
        Arch::new().dispatch(|| {
            for known in before.chunks_exact(order) {
                (first..last).for_each(|column| {
                    subtract(&mut rest[(column - first) * order..][column..order], (&known[column..], known[column]))
                });
            }
        });
        for column in first..last {
            let (known, after) = rest.split_at_mut((column + 1 - first) * order);
            let known = &mut known[(column - first) * order..];
            let pivot = known[column].sqrt();
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(LinalgError::NotPositiveDefinite { order });
            }
            known[column] = pivot;
            known[column + 1..].iter_mut().for_each(|entry| *entry /= pivot);
            let known = &*known;
            Arch::new().dispatch(|| {
                for next in column + 1..last {
                    subtract(&mut after[(next - column - 1) * order..][next..order], (&known[next..], known[next]));
                }
            });
        }
    }
    a.fill_upper_triangle(0.0, 1);
    Ok(a)
}

/// Solves `L x = b` for many right-hand sides at once: the columns of `sides` are the rows of all `b`, and of all `x` in the end.
pub(super) fn ordered_solve(factor: &DMatrix<f64>, sides: &mut DMatrix<f64>) {
    let (count, order) = sides.shape();
    if count == 0 {
        return;
    }
    Arch::new().dispatch(|| {
        for column in 0..order {
            let (known, after) = sides.as_mut_slice().split_at_mut((column + 1) * count);
            let known = &mut known[column * count..];
            let below = &factor.as_slice()[column * order..(column + 1) * order][column..];
            known.iter_mut().for_each(|entry| *entry /= below[0]);
            for (rest, entry) in after.chunks_exact_mut(count).zip(&below[1..]) {
                subtract(rest, (known, *entry));
            }
        }
    });
}

#[inline(always)]
fn subtract(from: &mut [f64], (of, times): (&[f64], f64)) {
    from.iter_mut().zip(of).for_each(|(from, of)| *from -= of * times);
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::linalg::{cholesky, solve_lower};
    use decore_math::random::uniform;

    #[test]
    fn it_is_the_factor_and_the_solution_to_rounding() {
        let order = 75;
        let wide = DMatrix::from_fn(order, order, |row, column| uniform(1, row as u64, column as u64) - 0.5);
        let matrix = &wide * wide.transpose() + DMatrix::identity(order, order);
        let factor = ordered_cholesky(matrix.clone()).expect("a factor");
        let dense = cholesky(matrix).expect("a factor");
        assert!((&factor - &dense).amax() < 1e-13);
        let mut sides = DMatrix::from_fn(9, order, |side, row| uniform(2, side as u64, row as u64));
        let mut expected = sides.transpose();
        solve_lower(&dense, &mut expected).expect("a solution");
        ordered_solve(&factor, &mut sides);
        assert!((sides.transpose() - expected).amax() < 1e-13);
        let refused = ordered_cholesky(DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]));
        assert_eq!(refused, Err(LinalgError::NotPositiveDefinite { order: 2 }));
    }
}
