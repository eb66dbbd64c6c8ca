//! Methods with a fixed step, for comparison with the default method.
//!
//! Nothing is located: what happens within a step is noticed at its end. Forces under an explicit rule follow the state at
//! every stage (a contact pushes where its bodies overlap and its law pushes), as a plain program evaluates them; an onset
//! is reported at the last state before it. Under an implicit rule, whose equations a force that jumps may leave without a
//! solution, contacts switch at the ends of steps: up to one step late, and pulling for what is left of the step in which
//! they open. Either way the error at a force that jumps, and that of the energy audit, is of first order in the step,
//! whatever the order of the rule; so it is at a scheduled stop, which takes effect at the next step. With
//! [`Settings::located`] switches and stops are located on the cubic Hermite interpolant instead and end their steps, as
//! under error control.

use crate::integrate::step::Dense;
use crate::integrate::stepper::{Settings, StepPlan, Stepper, Trial};
use crate::integrate::system::{Rebasing, System};

/// Share of a step by which a stop may lie beyond its end and still be passed there: times on a grid carry rounding.
const ROUNDING: f64 = 1e-6;

/// Rule by which a fixed step is made.
pub trait Rule {
    /// Whether forces may follow the state at every stage.
    const FOLLOWS_STATE: bool;

    /// The rule for `system`.
    fn new<S: System>(system: &S) -> Self;

    /// Writes the state at the end of a step into [`Trial::y_new`].
    ///
    /// # Errors
    /// Words for why the rule's equations have no solution.
    fn step<S: System>(&mut self, system: &mut S, trial: &mut Trial<'_>) -> Result<(), String>;
}

/// A rule at a fixed step.
#[derive(Debug)]
pub struct FixedStep<R> {
    rule: R,
    step_s: f64,
    located: bool,
    /// Time from which steps are counted, and their number: sums of steps would drift.
    from: f64,
    count: u64,
}

impl<R> FixedStep<R> {
    /// End of step number `count` on the present grid, s.
    fn end(&self, count: u64) -> f64 {
        self.from + count as f64 * self.step_s
    }
}

impl<S: Rebasing, R: Rule> Stepper<S> for FixedStep<R> {
    const DENSE: Dense = Dense::Hermite;

    fn new(system: &S) -> Self {
        Self { rule: R::new(system), step_s: f64::NAN, located: false, from: f64::NAN, count: 0 }
    }

    fn load(&mut self, _lane: usize, row: &S, settings: &Settings) {
        let Settings { step_s, located, .. } = *settings;
        *self = Self { rule: R::new(row), step_s, located, from: f64::NAN, count: 0 };
    }

    fn locates(&self) -> bool {
        self.located
    }

    fn follows_state(&self) -> bool {
        R::FOLLOWS_STATE && !self.located
    }

    fn rounding_s(&self) -> f64 {
        ROUNDING * self.step_s
    }

    fn plan(&mut self, _lane: usize, t: f64) -> StepPlan {
        if self.end(self.count) != t {
            (self.from, self.count) = (t, 0);
        }
        StepPlan { h: self.step_s, end: Some(self.end(self.count + 1)) }
    }

    fn attempt(&mut self, system: &mut S, mut trial: Trial<'_>) -> Result<f64, String> {
        self.rule.step(system, &mut trial)?;
        let Trial { t, h, y, y_new, rates, rhs_evaluations, .. } = trial;
        if !y_new.iter().all(|value| value.is_finite()) {
            return Err(system.diagnose(t + h, y_new));
        }
        let (last, mean) = rates[y.len()..].split_at_mut(y.len());
        System::rhs(system, t + h, y_new, last);
        *rhs_evaluations += 1;
        for ((mean, new), old) in mean.iter_mut().zip(&*y_new).zip(y) {
            *mean = (new - old) / h;
        }
        Ok(0.0)
    }

    fn accepted(&mut self, _lane: usize, _h: f64, _error: f64) {
        self.count += 1;
    }
}
