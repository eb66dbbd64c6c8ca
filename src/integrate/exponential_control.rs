//! The exponential step controller: such steps are made while contacts rest and nothing but stability bounds an explicit step.

use crate::integrate::exponential::Exponential;
use crate::integrate::{GuardSample, System};

/// Calm explicit steps in a row before an exponential one: each sees a ringing contact at another phase.
const WAIT: u32 = 3;
/// The same after exponential steps did not pay.
const PAUSE: u32 = 20;
/// `h lambda` of an explicit step from which on stability may be what bounds it.
const ENTER: f64 = 1.8;
/// Length of the first exponential step, in explicit ones.
const GROW: f64 = 2.2;
/// Explicit steps that an exponential one must be worth.
const GAIN: f64 = 1.2;
/// Explicit steps within which no guard may reach zero at its present rate: a contact that rings that much may open.
const CALM: f64 = 1.5;
/// Exponential steps are held to this share of the tolerance. They resolve what explicit ones, short for stability's sake,
/// follow far below the tolerance; on the paper's rig a share of 1 errs up to ten times more in the periodic energy for
/// a tenth fewer right-hand sides.
const SHARE: f64 = 1.0 / 30.0;

/// Exponential steps of an integration, and whether they are made.
#[derive(Debug)]
pub(super) struct ExponentialControl {
    pub method: Exponential,
    /// Whether the step being tried is one.
    pub trying: bool,
    /// Error of the step tried last in the components that the method corrects, in units of their scales.
    pub error: f64,
    /// Inverse scales of the other components.
    pub masked: Vec<f64>,
    /// Calm steps to wait for.
    wait: u32,
    /// Length of the next exponential step; `None` while explicit steps are made.
    h: Option<f64>,
}

impl ExponentialControl {
    /// For a system that knows a linear part.
    pub fn new<S: System>(system: &S) -> Option<Self> {
        let block = system.stiff_block()?;
        Some(Self {
            method: Exponential::new(block),
            trying: false,
            error: 0.0,
            masked: vec![0.0; system.controlled()],
            wait: WAIT,
            h: None,
        })
    }

    /// Whether an exponential step may be next, by what was seen of the guards.
    pub fn waits(&self) -> bool {
        self.wait > 0
    }

    /// Rung and length of the exponential step to be made now, at most `limit` long; `explicit_h` is the explicit step.
    pub fn plan<S: System>(&mut self, system: &mut S, explicit_h: f64, limit: f64) -> Option<(usize, f64)> {
        let linear = self.method.select(system);
        let planned = match self.h {
            Some(h) => h,
            None if explicit_h * linear.fastest_rad_s > ENTER => GROW * explicit_h,
            None => return None,
        };
        let rung = linear.rung(planned.min(limit));
        let plan = rung.map(|rung| (rung, linear.step_s(rung))).filter(|(_, h)| *h > GAIN * explicit_h);
        if plan.is_none() {
            (self.wait, self.h) = (PAUSE, None);
        }
        plan
    }

    /// Error of a step in units of the tolerance; `others` is that of the components that are not corrected.
    pub fn whole_error(&self, others: f64, tolerance: f64) -> f64 {
        let error = self.error / (SHARE * tolerance);
        // A NaN must survive.
        if others.is_nan() { others } else { error.max(others / SHARE) }
    }

    /// Takes note of an accepted step: whether it was cut by an event, and the guards at its end.
    pub fn watch(&mut self, cut: bool, guards: &[GuardSample], explicit_h: f64) {
        let reach = CALM * explicit_h;
        if !cut && guards.iter().all(|guard| guard.smooth + reach * guard.smooth_rate.abs() < 0.0) {
            self.wait = self.wait.saturating_sub(1);
        } else {
            self.leave();
        }
    }

    /// Back to explicit steps.
    pub fn leave(&mut self) {
        (self.wait, self.h) = (self.wait.max(WAIT), None);
    }

    /// Sets the length of the next exponential step.
    pub fn adapt(&mut self, h: f64) {
        self.h = Some(h);
    }
}
