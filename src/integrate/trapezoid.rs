//! The implicit trapezoid, solved by a modified Newton iteration.
//!
//! `y_1 - y_0 - h/2 (f_0 + f(y_1)) = 0` for the controlled components; quadratures follow from the rates. The matrix
//! `I - h/2 df/dy` comes from differences of the right-hand side and is kept, factorised, for as long as the iteration
//! converges with it, through switches too. Only a new factorisation allocates.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use crate::integrate::fixed::Start;
use crate::integrate::{Counters, System};

/// Correction in units of the scales at which the iteration ends.
const CONVERGED: f64 = 1e-8;
/// Corrections after which the iteration has failed with its matrix.
const ITERATIONS: usize = 15;
/// Ratio of one correction to the one before above which the matrix is no longer good enough.
const SLOW: f64 = 0.5;
/// Perturbation of a component for its column of the matrix, in units of its scale.
const PERTURBATION: f64 = 1e-4;

/// Working memory of the rule.
#[derive(Debug)]
pub(super) struct Trapezoid {
    factors: Option<LU<f64, Dyn, Dyn>>,
    scales: Vec<f64>,
    rate: Vec<f64>,
    perturbed: Vec<f64>,
    correction: DVector<f64>,
}

impl Trapezoid {
    pub fn new<S: System>(system: &S) -> Self {
        let n = system.dimension();
        Self {
            factors: None,
            scales: system.scales().to_vec(),
            rate: vec![0.0; n],
            perturbed: vec![0.0; n],
            correction: DVector::zeros(system.controlled()),
        }
    }

    /// Writes the state at the end of the step into `y_new`; the error says that the iteration fails.
    pub fn step<S: System>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        y_new: &mut [f64],
        counters: &mut Counters,
    ) -> Result<(), String> {
        let kept = self.factors.is_some();
        let converged = (kept && self.iterate(system, start, y_new, counters)) || {
            self.factorise(system, start, counters);
            self.iterate(system, start, y_new, counters)
        };
        if !converged {
            let t = start.t;
            return Err(format!("Newton's iteration does not converge at t = {t:.6} s: a shorter step may help"));
        }
        let rates = start.rate.iter().zip(&self.rate);
        for ((new, old), (before, after)) in y_new.iter_mut().zip(start.y).zip(rates).skip(self.scales.len()) {
            *new = old + 0.5 * start.h * (before + after);
        }
        Ok(())
    }

    /// Iterates from the explicit Euler step; returns whether it converges.
    fn iterate<S: System>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        y_new: &mut [f64],
        counters: &mut Counters,
    ) -> bool {
        let Some(factors) = &self.factors else { return false };
        for ((new, old), rate) in y_new.iter_mut().zip(start.y).zip(start.rate) {
            *new = old + start.h * rate;
        }
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            system.rhs(start.t + start.h, y_new, &mut self.rate);
            counters.rhs_evaluations += 1;
            for (i, correction) in self.correction.iter_mut().enumerate() {
                *correction = start.y[i] - y_new[i] + 0.5 * start.h * (start.rate[i] + self.rate[i]);
            }
            if !factors.solve_mut(&mut self.correction) {
                return false;
            }
            let mut largest = 0.0_f64;
            for ((new, correction), scale) in y_new.iter_mut().zip(&self.correction).zip(&self.scales) {
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
    fn factorise<S: System>(&mut self, system: &mut S, start: &Start<'_>, counters: &mut Counters) {
        let states = self.scales.len();
        let mut matrix = DMatrix::identity(states, states);
        self.perturbed.copy_from_slice(start.y);
        for j in 0..states {
            let by = PERTURBATION * self.scales[j];
            self.perturbed[j] = start.y[j] + by;
            system.rhs(start.t, &self.perturbed, &mut self.rate);
            self.perturbed[j] = start.y[j];
            for i in 0..states {
                matrix[(i, j)] -= 0.5 * start.h * (self.rate[i] - start.rate[i]) / by;
            }
        }
        counters.rhs_evaluations += states as u64;
        counters.factorisations += 1;
        self.factors = Some(matrix.lu());
    }
}
