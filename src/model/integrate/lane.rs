//! The driver's data of one lane: time, budgets, current step.

use crate::integrate::counters::Counters;
use crate::integrate::stepper::{Settings, StepPlan};

/// Reason why an integration ended.
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

/// Whether a lane has a row.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Work {
    /// No row.
    Idle,
    /// A row on its way.
    Running,
    /// A row that has ended and is still there.
    Ended(Stopped),
}

/// One lane of an integration.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    pub work: Work,
    pub t: f64,
    pub t_end: f64,
    /// Time that the present step must not pass.
    pub stop: f64,
    /// Time up to which the row's part outside the state holds, see [`crate::integrate::Rebasing::horizon`].
    pub horizon: f64,
    /// The present step.
    pub plan: StepPlan,
    /// Error, and the accepted fraction of the step; `None` if it is rejected.
    pub error: f64,
    pub accepted: Option<f64>,
    /// Whether the first rate is that at `(t, y)`, and the first samples are the guards there.
    pub rate_known: bool,
    /// Time of the next scheduled stop; `None` if the row has changed since it was asked.
    pub next_stop: Option<f64>,
    /// Guards that switched at the start of the present step.
    pub fresh: Vec<bool>,
    /// Guards that end the present step.
    pub hits: Vec<usize>,
    pub counters: Counters,
    max_steps: u64,
    max_wall_time_s: f64,
    /// Share of the wall time, s.
    pub wall_time_s: f64,
}

impl Lane {
    pub fn idle(guards: usize) -> Self {
        Self {
            work: Work::Idle,
            t: 0.0,
            t_end: 0.0,
            stop: 0.0,
            horizon: 0.0,
            plan: StepPlan { h: 0.0, end: None },
            error: f64::NAN,
            accepted: None,
            rate_known: false,
            next_stop: None,
            fresh: vec![false; guards],
            hits: Vec::with_capacity(guards),
            counters: Counters::default(),
            max_steps: 0,
            max_wall_time_s: 0.0,
            wall_time_s: 0.0,
        }
    }

    /// Begins anew at `t0`.
    pub fn load(&mut self, t0: f64, t_end: f64, settings: &Settings) {
        (self.t, self.t_end) = (t0, t_end);
        (self.max_steps, self.max_wall_time_s) = (settings.max_steps, settings.max_wall_time_s);
        self.work = Work::Running;
        (self.rate_known, self.next_stop) = (false, None);
        self.fresh.fill(false);
        self.counters = Counters::default();
        self.wall_time_s = 0.0;
    }

    pub fn is_running(&self) -> bool {
        self.work == Work::Running
    }

    /// Whether the step just tried may be accepted.
    pub fn is_good(&self) -> bool {
        self.is_running() && self.error <= 1.0
    }

    /// Exhausted budget.
    pub fn spent(&self) -> Option<Stopped> {
        if self.counters.steps + self.counters.rejected_steps >= self.max_steps {
            return Some(Stopped::StepBudget);
        }
        (self.wall_time_s > self.max_wall_time_s).then_some(Stopped::TimeBudget)
    }
}
