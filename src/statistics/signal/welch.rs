//! Power spectral density after Welch.

use std::f64::consts::TAU;

use super::error::SignalError;
use super::transform::RealTransform;

/// A single-sided power spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    /// Distance between two lines in Hz.
    pub resolution_hz: f64,
    /// Power per Hz of each line, from 0 Hz on up to half the sampling rate: the square of the signal's unit, by Hz.
    pub power: Vec<f64>,
}

/// The density of `values` at `rate_hz` samples a second: segments of `segment` samples (of a shorter signal all), each half over
/// the one before, their mean taken away, weighted by the periodic Hann window `w`, and of `|X_k|^2 / (rate_hz sum w^2)` (twice
/// that but for the mean and half the sampling rate) the mean over the segments:
/// `scipy.signal.welch(values, rate_hz, nperseg=segment)`, whose defaults are `window="hann"`, `detrend="constant"`,
/// `scaling="density"`.
///
/// # Errors
/// [`SignalError::Short`] for less than two samples.
pub fn welch(values: &[f64], rate_hz: f64, segment: usize) -> Result<Density, SignalError> {
    let n = segment.min(values.len());
    if n < 2 {
        return Err(SignalError::Short { samples: n, least: 2, purpose: "take a density" });
    }
    let window: Vec<f64> = (0..n).map(|k| 0.5 - 0.5 * (TAU * k as f64 / n as f64).cos()).collect();
    let transform = RealTransform::of(n);
    let (mut power, mut segments) = (vec![0.0; n / 2 + 1], 0.0);
    for part in values.windows(n).step_by(n - n / 2) {
        let mean = part.iter().sum::<f64>() / n as f64;
        let lines = transform.lines(part.iter().zip(&window).map(|(value, weight)| weight * (value - mean)));
        power.iter_mut().zip(lines).for_each(|(sum, line)| *sum += line.norm_sqr());
        segments += 1.0;
    }
    let scale = 1.0 / (segments * rate_hz * window.iter().map(|weight| weight * weight).sum::<f64>());
    for (line, power) in power.iter_mut().enumerate() {
        *power *= if line == 0 || 2 * line == n { scale } else { 2.0 * scale };
    }
    Ok(Density { resolution_hz: rate_hz / n as f64, power })
}
