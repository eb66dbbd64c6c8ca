//! What is integrated, by what a method asks of it: every system, one that switches, one that knows a linear part.

use std::ops::Range;

use nalgebra::DMatrix;

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

    /// Writes `f(t, y)` into `rate`. A state outside the model's validity gives NaN, and the step is rejected.
    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]);

    /// Words for a state at which no step succeeds.
    fn diagnose(&self, t: f64, _y: &[f64]) -> String {
        format!("the step size fell below the resolution of time at t = {t:.6} s")
    }
}

/// A system that is smooth between switches of a discrete state of its own.
///
/// Its guards are functions of the state that are negative while the present discrete state is right; times known
/// beforehand (a valve that opens) are scheduled stops. It may also carry a part of itself outside `y`, as functions of time
/// that hold up to a horizon.
pub trait Switching: System {
    /// Number of guards.
    fn guard_count(&self) -> usize;

    /// Components of `y` that guard `guard` depends on.
    fn guard_support(&self, guard: usize) -> &[usize];

    /// Value of a guard; only the components of its support are valid in `y`. Negative: nothing to do.
    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64;

    /// Samples every guard at the time and state for which [`System::rhs`] was called last, and that rate: see
    /// [`GuardSample`].
    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]);

    /// Changes the discrete state because `guard` has crossed zero at `(t, y)`; an impact law may change `y` too.
    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]);

    /// Time of the first scheduled stop that is not yet passed, or infinity.
    fn next_stop(&self) -> f64;

    /// Changes the discrete state at the scheduled stop that was due first.
    fn pass_stop(&mut self);

    /// Asks for right-hand sides that follow the state alone, as a plain program with its conditions in the right-hand
    /// side has them, instead of the discrete state; [`Switching::switch`] then only keeps the books. Returns whether the
    /// system does so: one that cannot need not.
    fn follow_state(&mut self, _follow: bool) -> bool {
        false
    }

    /// Time that no step may pass before [`Switching::rebase`] is called. Default: infinity.
    fn horizon(&self) -> f64 {
        f64::INFINITY
    }

    /// Brings the part outside `y` to time `t`; changes `y` and its rate to the new representation of the same state.
    fn rebase(&mut self, _t: f64, _y: &mut [f64], _rate: &mut [f64]) {}
}

/// A system that knows the linear part of its rates in each discrete state, for exponential steps.
pub trait LinearPart: System {
    /// Where linear springs and dampers join bodies so stiffly that exponential steps may pay; `None`: nowhere.
    fn stiff_block(&self) -> Option<StiffBlock>;

    /// A number that names what [`LinearPart::stiff_matrices`] depends on.
    fn discrete_state(&self) -> u64;

    /// Writes the matrices of the block in the present discrete state.
    fn stiff_matrices(&mut self, matrices: &mut StiffMatrices);

    /// Writes the `lambda >= 0` of the block's relaxing components at a state, 1/s.
    fn relaxation(&self, t: f64, y: &[f64], lambda: &mut [f64]);
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

/// Bodies in the state whose rates have a known linear part: `x' = v`, `v' = -K x - C v + (the rest)`; and integrals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StiffBlock {
    /// Index of the first position.
    pub positions: usize,
    /// Index of the first velocity.
    pub velocities: usize,
    /// Number of bodies.
    pub bodies: usize,
    /// Repeated integrals.
    pub integrals: Integrals,
    /// Components that may relax by themselves, `y' = -lambda y + (the rest)`.
    pub relaxing: Range<usize>,
}

/// Repeated integrals `z_{k+1}' = z_k` in the state: `width` quantities, each integrated `depth` times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Integrals {
    /// Index of the first integral of the first quantity; those of one order stand together.
    pub from: usize,
    /// Quantities that are integrated.
    pub width: usize,
    /// How many times.
    pub depth: usize,
}

impl Integrals {
    /// Their components of the state.
    pub fn range(&self) -> Range<usize> {
        self.from..self.from + self.width * self.depth
    }
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

impl StiffMatrices {
    /// Zero matrices of a block.
    pub fn zeros(block: &StiffBlock) -> Self {
        let (b, p) = (block.bodies, block.integrals.width);
        Self {
            stiffness: DMatrix::zeros(b, b),
            damping: DMatrix::zeros(b, b),
            integrated_stiffness: DMatrix::zeros(p, b),
            integrated_damping: DMatrix::zeros(p, b),
        }
    }
}
