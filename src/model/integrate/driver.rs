//! Step loop for all methods and any number of rows in lanes: time, budgets, scheduled stops, event location, acceptance.
//!
//! All lanes step together, each with its own time and step length. If the step of a lane is rejected or shortened, the lane stays there
//! while the others continue. A lane depends only on its own row.

use std::marker::PhantomData;
use std::time::Instant;

use crate::integrate::blend::{blend, blend_samples, suspects};
use crate::integrate::counters::Counters;
use crate::integrate::lane::{Lane, Stopped, Work};
use crate::integrate::locate::{Ends, Memory, SwitchedLane, first_events};
use crate::integrate::observer::Observer;
use crate::integrate::step::{Ingredients, Step};
use crate::integrate::stepper::{Settings, StepPlan, Stepper, Trial};
use crate::integrate::system::{GuardSample, InLanes, Rebasing, Switching, System};
use crate::integrate::taken::Taken;
use decore_math::number::{Mask, Number};

/// Steps between two looks at the clock.
const CLOCK_INTERVAL: u64 = 256;

/// An integration of rows `S` by the method `P` in the lanes of `R`, with its working memory: nothing is allocated once it exists.
#[derive(Debug)]
pub struct Integrator<S, P, R: Number = f64> {
    system: PhantomData<fn(&mut S)>,
    stepper: P,
    lanes: Vec<Lane>,
    y: Vec<R>,
    y_new: Vec<R>,
    rates: Vec<R>,
    /// Rates at the start of steps before they are taken over.
    fresh_rate: Vec<R>,
    /// Guards at the start of the step, known with the rate there, and at its end.
    samples: Vec<GuardSample<R>>,
    samples_new: Vec<GuardSample<R>>,
    /// Whether the system's right-hand side follows the state alone.
    following: bool,
    /// A lane's state and rate.
    state: Vec<f64>,
    rate: Vec<f64>,
    tries: u64,
    clock: Instant,
}

/// Initial values of a row.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// Time at the start in s.
    pub t0: f64,
    /// State there.
    pub y0: &'a [f64],
    /// Time at the end in s.
    pub t_end: f64,
}

/// One row alone.
impl<S: Rebasing, P: Stepper<S>> Integrator<S, P> {
    /// Prepares an integration of `system` from `(t0, y0)`.
    pub fn new(system: &S, t0: f64, y0: &[f64], settings: &Settings) -> Self {
        let mut integrator = Self::idle(system);
        integrator.load(system, 0, &Start { t0, y0, t_end: t0 }, settings);
        integrator
    }

    /// Integrates to `t_end` and shows every step and switch to `observer`.
    pub fn run<O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, t_end: f64) -> Stopped {
        self.lanes[0].t_end = t_end;
        self.lanes[0].work = Work::Running;
        self.following = system.follow_state(self.stepper.follows_state());
        self.clock = Instant::now();
        self.run_until_one_ends(system, std::slice::from_mut(observer)).map_or(Stopped::AtEnd, |(_, stopped)| stopped)
    }

    /// Present time in s.
    pub fn time(&self) -> f64 {
        self.lanes[0].t
    }

    /// Present state.
    pub fn state(&self) -> &[f64] {
        &self.y
    }

    /// Work done so far.
    pub fn counters(&self) -> Counters {
        self.lanes[0].counters
    }
}

impl<S: InLanes<R>, P: Stepper<S, R>, R: Number> Integrator<S, P, R> {
    /// Prepares integrations of rows like that in the first lane of `system`.
    pub fn idle(system: &S) -> Self {
        let row = system.row(0);
        let (n, guards) = (row.dimension(), row.guard_count());
        let zeros = |length: usize| vec![R::splat(0.0); length];
        let sample = GuardSample::default();
        Self {
            system: PhantomData,
            stepper: P::new(system),
            lanes: vec![Lane::idle(guards); R::LANES],
            y: zeros(n),
            y_new: zeros(n),
            rates: zeros(P::DENSE.rates() * n),
            fresh_rate: zeros(n),
            samples: vec![sample; guards],
            samples_new: vec![sample; guards],
            following: false,
            state: vec![0.0; n],
            rate: vec![0.0; n],
            tries: 0,
            clock: Instant::now(),
        }
    }

    /// Begins with the row that is in a lane now.
    pub fn load(&mut self, system: &S, lane: usize, start: &Start<'_>, settings: &Settings) {
        self.look_at_the_clock();
        self.stepper.load(lane, system.row(lane), settings);
        self.lanes[lane].load(start.t0, start.t_end, settings);
        self.lanes[lane].horizon = system.row(lane).horizon();
        write(start.y0, lane, &mut self.y);
    }

    /// Returns time, state (written into `y`), counters and shared wall time in s of a lane's row.
    pub fn reached(&self, lane: usize, y: &mut [f64]) -> (f64, Counters, f64) {
        read(&self.y, lane, y);
        (self.lanes[lane].t, self.lanes[lane].counters, self.lanes[lane].wall_time_s)
    }

    /// Integrates all lanes until the row in one of them ends; returns that lane and why. `None` if no lane has a row. Steps and
    /// switches of each lane are shown to its own observer.
    pub fn run_until_one_ends<O: Observer<S::Row>>(
        &mut self,
        system: &mut S,
        observers: &mut [O],
    ) -> Option<(usize, Stopped)> {
        loop {
            (0..R::LANES).for_each(|lane| self.begin(system, lane));
            if let Some(lane) = self.lanes.iter().position(|lane| matches!(lane.work, Work::Ended(_))) {
                self.look_at_the_clock();
                if let Work::Ended(stopped) = std::mem::replace(&mut self.lanes[lane].work, Work::Idle) {
                    return Some((lane, stopped));
                }
            }
            if !self.lanes.iter().any(Lane::is_running) {
                return None;
            }
            self.know_rates(system);
            (0..R::LANES).for_each(|lane| self.plan(system, lane));
            self.step(system, observers);
            self.tries += 1;
            if self.tries.is_multiple_of(CLOCK_INTERVAL) {
                self.look_at_the_clock();
            }
        }
    }

    /// Shares the time since the last look among the rows.
    fn look_at_the_clock(&mut self) {
        let now = Instant::now();
        let passed_s = now.duration_since(self.clock).as_secs_f64();
        self.clock = now;
        let rows = self.lanes.iter().filter(|lane| lane.work != Work::Idle).count();
        for lane in self.lanes.iter_mut().filter(|lane| lane.work != Work::Idle) {
            lane.wall_time_s += passed_s / rows as f64;
        }
    }

    /// Handles events that are due before a lane's next step, and detects the end of its row.
    fn begin(&mut self, system: &mut S, at: usize) {
        let lane = &mut self.lanes[at];
        while lane.is_running() {
            let ended = if lane.t >= lane.t_end { Some(Stopped::AtEnd) } else { lane.spent() };
            if let Some(stopped) = ended {
                lane.work = Work::Ended(stopped);
                return;
            }
            let mut next = lane.next_stop.unwrap_or_else(|| system.row(at).next_stop());
            while next <= lane.t + self.stepper.rounding_s() {
                system.row_mut(at).pass_stop();
                system.switched(at);
                lane.rate_known = false;
                next = system.row(at).next_stop();
            }
            lane.next_stop = Some(next);
            lane.stop = if self.stepper.locates() { next.min(lane.t_end) } else { lane.t_end };
            if lane.stop - lane.t > self.stepper.rounding_s().max(4.0 * f64::EPSILON * lane.stop.abs()) {
                return;
            }
            // An event fell on the stop to within rounding.
            lane.t = lane.stop;
        }
    }

    /// One value of each lane.
    fn gathered(&self, value: impl Fn(&Lane) -> f64) -> R {
        let mut gathered = R::splat(0.0);
        self.lanes.iter().enumerate().for_each(|(at, lane)| gathered.put(at, &value(lane)));
        gathered
    }

    /// Mask of the lanes for which a condition holds.
    fn mask(&self, holds: impl Fn(&Lane) -> bool) -> R::Mask {
        let mut mask = R::Mask::default();
        self.lanes.iter().enumerate().for_each(|(at, lane)| mask.put(at, holds(lane)));
        mask
    }

    /// Makes sure that rates and guards at the present states are known.
    fn know_rates(&mut self, system: &mut S) {
        let unknown = |lane: &Lane| lane.is_running() && !lane.rate_known;
        if !self.lanes.iter().any(unknown) {
            return;
        }
        let (t, n) = (self.gathered(|lane| lane.t), self.y.len());
        let mask = self.mask(unknown);
        // The rates of lanes without a row do not matter.
        if self.lanes.iter().all(|lane| !lane.is_running() || !lane.rate_known) {
            system.rhs(t, &self.y, &mut self.rates[..n]);
            system.sample_guards(t, &self.y, &self.rates[..n], &mut self.samples);
        } else {
            system.rhs(t, &self.y, &mut self.fresh_rate);
            system.sample_guards(t, &self.y, &self.fresh_rate, &mut self.samples_new);
            blend(mask, &self.fresh_rate, &mut self.rates[..n]);
            blend_samples(mask, &self.samples_new, &mut self.samples);
        }
        for lane in self.lanes.iter_mut().filter(|lane| unknown(lane)) {
            lane.rate_known = true;
            lane.counters.rhs_evaluations += 1;
        }
    }

    /// Plans a lane's next step: up to its next stop, and within the horizon of its row's part outside the state.
    fn plan(&mut self, system: &mut S, at: usize) {
        if !self.lanes[at].is_running() {
            self.lanes[at].plan = StepPlan { h: 0.0, end: None };
            return;
        }
        let (t, remaining) = (self.lanes[at].t, self.lanes[at].stop - self.lanes[at].t);
        let mut plan = self.stepper.plan(at, t);
        if t + plan.h > self.lanes[at].horizon {
            self.rebase(system, at);
            let room = self.lanes[at].horizon - t;
            plan = self.stepper.plan(at, t);
            if plan.h > room {
                plan = StepPlan { h: room, end: None };
            }
        }
        let stop = self.lanes[at].stop;
        let plan = if plan.h > remaining { StepPlan { h: remaining, end: Some(stop) } } else { plan };
        // Too short to move the clock: the steps before have shrunk to nothing.
        if t + 0.5 * plan.h <= t {
            read(&self.y, at, &mut self.state);
            let words = system.row(at).diagnose(t, &self.state);
            self.lanes[at].work = Work::Ended(Stopped::Diverged(words));
            self.lanes[at].plan = StepPlan { h: 0.0, end: None };
        } else {
            self.lanes[at].plan = plan;
        }
    }

    /// Rebases the part of a lane's row outside the state.
    fn rebase(&mut self, system: &mut S, at: usize) {
        let of = system.row(at).rebased_components();
        read(&self.y[of.clone()], at, &mut self.state[of.clone()]);
        read(&self.rates[of.clone()], at, &mut self.rate[of.clone()]);
        system.row_mut(at).rebase(self.lanes[at].t, &mut self.state, &mut self.rate);
        system.rebased(at);
        self.lanes[at].horizon = system.row(at).horizon();
        write(&self.state[of.clone()], at, &mut self.y[of.clone()]);
        write(&self.rate[of.clone()], at, &mut self.rates[of]);
    }

    /// Tries a step in all lanes, and accepts or rejects each.
    fn step<O: Observer<S::Row>>(&mut self, system: &mut S, observers: &mut [O]) {
        let (t, h) = (self.gathered(|lane| lane.t), self.gathered(|lane| lane.plan.h));
        let (mut rhs_evaluations, mut factorisations) = (0, 0);
        let trial = Trial {
            t,
            h,
            y: &self.y,
            y_new: &mut self.y_new,
            rates: &mut self.rates,
            rhs_evaluations: &mut rhs_evaluations,
            factorisations: &mut factorisations,
        };
        let tried = self.stepper.attempt(system, trial);
        for (at, lane) in self.lanes.iter_mut().enumerate().filter(|(_, lane)| lane.is_running()) {
            lane.counters.rhs_evaluations += rhs_evaluations;
            lane.counters.factorisations += factorisations;
            lane.accepted = None;
            match &tried {
                Ok(error) => lane.error = error.lane(at),
                Err(words) => lane.work = Work::Ended(Stopped::Diverged(words.clone())),
            }
        }
        if self.lanes.iter().any(Lane::is_good) {
            self.end_steps(system, observers, (t, h));
        }
        for at in 0..R::LANES {
            if !self.lanes[at].is_running() {
                continue;
            }
            if self.lanes[at].accepted.is_some() {
                self.accepted(system, observers, at);
            } else {
                self.lanes[at].counters.rejected_steps += 1;
                self.stepper.rejected(at, self.lanes[at].plan.h, self.lanes[at].error);
            }
        }
    }

    /// Ends the good steps, each at its first event, shows them to rows and observers and moves the states.
    fn end_steps<O: Observer<S::Row>>(&mut self, system: &mut S, observers: &mut [O], (t, h): (R, R)) {
        let n = self.y.len();
        let good = self.mask(Lane::is_good);
        let last = P::DENSE.last() * n..(P::DENSE.last() + 1) * n;
        let t1 = self.gathered(|lane| lane.t + lane.plan.h);
        system.sample_guards(t1, &self.y_new, &self.rates[last.clone()], &mut self.samples_new);
        self.cut(system, h, good);
        let theta = self.gathered(|lane| lane.accepted.unwrap_or(0.0));
        system.stepped(&Taken { accepted: good, t, h, theta, rates: &self.rates, dense: P::DENSE });
        for (at, lane) in self.lanes.iter().enumerate().filter(|(at, _)| good.lane(*at)) {
            let Some(theta) = lane.accepted.filter(|theta| *theta > 0.0) else { continue };
            let of = Ingredients { ends: [&self.y, &self.y_new], rates: &self.rates, dense: P::DENSE };
            let mut step = Step::new(&of, at, (lane.t, lane.plan.h));
            step.theta_end = theta;
            observers[at].step(system.row(at), &step);
        }
        // The rate at the end is the first of the next step; after an event it will be computed again.
        if self.lanes.iter().all(|lane| !lane.is_running() || lane.accepted.is_some()) {
            std::mem::swap(&mut self.y, &mut self.y_new);
            self.rates.copy_within(last, 0);
            std::mem::swap(&mut self.samples, &mut self.samples_new);
        } else {
            blend(good, &self.y_new, &mut self.y);
            let (first, others) = self.rates.split_at_mut(n);
            blend(good, &others[last.start - n..last.end - n], first);
            blend_samples(good, &self.samples_new, &mut self.samples);
        }
    }

    /// Finds the first event within each good step, of length `h`, and cuts the step there.
    fn cut(&mut self, system: &S, h: R, good: R::Mask) {
        let ends = Ends { h, start: &self.samples, end: &self.samples_new };
        let suspects = suspects(&ends);
        for (at, lane) in self.lanes.iter_mut().enumerate().filter(|(at, _)| good.lane(*at)) {
            lane.hits.clear();
            let mut theta = 1.0;
            if suspects.lane(at) {
                if self.stepper.locates() {
                    let of = Ingredients { ends: [&self.y, &self.y_new], rates: &self.rates, dense: P::DENSE };
                    let step = Step::new(&of, at, (lane.t, lane.plan.h));
                    let place = SwitchedLane { ends: &ends, lane: at, fresh: &lane.fresh };
                    let memory = Memory { hits: &mut lane.hits, y: &mut self.state };
                    theta = first_events(system.row(at), &step, &place, memory);
                    if theta < 1.0 {
                        step.state(theta, &mut self.state);
                        write(&self.state, at, &mut self.y_new);
                    }
                } else {
                    // Events within the step are detected at its end.
                    let hits = self.samples_new.iter().enumerate().filter(|(_, end)| end.value.lane(at) > 0.0);
                    lane.hits.extend(hits.map(|(guard, _)| guard));
                }
            }
            lane.accepted = Some(theta);
        }
    }

    /// Takes note of a lane's accepted step, and switches its row at every guard hit, all at the present time and state.
    fn accepted<O: Observer<S::Row>>(&mut self, system: &mut S, observers: &mut [O], at: usize) {
        let lane = &mut self.lanes[at];
        let Some(theta) = lane.accepted else { return };
        lane.counters.steps += 1;
        let (begin, h) = (lane.t, lane.plan.h);
        lane.t = lane.plan.end.filter(|_| theta == 1.0).unwrap_or(begin + theta * h);
        lane.rate_known = theta == 1.0;
        self.stepper.accepted(at, h, lane.error);
        // A switch at the very start of a step happens together with the one before.
        if theta > 0.0 {
            lane.fresh.fill(false);
        }
        if lane.hits.is_empty() {
            return;
        }
        // A switch that the right-hand side already followed is recorded at the beginning of the step.
        let (t, y) = if self.following { (begin, &mut self.y_new) } else { (lane.t, &mut self.y) };
        read(y, at, &mut self.state);
        for &guard in &lane.hits {
            system.row_mut(at).switch(guard, t, &mut self.state);
            observers[at].event(system.row(at), guard, t, &self.state);
            lane.fresh[guard] = true;
            self.stepper.switched(at, guard);
            lane.counters.located_events += 1;
        }
        write(&self.state, at, y);
        (lane.rate_known, lane.next_stop) = (false, None);
        system.switched(at);
    }
}

/// Reads one lane.
fn read<R: Number>(all: &[R], lane: usize, one: &mut [f64]) {
    let all: &[f64] = bytemuck::cast_slice(all);
    for (one, lanes) in one.iter_mut().zip(all.chunks_exact(R::LANES)) {
        *one = lanes[lane];
    }
}

/// Writes one lane.
fn write<R: Number>(one: &[f64], lane: usize, all: &mut [R]) {
    let all: &mut [f64] = bytemuck::cast_slice_mut(all);
    for (lanes, one) in all.chunks_exact_mut(R::LANES).zip(one) {
        lanes[lane] = *one;
    }
}
