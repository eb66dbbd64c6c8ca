//! The classical Runge-Kutta rule of order 4 (Kutta 1901).

use crate::integrate::fixed::Start;
use crate::integrate::{Counters, System};

/// Working memory of the rule.
#[derive(Debug)]
pub(super) struct Rk4 {
    scratch: Vec<f64>,
    rate: Vec<f64>,
}

impl Rk4 {
    pub fn new<S: System>(system: &S) -> Self {
        let n = system.dimension();
        Self { scratch: vec![0.0; n], rate: vec![0.0; n] }
    }

    /// Writes the state at the end of the step into `y_new`.
    pub fn step<S: System>(&mut self, system: &mut S, start: &Start<'_>, y_new: &mut [f64], counters: &mut Counters) {
        let Start { t, y, rate, h } = *start;
        for i in 0..y.len() {
            y_new[i] = y[i] + h / 6.0 * rate[i];
            self.scratch[i] = y[i] + 0.5 * h * rate[i];
        }
        // Node and weight of the stages that follow, and how far the next stage's state lies along their rate.
        for (node, weight, reach) in [(0.5, 1.0 / 3.0, 0.5), (0.5, 1.0 / 3.0, 1.0), (1.0, 1.0 / 6.0, 0.0)] {
            system.rhs(t + node * h, &self.scratch, &mut self.rate);
            for i in 0..y.len() {
                y_new[i] += weight * h * self.rate[i];
                self.scratch[i] = y[i] + reach * h * self.rate[i];
            }
        }
        counters.rhs_evaluations += 3;
    }
}
