//! Likelihood of a table, given lengths and noise.

use nalgebra::DMatrix;

use super::kernel::Kernel;
use super::minimise::{Sloped, dot};
use super::ordered::ordered_cholesky;
use super::places::{Places, Spread};
use super::points::Points;
use decore_math::linalg::{LinalgError, cholesky, cholesky_inverse};

/// Least noise, as a share of the process's variance: below it, rounding decides.
pub const LEAST_NOISE: f64 = 1e-6;
/// Prior of lengths and noise: normal distributions of their logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Prior {
    /// Noise that no search goes below, as a share of the process's variance.
    pub least_noise: f64,
    /// Mean and standard deviation of the logarithm of a length, beside half that of the number of factors (lengths grow with it as
    /// distances do: Hvarfner, Hellsten and Nardi, ICML 2024).
    lengths: [f64; 2],
    /// Mean and standard deviation of the logarithm of the noise's share.
    noise: [f64; 2],
}

impl Prior {
    /// Of -1 and 1 for rows that fail and rows that succeed: an edge anywhere, hardly any noise.
    pub const OF_SIGNS: Self = Self {
        least_noise: LEAST_NOISE,
        lengths: [std::f64::consts::SQRT_2, 1.732_050_807_568_877_2],
        noise: [-14.0, 3.0],
    };

    /// Of an output. The noise is believed to be well above the least one: of 10 to 20 rows, the likelihood alone is too sure that there
    /// is none.
    pub fn of_outputs(least_noise: f64) -> Self {
        let noise = [libm::log(least_noise.max(f64::MIN_POSITIVE)) + 8.8, 2.5];
        Self { least_noise, lengths: [0.7, 1.0], noise }
    }
}

/// Lengths and noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Hyperparameters {
    /// Inverse squared length of each factor, in its scaled range.
    pub weights: Vec<f64>,
    /// Variance of a place's noise over the variance of the process.
    pub noise: f64,
    /// Variance of a run's noise over the variance of the process; 0 if no runs at one place show it.
    pub spread: f64,
}

impl Hyperparameters {
    /// From the logarithms that are searched over: weights, noise above a least one, and spread where there is evidence of it.
    pub(super) fn from_logarithms(logarithms: &[f64], factors: usize, least_noise: f64) -> Self {
        let (weights, rest) = logarithms.split_at(factors.min(logarithms.len()));
        Self {
            weights: weights.iter().map(|weight| libm::exp(*weight)).collect(),
            noise: least_noise + rest.first().map_or(0.0, |noise| libm::exp(*noise)),
            spread: rest.get(1).map_or(0.0, |spread| libm::exp(*spread)),
        }
    }

    /// The logarithms that are searched over.
    pub(super) fn logarithms(&self, least_noise: f64) -> Vec<f64> {
        let noise = (self.noise - least_noise).max(0.01 * least_noise);
        let spread = (self.spread > 0.0).then_some(self.spread);
        let all = self.weights.iter().copied().chain([noise]).chain(spread);
        all.map(|value| libm::log(value.max(f64::MIN_POSITIVE))).collect()
    }

    /// The same to six digits: more mean nothing, and any reader of decimal numbers reads these alike.
    pub(super) fn rounded(&self) -> Self {
        let rounded = |value: &f64| format!("{value:.5e}").parse().unwrap_or(*value);
        let weights = self.weights.iter().map(rounded).collect();
        Self { weights, noise: rounded(&self.noise), spread: rounded(&self.spread) }
    }
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

    /// The matrix of correlations with this diagonal; of the lower triangle.
    fn matrix(&self, values: &[f64], diagonal: &[f64]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.rows, self.rows);
        let mut rest = values;
        for (column, own) in diagonal.iter().enumerate() {
            let (below, after) = rest.split_at(self.rows - 1 - column);
            let mut entries = matrix.column_mut(column);
            entries[column] = *own;
            entries.as_mut_slice()[column + 1..].copy_from_slice(below);
            rest = after;
        }
        matrix
    }
}

/// Diagonal of the correlations: the noise of each place and of its runs.
fn diagonal(of: &Hyperparameters, runs: &[f64]) -> Vec<f64> {
    runs.iter().map(|runs| 1.0 + of.noise + of.spread / runs).collect()
}

/// Solution for a table with given lengths and noise: mean and variance by generalised least squares.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    /// Lower Cholesky factor of the correlations `C`, noise on their diagonal.
    pub factor: DMatrix<f64>,
    /// `a = Q y`: the weights of the rows.
    pub alpha: Vec<f64>,
    /// The mean `b' y / (1' b)`.
    pub mean: f64,
    /// Variance: `y' Q y` and the differences of runs at one place, over the degrees of freedom of both.
    pub variance: f64,
    /// Logarithm of the restricted likelihood, without its constant.
    pub log_likelihood: f64,
}

/// `Q = C^-1 - b b' / (1' b)`, `b = C^-1 1`: the inverse that knows of the fitted mean.
pub(super) type Inverse = DMatrix<f64>;

/// A table whose likelihood is requested.
pub(super) struct Likelihood<'a> {
    pub kernel: Kernel,
    pub pairs: &'a Pairs,
    /// The places, their values scaled to the variance 1.
    pub places: &'a Places,
    pub prior: Prior,
}

/// Mean, variance and likelihood of places for lengths and noise.
pub(super) fn solve(
    places: &Places,
    (kernel, of): (Kernel, &Hyperparameters),
) -> Result<(Solved, Inverse), LinalgError> {
    let points = places.points();
    let mut matrix = DMatrix::zeros(points.rows(), points.rows());
    for (column, own) in diagonal(of, places.runs()).into_iter().enumerate() {
        matrix[(column, column)] = own;
        for row in column + 1..points.rows() {
            let along = |(factor, weight): (usize, &f64)| {
                weight * points.squared(factor, [points.row(column)[factor], points.row(row)[factor]])
            };
            matrix[(row, column)] = kernel.at(of.weights.iter().enumerate().map(along).sum());
        }
    }
    solved(ordered_cholesky(matrix)?, places, of.spread)
}

impl Likelihood<'_> {
    /// Minus the logarithm of the posterior density, and its gradient by the logarithms of weights, noise and spread; `None` if the
    /// correlations have no Cholesky factor.
    pub fn sloped(&self, logarithms: &[f64]) -> Option<Sloped> {
        let factors = self.places.points().factors();
        let of = Hyperparameters::from_logarithms(logarithms, factors, self.prior.least_noise);
        let (values, slopes): (Vec<f64>, Vec<f64>) =
            self.pairs.distances(&of.weights).iter().map(|squared| self.kernel.with_slope(*squared)).unzip();
        let factor = cholesky(self.pairs.matrix(&values, &diagonal(&of, self.places.runs()))).ok()?;
        let (solved, inverse) = solved(factor, self.places, of.spread).ok()?;
        // dl = sum_ij M_ij dC_ij / 2 with M = a a' / variance - Q.
        let scaled: Vec<f64> = solved.alpha.iter().map(|alpha| alpha / solved.variance).collect();
        let mut pull = slopes;
        let mut rest = pull.as_mut_slice();
        for (column, share) in scaled.iter().enumerate() {
            let (here, after) = rest.split_at_mut(self.pairs.rows - 1 - column);
            let inverse = &inverse.as_slice()[column * self.pairs.rows..][column + 1..];
            for ((pull, alpha), inverse) in here.iter_mut().zip(&solved.alpha[column + 1..]).zip(inverse) {
                *pull *= alpha * share - inverse;
            }
            rest = after;
        }
        let mut slope: Vec<f64> = (self.pairs.squared.iter().zip(&of.weights))
            .map(|(squared, weight)| -weight * dot(&pull, squared))
            .collect();
        let pulls = (0..self.pairs.rows).map(|row| solved.alpha[row] * scaled[row] - inverse[(row, row)]);
        let (mut trace, mut trace_of_runs) = (0.0, 0.0);
        for (pull, runs) in pulls.zip(self.places.runs()) {
            trace += pull;
            trace_of_runs += pull / runs;
        }
        slope.push(-0.5 * trace * (of.noise - self.prior.least_noise));
        if logarithms.len() > factors + 1 {
            let Spread { squares, freedom } = self.places.spread();
            let own = squares / (solved.variance * of.spread) - freedom;
            slope.push(-0.5 * (trace_of_runs * of.spread + own));
        }
        let belief = self.prior.loss(&logarithms[..=factors], &mut slope);
        let value = belief - solved.log_likelihood;
        (value.is_finite() && slope.iter().all(|part| part.is_finite())).then_some((value, slope))
    }
}

impl Prior {
    /// Start of a search: one length, a multiple of the usual one, and a noise, for values with variance 1.
    pub fn start(&self, factors: usize, [length, noise]: [f64; 2], spread: Spread) -> Vec<f64> {
        let mut start = vec![self.usual_weight(factors) - 2.0 * libm::log(length); factors];
        start.push(libm::log(noise));
        start.extend((spread.freedom > 0.0).then(|| libm::log(spread.squares / spread.freedom)));
        start
    }

    /// Logarithm of the inverse square of a usual length.
    fn usual_weight(&self, factors: usize) -> f64 {
        -2.0 * self.lengths[0] - libm::log(factors as f64)
    }

    /// Minus the logarithm of the density; adds its gradient.
    fn loss(&self, logarithms: &[f64], slope: &mut [f64]) -> f64 {
        let factors = logarithms.len() - 1;
        let lengths = [self.usual_weight(factors), 2.0 * self.lengths[1]];
        let mut sum = 0.0;
        for (place, (logarithm, slope)) in logarithms.iter().zip(slope).enumerate() {
            let [mean, deviation] = if place < factors { lengths } else { self.noise };
            let off = (logarithm - mean) / deviation;
            sum += 0.5 * off * off;
            *slope += off / deviation;
        }
        sum
    }
}

/// Solves places for the Cholesky factor of their correlations.
fn solved(factor: DMatrix<f64>, places: &Places, spread: f64) -> Result<(Solved, Inverse), LinalgError> {
    let (rows, values) = (factor.nrows(), places.values());
    let mut inverse = cholesky_inverse(&factor)?;
    let ones: Vec<f64> = inverse.column_iter().map(|column| column.sum()).collect();
    let total: f64 = ones.iter().sum();
    let mean = dot(&ones, values) / total;
    let centred: Vec<f64> = values.iter().map(|value| value - mean).collect();
    for (mut column, own) in inverse.column_iter_mut().zip(&ones) {
        column.iter_mut().zip(&ones).for_each(|(entry, other)| *entry -= other * own / total);
    }
    let alpha: Vec<f64> = inverse.column_iter().map(|column| dot(column.as_slice(), &centred)).collect();
    let (mut squares, mut freedom, mut of_runs) = (dot(&alpha, &centred), rows as f64 - 1.0, 0.0);
    if spread > 0.0 {
        let own = places.spread();
        squares += own.squares / spread;
        freedom += own.freedom;
        of_runs = 0.5 * own.freedom * libm::log(spread);
    }
    let variance = squares / freedom;
    let half_determinant: f64 = factor.diagonal().iter().map(|pivot| libm::log(*pivot)).sum();
    let log_likelihood = -0.5 * freedom * libm::log(variance) - half_determinant - 0.5 * libm::log(total) - of_runs;
    Ok((Solved { factor, alpha, mean, variance, log_likelihood }, inverse))
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;

    #[test]
    fn slopes_are_those_of_differences() {
        let coordinates = (0..75).map(|place| uniform(4, 0, place));
        let coordinates = coordinates.enumerate().map(|(place, x)| if place % 3 == 2 { (2.0 * x).floor() } else { x });
        let points = Points::new(coordinates.collect(), vec![false, false, true]).expect("points");
        let values: Vec<f64> = (0..25).map(|row| points.row(row)[0].sin() + points.row(row)[2]).collect();
        let pairs = Pairs::new(&points);
        let places = Places::new(&points, &values).expect("places").with_spread(Spread { squares: 0.4, freedom: 7.0 });
        for kernel in Kernel::ALL {
            let likelihood =
                Likelihood { kernel, pairs: &pairs, places: &places, prior: Prior::of_outputs(LEAST_NOISE) };
            let at = [1.0, 0.3, -0.5, -4.0, -3.0];
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
