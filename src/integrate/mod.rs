//! Time integration of piecewise smooth systems with located events. Knows no hammers.
//!
//! A [`System`] is smooth between switches. Its guards are functions of the state that are negative while its present
//! discrete state is right; the driver locates the first upward zero of a guard on the method's own dense output, ends
//! the step there and lets the system switch. Times known beforehand (a valve that opens) are scheduled stops.

mod counters;
mod driver;
mod exponential;
mod exponential_control;
mod fixed;
mod locate;
mod phi;
mod rk4;
mod step;
mod trapezoid;
mod tsit5;

use nalgebra::DMatrix;

pub use counters::Counters;
pub use driver::{Integrator, Settings, Stopped};
pub use fixed::{FixedRule, FixedSettings, FixedStep};
pub use step::Step;

/// A piecewise smooth initial value problem `y' = f(t, y)` with a discrete state of its own.
///
/// The first [`System::controlled`] components are under error control; the rest are quadratures, which no right-hand
/// side depends on.
pub trait System {
    /// Number of components of `y`, quadratures included.
    fn dimension(&self) -> usize;

    /// Number of leading components under error control.
    fn controlled(&self) -> usize;

    /// Size of each controlled component at which an error counts as 1 / tolerance; all positive.
    fn scales(&self) -> &[f64];

    /// Writes `f(t, y)` into `rate`. A state outside the model's validity gives NaN, and the step is rejected.
    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]);

    /// Number of guards.
    fn guard_count(&self) -> usize;

    /// Components of `y` that guard `guard` depends on.
    fn guard_support(&self, guard: usize) -> &[usize];

    /// Value of a guard; only the components of its support are valid in `y`. Negative: nothing to do.
    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64;

    /// Samples every guard at the time and state for which [`System::rhs`] was called last, and that rate: see
    /// [`GuardSample`].
    fn sample_guards(&mut self, t: f64, state_and_rate: (&[f64], &[f64]), samples: &mut [GuardSample]);

    /// Asks for right-hand sides that follow the state alone, as a plain program with its conditions in the right-hand
    /// side has them, instead of the discrete state; [`System::switch`] then only keeps the books. Returns whether the
    /// system does so: one that cannot need not.
    fn follow_state(&mut self, _follow: bool) -> bool {
        false
    }

    /// Time that no step may pass before [`System::rebase`] is called. Default: infinity.
    ///
    /// A system may carry a part of itself outside `y`, as functions of time that hold for a while.
    fn horizon(&self) -> f64 {
        f64::INFINITY
    }

    /// Brings the part outside `y` to time `t`; changes `y` and its rate to the new representation of the same state.
    fn rebase(&mut self, _t: f64, _y: &mut [f64], _rate: &mut [f64]) {}

    /// Where linear springs and dampers join bodies so stiffly that exponential steps may pay; `None`: nowhere.
    fn stiff_block(&self) -> Option<StiffBlock> {
        None
    }

    /// A number that names what [`System::stiff_matrices`] depends on.
    fn discrete_state(&self) -> u64 {
        0
    }

    /// Writes the matrices of the block in the present discrete state.
    fn stiff_matrices(&mut self, _matrices: &mut StiffMatrices) {}

    /// Writes the `lambda >= 0` of the block's relaxing components at a state, 1/s.
    fn relaxation(&self, _t: f64, _y: &[f64], _lambda: &mut [f64]) {}

    /// Changes the discrete state because `guard` has crossed zero at `(t, y)`; an impact law may change `y` too.
    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]);

    /// Time of the first scheduled stop that is not yet passed, or infinity.
    fn next_stop(&self) -> f64;

    /// Changes the discrete state at the scheduled stop that was due first.
    fn pass_stop(&mut self);

    /// Words for a state at which no step succeeds.
    fn diagnose(&self, t: f64, y: &[f64]) -> String;
}

/// Bodies in the state whose rates have a known linear part: `x' = v`, `v' = -K x - C v + (the rest)`; and integrals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StiffBlock {
    /// Index of the first position.
    pub positions: usize,
    /// Index of the first velocity.
    pub velocities: usize,
    /// Number of bodies.
    pub bodies: usize,
    /// Repeated integrals `z_{k+1}' = z_k`: index of the first, how many are integrated, how many times.
    pub integrals: (usize, usize, usize),
    /// Components that may relax by themselves, `y' = -lambda y + (the rest)`: index of the first, and how many.
    pub relaxing: (usize, usize),
}

/// The linear part of a [`StiffBlock`]'s rates.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffMatrices {
    /// `K`, in 1/s2: bodies x bodies.
    pub stiffness: DMatrix<f64>,
    /// `C`, in 1/s: bodies x bodies.
    pub damping: DMatrix<f64>,
    /// What positions add to the rates of the first integrals: integrals x bodies.
    pub integrated_stiffness: DMatrix<f64>,
    /// What velocities add to the rates of the first integrals: integrals x bodies.
    pub integrated_damping: DMatrix<f64>,
}

/// A guard at one end of a step.
///
/// A guard that is negative at both ends may still be positive in between: the step has passed over a short contact. To
/// see that, the system gives besides the guard's value a smooth function that is positive only if the guard is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GuardSample {
    /// Value of the guard.
    pub value: f64,
    /// The smooth function.
    pub smooth: f64,
    /// Its rate along the solution.
    pub smooth_rate: f64,
}

/// Sees every accepted step and every switch, in order of time.
pub trait Observer<S: System> {
    /// A step was accepted. It may have been cut at an event: its end is [`Step::end`].
    fn step(&mut self, system: &S, step: &Step<'_>);

    /// `guard` has crossed zero at `(t, y)`; the system has switched already.
    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]);
}

/// No observer at all.
impl<S: System> Observer<S> for () {
    fn step(&mut self, _system: &S, _step: &Step<'_>) {}

    fn event(&mut self, _system: &S, _guard: usize, _t: f64, _y: &[f64]) {}
}

/// Two observers, shown the same.
impl<S: System, A: Observer<S>, B: Observer<S>> Observer<S> for (A, B) {
    fn step(&mut self, system: &S, step: &Step<'_>) {
        self.0.step(system, step);
        self.1.step(system, step);
    }

    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]) {
        self.0.event(system, guard, t, y);
        self.1.event(system, guard, t, y);
    }
}
