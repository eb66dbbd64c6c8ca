//! The exponential step controller: such steps are made while contacts rest and nothing but stability bounds an explicit step.

use crate::integrate::explicit::{Tsit5, lengthened, shortened};
use crate::integrate::exponential::Exponential;
use crate::integrate::step::Dense;
use crate::integrate::stepper::{Plan, Settings, Stepper, Trial};
use crate::integrate::system::{GuardSample, LinearPart, StiffBlock, Switching};

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

/// The explicit pair of order 5(4), with exponential steps of the same order where they pay.
#[derive(Debug)]
pub struct ExponentialTsit5 {
    explicit: Tsit5,
    /// `None` for a system without a stiff block.
    control: Option<ExponentialControl>,
}

/// Exponential steps of an integration, and whether they are made.
#[derive(Debug)]
struct ExponentialControl {
    method: Exponential,
    /// Rung of the step that is tried; `None` if it is an explicit one.
    rung: Option<usize>,
    /// Inverse scales of the components that the method does not correct.
    masked: Vec<f64>,
    /// Calm steps to wait for.
    wait: u32,
    /// Length of the next exponential step; `None` while explicit steps are made.
    h: Option<f64>,
}

impl ExponentialControl {
    fn new(block: StiffBlock, controlled: usize) -> Self {
        Self { method: Exponential::new(block), rung: None, masked: vec![0.0; controlled], wait: WAIT, h: None }
    }

    /// Length of the exponential step to be made now, at most `limit` long; `explicit_h` is the explicit step.
    fn plan<S: LinearPart>(&mut self, system: &mut S, explicit_h: f64, limit: f64) -> Option<f64> {
        self.rung = None;
        if self.wait > 0 {
            return None;
        }
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
        self.rung = plan.map(|(rung, _)| rung);
        plan.map(|(_, h)| h)
    }

    /// Takes note of the guards after an accepted step, unless an event cut it.
    fn watch(&mut self, guards: Option<&[GuardSample]>, explicit_h: f64) {
        let reach = CALM * explicit_h;
        let calm = |guard: &GuardSample| guard.smooth + reach * guard.smooth_rate.abs() < 0.0;
        if guards.is_some_and(|guards| guards.iter().all(calm)) {
            self.wait = self.wait.saturating_sub(1);
        } else {
            self.leave();
        }
    }

    /// Back to explicit steps.
    fn leave(&mut self) {
        (self.wait, self.h) = (self.wait.max(WAIT), None);
    }
}

impl<S: Switching + LinearPart> Stepper<S> for ExponentialTsit5 {
    const DENSE: Dense = Dense::Tsit5;

    fn new(system: &S, settings: &Settings) -> Self {
        let control = system.stiff_block().map(|block| ExponentialControl::new(block, system.controlled()));
        Self { explicit: Stepper::<S>::new(system, settings), control }
    }

    fn plan(&mut self, system: &mut S, t: f64, room_s: f64) -> Plan {
        let explicit = &mut self.explicit;
        let limit = room_s.min(explicit.longest_step_s);
        match self.control.as_mut().and_then(|control| control.plan(system, explicit.h, limit)) {
            Some(h) => Plan { h, end: None },
            None => explicit.plan(system, t, room_s),
        }
    }

    fn attempt(&mut self, system: &mut S, mut trial: Trial<'_>) -> Result<f64, String> {
        let explicit = &mut self.explicit;
        let Some((rung, control)) = self.control.as_mut().and_then(|control| Some((control.rung?, control))) else {
            return explicit.attempt(system, trial);
        };
        let method = &mut control.method;
        method.begin(system, rung, &trial);
        explicit.stages(system, &mut trial, method);
        let corrected = method.error(&explicit.inverse_scales, &mut control.masked) / (SHARE * explicit.tolerance);
        let others = explicit.error(&control.masked, &trial);
        // A NaN must survive.
        Ok(if others.is_nan() { others } else { corrected.max(others / SHARE) })
    }

    fn may_be_cut(&mut self) -> bool {
        // Events end explicit steps, whose dense output follows what rings.
        match self.control.as_mut().filter(|control| control.rung.is_some()) {
            Some(control) => {
                control.leave();
                false
            }
            None => true,
        }
    }

    fn accepted(&mut self, h: f64, error: f64, guards: Option<&[GuardSample]>) {
        match self.control.as_mut().filter(|control| control.rung.is_some()) {
            Some(control) => control.h = Some(lengthened(h, error)),
            None => Stepper::<S>::accepted(&mut self.explicit, h, error, guards),
        }
        if let Some(control) = &mut self.control {
            control.watch(guards, self.explicit.h);
        }
    }

    fn rejected(&mut self, h: f64, error: f64) {
        match self.control.as_mut().filter(|control| control.rung.is_some()) {
            Some(control) => control.h = Some(shortened(h, error)),
            None => Stepper::<S>::rejected(&mut self.explicit, h, error),
        }
    }

    fn switched(&mut self, guard: usize) {
        Stepper::<S>::switched(&mut self.explicit, guard);
    }
}
