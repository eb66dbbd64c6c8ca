//! The explicit pair as a stepper: stages, error norm, step size control.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::integrate::step::Dense;
use crate::integrate::stepper::{Settings, StepPlan, Stepper, Trial};
use crate::integrate::system::{InLanes, Switching, System};
use crate::integrate::tsit5::{A, C, CONTROL_ORDER, ERROR, STAGES};
use decore_math::number::{Number, exp, ln};

/// Safety factor of step size control.
const SAFETY: f64 = 0.9;
/// Bounds of the change of the step size from one step to the next.
const CHANGE: (f64, f64) = (0.2, 5.0);
/// Exponents of proportional-integral step size control, before division by the order.
const PROPORTIONAL_INTEGRAL: (f64, f64) = (0.7, 0.4);
/// Least error that step size control reckons with.
const LEAST_ERROR: f64 = 1e-10;
/// Logarithm of the least error that the control remembers, 1e-4.
const LEAST_ERROR_LOG: f64 = -9.210_340_371_976_182;

/// The explicit pair of order 5(4) under error control.
#[derive(Debug)]
pub struct Tsit5<R = f64> {
    tolerance: R,
    inverse_scales: Vec<R>,
    without_scale: Range<usize>,
    /// State of the present stage.
    stage: Vec<R>,
    /// Logarithm of each lane's last accepted error, and that of the present step's.
    last_error_log: R,
    error_log: R,
    /// Change of the step that proportional-integral control asks for after the present step.
    change: R,
    controls: Vec<Control>,
}

/// Step size control of a lane.
#[derive(Debug, Clone)]
struct Control {
    longest_step_s: f64,
    /// Length of the next step, s.
    h: f64,
    /// First accepted step after the last switch of each guard, for either parity of its switches.
    step_after: Vec<[f64; 2]>,
    parity: Vec<bool>,
    /// Guard whose following step is to be stored.
    learning: Option<usize>,
}

impl<R: Number> Tsit5<R> {
    /// Computes the stages and the end of a step.
    fn stages<S: InLanes<R>>(&mut self, system: &mut S, trial: &mut Trial<'_, R>) {
        let times = R::dispatch(Times { t: trial.t, h: trial.h });
        self.stage::<S, 1>(system, trial, times[1]);
        self.stage::<S, 2>(system, trial, times[2]);
        self.stage::<S, 3>(system, trial, times[3]);
        self.stage::<S, 4>(system, trial, times[4]);
        self.stage::<S, 5>(system, trial, times[5]);
        const END: usize = STAGES - 1;
        let n = trial.y.len();
        let (done, rate) = trial.rates.split_at_mut(END * n);
        let out = &mut *trial.y_new;
        R::dispatch(Combination::<R, END> { weights: &A[END], h: trial.h, y: trial.y, rates: done, out });
        system.rhs(times[END], out, rate);
        *trial.rhs_evaluations += END as u64;
    }

    /// Computes stage `K` (counted from 0), which is at time `t`.
    fn stage<S: InLanes<R>, const K: usize>(&mut self, system: &mut S, trial: &mut Trial<'_, R>, t: R) {
        let n = trial.y.len();
        let (done, rest) = trial.rates.split_at_mut(K * n);
        // Quadratures feed no right-hand side: their stage values are not needed.
        let out = &mut self.stage[..self.inverse_scales.len()];
        R::dispatch(Combination::<R, K> { weights: &A[K], h: trial.h, y: trial.y, rates: done, out });
        system.rhs(t, &self.stage, &mut rest[..n]);
    }
}

/// Change of the step that would bring its error, given by its logarithm, to the tolerance, with a reserve.
fn ideal_change(error_log: f64) -> f64 {
    SAFETY * exp(error_log * (-1.0 / CONTROL_ORDER))
}

impl Control {
    fn new(guards: usize) -> Self {
        Self {
            longest_step_s: 0.0,
            h: 0.0,
            step_after: vec![[f64::INFINITY; 2]; guards],
            parity: vec![false; guards],
            learning: None,
        }
    }

    fn load(&mut self, settings: &Settings) {
        (self.longest_step_s, self.h) = (settings.longest_step_s, settings.first_step_s);
        self.learning = None;
        self.step_after.fill([f64::INFINITY; 2]);
        self.parity.fill(false);
    }

    fn accepted(&mut self, h: f64, error_log: f64, change: f64) {
        if let Some(guard) = self.learning.take() {
            let ideal = h * ideal_change(error_log).min(CHANGE.1);
            self.step_after[guard][usize::from(self.parity[guard])] = ideal;
        }
        let next = h * change.clamp(CHANGE.0, CHANGE.1);
        // A step shortened by a scheduled stop is no evidence against the planned step.
        self.h = if h < self.h { next.max(self.h) } else { next };
    }

    fn rejected(&mut self, h: f64, error: f64, error_log: f64) {
        let change = if error.is_finite() { ideal_change(error_log).clamp(CHANGE.0, 1.0) } else { CHANGE.0 };
        self.h = h * change;
    }

    fn switched(&mut self, guard: usize) {
        self.parity[guard] = !self.parity[guard];
        self.h = self.h.min(self.step_after[guard][usize::from(self.parity[guard])]);
        self.learning = Some(guard);
    }
}

impl<S: InLanes<R>, R: Number> Stepper<S, R> for Tsit5<R> {
    const DENSE: Dense = Dense::Tsit5;

    fn new(system: &S) -> Self {
        let row = system.row(0);
        Self {
            tolerance: R::splat(1.0),
            inverse_scales: vec![R::splat(0.0); row.controlled()],
            without_scale: row.without_scale(),
            stage: vec![R::splat(0.0); row.dimension()],
            last_error_log: R::splat(0.0),
            error_log: R::splat(0.0),
            change: R::splat(0.0),
            controls: vec![Control::new(row.guard_count()); R::LANES],
        }
    }

    fn load(&mut self, lane: usize, row: &S::Row, settings: &Settings) {
        self.tolerance.put(lane, &settings.tolerance);
        for (inverse, scale) in self.inverse_scales.iter_mut().zip(row.scales()) {
            inverse.put(lane, &(1.0 / scale));
        }
        self.last_error_log.put(lane, &0.0);
        self.controls[lane].load(settings);
    }

    fn plan(&mut self, lane: usize, _t: f64) -> StepPlan {
        let control = &self.controls[lane];
        StepPlan { h: control.h.min(control.longest_step_s), end: None }
    }

    fn attempt(&mut self, system: &mut S, mut trial: Trial<'_, R>) -> Result<R, String> {
        self.stages(system, &mut trial);
        let (inverse_scales, without_scale) = (&self.inverse_scales, &self.without_scale);
        let norm = ErrorNorm { inverse_scales, without_scale, h: trial.h, rates: trial.rates, n: trial.y.len() };
        let judgement = Judgement { norm, tolerance: self.tolerance, last_error_log: self.last_error_log };
        let error;
        (error, self.error_log, self.change) = R::dispatch(judgement);
        Ok(error)
    }

    fn accepted(&mut self, lane: usize, h: f64, _error: f64) {
        let error_log = self.error_log.lane(lane);
        self.controls[lane].accepted(h, error_log, self.change.lane(lane));
        self.last_error_log.put(lane, &error_log.max(LEAST_ERROR_LOG));
    }

    fn rejected(&mut self, lane: usize, h: f64, error: f64) {
        self.controls[lane].rejected(h, error, self.error_log.lane(lane));
    }

    fn switched(&mut self, lane: usize, guard: usize) {
        self.controls[lane].switched(guard);
    }
}

/// Times of the stages of a step.
struct Times<R> {
    t: R,
    h: R,
}

impl<R: Number> WithSimd for Times<R> {
    type Output = [R; STAGES];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [R; STAGES] {
        let mut times = [self.t; STAGES];
        for k in 1..STAGES {
            times[k] = self.t + R::splat(C[k]) * self.h;
        }
        times
    }
}

/// `out = y + h sum_j weights[j] k_j` over the leading `out.len()` components; stage `j` starts at `j * n`.
struct Combination<'c, R, const K: usize> {
    weights: &'c [f64],
    h: R,
    y: &'c [R],
    rates: &'c [R],
    out: &'c mut [R],
}

impl<R: Number, const K: usize> WithSimd for Combination<'_, R, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { weights, h, y, rates, out } = self;
        let n = rates.len() / K;
        let len = out.len();
        let mut w = [h; K];
        for j in 0..K {
            w[j] = h * R::splat(weights[j]);
        }
        let k: [&[R]; K] = std::array::from_fn(|j| &rates[j * n..j * n + len]);
        let y = &y[..len];
        for i in 0..len {
            let mut sum = y[i];
            for j in 0..K {
                sum = w[j].mul_add(k[j][i], sum);
            }
            out[i] = sum;
        }
    }
}

/// Components treated together: independent chains.
const BLOCK: usize = 4;

/// Step under judgement: its error in units of the tolerance, the logarithm of it, and the change of the step size by proportional-integral
/// control.
struct Judgement<'e, R> {
    norm: ErrorNorm<'e, R>,
    tolerance: R,
    last_error_log: R,
}

impl<R: Number> WithSimd for Judgement<'_, R> {
    type Output = (R, R, R);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (R, R, R) {
        let error = self.norm.with_simd(simd) / self.tolerance;
        let log = ln(error.greatest(R::splat(LEAST_ERROR)));
        let (proportional, integral) = PROPORTIONAL_INTEGRAL;
        let exponent =
            R::splat(integral / CONTROL_ORDER) * self.last_error_log - R::splat(proportional / CONTROL_ORDER) * log;
        (error, log, R::splat(SAFETY) * exp(exponent))
    }
}

/// Largest error estimate over the controlled components, each in units of its scale; NaN if any is not finite.
struct ErrorNorm<'e, R> {
    inverse_scales: &'e [R],
    /// Components that are passed over.
    without_scale: &'e Range<usize>,
    h: R,
    rates: &'e [R],
    /// Length of a stage.
    n: usize,
}

impl<R: Number> WithSimd for ErrorNorm<'_, R> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> R {
        let Self { inverse_scales, without_scale, h, rates, n } = self;
        // A NaN must survive: a maximum alone would drop it, a sum keeps it.
        let (mut largest, mut sum) = ([R::splat(0.0); BLOCK], [R::splat(0.0); BLOCK]);
        for part in [0..without_scale.start, without_scale.end..inverse_scales.len()] {
            let k: [&[R]; STAGES] = std::array::from_fn(|j| &rates[j * n..][part.clone()]);
            let (scale_blocks, scales_left) = inverse_scales[part].as_chunks::<BLOCK>();
            let k_blocks = k.map(|k| k.as_chunks::<BLOCK>().0);
            for (block, scales) in scale_blocks.iter().enumerate() {
                let mut estimate = [R::splat(0.0); BLOCK];
                for (k, weight) in k_blocks.iter().zip(ERROR) {
                    let k = &k[block];
                    for i in 0..BLOCK {
                        estimate[i] = R::splat(weight).mul_add(k[i], estimate[i]);
                    }
                }
                for i in 0..BLOCK {
                    let value = (h * estimate[i] * scales[i]).abs();
                    largest[i] = value.greatest(largest[i]);
                    sum[i] += value;
                }
            }
            let done = scale_blocks.len() * BLOCK;
            for (i, scale) in scales_left.iter().enumerate() {
                let mut estimate = R::splat(0.0);
                for (k, weight) in k.iter().zip(ERROR) {
                    estimate = R::splat(weight).mul_add(k[done + i], estimate);
                }
                let value = (h * estimate * *scale).abs();
                largest[0] = value.greatest(largest[0]);
                sum[0] += value;
            }
        }
        let finite = ((sum[0] + sum[1]) + (sum[2] + sum[3])).less(R::splat(f64::INFINITY));
        let largest = largest[0].greatest(largest[1]).greatest(largest[2].greatest(largest[3]));
        R::select(finite, largest, R::splat(f64::NAN))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The norm is the largest scaled estimate wherever it stands, in whole blocks and after them, and anything not finite in
    /// any stage of any controlled component survives.
    #[test]
    fn error_norm_keeps_what_is_not_finite() {
        const CONTROLLED: usize = 2 * BLOCK + 2;
        let n = CONTROLLED + 1;
        let inverse_scales: Vec<f64> = (1..=CONTROLLED).map(|i| 1.0 / i as f64).collect();
        let norm = |rates: &[f64]| {
            f64::dispatch(ErrorNorm { inverse_scales: &inverse_scales, without_scale: &(0..0), h: 0.1, rates, n })
        };
        let mut rates = vec![0.0; STAGES * n];
        let last = (STAGES - 1) * n;
        rates[last..].fill(6.6);
        // The last component is a quadrature: not controlled.
        rates[last + CONTROLLED] = 1e9;
        for (i, scale) in inverse_scales.iter().enumerate() {
            let mut one = rates.clone();
            one[last + i] = -6600.0;
            assert!((norm(&one) - 10.0 * scale).abs() < 1e-13, "component {i}: {}", norm(&one));
            for (bad, stage) in
                [f64::NAN, f64::INFINITY].into_iter().flat_map(|bad| (0..STAGES).map(move |stage| (bad, stage)))
            {
                let mut spoilt = rates.clone();
                spoilt[stage * n + i] = bad;
                assert!(norm(&spoilt).is_nan(), "{bad} in stage {stage} of component {i}");
            }
        }
    }
}
