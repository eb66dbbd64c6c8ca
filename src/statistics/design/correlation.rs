//! Rank correlations: by rearrangement (Iman and Conover) or point by point (Gaussian copula).

use std::f64::consts::PI;

use super::error::DesignError;
use decore_math::special::{normal_cdf, normal_quantile};

/// A matrix of rank correlations (Spearman) that factors shall have.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Correlation {
    asked: Vec<Vec<f64>>,
    /// Lower Cholesky factor of the correlations of normal scores.
    factor: Vec<Vec<f64>>,
}

impl Correlation {
    /// Checks the matrix: square of this size, symmetric, ones on the diagonal, positive definite.
    pub(super) fn new(matrix: &[Vec<f64>], size: usize) -> Result<Self, DesignError> {
        let fault = |message: String| Err(DesignError::Correlation(message));
        if matrix.len() != size || matrix.iter().any(|row| row.len() != size) {
            return fault(format!("the rank correlations must be a {size} x {size} matrix, a row per factor"));
        }
        for (i, row) in matrix.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let mirrored = matrix.get(j).and_then(|row| row.get(i)).copied().unwrap_or(f64::NAN);
                // Written so that a NaN is a fault.
                if i == j && *entry != 1.0 {
                    return fault(format!("the rank correlation of factor {i} with itself is {entry}, expected 1"));
                }
                if i != j && !(entry.abs() < 1.0 && *entry == mirrored) {
                    return fault(format!(
                        "the rank correlations of factors {i} and {j} are {entry} and {mirrored}, expected the same \
                         number between -1 and 1"
                    ));
                }
            }
        }
        // Correlation of normal variables whose ranks correlate as wanted (Pearson 1907).
        let normal = matrix.iter().map(|row| row.iter().map(|rho| 2.0 * libm::sin(PI * rho / 6.0)).collect()).collect();
        match cholesky(normal) {
            Some(factor) => Ok(Self { asked: matrix.to_vec(), factor }),
            None => fault("the rank correlations contradict each other: the matrix is not positive definite".into()),
        }
    }

    /// Requested matrix.
    pub(super) fn asked(&self) -> &[Vec<f64>] {
        &self.asked
    }

    /// Independent probabilities become correlated ones, each still uniform.
    pub(super) fn copula(&self, independent: &[f64]) -> Vec<f64> {
        let half_step = f64::EPSILON / 2.0;
        let clamp = |u: f64| u.clamp(half_step, 1.0 - half_step);
        let scores: Vec<f64> = independent.iter().map(|u| normal_quantile(clamp(*u))).collect();
        let correlated = |row: &Vec<f64>| row.iter().zip(&scores).map(|(factor, z)| factor * z).sum::<f64>();
        let mixes = |row: &Vec<f64>| row.iter().filter(|factor| **factor != 0.0).count() > 1;
        let pairs = self.factor.iter().zip(independent);
        pairs.map(|(row, u)| if mixes(row) { normal_cdf(correlated(row)) } else { *u }).collect()
    }

    /// Rearranges each column (Iman and Conover, Commun. Stat. B 11, 1982): the set of entries stays, and their ranks follow scores with
    /// exactly the wanted correlation. Swaps correct the rest: see [`super::ranks::Ranks`].
    pub(super) fn rearrange(&self, columns: &mut [&mut [u32]]) -> Result<(), DesignError> {
        let rows = columns.first().map_or(0, |column| column.len());
        let scores = (0..rows).map(|row| normal_quantile((row + 1) as f64 / (rows + 1) as f64));
        let scores: Vec<f64> = scores.collect();
        // Assign scores in each column's own order, so that an uncorrelated design stays unchanged.
        let mut table: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
        for column in columns.iter() {
            let mut score = vec![0.0; rows];
            for (row, value) in order(column).into_iter().zip(&scores) {
                score[row] = *value;
            }
            table.push(score);
        }
        let own = cholesky(correlations(&table)).ok_or_else(|| {
            DesignError::Correlation(format!("{rows} rows are too few to correlate {} factors", columns.len()))
        })?;
        let mut target = vec![0.0; columns.len()];
        let mut mixed = vec![vec![0.0; rows]; columns.len()];
        for row in 0..rows {
            // target = P Q^-1 scores, by forward substitution.
            for i in 0..target.len() {
                let known: f64 = own[i].iter().zip(&target).take(i).map(|(q, t)| q * t).sum();
                target[i] = (table[i][row] - known) / own[i][i];
            }
            for (mixed, factor) in mixed.iter_mut().zip(&self.factor) {
                mixed[row] = factor.iter().zip(&target).map(|(p, t)| p * t).sum();
            }
        }
        for (column, mixed) in columns.iter_mut().zip(&mixed) {
            let mut sorted = column.to_vec();
            sorted.sort_unstable();
            let mut places: Vec<usize> = (0..rows).collect();
            places.sort_by(|a, b| mixed[*a].total_cmp(&mixed[*b]));
            for (row, value) in places.into_iter().zip(sorted) {
                column[row] = value;
            }
        }
        Ok(())
    }
}

/// Rows in the order of their entries.
fn order(column: &[u32]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..column.len()).collect();
    order.sort_by_key(|row| column[*row]);
    order
}

fn correlations(table: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    // Normal scores have the mean 0 and all columns the same norm.
    let norm = table.first().map_or(1.0, |column| product(column, column));
    table.iter().map(|a| table.iter().map(|b| product(a, b) / norm).collect()).collect()
}

/// Lower Cholesky factor; `None` unless positive definite beyond rounding.
fn cholesky(matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let size = matrix.len();
    let mut factor = vec![vec![0.0; size]; size];
    for i in 0..size {
        for j in 0..=i {
            let known: f64 = factor[i].iter().zip(&factor[j]).take(j).map(|(a, b)| a * b).sum();
            let rest = matrix[i][j] - known;
            if i == j {
                if rest.is_nan() || rest <= 1e-10 {
                    return None;
                }
                factor[i][i] = rest.sqrt();
            } else {
                factor[i][j] = rest / factor[j][j];
            }
        }
    }
    Some(factor)
}
