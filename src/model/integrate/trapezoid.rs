//! The implicit trapezoid, solved by a modified Newton iteration.
//!
//! `y_1 - y_0 - h/2 (f_0 + f(y_1)) = 0` for the controlled components; quadratures follow from the rates. The matrix
//! `I - h/2 df/dy` comes from differences of the right-hand side and is kept, factorised, for as long as the iteration
//! converges with it, through switches too. Only a new factorisation allocates.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use crate::integrate::fixed::Rule;
use crate::integrate::stepper::Trial;
use crate::integrate::system::System;

/// Correction in units of the scales at which the iteration ends.
const CONVERGED: f64 = 1e-8;
/// Corrections after which the iteration has failed with its matrix.
const ITERATIONS: usize = 15;
/// Ratio of one correction to the one before above which the matrix is no longer good enough.
const SLOW: f64 = 0.5;
/// Perturbation of a component for its column of the matrix, in units of its scale.
const PERTURBATION: f64 = 1e-4;

/// The implicit trapezoid, `y_1 = y_0 + h/2 (f_0 + f_1)`, of order 2.
#[derive(Debug)]
pub struct Trapezoid {
    factors: Option<LU<f64, Dyn, Dyn>>,
    scales: Vec<f64>,
    rate: Vec<f64>,
    perturbed: Vec<f64>,
    correction: DVector<f64>,
}

impl Rule for Trapezoid {
    const FOLLOWS_STATE: bool = false;

    fn new<S: System>(system: &S) -> Self {
        let n = system.dimension();
        Self {
            factors: None,
            scales: system.scales().to_vec(),
            rate: vec![0.0; n],
            perturbed: vec![0.0; n],
            correction: DVector::zeros(system.controlled()),
        }
    }

    fn step<S: System>(&mut self, system: &mut S, trial: &mut Trial<'_>) -> Result<(), String> {
        let kept = self.factors.is_some();
        let converged = (kept && self.iterate(system, trial)) || {
            self.factorise(system, trial);
            self.iterate(system, trial)
        };
        if !converged {
            let t = trial.t;
            return Err(format!("Newton's iteration does not converge at t = {t:.6} s: a shorter step may help"));
        }
        let rates = trial.rates.iter().zip(&self.rate);
        for ((new, old), (before, after)) in trial.y_new.iter_mut().zip(trial.y).zip(rates).skip(self.scales.len()) {
            *new = old + 0.5 * trial.h * (before + after);
        }
        Ok(())
    }
}

impl Trapezoid {
    /// Iterates from the explicit Euler step; returns whether it converges.
    fn iterate<S: System>(&mut self, system: &mut S, trial: &mut Trial<'_>) -> bool {
        let Some(factors) = &self.factors else { return false };
        let (t, h, y) = (trial.t, trial.h, trial.y);
        for ((new, old), rate) in trial.y_new.iter_mut().zip(y).zip(&*trial.rates) {
            *new = old + h * rate;
        }
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            system.rhs(t + h, trial.y_new, &mut self.rate);
            *trial.rhs_evaluations += 1;
            for (i, correction) in self.correction.iter_mut().enumerate() {
                *correction = y[i] - trial.y_new[i] + 0.5 * h * (trial.rates[i] + self.rate[i]);
            }
            if !factors.solve_mut(&mut self.correction) {
                return false;
            }
            let mut largest = 0.0_f64;
            for ((new, correction), scale) in trial.y_new.iter_mut().zip(&self.correction).zip(&self.scales) {
                *new += correction;
                let scaled = (correction / scale).abs();
                // A NaN must survive.
                largest = if scaled <= largest { largest } else { scaled };
            }
            if largest <= CONVERGED {
                return true;
            }
            if largest.is_nan() || largest > SLOW * before {
                return false;
            }
            before = largest;
        }
        false
    }

    /// Factorises `I - h/2 df/dy` at the start of the step.
    fn factorise<S: System>(&mut self, system: &mut S, trial: &mut Trial<'_>) {
        let states = self.scales.len();
        let mut matrix = DMatrix::identity(states, states);
        self.perturbed.copy_from_slice(trial.y);
        for j in 0..states {
            let by = PERTURBATION * self.scales[j];
            self.perturbed[j] = trial.y[j] + by;
            system.rhs(trial.t, &self.perturbed, &mut self.rate);
            self.perturbed[j] = trial.y[j];
            for i in 0..states {
                matrix[(i, j)] -= 0.5 * trial.h * (self.rate[i] - trial.rates[i]) / by;
            }
        }
        *trial.rhs_evaluations += states as u64;
        *trial.factorisations += 1;
        self.factors = Some(matrix.lu());
    }
}
