//! How probable a table is, given lengths and noise.

use nalgebra::DMatrix;

use super::kernel::Kernel;
use super::minimise::{Sloped, dot};
use super::ordered::ordered_cholesky;
use super::points::Points;
use crate::linalg::{LinalgError, cholesky, cholesky_inverse};

/// Least noise, as a share of the process's variance: below it, rounding decides.
pub const LEAST_NOISE: f64 = 1e-6;
/// Mean and standard deviation of the logarithm of a length, beside half that of the number of factors (Hvarfner, Hellsten and
/// Nardi, ICML 2024): lengths grow with the number of factors as distances do.
const LENGTHS: [f64; 2] = [std::f64::consts::SQRT_2, 1.732_050_807_568_877_2];
/// Mean and standard deviation of the logarithm of the noise's share.
const NOISE: [f64; 2] = [-14.0, 3.0];

/// Lengths and noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Hyperparameters {
    /// Inverse squared length of each factor, in its scaled range.
    pub weights: Vec<f64>,
    /// Variance of the noise over that of the process.
    pub noise: f64,
}

impl Hyperparameters {
    /// From the logarithms that are searched over, above a least noise.
    pub(super) fn from_logarithms(logarithms: &[f64], least_noise: f64) -> Self {
        let (noise, weights) = logarithms.split_last().unwrap_or((&0.0, &[]));
        Self {
            weights: weights.iter().map(|weight| libm::exp(*weight)).collect(),
            noise: least_noise + libm::exp(*noise),
        }
    }

    /// The logarithms that are searched over, above a least noise.
    pub(super) fn logarithms(&self, least_noise: f64) -> Vec<f64> {
        let noise = (self.noise - least_noise).max(0.01 * least_noise);
        self.weights.iter().chain([&noise]).map(|value| libm::log(value.max(f64::MIN_POSITIVE))).collect()
    }

    /// The same to six digits: more mean nothing, and any reader of decimal numbers reads these alike.
    pub(super) fn rounded(&self) -> Self {
        let rounded = |value: &f64| format!("{value:.5e}").parse().unwrap_or(*value);
        Self { weights: self.weights.iter().map(rounded).collect(), noise: rounded(&self.noise) }
    }

    /// Where a search starts: one length, a multiple of the usual one, and a noise.
    pub(super) fn start(factors: usize, [length, noise]: [f64; 2]) -> Vec<f64> {
        let mut start = vec![usual_weight(factors) - 2.0 * libm::log(length); factors];
        start.push(libm::log(noise));
        start
    }
}

/// Logarithm of the inverse square of a usual length.
fn usual_weight(factors: usize) -> f64 {
    -2.0 * LENGTHS[0] - libm::log(factors as f64)
}

/// Squared distances of all pairs of rows along each factor, row after row of the lower triangle's columns.
pub(super) struct Pairs {
    rows: usize,
    squared: Vec<Vec<f64>>,
}

impl Pairs {
    pub fn new(points: &Points) -> Self {
        let rows = points.rows();
        let along = |factor: usize| {
            let pairs = (0..rows).flat_map(|a| (a + 1..rows).map(move |b| [a, b]));
            pairs.map(|pair| points.squared(factor, pair.map(|row| points.row(row)[factor]))).collect()
        };
        Self { rows, squared: (0..points.factors()).map(along).collect() }
    }

    /// Weighted squared distances.
    fn distances(&self, weights: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.rows * self.rows.saturating_sub(1) / 2];
        for (squared, weight) in self.squared.iter().zip(weights) {
            sum.iter_mut().zip(squared).for_each(|(sum, squared)| *sum += weight * squared);
        }
        sum
    }

    /// The matrix of correlations with the noise on its diagonal; of the lower triangle.
    fn matrix(&self, values: &[f64], noise: f64) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.rows, self.rows);
        let mut rest = values;
        for column in 0..self.rows {
            let (below, after) = rest.split_at(self.rows - 1 - column);
            let mut entries = matrix.column_mut(column);
            entries[column] = 1.0 + noise;
            entries.as_mut_slice()[column + 1..].copy_from_slice(below);
            rest = after;
        }
        matrix
    }
}

/// What follows from a table once lengths and noise are given: mean and variance by generalised least squares.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    /// Lower Cholesky factor of `C = R + noise I`.
    pub factor: DMatrix<f64>,
    /// `Q = C^-1 - b b' / (1' b)`, `b = C^-1 1`, the inverse that knows of the fitted mean.
    pub inverse: DMatrix<f64>,
    /// `a = Q y`: the weights of the rows.
    pub alpha: Vec<f64>,
    /// The mean `b' y / (1' b)`.
    pub mean: f64,
    /// The variance `y' Q y / (n - 1)`.
    pub variance: f64,
    /// Logarithm of the restricted likelihood, without its constant.
    pub log_likelihood: f64,
}

/// A table whose likelihood is asked for.
pub(super) struct Likelihood<'a> {
    pub kernel: Kernel,
    pub pairs: &'a Pairs,
    pub values: &'a [f64],
    /// Noise that no search goes below.
    pub least_noise: f64,
}

impl Likelihood<'_> {
    /// Mean, variance and likelihood for lengths and noise.
    pub fn solve(&self, of: &Hyperparameters) -> Result<Solved, LinalgError> {
        let distances = self.pairs.distances(&of.weights);
        let correlations: Vec<f64> = distances.iter().map(|squared| self.kernel.at(*squared)).collect();
        solved(ordered_cholesky(self.pairs.matrix(&correlations, of.noise))?, self.values)
    }

    /// Minus the logarithm of the posterior density, and its gradient by the logarithms of weights and noise; `None` where the
    /// correlations have no Cholesky factor.
    pub fn sloped(&self, logarithms: &[f64]) -> Option<Sloped> {
        let of = Hyperparameters::from_logarithms(logarithms, self.least_noise);
        let (values, slopes): (Vec<f64>, Vec<f64>) =
            self.pairs.distances(&of.weights).iter().map(|squared| self.kernel.with_slope(*squared)).unzip();
        let factor = cholesky(self.pairs.matrix(&values, of.noise)).ok()?;
        let solved = solved(factor, self.values).ok()?;
        // dl = sum_ij M_ij dC_ij / 2 with M = a a' / variance - Q.
        let scaled: Vec<f64> = solved.alpha.iter().map(|alpha| alpha / solved.variance).collect();
        let mut pull = slopes;
        let mut rest = pull.as_mut_slice();
        for (column, share) in scaled.iter().enumerate() {
            let (here, after) = rest.split_at_mut(self.pairs.rows - 1 - column);
            let inverse = &solved.inverse.as_slice()[column * self.pairs.rows..][column + 1..];
            for ((pull, alpha), inverse) in here.iter_mut().zip(&solved.alpha[column + 1..]).zip(inverse) {
                *pull *= alpha * share - inverse;
            }
            rest = after;
        }
        let mut slope: Vec<f64> = (self.pairs.squared.iter().zip(&of.weights))
            .map(|(squared, weight)| -weight * dot(&pull, squared))
            .collect();
        let diagonal = solved.inverse.diagonal();
        let trace: f64 = (0..self.pairs.rows).map(|row| solved.alpha[row] * scaled[row] - diagonal[row]).sum();
        slope.push(-0.5 * trace * (of.noise - self.least_noise));
        let prior = prior(logarithms, &mut slope);
        let value = prior - solved.log_likelihood;
        (value.is_finite() && slope.iter().all(|part| part.is_finite())).then_some((value, slope))
    }
}

/// Minus the logarithm of the prior density; adds its gradient.
fn prior(logarithms: &[f64], slope: &mut [f64]) -> f64 {
    let factors = logarithms.len() - 1;
    let mut sum = 0.0;
    for (place, (logarithm, slope)) in logarithms.iter().zip(slope).enumerate() {
        let [mean, deviation] = if place < factors { [usual_weight(factors), 2.0 * LENGTHS[1]] } else { NOISE };
        let off = (logarithm - mean) / deviation;
        sum += 0.5 * off * off;
        *slope += off / deviation;
    }
    sum
}

/// Solves a table for the Cholesky factor of its correlations.
fn solved(factor: DMatrix<f64>, values: &[f64]) -> Result<Solved, LinalgError> {
    let rows = factor.nrows();
    let mut inverse = cholesky_inverse(&factor)?;
    let ones: Vec<f64> = inverse.column_iter().map(|column| column.sum()).collect();
    let total: f64 = ones.iter().sum();
    let mean = dot(&ones, values) / total;
    let centred: Vec<f64> = values.iter().map(|value| value - mean).collect();
    for (mut column, own) in inverse.column_iter_mut().zip(&ones) {
        column.iter_mut().zip(&ones).for_each(|(entry, other)| *entry -= other * own / total);
    }
    let alpha: Vec<f64> = inverse.column_iter().map(|column| dot(column.as_slice(), &centred)).collect();
    let freedom = rows as f64 - 1.0;
    let variance = dot(&alpha, &centred) / freedom;
    let half_determinant: f64 = factor.diagonal().iter().map(|pivot| libm::log(*pivot)).sum();
    let log_likelihood = -0.5 * freedom * libm::log(variance) - half_determinant - 0.5 * libm::log(total);
    Ok(Solved { factor, inverse, alpha, mean, variance, log_likelihood })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;

    #[test]
    fn slopes_are_those_of_differences() {
        let coordinates = (0..75).map(|place| uniform(4, 0, place));
        let coordinates = coordinates.enumerate().map(|(place, x)| if place % 3 == 2 { (2.0 * x).floor() } else { x });
        let points = Points::new(coordinates.collect(), vec![false, false, true]).expect("points");
        let values: Vec<f64> = (0..25).map(|row| points.row(row)[0].sin() + points.row(row)[2]).collect();
        let pairs = Pairs::new(&points);
        for kernel in Kernel::ALL {
            let likelihood = Likelihood { kernel, pairs: &pairs, values: &values, least_noise: LEAST_NOISE };
            let at = [1.0, 0.3, -0.5, -4.0];
            let (_, slope) = likelihood.sloped(&at).expect("a value");
            for (place, slope) in slope.iter().enumerate() {
                let beside = |step: f64| {
                    let mut at = at;
                    at[place] += step;
                    likelihood.sloped(&at).expect("a value").0
                };
                let difference = (beside(1e-4) - beside(-1e-4)) / 2e-4;
                assert!(
                    (slope - difference).abs() < 1e-5 * (1.0 + slope.abs()),
                    "{kernel:?} {place}: {slope} {difference}"
                );
            }
        }
    }
}
