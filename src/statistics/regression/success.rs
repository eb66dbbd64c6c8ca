//! Probability that a row succeeds.

use super::error::RegressionError;
use super::gaussian::{GaussianProcess, Prediction};
use super::minimise::{Stop, minimise};
use super::places::Places;
use super::points::Points;

/// Places of the rarer kind from which on the probability depends on the place.
const LEAST_OF_A_KIND: f64 = 4.0;
/// Mean and standard deviation of the logarithm of the slope.
const SLOPE: [f64; 2] = [1.0, 1.0];
/// Mean and standard deviation of the offset. The share of failed rows is in the process's mean already, and rows chosen near a boundary
/// carry no information about the rest.
const OFFSET: [f64; 2] = [0.0, 0.1];
/// When the search for slope and offset ends.
const SEARCH: Stop = Stop { steps: 100, gain: 1e-9 };

/// The probability that a row succeeds, by place.
///
/// A Gaussian process of 1 and -1, and `p = 1 / (1 + exp(-(slope m + offset) / sqrt(1 + pi slope^2 s^2 / 8)))` of its mean `m` and
/// standard deviation `s`, slope and offset being those under which rows that were left out are most probable (least-squares
/// classification: Rasmussen and Williams, 2006, section 6.5; Platt, 1999; the square root: MacKay, 1992), with normal priors: of the
/// logarithm of the slope (1, standard deviation 1) and of the offset (0, standard deviation 0.1).
#[derive(Debug, Clone)]
pub enum Success {
    /// The same everywhere, as too few rows of one kind are there: `(successes + 1) / (places + 2)`.
    Everywhere(f64),
    /// By place.
    ByPlace {
        /// Of 1 (success) and -1.
        process: Box<GaussianProcess>,
        /// Slope and offset.
        scaling: [f64; 2],
    },
}

impl Success {
    /// From rows of which it is known whether they succeeded.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for another number of rows; [`RegressionError::Linalg`].
    pub fn fit(points: &Points, succeeded: &[bool]) -> Result<Self, RegressionError> {
        let signs: Vec<f64> = succeeded.iter().map(|success| if *success { 1.0 } else { -1.0 }).collect();
        let places = Places::new(points, &signs)?;
        // Of places with runs of both kinds, each kind has its share.
        let shares: Vec<f64> = places.values().iter().map(|mean| 0.5 * (1.0 + mean)).collect();
        let (count, all) = (shares.iter().sum::<f64>(), shares.len() as f64);
        if count.min(all - count) < LEAST_OF_A_KIND {
            return Ok(Self::Everywhere((count + 1.0) / (all + 2.0)));
        }
        let process = Box::new(GaussianProcess::fit_signs(&places)?);
        let left_out = process.residuals();
        let errors = left_out.errors().iter().zip(left_out.std_devs());
        let rows: Vec<(f64, f64, Prediction)> = (places.values().iter().zip(&shares).zip(errors))
            .flat_map(|((value, share), (error, std_dev))| {
                let at = Prediction { mean: value - error, std_dev: *std_dev };
                [(1.0, *share, at), (-1.0, 1.0 - share, at)]
            })
            .filter(|(_, share, _)| *share > 0.0)
            .collect();
        let mut loss = |at: &[f64]| Some(loss(at, &rows));
        let scaling = match minimise(vec![SLOPE[0], OFFSET[0]], SEARCH, &mut loss) {
            Some(found) => [libm::exp(found.at[0]), found.at[1]],
            None => [libm::exp(SLOPE[0]), OFFSET[0]],
        };
        Ok(Self::ByPlace { process, scaling })
    }

    /// The probability at places with the same factors.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for another number of factors.
    pub fn predict(&self, places: &Points) -> Result<Vec<f64>, RegressionError> {
        match self {
            Self::Everywhere(probability) => Ok(vec![*probability; places.rows()]),
            Self::ByPlace { process, scaling } => {
                let of = |at: &Prediction| 1.0 / (1.0 + libm::exp(-scaled(*scaling, at)));
                Ok(process.predict(places)?.iter().map(of).collect())
            }
        }
    }
}

fn scaled([slope, offset]: [f64; 2], at: &Prediction) -> f64 {
    let spread = std::f64::consts::PI / 8.0 * (slope * at.std_dev).powi(2);
    (slope * at.mean + offset) / (1.0 + spread).sqrt()
}

/// Minus the logarithm of the probability of the rows, with the priors of slope and offset, and its gradient by the slope's logarithm and
/// the offset.
fn loss(at: &[f64], rows: &[(f64, f64, Prediction)]) -> (f64, Vec<f64>) {
    let (slope, offset) = (libm::exp(at[0]), at[1]);
    let off = [(at[0] - SLOPE[0]) / SLOPE[1], (at[1] - OFFSET[0]) / OFFSET[1]];
    let (mut sum, mut gradient) =
        (0.5 * (off[0] * off[0] + off[1] * off[1]), vec![off[0] / SLOPE[1], off[1] / OFFSET[1]]);
    for (sign, share, row) in rows {
        let spread = std::f64::consts::PI / 8.0 * (slope * row.std_dev).powi(2);
        let root = (1.0 + spread).sqrt();
        let margin = sign * (slope * row.mean + offset) / root;
        // ln(1 + exp(-margin)), without overflow.
        sum += share * (libm::log1p(libm::exp(-margin.abs())) + (-margin).max(0.0));
        let pull = -sign * share / (1.0 + libm::exp(margin));
        gradient[0] += pull * (slope * row.mean / root - (slope * row.mean + offset) * spread / root.powi(3));
        gradient[1] += pull / root;
    }
    (sum, gradient)
}
