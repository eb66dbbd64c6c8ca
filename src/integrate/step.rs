//! One accepted step with its dense output.

use crate::integrate::tsit5::{self, STAGES};

/// How a step is interpolated from its rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dense {
    /// The stages of the method of order 5.
    Tsit5,
    /// Rate at the start, rate at the end, mean rate: the cubic through both ends with their rates.
    Hermite,
}

impl Dense {
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
    /// Rates, stage after stage, each of the state's length.
    pub(super) stages: &'a [f64],
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

    /// Rates of component `index` at the stages.
    #[inline]
    fn stage_rates(&self, index: usize) -> impl Iterator<Item = f64> {
        self.stages[index..].iter().step_by(self.y0.len()).copied()
    }

    /// Largest absolute stage rate of a sum of components with coefficients: a practical bound of its rate within the step.
    pub fn largest_rate(&self, terms: impl Iterator<Item = (usize, f64)> + Clone) -> f64 {
        let rate = |stage: &[f64]| terms.clone().map(|(index, c)| c * stage[index]).sum::<f64>().abs();
        self.stages.chunks_exact(self.y0.len()).map(rate).fold(0.0, f64::max)
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
        for (weight, rates) in weights.iter().zip(self.stages.chunks_exact(self.y0.len())) {
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
        for (weight, rate) in weights.iter().zip(self.stage_rates(index)) {
            sum += weight * rate;
        }
        self.y0[index] + self.h * sum
    }
}
