//! Observers of a solution while it is computed.

use crate::integrate::step::Step;

/// Sees every accepted step and every switch, in order of time.
pub trait Observer<S> {
    /// A step was accepted. It may have been cut at an event: its end is [`Step::end`].
    fn step(&mut self, system: &S, step: &Step<'_>);

    /// `guard` has crossed zero at `(t, y)`; the system has switched already.
    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]);
}

/// No observer at all.
impl<S> Observer<S> for () {
    fn step(&mut self, _system: &S, _step: &Step<'_>) {}

    fn event(&mut self, _system: &S, _guard: usize, _t: f64, _y: &[f64]) {}
}

/// A borrowed observer.
impl<S, O: Observer<S> + ?Sized> Observer<S> for &mut O {
    fn step(&mut self, system: &S, step: &Step<'_>) {
        (**self).step(system, step);
    }

    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]) {
        (**self).event(system, guard, t, y);
    }
}

/// Two observers, shown the same.
impl<S, A: Observer<S>, B: Observer<S>> Observer<S> for (A, B) {
    fn step(&mut self, system: &S, step: &Step<'_>) {
        self.0.step(system, step);
        self.1.step(system, step);
    }

    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]) {
        self.0.event(system, guard, t, y);
        self.1.event(system, guard, t, y);
    }
}

/// An observer that may be missing.
impl<S, O: Observer<S>> Observer<S> for Option<O> {
    fn step(&mut self, system: &S, step: &Step<'_>) {
        self.iter_mut().for_each(|observer| observer.step(system, step));
    }

    fn event(&mut self, system: &S, guard: usize, t: f64, y: &[f64]) {
        self.iter_mut().for_each(|observer| observer.event(system, guard, t, y));
    }
}
