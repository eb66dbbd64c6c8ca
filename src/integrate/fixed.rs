//! Integration at a fixed step: what the default method is measured against.
//!
//! Nothing is located: what happens within a step is noticed at its end. Forces under the explicit rule follow the state at
//! every stage (a contact pushes where its bodies overlap and its law pushes), as a plain program evaluates them; an onset
//! is reported at the last state before it. Under the implicit rule, whose equations a force that jumps may leave without a
//! solution, contacts switch at the ends of steps: up to one step late, and pulling for what is left of the step in which
//! they open. Either way the error at a force that jumps, and that of the energy audit, is of first order in the step,
//! whatever the order of the rule; so it is at a scheduled stop, which takes effect at the next step. With [`FixedSettings::located`] switches and stops are located on the cubic Hermite interpolant instead and
//! end their steps, as under error control.

use std::time::Instant;

use crate::integrate::driver::spent;
use crate::integrate::locate::{Ends, first_events};
use crate::integrate::rk4::Rk4;
use crate::integrate::step::Dense;
use crate::integrate::trapezoid::Trapezoid;
use crate::integrate::{Counters, GuardSample, Observer, Step, Stopped, System};

/// Share of a step by which a stop may lie beyond its end and still be passed there: times on a grid carry rounding.
const ROUNDING: f64 = 1e-6;

/// Rule by which a step is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FixedRule {
    /// The classical explicit Runge-Kutta rule of order 4.
    Rk4,
    /// The implicit trapezoid, `y_1 = y_0 + h/2 (f_0 + f_1)`, of order 2.
    Trapezoid,
}

/// Step and effort of an integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedSettings {
    /// Rule of a step.
    pub rule: FixedRule,
    /// Length of a step in s.
    pub step_s: f64,
    /// Whether switches and stops are located; otherwise they are noticed at the ends of steps.
    pub located: bool,
    /// Steps after which the integration stops.
    pub max_steps: u64,
    /// Wall time in s after which the integration stops.
    pub max_wall_time_s: f64,
}

/// What a rule needs to make a step: where it starts, the rate there, and the length.
pub(super) struct Start<'a> {
    pub t: f64,
    pub y: &'a [f64],
    pub rate: &'a [f64],
    pub h: f64,
}

#[derive(Debug)]
enum Rule {
    Rk4(Rk4),
    Trapezoid(Box<Trapezoid>),
}

/// Working memory of one integration at a fixed step.
#[derive(Debug)]
pub struct FixedStep {
    settings: FixedSettings,
    rule: Rule,
    t: f64,
    /// Time from which steps are counted, and their number: sums of steps would drift.
    grid: (f64, u64),
    y: Vec<f64>,
    y_new: Vec<f64>,
    scratch: Vec<f64>,
    /// Rate at the start, rate at the end, mean rate.
    rates: Vec<f64>,
    /// Whether the system's right-hand side follows the state alone.
    following: bool,
    /// Whether the first rate holds at `(t, y)`.
    rate_known: bool,
    fresh: Vec<bool>,
    hits: Vec<usize>,
    samples: [Vec<GuardSample>; 2],
    counters: Counters,
}

impl FixedStep {
    /// Prepares an integration of `system` from `(t0, y0)`.
    pub fn new<S: System>(system: &S, t0: f64, y0: &[f64], settings: FixedSettings) -> Self {
        let guards = system.guard_count();
        let rule = match settings.rule {
            FixedRule::Rk4 => Rule::Rk4(Rk4::new(system)),
            FixedRule::Trapezoid => Rule::Trapezoid(Box::new(Trapezoid::new(system))),
        };
        Self {
            settings,
            rule,
            t: t0,
            grid: (t0, 0),
            y: y0.to_vec(),
            y_new: y0.to_vec(),
            scratch: y0.to_vec(),
            rates: vec![0.0; 3 * y0.len()],
            following: false,
            rate_known: false,
            fresh: vec![false; guards],
            hits: Vec::with_capacity(guards),
            samples: [vec![GuardSample::default(); guards], vec![GuardSample::default(); guards]],
            counters: Counters::default(),
        }
    }

    /// Present time in s.
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Present state.
    pub fn state(&self) -> &[f64] {
        &self.y
    }

    /// Work done so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Integrates to `t_end` and shows every step and switch to `observer`.
    pub fn run<S: System, O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, t_end: f64) -> Stopped {
        let begin = Instant::now();
        let follow = self.settings.rule == FixedRule::Rk4 && !self.settings.located;
        self.following = system.follow_state(follow);
        while self.t < t_end {
            let budget = (self.settings.max_steps, self.settings.max_wall_time_s);
            if let Some(stopped) = spent(self.counters.steps, begin, budget) {
                return stopped;
            }
            let stop =
                if self.pass_stops(system) < t_end && self.settings.located { system.next_stop() } else { t_end };
            let remaining = stop - self.t;
            if remaining <= ROUNDING * self.settings.step_s {
                self.t = stop;
                self.grid = (stop, 0);
                continue;
            }
            if let Err(reason) = self.step(system, observer, remaining) {
                return Stopped::Diverged(reason);
            }
        }
        self.rebase_beyond(system, f64::INFINITY);
        Stopped::AtEnd
    }

    /// Passes the scheduled stops that are due; returns the time of the next one.
    fn pass_stops<S: System>(&mut self, system: &mut S) -> f64 {
        while system.next_stop() <= self.t + ROUNDING * self.settings.step_s {
            system.pass_stop();
            self.rate_known = false;
        }
        system.next_stop()
    }

    /// Rebases what the system carries outside the state if a step to `t` needs it.
    fn rebase_beyond<S: System>(&mut self, system: &mut S, t: f64) {
        let n = self.y.len();
        if !self.rate_known {
            let rate = &mut self.rates[..n];
            system.rhs(self.t, &self.y, rate);
            system.sample_guards(self.t, (&self.y, rate), &mut self.samples[0]);
            self.rate_known = true;
            self.counters.rhs_evaluations += 1;
        }
        if system.horizon() < t {
            system.rebase(self.t, &mut self.y, &mut self.rates[..n]);
        }
    }

    /// Makes a step of the fixed length, or of what remains; the error says why there is no state at its end.
    fn step<S: System, O: Observer<S>>(
        &mut self,
        system: &mut S,
        observer: &mut O,
        remaining: f64,
    ) -> Result<(), String> {
        let n = self.y.len();
        let whole = self.settings.step_s <= remaining;
        let h = if whole { self.settings.step_s } else { remaining };
        self.rebase_beyond(system, self.t + h);
        let start = Start { t: self.t, y: &self.y, rate: &self.rates[..n], h };
        match &mut self.rule {
            Rule::Rk4(rule) => rule.step(system, &start, &mut self.y_new, &mut self.counters),
            Rule::Trapezoid(rule) => rule.step(system, &start, &mut self.y_new, &mut self.counters)?,
        }
        if !self.y_new.iter().all(|value| value.is_finite()) {
            return Err(system.diagnose(self.t + h, &self.y_new));
        }
        self.counters.steps += 1;
        let begin = self.t;
        let theta = self.finish(system, observer, h);
        let (from, count) = (self.grid.0, self.grid.1 + 1);
        if theta == 1.0 && whole {
            self.t = from + count as f64 * h;
            self.grid = (from, count);
        } else {
            self.t += theta * h;
            self.grid = (self.t, 0);
        }
        for index in 0..self.hits.len() {
            let guard = self.hits[index];
            // What a right-hand side that follows the state has already acted upon is booked where the step began.
            let (t, y) = if self.following { (begin, &mut self.y_new) } else { (self.t, &mut self.y) };
            system.switch(guard, t, y);
            observer.event(system, guard, t, y);
            self.fresh[guard] = true;
            self.rate_known = false;
            self.counters.located_events += 1;
        }
        Ok(())
    }

    /// Finds what switches, shows the step, moves to its end; returns the share of the step that was accepted.
    fn finish<S: System, O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, h: f64) -> f64 {
        let n = self.y.len();
        let t1 = self.t + h;
        let (last, mean) = self.rates[n..].split_at_mut(n);
        system.rhs(t1, &self.y_new, last);
        self.counters.rhs_evaluations += 1;
        for ((mean, new), old) in mean.iter_mut().zip(&self.y_new).zip(&self.y) {
            *mean = (new - old) / h;
        }
        let after = &mut self.samples[1];
        system.sample_guards(t1, (&self.y_new, last), after);
        let mut theta = 1.0;
        if !self.settings.located {
            self.hits.clear();
            self.hits.extend(after.iter().enumerate().filter(|(_, sample)| sample.value > 0.0).map(|(guard, _)| guard));
        }
        let dense = Dense::Hermite;
        let (y0, y1, stages) = (self.y.as_slice(), self.y_new.as_slice(), self.rates.as_slice());
        let mut step = Step { t0: self.t, h, theta_end: 1.0, dense, y0, y1, stages };
        if self.settings.located {
            let ends = Ends { start: &self.samples[0], end: &self.samples[1], fresh: &self.fresh };
            theta = first_events(system, &step, &ends, (&mut self.hits, &mut self.scratch));
        }
        if theta < 1.0 {
            step.state(theta, &mut self.scratch);
            step.theta_end = theta;
            step.y1 = &self.scratch;
        }
        if theta > 0.0 {
            observer.step(system, &step);
            self.fresh.fill(false);
        }
        if theta < 1.0 {
            self.y.copy_from_slice(&self.scratch);
        } else {
            std::mem::swap(&mut self.y, &mut self.y_new);
            self.rates.copy_within(n..2 * n, 0);
            self.samples.swap(0, 1);
        }
        self.rate_known = theta == 1.0;
        theta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interpolant goes through both ends with their rates: a cubic is reproduced exactly.
    #[test]
    fn analytic_hermite_interpolant_reproduces_cubics() {
        let cubic = |t: f64| [1.0 + t * (2.0 + t * (-3.0 + 0.5 * t))];
        let rate = |t: f64| 2.0 + t * (-6.0 + 1.5 * t);
        let (t0, h) = (0.3, 0.7);
        let (y0, y1) = (cubic(t0), cubic(t0 + h));
        let stages = [rate(t0), rate(t0 + h), (y1[0] - y0[0]) / h];
        let step = Step { t0, h, theta_end: 1.0, dense: Dense::Hermite, y0: &y0, y1: &y1, stages: &stages };
        for theta in [0.0, 0.2, 0.5, 0.9, 1.0] {
            assert!((step.component(0, theta) - cubic(t0 + theta * h)[0]).abs() < 1e-14);
        }
        assert_eq!(
            step.largest_rate([(0, 1.0)].into_iter()),
            stages.iter().fold(0.0_f64, |largest, rate| largest.max(rate.abs()))
        );
    }
}
