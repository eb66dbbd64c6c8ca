//! Compares a measured channel with the calculated signal.

use schemars::JsonSchema;
use serde::Serialize;

use super::error::MeasurementError;
use super::read::Measured;
use decore_statistics::signal::{
    Butterworth, Grid, Offset, Offsets, Spectrum, dominant_frequency_hz, offset, peak, relative_difference, resampled,
    rms, spikes,
};

/// Cut-off frequency of the low-pass in Hz: the paper's.
pub const LOW_PASS_HZ: f64 = 4000.0;
/// Order of the low-pass, once forwards and once backwards.
pub const LOW_PASS_ORDER: usize = 4;
/// Most samples of a measurement at the interval of the calculated signal: 400 s of it at 20 us.
const MOST_SAMPLES: usize = 20_000_000;
/// Fewest samples in common.
pub(super) const LEAST_SAMPLES: usize = 64;
/// Median intervals of a measurement from one sample to the next beyond which there is a gap between them: samples that are lost one by
/// one, and clocks that jitter, make none.
const GAP_INTERVALS: f64 = 5.0;
/// Correlation below which an offset is doubtful: less than a quarter of the variance is common to both then.
const LEAST_CORRELATION: f64 = 0.5;
/// Share of the variance that is not common to both, over that with the sign turned, up to which the sign seems to be turned.
const REVERSED_SHARE: f64 = 0.5;

/// Treatment of both signals before the comparison.
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

/// Both signals over a time in which the measurement has no gap.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Piece {
    /// Begin, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// Index of its first instant among the calculated ones. Not in the JSON.
    #[serde(skip)]
    pub first: usize,
    /// The calculated signal as it was compared, at each instant of it. No part of the JSON.
    #[serde(skip)]
    pub calculated: Vec<f64>,
    /// The measurement as it was compared, at the same instants. No part of the JSON.
    #[serde(skip)]
    pub measured: Vec<f64>,
}

/// Comparison of a measured channel with the calculated signal, over the time that both cover.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredBeside {
    /// Time in s by which the measurement's clock is ahead of the calculated time.
    pub offset_s: f64,
    /// Correlation coefficient at that offset; null if it was given.
    pub correlation: Option<f64>,
    /// Reasons to doubt the offset, and with it all figures.
    pub warnings: Vec<String>,
    /// Cut-off frequency of the low-pass on both in Hz; null: none.
    pub low_pass_hz: Option<f64>,
    /// Begin of the time in common, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// Calculated times in s of single-sample spikes in the measurement; they are marked and left as they are.
    pub spikes_s: Vec<f64>,
    /// The times that both have: one, or several with gaps of the measurement between them. All figures leave gaps out of both.
    pub pieces: Vec<Piece>,
    /// Root mean squares.
    pub rms: Compared,
    /// Largest absolute values.
    pub peak: Compared,
    /// Frequencies in Hz of the highest line in the longest piece, the mean left out; null if a signal has none, and where that
    /// piece has less than 64 samples.
    pub frequency_hz: Option<Compared>,
}

impl MeasuredBeside {
    /// Whether both have all of a time, without a gap.
    pub fn has(&self, from_s: f64, to_s: f64) -> bool {
        self.pieces.iter().any(|piece| piece.from_s <= from_s && to_s <= piece.to_s)
    }
}

/// Compares a measurement with `calculated`, which has a value every `interval_s` from 0 on. The measurement is interpolated linearly to
/// that interval. Both pass the same zero-phase low-pass. The offset is the shift with the best correlation. Figures use the common time.
/// If two samples are further apart than five median intervals, the measurement has a gap, which is not compared.
///
/// # Errors
/// [`MeasurementError::Long`], [`MeasurementError::Apart`]; signals too short for the filter, a cut-off above half of the sampling rate.
pub fn beside(
    (calculated, interval_s): (&[f64], f64),
    measured: &Measured,
    treatment: Treatment,
) -> Result<MeasuredBeside, MeasurementError> {
    let Measured { times_s, values } = measured;
    let (first_s, last_s) = (times_s.first().copied().unwrap_or(0.0), times_s.last().copied().unwrap_or(0.0));
    let (calculated, held) = treated((calculated, interval_s), measured, treatment.low_pass_hz)?;
    let (offset_s, correlation, warnings) = match treatment.offset_s {
        Some(offset_s) => (offset_s, None, Vec::new()),
        None => {
            let found = offset(&calculated, &held, interval_s)?;
            (first_s + found.upright.time_s, Some(found.upright.correlation), warnings(&found, first_s))
        }
    };
    let at = |place: usize| first_s - offset_s + interval_s * place as f64;
    let (places, shifted): (Vec<f64>, Vec<f64>) =
        held.iter().enumerate().filter_map(|(place, value)| Some((at(place), (*value)?))).unzip();
    let grid = Grid { from_s: 0.0, interval_s, count: calculated.len() };
    // Instants that follow each other are one interval apart.
    let pieces = pieces(&resampled(&places, &shifted, grid, 1.5 * interval_s), &calculated, interval_s);
    let parts: Vec<SignalPair<'_>> = pieces.iter().map(|piece| [&piece.calculated[..], &piece.measured]).collect();
    let is_enough = parts.iter().map(|[_, theirs]| theirs.len()).sum::<usize>() >= LEAST_SAMPLES;
    let ends = pieces.first().zip(pieces.last()).map(|(first, last)| (first.from_s, last.to_s));
    let Some((from_s, to_s)) = ends.filter(|_| is_enough) else {
        let duration_s = interval_s * calculated.len().saturating_sub(1) as f64;
        let [from_s, to_s] = [first_s, last_s].map(|time_s| time_s - offset_s);
        return Err(MeasurementError::Apart { offset_s, from_s, to_s, duration_s });
    };
    let [rms, peak] = Compared::rms_and_peak(&parts);
    Ok(MeasuredBeside {
        offset_s,
        correlation,
        warnings,
        low_pass_hz: treatment.low_pass_hz,
        from_s,
        to_s,
        spikes_s: spikes(values).into_iter().map(|place| times_s[place] - offset_s).collect(),
        rms,
        peak,
        frequency_hz: Compared::frequency_hz(longest(&parts), interval_s),
        pieces,
    })
}

/// Returns reasons to doubt an offset that was found for a measurement that begins at `first_s`.
fn warnings(Offsets { upright, reversed }: &Offsets, first_s: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if upright.correlation < LEAST_CORRELATION {
        warnings.push(format!(
            "the best correlation is below {LEAST_CORRELATION}: the offset is doubtful, and with it all figures (are the times in s? \
             `--time-column COLUMN:ms` reads ms; does the channel measure this signal? `--offset-s` gives the offset)"
        ));
    }
    let apart = |offset: &Offset| 1.0 - offset.correlation.max(0.0).powi(2);
    if apart(reversed) < REVERSED_SHARE * apart(upright) {
        warnings.push(format!(
            "with its sign turned the channel correlates better, by {:.4} at an offset of {:.6} s: is the sensor \
             mounted the other way round? (a minus before the unit changes the sign: SIGNAL=COLUMN:-UNIT)",
            reversed.correlation,
            first_s + reversed.time_s
        ));
    }
    warnings
}

/// Both signals at the interval of the calculated one, through the low-pass; the measurement from its first sample on, with nothing
/// in its gaps.
fn treated(
    (calculated, interval_s): (&[f64], f64),
    Measured { times_s, values }: &Measured,
    low_pass_hz: Option<f64>,
) -> Result<(Vec<f64>, Vec<Option<f64>>), MeasurementError> {
    let (from_s, to_s) = (times_s.first().copied().unwrap_or(0.0), times_s.last().copied().unwrap_or(0.0));
    let intervals = (to_s - from_s) / interval_s + 1e-9;
    if intervals >= MOST_SAMPLES as f64 {
        return Err(MeasurementError::Long { from_s, to_s, interval_s, most: MOST_SAMPLES });
    }
    let grid = Grid { from_s, interval_s, count: intervals.floor() as usize + 1 };
    let held = resampled(times_s, values, grid, GAP_INTERVALS * median_interval_s(times_s));
    let Some(cutoff_hz) = low_pass_hz else { return Ok((calculated.to_vec(), held)) };
    let filter = Butterworth::low_pass(LOW_PASS_ORDER, cutoff_hz, 1.0 / interval_s)?;
    // For the filter alone a straight line bridges a gap.
    let bridged: Vec<f64> = resampled(times_s, values, grid, f64::INFINITY).into_iter().map_while(|at| at).collect();
    let filtered = filter.zero_phase(&bridged)?;
    let held = filtered.into_iter().zip(held).map(|(value, held)| held.map(|_| value)).collect();
    Ok((filter.zero_phase(calculated)?, held))
}

/// The median time in s from one sample to the next; of less than two samples 0.
fn median_interval_s(times_s: &[f64]) -> f64 {
    let mut intervals: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() { 0.0 } else { *intervals.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Returns the pieces that both signals cover, in order. `measured`: values at the calculated instants, from the first one.
fn pieces(measured: &[Option<f64>], calculated: &[f64], interval_s: f64) -> Vec<Piece> {
    let (mut pieces, mut first) = (Vec::new(), 0);
    for run in measured.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let values: Vec<f64> = run.iter().copied().flatten().collect();
        if !values.is_empty() {
            let [from_s, to_s] = [first, first + run.len() - 1].map(|at| interval_s * at as f64);
            let calculated = calculated[first..first + run.len()].to_vec();
            pieces.push(Piece { from_s, to_s, first, calculated, measured: values });
        }
        first += run.len();
    }
    pieces
}

/// A part of a piece: the calculated signal, the measured one.
pub(super) type SignalPair<'a> = [&'a [f64]; 2];

/// The longest of some parts, of equally long ones the first.
pub(super) fn longest<'a>(parts: &[SignalPair<'a>]) -> SignalPair<'a> {
    parts.iter().rev().max_by_key(|[ours, _]| ours.len()).copied().unwrap_or_default()
}

fn frequency(values: &[f64], interval_s: f64) -> Option<f64> {
    let spectrum = Spectrum::of(values, interval_s);
    dominant_frequency_hz(&spectrum.amplitudes, spectrum.resolution_hz)
}

impl Compared {
    pub(super) fn of(calculated: f64, measured: f64) -> Self {
        Self { calculated, measured, difference: relative_difference(calculated, measured) }
    }

    /// Root mean squares, and largest absolute values.
    pub(super) fn rms_and_peak(parts: &[SignalPair<'_>]) -> [Self; 2] {
        let [ours, theirs] = [0, 1].map(|side| parts.iter().flat_map(|part| part[side]).copied().collect::<Vec<f64>>());
        [rms, peak].map(|of| Self::of(of(&ours), of(&theirs)))
    }

    /// Frequencies in Hz of the highest lines; `None` if a signal has none, and of too few samples.
    pub(super) fn frequency_hz([ours, theirs]: SignalPair<'_>, interval_s: f64) -> Option<Self> {
        if ours.len() < LEAST_SAMPLES {
            return None;
        }
        let both = frequency(ours, interval_s).zip(frequency(theirs, interval_s));
        both.map(|(ours, theirs)| Self::of(ours, theirs))
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
    fn gaps_are_left_out_of_both() {
        let whole = measured(0.8, 3.0);
        // The clock is that of the calculation: a gap from 0.1 to 0.2 s, and one sample that is lost at 0.3 s.
        let kept = |time_s: f64| !(3.1..3.2).contains(&time_s) && (time_s - 3.3).abs() > 2e-5;
        let (times_s, values) = (whole.times_s.iter().zip(&whole.values)).filter(|(time_s, _)| kept(**time_s)).unzip();
        let gapped = Measured { times_s, values };
        for low_pass_hz in [Some(LOW_PASS_HZ), None] {
            let treatment = Treatment { low_pass_hz, offset_s: None };
            let found = beside((&calculated(), INTERVAL_S), &gapped, treatment).expect("comparison");
            assert!((found.offset_s - 3.0).abs() < 1e-5 && found.correlation > Some(0.99), "{:?}", found.rms);
            let ends: Vec<[f64; 2]> = found.pieces.iter().map(|piece| [piece.from_s, piece.to_s]).collect();
            let [[from_s, begin_s], [end_s, to_s]] = ends[..] else { panic!("{ends:?}") };
            assert!((begin_s - 0.1).abs() < 2e-4 && (end_s - 0.2).abs() < 2e-4, "{ends:?}");
            assert_eq!((from_s, to_s), (found.from_s, found.to_s));
            // As if nothing were missing: calculated 1 / 0.8 of measured.
            assert!((found.rms.difference - 0.25).abs() < 5e-3, "{:?}", found.rms);
            // In the longest piece, 0.2 to 0.35 s, 80 Hz stand between lines 6.6 Hz apart.
            let frequency = found.frequency_hz.expect("frequency");
            assert!((frequency.calculated - 80.0).abs() < 6.6 && frequency.difference == 0.0, "{frequency:?}");
        }
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
