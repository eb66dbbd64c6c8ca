//! One accepted step with its dense output.

use crate::integrate::tsit5::{self, STAGES};

/// How a step is interpolated, from rates of which the first is that at its start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dense {
    /// The stages of the method of order 5.
    Tsit5,
    /// Rate at the start, rate at the end, mean rate: the cubic through both ends with their rates.
    Hermite,
}

impl Dense {
    /// Number of rates.
    pub(super) const fn rates(self) -> usize {
        match self {
            Self::Tsit5 => STAGES,
            Self::Hermite => 3,
        }
    }

    /// Which of them is that at the end of the step.
    pub(super) const fn last(self) -> usize {
        match self {
            Self::Tsit5 => STAGES - 1,
            Self::Hermite => 1,
        }
    }

    /// Weights of the rates at fraction `theta`; what a method does not have carries none.
    #[inline]
    fn weights(self, theta: f64) -> [f64; STAGES] {
        match self {
            Self::Tsit5 => tsit5::interpolant(theta),
            Self::Hermite => {
                let (back, square) = (1.0 - theta, theta * theta);
                [theta * back * back, -square * back, square * (3.0 - 2.0 * theta), 0.0, 0.0, 0.0, 0.0]
            }
        }
    }
}

/// An accepted step: from `t0`, `theta_end * h` long, with dense output at any fraction of `h` up to `theta_end`.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// Time at the start in s.
    pub t0: f64,
    /// Length of the step as computed, in s; the accepted part may be shorter.
    pub h: f64,
    /// Fraction of `h` that was accepted: 1, or less where an event ended the step.
    pub theta_end: f64,
    pub(super) dense: Dense,
    pub(super) y0: &'a [f64],
    pub(super) y1: &'a [f64],
    /// Rates, one after the other, each of the state's length.
    pub(super) rates: &'a [f64],
}

impl<'a> Step<'a> {
    /// Time at the end of the accepted part in s.
    pub fn t1(&self) -> f64 {
        self.time(self.theta_end)
    }

    /// Time at fraction `theta` in s.
    pub fn time(&self, theta: f64) -> f64 {
        self.t0 + theta * self.h
    }

    /// Fraction at time `t` within the accepted part.
    pub fn fraction(&self, t: f64) -> f64 {
        ((t - self.t0) / self.h).clamp(0.0, self.theta_end)
    }

    /// State at the start.
    pub fn start(&self) -> &'a [f64] {
        self.y0
    }

    /// State at the end of the accepted part.
    pub fn end(&self) -> &'a [f64] {
        self.y1
    }

    /// Rates of component `index`.
    #[inline]
    fn rates_of(&self, index: usize) -> impl Iterator<Item = f64> {
        self.rates[index..].iter().step_by(self.y0.len()).copied()
    }

    /// Largest absolute rate of a sum of components with coefficients: a practical bound of its rate within the step.
    pub fn largest_rate(&self, terms: impl Iterator<Item = (usize, f64)> + Clone) -> f64 {
        let rate = |rates: &[f64]| terms.clone().map(|(index, c)| c * rates[index]).sum::<f64>().abs();
        self.rates.chunks_exact(self.y0.len()).map(rate).fold(0.0, f64::max)
    }

    /// Component `index` of the state at fraction `theta`.
    pub fn component(&self, index: usize, theta: f64) -> f64 {
        self.component_with(index, &self.dense.weights(theta))
    }

    /// Writes the components `support` of the state at fraction `theta` into `y`; the others are left as they are.
    pub fn components(&self, support: &[usize], theta: f64, y: &mut [f64]) {
        let weights = self.dense.weights(theta);
        for &index in support {
            y[index] = self.component_with(index, &weights);
        }
    }

    /// Writes the whole state at fraction `theta` into `y`.
    pub fn state(&self, theta: f64, y: &mut [f64]) {
        let weights = self.dense.weights(theta);
        y.fill(0.0);
        for (weight, rates) in weights.iter().zip(self.rates.chunks_exact(self.y0.len())) {
            for (sum, rate) in y.iter_mut().zip(rates) {
                *sum += weight * rate;
            }
        }
        for (value, start) in y.iter_mut().zip(self.y0) {
            *value = start + self.h * *value;
        }
    }

    fn component_with(&self, index: usize, weights: &[f64; STAGES]) -> f64 {
        let mut sum = 0.0;
        for (weight, rate) in weights.iter().zip(self.rates_of(index)) {
            sum += weight * rate;
        }
        self.y0[index] + self.h * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interpolant goes through both ends with their rates: a cubic is reproduced exactly.
    #[test]
    fn analytic_hermite_interpolant_reproduces_cubics() {
        let cubic = |t: f64| [1.0 + t * (2.0 + t * (-3.0 + 0.5 * t))];
        let slope = |t: f64| 2.0 + t * (-6.0 + 1.5 * t);
        let (t0, h) = (0.3, 0.7);
        let (y0, y1) = (cubic(t0), cubic(t0 + h));
        let rates = [slope(t0), slope(t0 + h), (y1[0] - y0[0]) / h];
        let step = Step { t0, h, theta_end: 1.0, dense: Dense::Hermite, y0: &y0, y1: &y1, rates: &rates };
        for theta in [0.0, 0.2, 0.5, 0.9, 1.0] {
            assert!((step.component(0, theta) - cubic(t0 + theta * h)[0]).abs() < 1e-14);
        }
        assert_eq!(
            step.largest_rate([(0, 1.0)].into_iter()),
            rates.iter().fold(0.0_f64, |largest, rate| largest.max(rate.abs()))
        );
    }
}
