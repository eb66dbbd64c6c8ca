//! The coupled system with a change of what an integrator sees of it: a planted error, an event that is hidden.

use decore_model::integrate::{GuardSample, Rebasing, Settings, Switching, System, Taken};
use decore_model::system::Coupled;

/// What is changed; what is left as it is here is as the system within has it.
pub trait Change {
    /// The rates at (t, y).
    fn rhs(&self, inner: &mut Coupled, (t, y): (f64, &[f64]), rate: &mut [f64]) {
        inner.rhs(t, y, rate);
    }

    /// The value of a guard at (t, y).
    fn guard(&self, inner: &Coupled, guard: usize, (t, y): (f64, &[f64])) -> f64 {
        inner.guard(guard, t, y)
    }

    /// Changes what was sampled of the guards at the end of a step, at time `t`.
    fn change_samples(&mut self, _inner: &Coupled, _t: f64, _samples: &mut [GuardSample]) {}
}

/// A coupled system and the change of it.
pub struct Changed<C> {
    /// The system as it is.
    pub inner: Coupled,
    /// What is changed.
    pub change: C,
}

impl<C: Change> System for Changed<C> {
    fn dimension(&self) -> usize {
        self.inner.dimension()
    }

    fn scales(&self) -> &[f64] {
        self.inner.scales()
    }

    fn rhs(&mut self, t: f64, y: &[f64], rate: &mut [f64]) {
        self.change.rhs(&mut self.inner, (t, y), rate);
    }

    fn diagnose(&self, t: f64, y: &[f64]) -> String {
        self.inner.diagnose(t, y)
    }
}

impl<C: Change> Rebasing for Changed<C> {
    fn horizon(&self) -> f64 {
        self.inner.horizon()
    }

    fn rebase(&mut self, t: f64, y: &mut [f64], rate: &mut [f64]) {
        self.inner.rebase(t, y, rate);
    }

    fn stepped(&mut self, taken: &Taken<'_>) {
        self.inner.stepped(taken);
    }
}

impl<C: Change> Switching for Changed<C> {
    fn guard_count(&self) -> usize {
        self.inner.guard_count()
    }

    fn guard_support(&self, guard: usize) -> &[usize] {
        self.inner.guard_support(guard)
    }

    fn guard(&self, guard: usize, t: f64, y: &[f64]) -> f64 {
        self.change.guard(&self.inner, guard, (t, y))
    }

    fn sample_guards(&mut self, t: f64, y: &[f64], rate: &[f64], samples: &mut [GuardSample]) {
        self.inner.sample_guards(t, y, rate, samples);
        self.change.change_samples(&self.inner, t, samples);
    }

    fn switch(&mut self, guard: usize, t: f64, y: &mut [f64]) {
        self.inner.switch(guard, t, y);
    }

    fn next_stop(&self) -> f64 {
        self.inner.next_stop()
    }

    fn pass_stop(&mut self) {
        self.inner.pass_stop();
    }
}

/// Settings for a run of the coupled system at a tolerance, with budgets that no run reaches by accident.
pub fn settings(tolerance: f64) -> Settings {
    Settings {
        tolerance,
        first_step_s: 1e-6,
        longest_step_s: 1e-3,
        step_s: 1e-5,
        located: false,
        max_steps: 10_000_000,
        max_wall_time_s: 600.0,
    }
}
