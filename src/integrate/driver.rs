//! The step loop, one for all methods: time, budgets, scheduled stops, event location, acceptance.

use std::marker::PhantomData;
use std::time::Instant;

use crate::integrate::counters::Counters;
use crate::integrate::locate::{Ends, Locator};
use crate::integrate::observer::Observer;
use crate::integrate::step::Step;
use crate::integrate::stepper::{Plan, Settings, Stepper, Trial};
use crate::integrate::system::{GuardSample, Switching};

/// Steps between two looks at the clock.
const CLOCK_INTERVAL: u64 = 256;

/// Why an integration ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Stopped {
    /// It reached its end.
    AtEnd,
    /// No step succeeds any more; the system's own words for the state.
    Diverged(String),
    /// The budget of steps is used up.
    StepBudget,
    /// The budget of wall time is used up.
    TimeBudget,
}

/// An integration of a system `S` by the method `P`, with its working memory: nothing is allocated once it exists.
#[derive(Debug)]
pub struct Integrator<S, P> {
    system: PhantomData<fn(&mut S)>,
    stepper: P,
    max_steps: u64,
    max_wall_time_s: f64,
    t: f64,
    y: Vec<f64>,
    y_new: Vec<f64>,
    rates: Vec<f64>,
    /// Whether the first rate is that at `(t, y)`, and the first samples are the guards there.
    rate_known: bool,
    /// Whether the system's right-hand side follows the state alone.
    following: bool,
    /// Guards that switched at the start of the present step.
    fresh: Vec<bool>,
    /// Guards that end the present step.
    locator: Locator,
    /// Guards at the start of the step, known with the rate there, and at its end.
    samples: Vec<GuardSample>,
    samples_new: Vec<GuardSample>,
    counters: Counters,
}

impl<S: Switching, P: Stepper<S>> Integrator<S, P> {
    /// Prepares an integration of `system` from `(t0, y0)`.
    pub fn new(system: &S, t0: f64, y0: &[f64], settings: &Settings) -> Self {
        let guards = system.guard_count();
        Self {
            system: PhantomData,
            stepper: P::new(system, settings),
            max_steps: settings.max_steps,
            max_wall_time_s: settings.max_wall_time_s,
            t: t0,
            y: y0.to_vec(),
            y_new: y0.to_vec(),
            rates: vec![0.0; P::DENSE.rates() * y0.len()],
            rate_known: false,
            following: false,
            fresh: vec![false; guards],
            locator: Locator::new(guards, y0),
            samples: vec![GuardSample::default(); guards],
            samples_new: vec![GuardSample::default(); guards],
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
    pub fn run<O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, t_end: f64) -> Stopped {
        let begin = Instant::now();
        self.following = system.follow_state(self.stepper.follows_state());
        while self.t < t_end {
            if let Some(stopped) = self.spent(begin) {
                return stopped;
            }
            let next = self.pass_stops(system);
            let stop = if self.stepper.locates() { next.min(t_end) } else { t_end };
            if stop - self.t <= self.stepper.rounding_s().max(4.0 * f64::EPSILON * stop.abs()) {
                // An event fell on the stop to within rounding.
                self.t = stop;
            } else if let Err(reason) = self.step(system, observer, stop) {
                return Stopped::Diverged(reason);
            }
        }
        Stopped::AtEnd
    }

    /// Which budget is used up; the clock is looked at now and then.
    fn spent(&self, begin: Instant) -> Option<Stopped> {
        let tried = self.counters.steps + self.counters.rejected_steps;
        if tried >= self.max_steps {
            return Some(Stopped::StepBudget);
        }
        let look = tried % CLOCK_INTERVAL == CLOCK_INTERVAL - 1;
        (look && begin.elapsed().as_secs_f64() > self.max_wall_time_s).then_some(Stopped::TimeBudget)
    }

    /// Passes the scheduled stops that are due; returns the time of the next one.
    fn pass_stops(&mut self, system: &mut S) -> f64 {
        while system.next_stop() <= self.t + self.stepper.rounding_s() {
            system.pass_stop();
            self.rate_known = false;
        }
        system.next_stop()
    }

    /// Tries a step up to `stop`, and accepts or rejects it; the error says why no step succeeds.
    fn step<O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, stop: f64) -> Result<(), String> {
        let plan = self.plan(system, stop);
        // Too short to move the clock: the steps before have shrunk to nothing.
        if self.t + 0.5 * plan.h <= self.t {
            return Err(system.diagnose(self.t, &self.y));
        }
        let trial = Trial {
            t: self.t,
            h: plan.h,
            y: &self.y,
            y_new: &mut self.y_new,
            rates: &mut self.rates,
            counters: &mut self.counters,
        };
        let error = self.stepper.attempt(system, trial)?;
        if error <= 1.0 {
            self.accept(system, observer, &plan, error);
        } else {
            self.counters.rejected_steps += 1;
            self.stepper.rejected(plan.h, error);
        }
        Ok(())
    }

    /// Makes sure that rate and guards at the present state are known; the next step, up to `stop` at most, and within the
    /// horizon of what the system carries outside the state.
    fn plan(&mut self, system: &mut S, stop: f64) -> Plan {
        let rate = &mut self.rates[..self.y.len()];
        if !self.rate_known {
            system.rhs(self.t, &self.y, rate);
            system.sample_guards(self.t, &self.y, rate, &mut self.samples);
            self.rate_known = true;
            self.counters.rhs_evaluations += 1;
        }
        let remaining = stop - self.t;
        let mut plan = self.stepper.plan(system, self.t, remaining);
        if self.t + plan.h > system.horizon() {
            system.rebase(self.t, &mut self.y, rate);
            let room = system.horizon() - self.t;
            plan = self.stepper.plan(system, self.t, remaining.min(room));
            if plan.h > room {
                plan = Plan { h: room, end: None };
            }
        }
        if plan.h > remaining { Plan { h: remaining, end: Some(stop) } } else { plan }
    }

    /// Ends the step at its first event, shows it to the observer, switches the system.
    fn accept<O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, plan: &Plan, error: f64) {
        let (n, h) = (self.y.len(), plan.h);
        let last = P::DENSE.last() * n..(P::DENSE.last() + 1) * n;
        system.sample_guards(self.t + h, &self.y_new, &self.rates[last.clone()], &mut self.samples_new);
        let mut step =
            Step { t0: self.t, h, theta_end: 1.0, dense: P::DENSE, y0: &self.y, y1: &self.y_new, rates: &self.rates };
        let ends = Ends { start: &self.samples, end: &self.samples_new, fresh: &self.fresh };
        let theta = if self.stepper.locates() {
            self.locator.first_events(system, &step, &ends)
        } else {
            self.locator.events_at_end(&ends)
        };
        if !self.locator.hits.is_empty() && !self.stepper.may_be_cut() {
            self.counters.rejected_steps += 1;
            return;
        }
        self.counters.steps += 1;
        if theta < 1.0 {
            step.state(theta, &mut self.locator.state);
            step.theta_end = theta;
            step.y1 = &self.locator.state;
        }
        if theta > 0.0 {
            observer.step(system, &step);
        }
        let begin = self.t;
        self.t = plan.end.filter(|_| theta == 1.0).unwrap_or(step.t1());
        if theta < 1.0 {
            self.y.copy_from_slice(&self.locator.state);
        } else {
            std::mem::swap(&mut self.y, &mut self.y_new);
            // The rate at the end is the first of the next step.
            self.rates.copy_within(last, 0);
            std::mem::swap(&mut self.samples, &mut self.samples_new);
        }
        self.rate_known = theta == 1.0;
        self.stepper.accepted(h, error, self.rate_known.then_some(&self.samples[..]));
        // A switch at the very start of a step happens together with the one before.
        if theta > 0.0 {
            self.fresh.fill(false);
        }
        self.switch_hits(system, observer, begin);
    }

    /// Switches the system at every guard hit, all at the present time and state; `begin` is where the step began.
    fn switch_hits<O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, begin: f64) {
        for &guard in &self.locator.hits {
            // What a right-hand side that follows the state has already acted upon is booked where the step began.
            let (t, y) = if self.following { (begin, &mut self.y_new) } else { (self.t, &mut self.y) };
            system.switch(guard, t, y);
            observer.event(system, guard, t, y);
            self.fresh[guard] = true;
            self.stepper.switched(guard);
            self.rate_known = false;
            self.counters.located_events += 1;
        }
    }
}
