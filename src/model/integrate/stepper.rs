//! Interface between driver and method: the length of a step, and the step.

use crate::integrate::step::Dense;
use crate::integrate::system::InLanes;
use decore_math::number::Number;

/// Accuracy and effort of an integration. Methods ignore settings that they do not need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest error of a step in any controlled component, in units of its scale; under error control.
    pub tolerance: f64,
    /// First step in s; under error control.
    pub first_step_s: f64,
    /// Longest step in s; under error control.
    pub longest_step_s: f64,
    /// Length of a fixed step in s.
    pub step_s: f64,
    /// Whether a method with a fixed step locates switches and stops; otherwise it notices them at the ends of steps.
    pub located: bool,
    /// Accepted and rejected steps after which the integration stops.
    pub max_steps: u64,
    /// Wall time in s after which the integration stops.
    pub max_wall_time_s: f64,
}

/// The next step as a method would have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepPlan {
    /// Length in s, cut off at the next stop.
    pub h: f64,
    /// Time of its end, if it is known more precisely than by adding the length.
    pub end: Option<f64>,
}

/// A step to be computed, in each lane one.
#[derive(Debug)]
pub struct Trial<'a, R = f64> {
    /// Time at its start in s.
    pub t: R,
    /// Length in s; 0 in a lane without a row.
    pub h: R,
    /// State at its start.
    pub y: &'a [R],
    /// Becomes the state at its end.
    pub y_new: &'a mut [R],
    /// Becomes the rates that [`Stepper::DENSE`] asks for, one after the other; the first, at the start, is known.
    pub rates: &'a mut [R],
    /// Right-hand sides evaluated in each lane, to be added to.
    pub rhs_evaluations: &'a mut u64,
    /// Factorisations of a matrix, to be added to.
    pub factorisations: &'a mut u64,
}

impl<R> Trial<'_, R> {
    /// Rate at its start.
    pub fn rate(&self) -> &[R] {
        &self.rates[..self.y.len()]
    }
}

/// A method as the driver sees it; time, budgets, stops, events and acceptance are the driver's.
pub trait Stepper<S: InLanes<R>, R: Number = f64> {
    /// Interpolation of the steps, and its rates.
    const DENSE: Dense;

    /// Creates the method for rows like the rows of `system`.
    fn new(system: &S) -> Self;

    /// Begins anew with the row that is in a lane now.
    fn load(&mut self, lane: usize, row: &S::Row, settings: &Settings);

    /// Whether switches and stops are located within steps; otherwise they are noticed at the ends of steps.
    fn locates(&self) -> bool {
        true
    }

    /// Whether right-hand sides should follow the state alone where the system can do so.
    fn follows_state(&self) -> bool {
        false
    }

    /// Time in s by which a stop may lie beyond the end of a step and still be passed there.
    fn rounding_s(&self) -> f64 {
        0.0
    }

    /// Plans the step from `t` in a lane. Planning it twice changes nothing.
    fn plan(&mut self, lane: usize, t: f64) -> StepPlan;

    /// Computes a step; returns its error in units of the tolerance, up to 1 where it may be accepted.
    ///
    /// # Errors
    /// Words for why there is no state at its end and a repetition would not help.
    fn attempt(&mut self, system: &mut S, trial: Trial<'_, R>) -> Result<R, String>;

    /// Takes note of a step of length `h` that was accepted in a lane, and its error.
    fn accepted(&mut self, lane: usize, h: f64, error: f64);

    /// Takes note of a step of length `h` that was rejected in a lane for its error.
    fn rejected(&mut self, _lane: usize, _h: f64, _error: f64) {}

    /// Takes note of a switch of `guard` at the end of a lane's last step.
    fn switched(&mut self, _lane: usize, _guard: usize) {}
}
