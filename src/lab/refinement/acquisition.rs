//! Choice of the most useful places for a run.

use nalgebra::DMatrix;

use decore_math::special::normal_cdf;
use decore_statistics::regression::{GaussianProcess, Points, Prediction, RegressionError};

/// End of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Small values: an optimum that is a least value, a limit that is not to be exceeded.
    Least,
    /// Large values.
    Most,
}

impl Side {
    /// The sign by which small values become the ones that are meant.
    fn sign(self) -> f64 {
        match self {
            Self::Least => 1.0,
            Self::Most => -1.0,
        }
    }
}

/// Share of the largest variance below which the variance of a candidate is rounding.
const ROUNDING: f64 = 1e-12;

/// An output to learn.
#[derive(Debug, Clone)]
pub struct Learned<'a> {
    /// Process of the output.
    pub process: &'a GaussianProcess,
    /// Probability of each candidate that a run there has the output.
    pub success: Vec<f64>,
    /// `None`: the output matters everywhere. A value: it matters where the output may have this value.
    pub boundary: Option<f64>,
}

/// Unknown part of an output at the candidates.
struct Unknown<'a> {
    of: &'a Learned<'a>,
    /// Expected values there.
    means: Vec<f64>,
    /// By how much squared errors are larger there than the process expects.
    scales: Vec<f64>,
    covariances: DMatrix<f64>,
    noise: f64,
}

/// Chooses the candidates, in order, that leave the least variance over all candidates. Each run reduces it by `sum_r w_r c(r, x)^2 / (c(x,
/// x) + noise)`, `c` the covariances given the earlier ones (integrated variance: active learning of Cohn, J. Artif. Intell. Res. 4, 1996,
/// for Gaussian processes), times the probability that a run there has the output. Each output is relative to its variance over the
/// candidates. `w` is the local variance by the errors of left-out rows ([`GaussianProcess::local_scale`]), because lengths are the same
/// everywhere but an output may not be. For a boundary, `w` is the density of the expected value there (targeted integrated variance:
/// Picheny, Ginsbourger, Roustant, Haftka and Kim, J. Mech. Des. 132, 2010).
///
/// # Errors
/// Those of [`GaussianProcess::covariances`].
pub fn learning(outputs: &[Learned<'_>], candidates: &Points, batch: usize) -> Result<Vec<usize>, RegressionError> {
    let mut left = Vec::with_capacity(outputs.len());
    for of in outputs {
        let means = of.process.predict(candidates)?.iter().map(|at| at.mean).collect();
        let covariances = of.process.covariances(candidates)?;
        let scales = of.process.local_scale(candidates)?;
        left.push(Unknown { of, means, scales, covariances, noise: of.process.noise_std_dev().powi(2) });
    }
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < batch.min(candidates.rows()) {
        let mut gains = vec![0.0; candidates.rows()];
        left.iter().for_each(|unknown| unknown.add_gains(&mut gains));
        let Some(next) = largest(&gains, &chosen) else { break };
        chosen.push(next);
        left.iter_mut().for_each(|unknown| know(&mut unknown.covariances, next, unknown.noise));
    }
    Ok(chosen)
}

impl Unknown<'_> {
    fn add_gains(&self, gains: &mut [f64]) {
        let variances = self.covariances.diagonal();
        let least = ROUNDING * variances.max();
        let weights: Vec<f64> = match self.of.boundary {
            None => self.scales.clone(),
            Some(value) => (self.means.iter().zip(&variances))
                .map(|(mean, variance)| if *variance > least { density(value - mean, *variance) } else { 0.0 })
                .collect(),
        };
        let total: f64 = weights.iter().zip(&variances).map(|(weight, variance)| weight * variance).sum();
        if total > 0.0 {
            for (place, (gain, success)) in gains.iter_mut().zip(&self.of.success).enumerate() {
                *gain += success
                    * reduction(&self.covariances, place, &Weighing { weights: &weights, noise: self.noise, least })
                    / total;
            }
        }
    }
}

/// Density of a normal distribution, but for a constant.
fn density(off: f64, variance: f64) -> f64 {
    (-0.5 * off * off / variance).exp() / variance.sqrt()
}

/// Weights of the variances.
struct Weighing<'a> {
    /// A weight per place.
    weights: &'a [f64],
    /// Variance of the noise of a run.
    noise: f64,
    /// The largest variance at which nothing is unknown.
    least: f64,
}

/// Reduction of the weighted sum of the variances by one run; 0 if the unknown part is at most `least`.
fn reduction(of: &DMatrix<f64>, place: usize, &Weighing { weights, noise, least }: &Weighing<'_>) -> f64 {
    let own = of[(place, place)];
    if own <= least {
        return 0.0;
    }
    let squares: f64 = of.column(place).iter().zip(weights).map(|(entry, weight)| weight * entry * entry).sum();
    squares / (own + noise)
}

/// The covariances once a place is run.
fn know(of: &mut DMatrix<f64>, place: usize, noise: f64) {
    let column = of.column(place).clone_owned();
    let own = column[place] + noise;
    if own > 0.0 {
        of.ger(-1.0 / own, &column, &column, 1.0);
    }
}

/// The first of the largest that is not chosen yet.
fn largest(gains: &[f64], chosen: &[usize]) -> Option<usize> {
    let free = (0..gains.len()).filter(|place| !chosen.contains(place));
    free.fold(None, |best: Option<usize>, place| match best {
        Some(best) if gains[best] >= gains[place] => Some(best),
        _ => Some(place),
    })
}

/// An output that is limited.
#[derive(Debug, Clone, Copy)]
pub struct Limited<'a> {
    /// Process of the limited output.
    pub process: &'a GaussianProcess,
    /// Side of the limit that is permitted.
    pub side: Side,
    /// The limit.
    pub value: f64,
}

/// On which side of a limit an output is expected to lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitSide {
    /// Probability that its expected value lies within the limit.
    pub within: f64,
    /// Density of that value at the limit times its standard deviation squared: where the boundary may be, and is not known.
    pub unknown: f64,
}

impl Limited<'_> {
    /// On which side of the limit each place lies; noise left out.
    ///
    /// # Errors
    /// Those of [`GaussianProcess::predict`].
    pub fn beside(&self, places: &Points) -> Result<Vec<LimitSide>, RegressionError> {
        let noise = self.process.noise_std_dev().powi(2);
        let beside = |at: &Prediction| {
            let variance = (at.std_dev * at.std_dev - noise).max(f64::MIN_POSITIVE);
            let off = self.value - at.mean;
            let within = normal_cdf(self.side.sign() * off / variance.sqrt());
            LimitSide { within, unknown: density(off, variance) * variance }
        };
        Ok(self.process.predict(places)?.iter().map(beside).collect())
    }

    /// Probability of each place to be within the limit.
    fn probabilities(&self, places: &Points) -> Result<Vec<f64>, RegressionError> {
        let within = |expected: f64, own: f64| normal_cdf(self.side.sign() * (self.value - expected) / own);
        Ok(self.process.predict(places)?.iter().map(|at| within(at.mean, at.std_dev.max(f64::MIN_POSITIVE))).collect())
    }
}

/// Criterion by which a place is judged.
#[derive(Clone, Copy)]
pub struct Seeking<'a> {
    /// The output's process.
    pub process: &'a GaussianProcess,
    /// Whether to minimise or maximise.
    pub side: Side,
    /// Limits of other outputs.
    pub limits: &'a [Limited<'a>],
    /// Best value so far, to be improved.
    pub best: Option<f64>,
    /// Share of the standard deviation that counts: 1 for the expected improvement, less to trust the expectation more.
    pub share: f64,
}

/// Logarithm of the expected improvement of an output over the best times the probability of each place to be within the limits;
/// without a best, of that probability alone (Schonlau, Welch and Jones, 1998).
///
/// # Errors
/// Those of [`GaussianProcess::predict`].
pub fn improving(seeking: &Seeking<'_>, places: &Points) -> Result<Vec<f64>, RegressionError> {
    let &Seeking { process, side, limits, best, share } = seeking;
    let mut merits = vec![0.0; places.rows()];
    if let Some(best) = best {
        let noise = process.noise_std_dev().powi(2);
        for (merit, at) in merits.iter_mut().zip(process.predict(places)?) {
            let own = (at.std_dev * at.std_dev - noise).max(0.0).sqrt();
            *merit = log_improvement(side.sign() * (best - at.mean), share * own);
        }
    }
    for limit in limits {
        for (merit, probability) in merits.iter_mut().zip(limit.probabilities(places)?) {
            *merit += probability.max(f64::MIN_POSITIVE).ln();
        }
    }
    Ok(merits)
}

/// Logarithm of `s (z Phi(z) + phi(z))`, `z` the gain over the standard deviation `s`; far below it by the tail's series.
fn log_improvement(gain: f64, own: f64) -> f64 {
    if own <= 0.0 {
        return if gain > 0.0 { gain.ln() } else { f64::MIN };
    }
    let z = gain / own;
    let density = -0.5 * z * z - 0.5 * (2.0 * std::f64::consts::PI).ln();
    let unit = match z {
        // phi(z) / z^2 (1 - 3 / z^2 + ...)
        z if z < -6.0 => density - 2.0 * z.abs().ln() + (-3.0 / (z * z)).ln_1p(),
        z => (z * normal_cdf(z) + density.exp()).max(f64::MIN_POSITIVE).ln(),
    };
    own.ln() + unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn improvement_is_continuous_where_its_series_begins() {
        assert!((log_improvement(-5.999_999, 1.0) - log_improvement(-6.000_001, 1.0)).abs() < 0.02);
        // s = 2, gain 1: 2 (0.5 Phi(0.5) + phi(0.5)).
        let expected = (2.0_f64 * (0.5 * 0.691_462_461_274_013 + 0.352_065_326_764_299_5)).ln();
        assert!((log_improvement(1.0, 2.0) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_known_place_leaves_no_variance_there() {
        let mut of = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 3.0]);
        assert!((reduction(&of, 0, &Weighing { weights: &[1.0, 1.0], noise: 0.0, least: 0.0 }) - 2.5).abs() < 1e-15);
        assert!((reduction(&of, 0, &Weighing { weights: &[0.5, 2.0], noise: 2.0, least: 0.0 }) - 1.0).abs() < 1e-15);
        know(&mut of, 0, 0.0);
        assert_eq!(of, DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 2.5]));
    }
}
