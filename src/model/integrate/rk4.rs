//! The classical Runge-Kutta rule of order 4 (Kutta 1901).

use crate::integrate::fixed::Rule;
use crate::integrate::stepper::Trial;
use crate::integrate::system::System;

/// The classical explicit Runge-Kutta rule of order 4.
#[derive(Debug)]
pub struct Rk4 {
    scratch: Vec<f64>,
    rate: Vec<f64>,
}

impl Rule for Rk4 {
    const FOLLOWS_STATE: bool = true;

    fn new<S: System>(system: &S) -> Self {
        let n = system.dimension();
        Self { scratch: vec![0.0; n], rate: vec![0.0; n] }
    }

    fn step<S: System>(&mut self, system: &mut S, trial: &mut Trial<'_>) -> Result<(), String> {
        let (h, y) = (trial.h, trial.y);
        for (i, start) in y.iter().enumerate() {
            trial.y_new[i] = start + h / 6.0 * trial.rates[i];
            self.scratch[i] = start + 0.5 * h * trial.rates[i];
        }
        // Node and weight of the stages that follow, and how far the next stage's state lies along their rate.
        for (node, weight, reach) in [(0.5, 1.0 / 3.0, 0.5), (0.5, 1.0 / 3.0, 1.0), (1.0, 1.0 / 6.0, 0.0)] {
            system.rhs(trial.t + node * h, &self.scratch, &mut self.rate);
            for (i, start) in y.iter().enumerate() {
                trial.y_new[i] += weight * h * self.rate[i];
                self.scratch[i] = start + reach * h * self.rate[i];
            }
        }
        *trial.rhs_evaluations += 3;
        Ok(())
    }
}
