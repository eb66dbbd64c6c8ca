//! A Butterworth low-pass as second-order sections, and filtering without a shift in time.

use std::f64::consts::PI;

use rustfft::num_complex::Complex;

use super::error::SignalError;

/// Highest order of a filter.
pub const MOST_ORDER: usize = 20;

/// A section `H(z) = (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Coefficients `b0, b1, b2` of the numerator.
    pub b: [f64; 3],
    /// Coefficients `a1, a2` of the denominator; `a0 = 1`.
    pub a: [f64; 2],
}

/// A digital Butterworth low-pass: `|H|^2 = 1 / (1 + (tan(pi f / r) / tan(pi c / r))^(2 n))` at `f` Hz, of order `n`, cut-off
/// frequency `c` and `r` samples a second.
#[derive(Debug, Clone, PartialEq)]
pub struct Butterworth {
    sections: Vec<Section>,
}

impl Butterworth {
    /// The filter of `order` (1 to [`MOST_ORDER`]) with cut-off frequency `cutoff_hz` at `rate_hz` samples a second: the analogue
    /// poles on a circle, taken over by the bilinear transform with the cut-off frequency prewarped. Sections, their order and
    /// the zeros in each are those of `scipy.signal.butter(order, cutoff_hz, fs=rate_hz, output="sos")`.
    ///
    /// # Errors
    /// [`SignalError::Filter`] for another order, or a cut-off frequency that is not between 0 and half the sampling rate.
    pub fn low_pass(order: usize, cutoff_hz: f64, rate_hz: f64) -> Result<Self, SignalError> {
        let refused = |expected| Err(SignalError::Filter { order, cutoff_hz, rate_hz, expected });
        if !(1..=MOST_ORDER).contains(&order) {
            return refused("the order has to lie between 1 and 20");
        }
        if !(rate_hz.is_finite() && cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz) {
            return refused("the cut-off frequency has to lie above 0 and below half the sampling rate");
        }
        // In units of half the bilinear transform's rate, so that `z = (2 + s) / (2 - s)`.
        let warped = 2.0 * (PI * cutoff_hz / rate_hz).tan();
        let (mut poles, mut gain) = (Vec::new(), 1.0);
        for k in 0..order.div_ceil(2) {
            let angle = PI * (2 * k + 1) as f64 / (2 * order) as f64;
            // Left half plane: the angle counts from the imaginary axis.
            let alone = 2 * k + 1 == order;
            let s = if alone { Complex::new(-warped, 0.0) } else { warped * Complex::new(-angle.sin(), angle.cos()) };
            poles.push((2.0 + s) / (2.0 - s));
            let factor = if alone { warped / (2.0 + warped) } else { warped * warped / (2.0 - s).norm_sqr() };
            gain *= factor;
        }
        // Poles nearest to the unit circle come last, so that their gain is not amplified again.
        poles.sort_by(|p, q| (1.0 - q.norm()).abs().total_cmp(&(1.0 - p.norm()).abs()));
        Ok(Self { sections: sections(order, &poles, gain) })
    }

    /// The sections, in the order in which a signal passes them.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Samples by which [`Self::zero_phase`] lengthens a signal at each end: `3 (2 s + 1 - m)` with `s` sections, `m` the lesser
    /// of the numbers of sections without `b2` and without `a2`; scipy's default.
    pub fn padding(&self) -> usize {
        let without = |last: fn(&Section) -> f64| self.sections.iter().filter(|section| last(section) == 0.0).count();
        3 * (2 * self.sections.len() + 1 - without(|section| section.b[2]).min(without(|section| section.a[1])))
    }

    /// The signal filtered forwards and then backwards: no shift in time, the gain twice. Before it, both ends are lengthened by
    /// [`Self::padding`] samples of odd reflection (`2 x_0 - x_k`), and each pass begins in the steady state of its first sample:
    /// `scipy.signal.sosfiltfilt(sos, values)` with its default `padtype="odd"` and `padlen=None`.
    ///
    /// # Errors
    /// [`SignalError::Short`] for a signal that is not longer than the padding.
    pub fn zero_phase(&self, values: &[f64]) -> Result<Vec<f64>, SignalError> {
        let padding = self.padding();
        let (Some(first), Some(last), true) = (values.first(), values.last(), values.len() > padding) else {
            let purpose = "filter it forwards and backwards";
            return Err(SignalError::Short { samples: values.len(), least: padding + 1, purpose });
        };
        let before = values[1..=padding].iter().rev().map(|value| 2.0 * first - value);
        let after = values[values.len() - 1 - padding..values.len() - 1].iter().rev().map(|value| 2.0 * last - value);
        let mut long: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
        self.pass(&mut long);
        long.reverse();
        self.pass(&mut long);
        long.reverse();
        Ok(long[padding..padding + values.len()].to_vec())
    }

    /// One pass, in place, from the steady state of the first sample (direct form II, transposed).
    fn pass(&self, values: &mut [f64]) {
        let mut level = values.first().copied().unwrap_or(0.0);
        for Section { b: [b0, b1, b2], a: [a1, a2] } in &self.sections {
            let steady = level * (b0 + b1 + b2) / (1.0 + a1 + a2);
            let (mut one, mut two) = (steady - b0 * level, b2 * level - a2 * steady);
            for value in values.iter_mut() {
                let out = b0 * *value + one;
                one = b1 * *value - a1 * out + two;
                two = b2 * *value - a2 * out;
                *value = out;
            }
            level = steady;
        }
    }
}

/// Sections of poles (one of each pair) in their order, with the zeros at -1 and, where the order is odd, one at 0 that makes up
/// for a pole at 0. The poles that matter most choose first, the nearest zero to them.
fn sections(order: usize, poles: &[Complex<f64>], gain: f64) -> Vec<Section> {
    let mut at_zero = order % 2 == 1;
    let mut sections: Vec<Section> = (poles.iter().rev())
        .map(|pole| {
            let alone = pole.im == 0.0;
            // The lone pole's partner is the one at 0.
            let takes = at_zero && (alone || pole.norm() <= (pole + 1.0).norm());
            at_zero &= !takes;
            let b = if takes { [1.0, 1.0, 0.0] } else { [1.0, 2.0, 1.0] };
            let a = if alone { [-pole.re, 0.0] } else { [-2.0 * pole.re, pole.norm_sqr()] };
            Section { b, a }
        })
        .collect();
    sections.reverse();
    if let Some(first) = sections.first_mut() {
        first.b = first.b.map(|b| gain * b);
    }
    sections
}
