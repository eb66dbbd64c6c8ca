//! Traits of systems, by the needs of a method: every system, systems that switch, systems with a part outside the state, several rows in
//! lanes.

use std::ops::Range;

use crate::integrate::taken::Taken;
use decore_math::number::Number;

/// An initial value problem `y' = f(t, y)`.
///
/// The first [`System::controlled`] components are under error control; the rest are quadratures, which no right-hand
/// side depends on.
pub trait System {
    /// Number of components of `y`, quadratures included.
    fn dimension(&self) -> usize;

    /// Size of each controlled component at which an error counts as 1 / tolerance; all positive.
    fn scales(&self) -> &[f64];

    /// Number of leading components under error control: those that have a scale.
    fn controlled(&self) -> usize {
        self.scales().len()
    }

    /// Controlled components of one row without an error scale: their scale is infinite, because their errors follow from others. Default:
    /// none.
    fn without_scale(&self) -> Range<usize> {
        0..0
    }

    /// Writes `f(t, y)` into `rate`. A state outside the model's validity gives NaN, and the step is rejected.
    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]);

    /// Words for a state at which no step succeeds.
    fn diagnose(&self, t: f64, _y: &[f64]) -> String {
        format!("the step size fell below the resolution of time at t = {t:.6} s")
    }
}

/// A system that is smooth between switches of a discrete state of its own.
///
/// Guards are functions of the state that are negative while the discrete state is right. Known times (a valve that opens) are scheduled
/// stops.
pub trait Switching: System {
    /// Number of guards.
    fn guard_count(&self) -> usize;

    /// Components of `y` that guard `guard` depends on.
    fn guard_support(&self, guard: usize) -> &[usize];

    /// Value of a guard; only the components of its support are valid in `y`. Negative: nothing to do.
    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64;

    /// The two sums of components, each with its coefficient, that guard `guard` is a function of, for a guard that is one of no
    /// more; see [`Switching::guard_of`]. Default: `None`.
    fn guard_sums(&self, _guard: usize) -> Option<&[Vec<(usize, f64)>; 2]> {
        None
    }

    /// Value of a guard by its [`Switching::guard_sums`]. Default: not a number.
    fn guard_of(&self, _guard: usize, _sums: [f64; 2]) -> f64 {
        f64::NAN
    }

    /// Samples every guard at the time and state for which [`System::rhs`] was called last, and that rate: see
    /// [`GuardSample`].
    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]);

    /// Changes the discrete state because `guard` has crossed zero at `(t, y)`; an impact law may change `y` too.
    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]);

    /// Time of the first scheduled stop that is not yet passed, or infinity. It changes at switches and stops only.
    fn next_stop(&self) -> f64;

    /// Changes the discrete state at the scheduled stop that was due first.
    fn pass_stop(&mut self);

    /// Makes right-hand sides follow the state alone, like a plain program with conditions in its right-hand side, instead of the discrete
    /// state. [`Switching::switch`] then only records. Returns whether the system supports this.
    fn follow_state(&mut self, _follow: bool) -> bool {
        false
    }
}

/// A system with a part outside `y`, as functions of time that hold up to a horizon: the linear part, which is known ahead. Default: no
/// such part.
pub trait Rebasing: Switching {
    /// Time that no step may pass before [`Rebasing::rebase`] is called. Default: infinity.
    fn horizon(&self) -> f64 {
        f64::INFINITY
    }

    /// Components of the state and of its rate that [`Rebasing::rebase`] reads and changes; the others are not valid there. Default: all.
    fn rebased_components(&self) -> Range<usize> {
        0..self.dimension()
    }

    /// Brings the part outside `y` to time `t`; changes `y` and its rate to the new representation of the same state.
    fn rebase(&mut self, _t: f64, _y: &mut [f64], _rate: &mut [f64]) {}

    /// Takes note of an accepted step, before any switch at its end. Default: nothing.
    fn stepped(&mut self, _taken: &Taken<'_>) {}
}

/// Rows integrated side by side, one in each lane of `R`, all of one shape: with the same components of the state and guards.
///
/// Each row keeps its own discrete state. Evaluations at every step are for all lanes at once, and no lane depends on another.
pub trait InLanes<R: Number> {
    /// A row by itself.
    type Row: Rebasing;

    /// The row in a lane.
    fn row(&self, lane: usize) -> &Self::Row;

    /// The row in a lane, to be changed; [`InLanes::switched`] or [`InLanes::rebased`] is called after.
    fn row_mut(&mut self, lane: usize) -> &mut Self::Row;

    /// Takes note that the discrete state of the row in a lane has changed.
    fn switched(&mut self, lane: usize);

    /// Called when the part of a lane's row outside `y` has changed.
    fn rebased(&mut self, lane: usize);

    /// Takes note of the steps of all lanes, as [`Rebasing::stepped`].
    fn stepped(&mut self, taken: &Taken<'_, R>);

    /// Writes `f(t, y)` of each lane into `rate`.
    fn rhs(&mut self, t: R, y: &[R], rate: &mut [R]);

    /// Samples the guards of each lane, as [`Switching::sample_guards`].
    fn sample_guards(&mut self, t: R, y: &[R], rate: &[R], samples: &mut [GuardSample<R>]);
}

/// A row alone.
impl<S: Rebasing> InLanes<f64> for S {
    type Row = S;

    fn row(&self, _: usize) -> &S {
        self
    }

    fn row_mut(&mut self, _: usize) -> &mut S {
        self
    }

    fn switched(&mut self, _: usize) {}

    fn rebased(&mut self, _: usize) {}

    fn stepped(&mut self, taken: &Taken<'_>) {
        Rebasing::stepped(self, taken);
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        System::rhs(self, t, y, rate);
    }

    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        Switching::sample_guards(self, t, y, rate, samples);
    }
}

/// A guard at one end of a step.
///
/// A guard that is negative at both ends may still be positive in between: the step has passed over a short contact. To
/// see that, the system gives besides the guard's value a smooth function that is positive only if the guard is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GuardSample<R = f64> {
    /// Value of the guard.
    pub value: R,
    /// The smooth function.
    pub smooth: R,
    /// Rate along the solution.
    pub smooth_rate: R,
}

impl<R: Number> GuardSample<R> {
    /// Sample of one lane.
    pub(super) fn lane(&self, lane: usize) -> GuardSample {
        GuardSample {
            value: self.value.lane(lane),
            smooth: self.smooth.lane(lane),
            smooth_rate: self.smooth_rate.lane(lane),
        }
    }

    /// The one or the other, lane by lane.
    #[inline(always)]
    pub(super) fn select(mask: R::Mask, yes: &Self, no: &Self) -> Self {
        Self {
            value: R::select(mask, yes.value, no.value),
            smooth: R::select(mask, yes.smooth, no.smooth),
            smooth_rate: R::select(mask, yes.smooth_rate, no.smooth_rate),
        }
    }
}
