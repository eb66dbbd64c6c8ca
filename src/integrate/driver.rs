//! The step loop: error control, event location, scheduled stops, budgets.

use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};

use crate::integrate::counters::Counters;
use crate::integrate::exponential_control::ExponentialControl;
use crate::integrate::locate::{Ends, first_events};
use crate::integrate::step::Dense;
use crate::integrate::tsit5::{A, C, CONTROL_ORDER, ERROR, STAGES};
use crate::integrate::{GuardSample, Observer, Step, System};

/// Steps between two looks at the clock.
const CLOCK_INTERVAL: u64 = 256;
/// Safety factor of step size control.
const SAFETY: f64 = 0.9;
/// Bounds of the change of the step size from one step to the next.
const CHANGE: (f64, f64) = (0.2, 5.0);
/// Exponents of proportional-integral step size control, before division by the order.
const PROPORTIONAL_INTEGRAL: (f64, f64) = (0.7, 0.4);
/// Logarithm of the least error that the control remembers, 1e-4.
const LEAST_ERROR_LOG: f64 = -9.210_340_371_976_182;

/// Accuracy and effort of an integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest error of a step in any controlled component, in units of its scale.
    pub tolerance: f64,
    /// First step in s.
    pub first_step_s: f64,
    /// Longest step in s.
    pub longest_step_s: f64,
    /// Accepted and rejected steps after which the integration stops.
    pub max_steps: u64,
    /// Wall time in s after which the integration stops.
    pub max_wall_time_s: f64,
}

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

/// Working memory of one integration: nothing is allocated once it exists.
#[derive(Debug)]
pub struct Integrator {
    settings: Settings,
    n: usize,
    controlled: usize,
    t: f64,
    h: f64,
    y: Vec<f64>,
    y_new: Vec<f64>,
    scratch: Vec<f64>,
    stages: Vec<f64>,
    /// Whether the first stage holds the rate at `(t, y)`, and the first samples are the guards there.
    rate_known: bool,
    /// Logarithm of the last accepted step's error.
    last_error_log: f64,
    /// Guards that switched at the start of the present step.
    fresh: Vec<bool>,
    /// First accepted step after the last switch of each guard, for either parity of its switches.
    step_after: Vec<[f64; 2]>,
    parity: Vec<bool>,
    /// The guard whose following step is to be remembered.
    learning: Option<usize>,
    /// Guards that end the present step.
    hits: Vec<usize>,
    /// Guards at the start of the step, known with the rate there, and at its end.
    samples: Vec<GuardSample>,
    samples_new: Vec<GuardSample>,
    inverse_scales: Vec<f64>,
    /// Exponential steps, if the system knows a linear part.
    exponential: Option<ExponentialControl>,
    counters: Counters,
}

impl Integrator {
    /// Prepares an integration of `system` from `(t0, y0)`.
    pub fn new<S: System>(system: &S, t0: f64, y0: &[f64], settings: Settings) -> Self {
        let (n, guards) = (system.dimension(), system.guard_count());
        Self {
            settings,
            n,
            controlled: system.controlled(),
            t: t0,
            h: settings.first_step_s,
            y: y0.to_vec(),
            y_new: y0.to_vec(),
            scratch: y0.to_vec(),
            stages: vec![0.0; STAGES * n],
            rate_known: false,
            last_error_log: 0.0,
            fresh: vec![false; guards],
            step_after: vec![[f64::INFINITY; 2]; guards],
            parity: vec![false; guards],
            learning: None,
            hits: Vec::with_capacity(guards),
            samples: vec![GuardSample::default(); guards],
            samples_new: vec![GuardSample::default(); guards],
            inverse_scales: system.scales().iter().map(|scale| 1.0 / scale).collect(),
            exponential: ExponentialControl::new(system),
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
        while self.t < t_end {
            let tried = self.counters.steps + self.counters.rejected_steps;
            if let Some(stopped) = spent(tried, begin, (self.settings.max_steps, self.settings.max_wall_time_s)) {
                return stopped;
            }
            let stop = self.pass_stops(system).min(t_end);
            let remaining = stop - self.t;
            if remaining <= 4.0 * f64::EPSILON * stop.abs() {
                // An event fell on the stop to within rounding.
                self.t = stop;
                continue;
            }
            if let Some(trial) = self.exponential_trial(system, remaining) {
                self.conclude(system, observer, trial);
                continue;
            }
            let mut planned = self.h.min(self.settings.longest_step_s);
            if self.t + planned > system.horizon() {
                self.rebase(system);
                planned = planned.min(system.horizon() - self.t);
            }
            let stop = (planned >= remaining).then_some(stop);
            let h = planned.min(remaining);
            // Too short to move the clock: the steps before have shrunk to nothing.
            if self.t + 0.5 * h <= self.t {
                return Stopped::Diverged(system.diagnose(self.t, &self.y));
            }
            let error = self.try_step(system, h);
            self.conclude(system, observer, Trial { h, stop, error, exponential: false });
        }
        Stopped::AtEnd
    }

    /// Accepts or rejects a step that was computed.
    fn conclude<S: System, O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, trial: Trial) {
        if trial.error <= 1.0 {
            self.accept(system, observer, trial);
        } else {
            self.reject(&trial);
        }
    }

    /// Computes an exponential step within `remaining`, if one is to be made.
    fn exponential_trial<S: System>(&mut self, system: &mut S, remaining: f64) -> Option<Trial> {
        let exponential = self.exponential.as_mut().filter(|exponential| !exponential.waits())?;
        let limit = remaining.min(self.settings.longest_step_s);
        let (_, h) = exponential.plan(system, self.h, limit)?;
        if self.t + h > system.horizon() {
            self.rebase(system);
        }
        self.know_rate(system);
        let exponential = self.exponential.as_mut()?;
        let (rung, h) = exponential.plan(system, self.h, limit.min(system.horizon() - self.t))?;
        exponential.method.begin(system, rung, (self.t, &self.y, &self.stages[..self.n]));
        exponential.trying = true;
        let others = self.try_step(system, h);
        let exponential = self.exponential.as_mut()?;
        exponential.trying = false;
        let error = exponential.whole_error(others, self.settings.tolerance);
        Some(Trial { h, stop: None, error, exponential: true })
    }

    /// Rebases what the system carries outside the state, if it does.
    fn rebase<S: System>(&mut self, system: &mut S) {
        if system.horizon() == f64::INFINITY {
            return;
        }
        self.know_rate(system);
        system.rebase(self.t, &mut self.y, &mut self.stages[..self.n]);
    }

    /// Makes sure that rate and guards at the present state are known.
    fn know_rate<S: System>(&mut self, system: &mut S) {
        if !self.rate_known {
            let rate = &mut self.stages[..self.n];
            system.rhs(self.t, &self.y, rate);
            system.sample_guards(self.t, (&self.y, rate), &mut self.samples);
            self.rate_known = true;
            self.counters.rhs_evaluations += 1;
        }
    }

    /// Passes the scheduled stops that are due; returns the time of the next one.
    fn pass_stops<S: System>(&mut self, system: &mut S) -> f64 {
        while system.next_stop() <= self.t {
            system.pass_stop();
            self.rate_known = false;
        }
        system.next_stop()
    }

    /// Computes the stages of a step of length `h`; returns its error in units of the tolerance.
    fn try_step<S: System>(&mut self, system: &mut S, h: f64) -> f64 {
        let n = self.n;
        self.know_rate(system);
        self.stage::<S, 1>(system, h);
        self.stage::<S, 2>(system, h);
        self.stage::<S, 3>(system, h);
        self.stage::<S, 4>(system, h);
        self.stage::<S, 5>(system, h);
        let (done, last) = self.stages.split_at_mut((STAGES - 1) * n);
        let (y, out) = (&self.y, &mut self.y_new[..]);
        Arch::new().dispatch(Combination::<{ STAGES - 1 }> { weights: &A[STAGES - 1], h, y, stages: done, out });
        let mut inverse_scales = &self.inverse_scales;
        match self.exponential.as_mut().filter(|exponential| exponential.trying) {
            None => system.rhs(self.t + h, &self.y_new, last),
            Some(exponential) => {
                exponential.method.correct(STAGES - 1, (&self.y, done), &mut self.y_new);
                system.rhs(self.t + h, &self.y_new, last);
                exponential.method.observe(STAGES - 1, (&self.y, &self.y_new), (&done[..n], last));
                exponential.error = exponential.method.error(inverse_scales, &mut exponential.masked);
                inverse_scales = &exponential.masked;
            }
        }
        self.counters.rhs_evaluations += (STAGES - 1) as u64;
        let norm = ErrorNorm { inverse_scales, h, stages: &self.stages, n };
        Arch::new().dispatch(norm) / self.settings.tolerance
    }

    /// Computes stage `K` (counted from 0).
    fn stage<S: System, const K: usize>(&mut self, system: &mut S, h: f64) {
        let n = self.n;
        let (done, rest) = self.stages.split_at_mut(K * n);
        // Quadratures feed no right-hand side: their stage values are not needed.
        let c = self.controlled;
        let (y, out) = (&self.y, &mut self.scratch[..c]);
        Arch::new().dispatch(Combination::<K> { weights: &A[K], h, y, stages: done, out });
        let (t, rate) = (self.t + C[K] * h, &mut rest[..n]);
        match self.exponential.as_mut().filter(|exponential| exponential.trying) {
            None => system.rhs(t, &self.scratch, rate),
            Some(exponential) => {
                exponential.method.correct(K, (&self.y, done), &mut self.scratch);
                system.rhs(t, &self.scratch, rate);
                exponential.method.observe(K, (&self.y, &self.scratch), (&done[..n], rate));
            }
        }
    }

    /// Ends the step at its first event, shows it to the observer, switches the system, chooses the next step.
    fn accept<S: System, O: Observer<S>>(&mut self, system: &mut S, observer: &mut O, trial: Trial) {
        let mut step = Step {
            t0: self.t,
            h: trial.h,
            theta_end: 1.0,
            dense: Dense::Tsit5,
            y0: &self.y,
            y1: &self.y_new,
            stages: &self.stages,
        };
        let n = self.n;
        let rate_new = &self.stages[(STAGES - 1) * n..];
        system.sample_guards(self.t + trial.h, (&self.y_new, rate_new), &mut self.samples_new);
        let ends = Ends { start: &self.samples, end: &self.samples_new, fresh: &self.fresh };
        let theta = first_events(system, &step, &ends, (&mut self.hits, &mut self.scratch));
        if let (true, false, Some(exponential)) = (trial.exponential, self.hits.is_empty(), &mut self.exponential) {
            // Events end explicit steps, whose dense output follows what rings.
            self.counters.rejected_steps += 1;
            exponential.leave();
            return;
        }
        self.counters.steps += 1;
        if theta < 1.0 {
            step.state(theta, &mut self.scratch);
            step.theta_end = theta;
            step.y1 = &self.scratch;
        }
        if theta > 0.0 {
            observer.step(system, &step);
        }
        self.t = match trial.stop {
            Some(stop) if theta == 1.0 => stop,
            _ => step.t1(),
        };
        if theta < 1.0 {
            self.y.copy_from_slice(&self.scratch);
        } else {
            std::mem::swap(&mut self.y, &mut self.y_new);
            // The last stage is the first of the next step.
            self.stages.copy_within((STAGES - 1) * n.., 0);
            std::mem::swap(&mut self.samples, &mut self.samples_new);
        }
        self.rate_known = theta == 1.0;
        self.adapt(&trial);
        if let Some(exponential) = &mut self.exponential {
            exponential.watch(theta < 1.0, &self.samples, self.h);
        }
        // A switch at the very start of a step happens together with the one before.
        if theta > 0.0 {
            self.fresh.fill(false);
        }
        self.switch_hits(system, observer);
    }

    /// Switches the system at every guard hit, all at the present time and state.
    fn switch_hits<S: System, O: Observer<S>>(&mut self, system: &mut S, observer: &mut O) {
        for &guard in &self.hits {
            system.switch(guard, self.t, &mut self.y);
            observer.event(system, guard, self.t, &self.y);
            self.fresh[guard] = true;
            self.parity[guard] = !self.parity[guard];
            let remembered = self.step_after[guard][usize::from(self.parity[guard])];
            self.h = self.h.min(remembered);
            self.learning = Some(guard);
            self.rate_known = false;
            self.counters.located_events += 1;
        }
    }

    /// Chooses the next step after one that was accepted.
    fn adapt(&mut self, trial: &Trial) {
        let error = trial.error.max(1e-10);
        if let (true, Some(exponential)) = (trial.exponential, &mut self.exponential) {
            exponential.adapt(trial.h * (SAFETY * error.powf(-1.0 / CONTROL_ORDER)).clamp(CHANGE.0, CHANGE.1));
            return;
        }
        if let Some(guard) = self.learning.take() {
            let ideal = trial.h * (SAFETY * error.powf(-1.0 / CONTROL_ORDER)).min(CHANGE.1);
            self.step_after[guard][usize::from(self.parity[guard])] = ideal;
        }
        let (proportional, integral) = PROPORTIONAL_INTEGRAL;
        let log = error.ln();
        let change = SAFETY * ((integral * self.last_error_log - proportional * log) / CONTROL_ORDER).exp();
        let next = trial.h * change.clamp(CHANGE.0, CHANGE.1);
        // A step that a scheduled stop cut short says nothing against the step planned before.
        self.h = if trial.h < self.h { next.max(self.h) } else { next };
        self.last_error_log = log.max(LEAST_ERROR_LOG);
    }

    /// Shortens the step after one that was rejected.
    fn reject(&mut self, trial: &Trial) {
        self.counters.rejected_steps += 1;
        let change = if trial.error.is_finite() {
            (SAFETY * trial.error.powf(-1.0 / CONTROL_ORDER)).clamp(CHANGE.0, 1.0)
        } else {
            CHANGE.0
        };
        match &mut self.exponential {
            Some(exponential) if trial.exponential => exponential.adapt(trial.h * change),
            _ => self.h = trial.h * change,
        }
    }
}

/// Which budget, of steps or of wall time in s, is used up after `tried` steps; the clock is looked at now and then.
pub(super) fn spent(tried: u64, begin: Instant, (max_steps, max_wall_time_s): (u64, f64)) -> Option<Stopped> {
    if tried >= max_steps {
        return Some(Stopped::StepBudget);
    }
    let look = tried % CLOCK_INTERVAL == CLOCK_INTERVAL - 1;
    (look && begin.elapsed().as_secs_f64() > max_wall_time_s).then_some(Stopped::TimeBudget)
}

/// A step that was computed.
struct Trial {
    h: f64,
    /// The stop that it ends at, if it reaches one.
    stop: Option<f64>,
    /// Error in units of the tolerance.
    error: f64,
    /// Whether it is an exponential one.
    exponential: bool,
}

/// `out = y + h sum_j weights[j] k_j` over the leading `out.len()` components; stage `j` starts at `j * n`.
struct Combination<'c, const K: usize> {
    weights: &'c [f64],
    h: f64,
    y: &'c [f64],
    stages: &'c [f64],
    out: &'c mut [f64],
}

impl<const K: usize> WithSimd for Combination<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { weights, h, y, stages, out } = self;
        let n = stages.len() / K;
        let len = out.len();
        let w: [f64; K] = std::array::from_fn(|j| h * weights[j]);
        let k: [&[f64]; K] = std::array::from_fn(|j| &stages[j * n..j * n + len]);
        let y = &y[..len];
        for i in 0..len {
            let mut sum = y[i];
            for j in 0..K {
                sum += w[j] * k[j][i];
            }
            out[i] = sum;
        }
    }
}

/// Components treated together: independent chains that the compiler can put into vector registers.
const LANES: usize = 4;

/// Largest error estimate over the controlled components, each in units of its scale; NaN if any is not finite.
struct ErrorNorm<'e> {
    inverse_scales: &'e [f64],
    h: f64,
    stages: &'e [f64],
    /// Length of a stage.
    n: usize,
}

impl WithSimd for ErrorNorm<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { inverse_scales, h, stages, n } = self;
        let len = inverse_scales.len();
        let k: [&[f64]; STAGES] = std::array::from_fn(|j| &stages[j * n..j * n + len]);
        let (scale_blocks, scales_left) = inverse_scales.as_chunks::<LANES>();
        let k_blocks = k.map(|k| k.as_chunks::<LANES>().0);
        // A NaN must survive: a maximum alone would drop it, a sum keeps it.
        let (mut largest, mut sum) = ([0.0_f64; LANES], [0.0_f64; LANES]);
        for (block, scales) in scale_blocks.iter().enumerate() {
            let mut estimate = [0.0; LANES];
            for (k, weight) in k_blocks.iter().zip(ERROR) {
                let k = &k[block];
                for lane in 0..LANES {
                    estimate[lane] += weight * k[lane];
                }
            }
            for lane in 0..LANES {
                let value = (h * estimate[lane] * scales[lane]).abs();
                largest[lane] = if value > largest[lane] { value } else { largest[lane] };
                sum[lane] += value;
            }
        }
        let done = len - scales_left.len();
        for (i, scale) in scales_left.iter().enumerate() {
            let estimate: f64 = k.iter().zip(ERROR).map(|(k, weight)| weight * k[done + i]).sum();
            let value = (h * estimate * scale).abs();
            largest[0] = largest[0].max(value);
            sum[0] += value;
        }
        if sum.iter().sum::<f64>().is_finite() { largest.into_iter().fold(0.0, f64::max) } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The norm is the largest scaled estimate wherever it stands, in whole blocks and after them, and anything not finite in
    /// any stage of any controlled component survives.
    #[test]
    fn error_norm_keeps_what_is_not_finite() {
        const CONTROLLED: usize = 2 * LANES + 2;
        let n = CONTROLLED + 1;
        let inverse_scales: Vec<f64> = (1..=CONTROLLED).map(|i| 1.0 / i as f64).collect();
        let norm =
            |stages: &[f64]| Arch::new().dispatch(ErrorNorm { inverse_scales: &inverse_scales, h: 0.1, stages, n });
        let mut stages = vec![0.0; STAGES * n];
        let last = (STAGES - 1) * n;
        stages[last..].fill(6.6);
        // The last component is a quadrature: not controlled.
        stages[last + CONTROLLED] = 1e9;
        for (i, scale) in inverse_scales.iter().enumerate() {
            let mut one = stages.clone();
            one[last + i] = -6600.0;
            assert!((norm(&one) - 10.0 * scale).abs() < 1e-13, "component {i}: {}", norm(&one));
            for (bad, stage) in
                [f64::NAN, f64::INFINITY].into_iter().flat_map(|bad| (0..STAGES).map(move |stage| (bad, stage)))
            {
                let mut spoilt = stages.clone();
                spoilt[stage * n + i] = bad;
                assert!(norm(&spoilt).is_nan(), "{bad} in stage {stage} of component {i}");
            }
        }
    }
}
