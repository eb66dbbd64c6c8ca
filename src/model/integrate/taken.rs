//! Accepted steps of all lanes, for parts of rows outside their states.

use crate::integrate::step::Dense;
use decore_math::number::Number;

/// The steps of all lanes.
#[derive(Debug)]
pub struct Taken<'t, R: Number = f64> {
    /// Lanes with an accepted step; values of other lanes are meaningless.
    pub accepted: R::Mask,
    /// Time at its start, s.
    pub t: R,
    /// Computed length, s.
    pub h: R,
    /// Fraction of it that is accepted.
    pub theta: R,
    /// Rates of the state, one after the other.
    pub rates: &'t [R],
    /// Interpolation of the steps.
    pub dense: Dense,
}

impl<R: Number> Taken<'_, R> {
    /// Rates of `N` interpolated components of the state from `first` on: coefficients by powers of the fraction of the step. At both
    /// ends of it they are those of the system.
    #[inline(always)]
    pub fn slopes<const N: usize>(&self, first: usize) -> [[R; N]; 4] {
        match self.dense {
            Dense::Tsit5 => self.slopes_of::<{ Dense::Tsit5.rates() }, N>(const { &Dense::Tsit5.slopes() }, first),
            Dense::Hermite => {
                self.slopes_of::<{ Dense::Hermite.rates() }, N>(const { &Dense::Hermite.slopes() }, first)
            }
        }
    }

    #[inline(always)]
    fn slopes_of<const RATES: usize, const N: usize>(&self, weights: &[[f64; 4]], first: usize) -> [[R; N]; 4] {
        let n = self.rates.len() / RATES;
        let mut slopes = [[R::splat(0.0); N]; 4];
        for (j, weights) in weights.iter().enumerate().take(RATES) {
            let rates = &self.rates[j * n + first..][..N];
            for (slope, weight) in slopes.iter_mut().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                for (slope, rate) in slope.iter_mut().zip(rates) {
                    *slope = R::splat(*weight).mul_add(*rate, *slope);
                }
            }
        }
        slopes
    }
}
