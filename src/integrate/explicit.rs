//! The explicit pair as a stepper: stages, error norm, step size control.

use pulp::{Arch, Simd, WithSimd};

use crate::integrate::step::Dense;
use crate::integrate::stepper::{Plan, Settings, Stepper, Trial};
use crate::integrate::system::{GuardSample, Switching, System};
use crate::integrate::tsit5::{A, C, CONTROL_ORDER, ERROR, STAGES};

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
pub struct Tsit5 {
    pub(super) tolerance: f64,
    pub(super) longest_step_s: f64,
    pub(super) inverse_scales: Vec<f64>,
    /// Length of the next step, s.
    pub(super) h: f64,
    /// State of the present stage.
    stage: Vec<f64>,
    /// Logarithm of the last accepted step's error.
    last_error_log: f64,
    /// First accepted step after the last switch of each guard, for either parity of its switches.
    step_after: Vec<[f64; 2]>,
    parity: Vec<bool>,
    /// The guard whose following step is to be remembered.
    learning: Option<usize>,
}

/// What another method changes in the explicit stages, which are counted from 0; the last is the end of the step.
pub(super) trait Correction {
    /// Corrects the explicit state `out` of stage `k`; `rates` are those of the stages before.
    fn correct(&mut self, k: usize, y: &[f64], rates: &[f64], out: &mut [f64]);

    /// Takes note of stage `k` with the state `state`; the last of `rates` is its own.
    fn observe(&mut self, k: usize, y: &[f64], state: &[f64], rates: &[f64]);
}

/// Nothing is changed.
impl Correction for () {
    fn correct(&mut self, _k: usize, _y: &[f64], _rates: &[f64], _out: &mut [f64]) {}

    fn observe(&mut self, _k: usize, _y: &[f64], _state: &[f64], _rates: &[f64]) {}
}

impl Tsit5 {
    /// Computes the stages and the end of a step.
    pub(super) fn stages<S: System, K: Correction>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<'_>,
        correction: &mut K,
    ) {
        self.stage::<S, K, 1>(system, trial, correction);
        self.stage::<S, K, 2>(system, trial, correction);
        self.stage::<S, K, 3>(system, trial, correction);
        self.stage::<S, K, 4>(system, trial, correction);
        self.stage::<S, K, 5>(system, trial, correction);
        const END: usize = STAGES - 1;
        let n = trial.y.len();
        let (done, rate) = trial.rates.split_at_mut(END * n);
        let out = &mut *trial.y_new;
        Arch::new().dispatch(Combination::<END> { weights: &A[END], h: trial.h, y: trial.y, rates: done, out });
        correction.correct(END, trial.y, done, out);
        system.rhs(trial.t + trial.h, out, rate);
        correction.observe(END, trial.y, out, trial.rates);
        trial.counters.rhs_evaluations += END as u64;
    }

    /// Computes stage `K` (counted from 0).
    fn stage<S: System, X: Correction, const K: usize>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<'_>,
        correction: &mut X,
    ) {
        let n = trial.y.len();
        let (done, rest) = trial.rates.split_at_mut(K * n);
        // Quadratures feed no right-hand side: their stage values are not needed.
        let out = &mut self.stage[..self.inverse_scales.len()];
        Arch::new().dispatch(Combination::<K> { weights: &A[K], h: trial.h, y: trial.y, rates: done, out });
        correction.correct(K, trial.y, done, &mut self.stage);
        system.rhs(trial.t + C[K] * trial.h, &self.stage, &mut rest[..n]);
        correction.observe(K, trial.y, &self.stage, &trial.rates[..(K + 1) * n]);
    }

    /// Error of a step that was computed, in units of the tolerance.
    pub(super) fn error(&self, inverse_scales: &[f64], trial: &Trial<'_>) -> f64 {
        let norm = ErrorNorm { inverse_scales, h: trial.h, rates: trial.rates, n: trial.y.len() };
        Arch::new().dispatch(norm) / self.tolerance
    }
}

/// Change of the step that would bring its error to the tolerance, with a reserve.
fn ideal_change(error: f64) -> f64 {
    SAFETY * error.max(LEAST_ERROR).powf(-1.0 / CONTROL_ORDER)
}

/// Length after an accepted step of length `h` by its own error alone.
pub(super) fn lengthened(h: f64, error: f64) -> f64 {
    h * ideal_change(error).clamp(CHANGE.0, CHANGE.1)
}

/// Length after a rejected step of length `h`.
pub(super) fn shortened(h: f64, error: f64) -> f64 {
    h * if error.is_finite() { ideal_change(error).clamp(CHANGE.0, 1.0) } else { CHANGE.0 }
}

impl<S: Switching> Stepper<S> for Tsit5 {
    const DENSE: Dense = Dense::Tsit5;

    fn new(system: &S, settings: &Settings) -> Self {
        let guards = system.guard_count();
        Self {
            tolerance: settings.tolerance,
            longest_step_s: settings.longest_step_s,
            inverse_scales: system.scales().iter().map(|scale| 1.0 / scale).collect(),
            h: settings.first_step_s,
            stage: vec![0.0; system.dimension()],
            last_error_log: 0.0,
            step_after: vec![[f64::INFINITY; 2]; guards],
            parity: vec![false; guards],
            learning: None,
        }
    }

    fn plan(&mut self, _system: &mut S, _t: f64, _room_s: f64) -> Plan {
        Plan { h: self.h.min(self.longest_step_s), end: None }
    }

    fn attempt(&mut self, system: &mut S, mut trial: Trial<'_>) -> Result<f64, String> {
        self.stages(system, &mut trial, &mut ());
        Ok(self.error(&self.inverse_scales, &trial))
    }

    fn accepted(&mut self, h: f64, error: f64, _guards: Option<&[GuardSample]>) {
        if let Some(guard) = self.learning.take() {
            let ideal = h * ideal_change(error).min(CHANGE.1);
            self.step_after[guard][usize::from(self.parity[guard])] = ideal;
        }
        let (proportional, integral) = PROPORTIONAL_INTEGRAL;
        let log = error.max(LEAST_ERROR).ln();
        let change = SAFETY * ((integral * self.last_error_log - proportional * log) / CONTROL_ORDER).exp();
        let next = h * change.clamp(CHANGE.0, CHANGE.1);
        // A step that a scheduled stop cut short says nothing against the step planned before.
        self.h = if h < self.h { next.max(self.h) } else { next };
        self.last_error_log = log.max(LEAST_ERROR_LOG);
    }

    fn rejected(&mut self, h: f64, error: f64) {
        self.h = shortened(h, error);
    }

    fn switched(&mut self, guard: usize) {
        self.parity[guard] = !self.parity[guard];
        self.h = self.h.min(self.step_after[guard][usize::from(self.parity[guard])]);
        self.learning = Some(guard);
    }
}

/// `out = y + h sum_j weights[j] k_j` over the leading `out.len()` components; stage `j` starts at `j * n`.
struct Combination<'c, const K: usize> {
    weights: &'c [f64],
    h: f64,
    y: &'c [f64],
    rates: &'c [f64],
    out: &'c mut [f64],
}

impl<const K: usize> WithSimd for Combination<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { weights, h, y, rates, out } = self;
        let n = rates.len() / K;
        let len = out.len();
        let w: [f64; K] = std::array::from_fn(|j| h * weights[j]);
        let k: [&[f64]; K] = std::array::from_fn(|j| &rates[j * n..j * n + len]);
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
    rates: &'e [f64],
    /// Length of a stage.
    n: usize,
}

impl WithSimd for ErrorNorm<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { inverse_scales, h, rates, n } = self;
        let len = inverse_scales.len();
        let k: [&[f64]; STAGES] = std::array::from_fn(|j| &rates[j * n..j * n + len]);
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
            |rates: &[f64]| Arch::new().dispatch(ErrorNorm { inverse_scales: &inverse_scales, h: 0.1, rates, n });
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
