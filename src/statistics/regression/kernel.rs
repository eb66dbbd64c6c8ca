//! Correlations that fall with the distance.
//!
//! Weights of rows are large numbers of both signs. Other programs that predict with a stored model must repeat these operations one by
//! one.

use decore_math::number::exp;

/// Correlation of two rows over their distance `s`, `s^2 = sum_k w_k d_k^2`, `d_k` their difference in factor `k` (for names 1 if they
/// differ), `w_k` the factor's inverse squared length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kernel {
    /// `exp(-s^2 / 2)`: outputs that are as smooth as can be.
    SquaredExponential,
    /// `(1 + sqrt(5) s + 5 s^2 / 3) exp(-sqrt(5) s)`: outputs that have two derivatives.
    Matern52,
}

impl Kernel {
    /// All kernels.
    pub const ALL: [Self; 2] = [Self::Matern52, Self::SquaredExponential];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::SquaredExponential => "squared_exponential",
            Self::Matern52 => "matern_5_2",
        }
    }

    /// The correlation at a squared distance.
    pub fn at(self, squared: f64) -> f64 {
        match self {
            Self::SquaredExponential => exp(-0.5 * squared),
            Self::Matern52 => {
                let s = (5.0 * squared).sqrt();
                (1.0 + s + s * s / 3.0) * exp(-s)
            }
        }
    }

    /// The correlation, and its derivative by the squared distance.
    pub(super) fn with_slope(self, squared: f64) -> (f64, f64) {
        match self {
            Self::SquaredExponential => {
                let value = exp(-0.5 * squared);
                (value, -0.5 * value)
            }
            Self::Matern52 => {
                let s = (5.0 * squared).sqrt();
                let decay = exp(-s);
                ((1.0 + s + s * s / 3.0) * decay, -5.0 / 6.0 * (1.0 + s) * decay)
            }
        }
    }
}
