//! Eigenpairs of a diagonal matrix to which one of few columns is added, `(N + U U') z = nu z`.
//!
//! With the poles `nu_i` on the diagonal of N, an eigenvalue solves `det H(nu) = 0`, `H = I - sum u_i u_i' / (nu - nu_i)`, a matrix
//! as small as U has columns, and its vector is `z_i = u_i' q / (nu - nu_i)` with `H q = 0`. A dense solution of n poles takes
//! some `10 n^3` products; here a pair takes `n r^2` a few times.
//!
//! - Poles near an eigenvalue make H useless for arithmetic. Of a window of poles the matrix itself is kept beside q,
//!   `T(nu) = [N_w - nu, U_w; U_w', -H_far(nu)]`, which is smooth there ([`window`]).
//! - Linear in nu around the window's centre, T is a symmetric pencil, whose pairs are those of T but for the curvature of
//!   `H_far`; that is put back by perturbation of each pair.
//! - What has been found is counted: by Sylvester's law of inertia as many eigenvalues lie above nu as there are poles above it
//!   and negative eigenvalues of `H(nu)` ([`march`]). A window keeps what the count confirms; where none comes to an end, the
//!   matrix is solved as a dense one.

mod march;
mod small;
mod sums;
mod window;

use nalgebra::DMatrix;

use super::{LinalgError, multiply, multiply_transposed, symmetric_eigen};
use march::march;
use sums::weighted_square;

/// Poles per column of U below which a dense solution costs no more.
const LEAST_POLES_PER_COLUMN: usize = 16;
/// Share of the largest eigenvalue below which rounding of the poles decides, per pole.
const NOISE: f64 = 4.0 * f64::EPSILON;

/// Eigenpairs of `N + U U'`.
#[derive(Debug, Clone)]
pub struct UpdatedPairs {
    /// Eigenvalues, falling.
    pub values: Vec<f64>,
    /// Unit eigenvectors by column (poles x eigenvalues).
    pub vectors: DMatrix<f64>,
    /// `U' z` by column (columns of U x eigenvalues).
    pub coupled: DMatrix<f64>,
}

/// The eigenpairs of `N + U U'` whose value is above `least`, the largest first.
///
/// `poles`: the diagonal of N, falling, none negative. `columns`: U (poles x r). What rounding of the largest pole reaches is left
/// out (`4 n eps` of the largest eigenvalue).
///
/// # Errors
/// Sizes that do not match, entries that are not finite, no convergence of a dense solution.
pub fn updated_pairs(poles: &[f64], columns: &DMatrix<f64>, least: f64) -> Result<UpdatedPairs, LinalgError> {
    let n = poles.len();
    if columns.nrows() != n {
        return Err(LinalgError::Shape { left: (n, n), right: columns.shape() });
    }
    if poles.iter().chain(columns.iter()).any(|value| !value.is_finite()) {
        return Err(LinalgError::NotFinite { order: n });
    }
    let gram = multiply_transposed(columns, columns)?;
    let largest = poles.first().copied().unwrap_or(0.0) + gram.trace();
    let least = least.max(NOISE * n as f64 * largest);
    let pairs = if columns.ncols() == 0 {
        let above = poles.partition_point(|pole| *pole > least);
        Some((poles[..above].to_vec(), DMatrix::identity(n, above)))
    } else if n < LEAST_POLES_PER_COLUMN * columns.ncols() {
        None
    } else {
        march(poles, columns, least)
    };
    let (mut values, vectors) = match pairs {
        Some(pairs) => pairs,
        None => dense(poles, columns, least)?,
    };
    let coupled = multiply_transposed(columns, &vectors)?;
    for ((value, vector), coupled) in values.iter_mut().zip(vectors.column_iter()).zip(coupled.column_iter()) {
        // Rayleigh's quotient: its error is the square of the vector's.
        *value = weighted_square(poles, vector.as_slice()) + coupled.norm_squared();
    }
    Ok(UpdatedPairs { values, vectors, coupled })
}

/// The same by a dense solution.
fn dense(poles: &[f64], columns: &DMatrix<f64>, least: f64) -> Result<(Vec<f64>, DMatrix<f64>), LinalgError> {
    let mut matrix = multiply(columns, &columns.transpose())?;
    for (i, pole) in poles.iter().enumerate() {
        matrix[(i, i)] += pole;
    }
    let eigen = symmetric_eigen(&matrix)?;
    let above: Vec<usize> = (0..poles.len()).rev().take_while(|&i| eigen.values[i] > least).collect();
    Ok((above.iter().map(|&i| eigen.values[i]).collect(), eigen.vectors.select_columns(&above)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1) that look random.
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Every pair solves the problem, all are orthonormal, and the values are those of a dense solution.
    fn holds(poles: &[f64], columns: &DMatrix<f64>, least: f64, marched: bool) {
        let UpdatedPairs { values, vectors, .. } = updated_pairs(poles, columns, least).expect("solves");
        assert!(!marched || march(poles, columns, least.max(1e-13)).is_some(), "comes to an end");
        let (expected, _) = dense(poles, columns, least).expect("converges");
        assert_eq!(values.len(), expected.len());
        let largest = expected.first().copied().unwrap_or(1.0);
        for (k, (value, expected)) in values.iter().zip(&expected).enumerate() {
            assert!((value - expected).abs() < 1e-13 * largest, "value {k}: {value:e} instead of {expected:e}");
        }
        let through = columns * (columns.transpose() * &vectors);
        for (k, value) in values.iter().enumerate() {
            let residual = (0..poles.len())
                .map(|i| ((poles[i] - value) * vectors[(i, k)] + through[(i, k)]).powi(2))
                .sum::<f64>()
                .sqrt();
            assert!(residual < 1e-9 * value, "pair {k}: residual {:e}", residual / value);
        }
        let gram = vectors.transpose() * &vectors;
        let worst = (gram - DMatrix::identity(values.len(), values.len())).amax();
        assert!(worst < 1e-8, "orthonormal to {worst:e}");
    }

    /// Poles of a structure: squares of frequencies that grow denser, in the inverse.
    fn poles(n: usize, draw: &mut impl FnMut() -> f64) -> Vec<f64> {
        let mut poles: Vec<f64> = (0..n).map(|i| (3.0 + i as f64 + 0.9 * draw()).powi(-2)).collect();
        poles.sort_by(|a, b| b.total_cmp(a));
        poles
    }

    #[test]
    fn pairs_are_those_of_the_dense_problem() {
        for (n, r, seed) in [(100, 6, 1), (331, 6, 2), (546, 6, 3), (120, 1, 4), (400, 12, 5), (350, 18, 6)] {
            let mut draw = noise(seed);
            let poles = poles(n, &mut draw);
            // From none to strong coupling, as points of a structure have.
            let columns = DMatrix::from_fn(n, r, |i, _| {
                (draw() - 0.5) * 10f64.powf(-6.0 * draw()) * poles[i].sqrt() * if i % 17 == 3 { 0.0 } else { 1.0 }
            });
            holds(&poles, &columns, 0.0, true);
            holds(&poles, &columns, poles[n / 2], true);
        }
    }

    #[test]
    fn equal_poles_and_poles_that_nothing_moves() {
        let mut draw = noise(7);
        let mut poles = poles(200, &mut draw);
        for i in (10..180).step_by(10) {
            poles[i + 1] = poles[i];
            poles[i + 2] = poles[i] * (1.0 - 1e-15);
        }
        poles[190..].fill(0.0);
        let columns = DMatrix::from_fn(200, 6, |i, _| if i % 3 == 0 { 0.0 } else { (draw() - 0.5) * poles[i].sqrt() });
        holds(&poles, &columns, 0.0, false);
        holds(&poles, &DMatrix::zeros(200, 6), 0.0, false);
        holds(&poles, &DMatrix::zeros(200, 0), 0.0, false);
        holds(&[], &DMatrix::zeros(0, 2), 0.0, false);
        holds(&poles[..5], &columns.rows(0, 5).into_owned(), 0.0, false);
    }

    #[test]
    fn bad_input_is_an_error() {
        let columns = DMatrix::from_element(3, 1, 1.0);
        assert!(matches!(updated_pairs(&[1.0, 0.5], &columns, 0.0), Err(LinalgError::Shape { .. })));
        assert!(matches!(updated_pairs(&[1.0, f64::NAN, 0.0], &columns, 0.0), Err(LinalgError::NotFinite { .. })));
    }
}
