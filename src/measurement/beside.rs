//! A measured channel beside the calculated signal.

use schemars::JsonSchema;
use serde::Serialize;

use super::error::MeasurementError;
use super::read::Measured;
use crate::metrics::Spectrum;
use crate::signal::{
    Butterworth, Grid, dominant_frequency_hz, offset, peak, relative_difference, resampled, rms, spikes,
};

/// Cut-off frequency of the low-pass in Hz: the paper's.
pub const LOW_PASS_HZ: f64 = 4000.0;
/// Order of the low-pass, once forwards and once backwards.
pub const LOW_PASS_ORDER: usize = 4;
/// Most samples of a measurement at the interval of the calculated signal: 400 s of it at 20 us.
const MOST_SAMPLES: usize = 20_000_000;
/// Fewest samples in common.
const LEAST_SAMPLES: usize = 64;

/// What is done to both signals before they are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Treatment {
    /// Cut-off frequency of the low-pass in Hz; `None`: signals as they are.
    pub low_pass_hz: Option<f64>,
    /// Time in s by which the measurement's clock is ahead of the calculated time; `None`: found by cross-correlation.
    pub offset_s: Option<f64>,
}

/// One figure of both signals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Compared {
    /// Of the calculated signal.
    pub calculated: f64,
    /// Of the measured one.
    pub measured: f64,
    /// `(calculated - measured) / measured`.
    pub difference: f64,
}

/// A measured channel beside the calculated signal, over the time that both have.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Beside {
    /// Time in s by which the measurement's clock is ahead of the calculated time.
    pub offset_s: f64,
    /// Correlation coefficient at that offset; null where it was given.
    pub correlation: Option<f64>,
    /// Cut-off frequency of the low-pass on both in Hz; null: none.
    pub low_pass_hz: Option<f64>,
    /// Begin of the time in common, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
    /// Calculated times in s of single-sample spikes in the measurement; they are marked and left as they are.
    pub spikes_s: Vec<f64>,
    /// Root mean squares.
    pub rms: Compared,
    /// Largest absolute values.
    pub peak: Compared,
    /// Frequencies in Hz of the highest line, the mean left out; null where a signal has none.
    pub frequency_hz: Option<Compared>,
    /// The measurement as it was compared, at each calculated instant from `from_s` on. No part of the JSON.
    #[serde(skip)]
    pub measured: Vec<f64>,
    /// The calculated signal as it was compared, at the same instants. No part of the JSON.
    #[serde(skip)]
    pub calculated: Vec<f64>,
}

/// Puts a measurement beside `calculated`, which has a value every `interval_s` from 0 on: the measurement is brought to that
/// interval (linearly between its samples), both pass the same zero-phase low-pass, the offset is where they correlate best, and figures
/// are taken over the time in common.
///
/// # Errors
/// [`MeasurementError::Long`], [`MeasurementError::Apart`]; signals too short for the filter, a cut-off above half of the sampling rate.
pub fn beside(
    (calculated, interval_s): (&[f64], f64),
    measured: &Measured,
    treatment: Treatment,
) -> Result<Beside, MeasurementError> {
    let Measured { times_s, values } = measured;
    let (first_s, last_s) = (times_s.first().copied().unwrap_or(0.0), times_s.last().copied().unwrap_or(0.0));
    let intervals = (last_s - first_s) / interval_s + 1e-9;
    if intervals >= MOST_SAMPLES as f64 {
        return Err(MeasurementError::Long { from_s: first_s, to_s: last_s, interval_s, most: MOST_SAMPLES });
    }
    let count = intervals.floor() as usize + 1;
    let grid: Vec<f64> = resampled(times_s, values, Grid { from_s: first_s, interval_s, count })
        .into_iter()
        .map_while(|at| at)
        .collect();
    let (calculated, grid) = match treatment.low_pass_hz {
        None => (calculated.to_vec(), grid),
        Some(cutoff_hz) => {
            let filter = Butterworth::low_pass(LOW_PASS_ORDER, cutoff_hz, 1.0 / interval_s)?;
            (filter.zero_phase(calculated)?, filter.zero_phase(&grid)?)
        }
    };
    let (offset_s, correlation) = match treatment.offset_s {
        Some(offset_s) => (offset_s, None),
        None => {
            let found = offset(&calculated, &grid, interval_s)?;
            (first_s + found.time_s, Some(found.correlation))
        }
    };
    let places: Vec<f64> = (0..grid.len()).map(|place| first_s - offset_s + interval_s * place as f64).collect();
    let common = resampled(&places, &grid, Grid { from_s: 0.0, interval_s, count: calculated.len() });
    let begin = common.iter().position(Option::is_some).unwrap_or(0);
    let shown: Vec<f64> = common.into_iter().skip(begin).map_while(|at| at).collect();
    let ours = &calculated[begin..begin + shown.len()];
    if shown.len() < LEAST_SAMPLES {
        let duration_s = interval_s * calculated.len().saturating_sub(1) as f64;
        return Err(MeasurementError::Apart {
            offset_s,
            from_s: first_s - offset_s,
            to_s: last_s - offset_s,
            duration_s,
        });
    }
    let [rms, peak] = Compared::rms_and_peak(ours, &shown);
    Ok(Beside {
        offset_s,
        correlation,
        low_pass_hz: treatment.low_pass_hz,
        from_s: interval_s * begin as f64,
        to_s: interval_s * (begin + shown.len() - 1) as f64,
        spikes_s: spikes(values).into_iter().map(|place| times_s[place] - offset_s).collect(),
        rms,
        peak,
        frequency_hz: Compared::frequency_hz(ours, &shown, interval_s)?,
        calculated: ours.to_vec(),
        measured: shown,
    })
}

fn frequency(values: &[f64], interval_s: f64) -> Result<Option<f64>, MeasurementError> {
    let spectrum = Spectrum::of(values, interval_s)?;
    Ok(dominant_frequency_hz(&spectrum.amplitudes, spectrum.resolution_hz))
}

impl Compared {
    pub(super) fn of(calculated: f64, measured: f64) -> Self {
        Self { calculated, measured, difference: relative_difference(calculated, measured) }
    }

    /// Root mean squares, and largest absolute values.
    pub(super) fn rms_and_peak(calculated: &[f64], measured: &[f64]) -> [Self; 2] {
        [rms, peak].map(|of| Self::of(of(calculated), of(measured)))
    }

    /// Frequencies in Hz of the highest lines; `None` where a signal has none.
    pub(super) fn frequency_hz(
        calculated: &[f64],
        measured: &[f64],
        interval_s: f64,
    ) -> Result<Option<Self>, MeasurementError> {
        let both = frequency(calculated, interval_s)?.zip(frequency(measured, interval_s)?);
        Ok(both.map(|(ours, theirs)| Self::of(ours, theirs)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL_S: f64 = 5e-5;

    /// A decaying 80 Hz vibration from 0.05 s on.
    fn wave(time_s: f64) -> f64 {
        let since_s = time_s - 0.05;
        if since_s < 0.0 { 0.0 } else { (-20.0 * since_s).exp() * (std::f64::consts::TAU * 80.0 * since_s).sin() }
    }

    fn calculated() -> Vec<f64> {
        (0..8000).map(|k| wave(k as f64 * INTERVAL_S)).collect()
    }

    /// The vibration at another rate, later on its own clock, larger, with noise, and with spikes.
    fn measured(gain: f64, offset_s: f64) -> Measured {
        let times_s: Vec<f64> = (0..9000).map(|k| 3.0 + k as f64 * 3.9e-5).collect();
        let noise = |k: usize| 1e-3 * (((k as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0) - 0.5);
        let mut values: Vec<f64> =
            times_s.iter().enumerate().map(|(k, time_s)| gain * wave(time_s - offset_s) + noise(k)).collect();
        values[7000] += 0.5;
        values[8000] -= 0.5;
        Measured { times_s, values }
    }

    #[test]
    fn offset_gain_and_spikes_are_found() {
        let treatment = Treatment { low_pass_hz: Some(LOW_PASS_HZ), offset_s: None };
        let found = beside((&calculated(), INTERVAL_S), &measured(1.25, 3.021), treatment).expect("comparison");
        assert!((found.offset_s - 3.021).abs() < 1e-5, "{}", found.offset_s);
        assert!(found.correlation > Some(0.995), "{:?}", found.correlation);
        // The calculated one is 1 / 1.25 of the measured one, less what the spikes add.
        assert!((found.rms.difference + 0.2).abs() < 2e-3, "{:?}", found.rms);
        assert!((found.peak.difference + 0.2).abs() < 5e-3, "{:?}", found.peak);
        let frequency = found.frequency_hz.expect("frequency");
        assert!((frequency.calculated - 80.0).abs() < 4.0 && frequency.difference == 0.0, "{frequency:?}");
        let expected = [7000, 8000].map(|k| 3.0 + f64::from(k) * 3.9e-5 - found.offset_s);
        assert_eq!(found.spikes_s, expected);
        assert_eq!(found.from_s, 0.0);
        assert!((found.to_s - (3.0 + 8999.0 * 3.9e-5 - 3.021)).abs() < INTERVAL_S, "{}", found.to_s);
    }

    #[test]
    fn times_that_are_no_seconds_are_refused() {
        let stamps = Measured { times_s: vec![0.0, 1.7e12], values: vec![0.0, 1.0] };
        let treatment = Treatment { low_pass_hz: None, offset_s: None };
        let error = beside((&calculated(), INTERVAL_S), &stamps, treatment).expect_err("long");
        assert!(matches!(error, MeasurementError::Long { .. }), "{error}");
    }

    #[test]
    fn signals_that_are_apart_are_refused() {
        let treatment = Treatment { low_pass_hz: None, offset_s: Some(-5.0) };
        let error = beside((&calculated(), INTERVAL_S), &measured(1.0, 3.0), treatment).expect_err("apart");
        assert!(matches!(error, MeasurementError::Apart { .. }), "{error}");
        let treatment = Treatment { low_pass_hz: Some(2e4), offset_s: None };
        let error = beside((&calculated(), INTERVAL_S), &measured(1.0, 3.0), treatment).expect_err("cut-off");
        assert!(matches!(error, MeasurementError::Signal(_)), "{error}");
    }
}
