//! Compares a measurement with the calculated signal, phase by phase.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Serialize;

use super::beside::{Compared, LEAST_SAMPLES, MeasuredBeside, Piece, SignalPair, longest};
use super::error::MeasurementError;
use decore_model::metrics::{Phase, PhaseKind};
use decore_statistics::signal::{Density, welch};

/// Longest segment of a density in s, and the shortest that is worth one: its lines are as far apart as one over it.
const SEGMENT_S: [f64; 2] = [0.02, 0.5];
/// Largest frequency in Hz of printed densities, as in the paper's figures.
const MOST_FREQUENCY_HZ: f64 = 1000.0;
/// Number of printed lines of each signal.
const MOST_LINES: usize = 3;
/// Power of a line over the highest one's, below which it is none.
const LEAST_POWER: f64 = 0.01;
/// Two lines are the same if their distance is at most this share of their frequency, or one line of the density.
const SAME_LINE: f64 = 0.1;

/// Both signals over a phase, as far as both have it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PhaseBeside {
    /// The phase.
    pub phase: PhaseKind,
    /// Begin of the common part, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// Share of the phase that both have: gaps of the measurement do not count.
    pub covered: f64,
    /// Begin and end in s of its longest part without a gap, for frequencies and densities.
    pub longest_s: [f64; 2],
    /// Root mean squares.
    pub rms: Compared,
    /// Largest absolute values.
    pub peak: Compared,
    /// Frequencies in Hz of the highest line of the amplitudes, the mean left out; null if a signal has none.
    pub frequency_hz: Option<Compared>,
    /// Power densities; null if the phase is too short for two segments of 0.02 s, each half over the other.
    pub density: Option<DensityBeside>,
}

/// Power densities after Welch of both signals.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DensityBeside {
    /// Length of a segment in s.
    pub segment_s: f64,
    /// Distance between two lines in Hz.
    pub resolution_hz: f64,
    /// Of the calculated signal, from 0 Hz on up to 1000 Hz: the square of its unit, by Hz.
    pub calculated: Vec<f64>,
    /// Of the measured one.
    pub measured: Vec<f64>,
    /// The strongest lines of either signal, by rising frequency, between the density's own by a parabola through the logarithms.
    pub lines: Vec<LineBeside>,
}

/// A line of one density, and the one of the other that is the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct LineBeside {
    /// Frequency in Hz in the calculated signal; null if it has none there.
    pub calculated_hz: Option<f64>,
    /// In the measured one.
    pub measured_hz: Option<f64>,
    /// `(calculated - measured) / measured`; null if one has none.
    pub difference: Option<f64>,
}

/// A phase that is not compared.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MissingPhase {
    /// The phase.
    pub phase: PhaseKind,
    /// Reason.
    pub reason: String,
}

/// Both signals in each phase.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Phases {
    /// The phases that both have.
    pub phases: Vec<PhaseBeside>,
    /// Phases that are missing in the row or the measurement.
    pub missing_phases: Vec<MissingPhase>,
}

/// Compares both signals over the phases of a row; `interval_s`: the interval of both.
///
/// # Errors
/// Those of transforms, of which none is known.
pub fn phases(beside: &MeasuredBeside, interval_s: f64, had: &[Phase]) -> Result<Phases, MeasurementError> {
    let mut found = Phases::default();
    for kind in PhaseKind::ALL {
        let missing = |reason: String| MissingPhase { phase: kind, reason };
        let Some(phase) = had.iter().find(|phase| phase.kind == kind) else {
            found.missing_phases.push(missing("the row has none".to_owned()));
            continue;
        };
        let samples = phase.samples(interval_s);
        let (ranges, parts): (Vec<Range<usize>>, Vec<SignalPair<'_>>) =
            beside.pieces.iter().filter_map(|piece| within(piece, &samples)).unzip();
        let count: usize = ranges.iter().map(Range::len).sum();
        let (Some(first), Some(last), true) = (ranges.first(), ranges.last(), count >= LEAST_SAMPLES) else {
            found.missing_phases.push(missing(format!(
                "both have {count} samples of it ({:.4} to {:.4} s), where {LEAST_SAMPLES} are needed",
                phase.from_s, phase.to_s
            )));
            continue;
        };
        let whole = ranges.iter().rev().max_by_key(|range| range.len()).unwrap_or(first);
        let [rms, peak] = Compared::rms_and_peak(&parts);
        found.phases.push(PhaseBeside {
            phase: kind,
            from_s: interval_s * first.start as f64,
            to_s: interval_s * last.end as f64,
            covered: count as f64 / samples.len().max(1) as f64,
            longest_s: [whole.start, whole.end].map(|at| interval_s * at as f64),
            rms,
            peak,
            frequency_hz: Compared::frequency_hz(longest(&parts), interval_s),
            density: density(longest(&parts), interval_s)?,
        });
    }
    Ok(found)
}

/// Returns the part of a piece within some samples: their range and both signals.
fn within<'a>(piece: &'a Piece, samples: &Range<usize>) -> Option<(Range<usize>, SignalPair<'a>)> {
    let end = piece.first + piece.measured.len();
    let [from, to] = [samples.start, samples.end].map(|at| at.clamp(piece.first, end));
    let part = from - piece.first..to - piece.first;
    (from < to).then(|| (from..to, [&piece.calculated[part.clone()], &piece.measured[part]]))
}

/// Densities of both signals over segments of half their length; `None` if these are too short.
fn density([ours, theirs]: SignalPair<'_>, interval_s: f64) -> Result<Option<DensityBeside>, MeasurementError> {
    let [least_s, most_s] = SEGMENT_S;
    let samples = |time_s: f64| (time_s / interval_s).round() as usize;
    let segment = (ours.len() / 2).min(samples(most_s));
    if segment < samples(least_s).max(2) {
        return Ok(None);
    }
    let told = |values: &[f64]| -> Result<Density, MeasurementError> {
        let mut density = welch(values, 1.0 / interval_s, segment)?;
        density.power.truncate((MOST_FREQUENCY_HZ / density.resolution_hz + 1e-9) as usize + 1);
        Ok(density)
    };
    let (calculated, measured) = (told(ours)?, told(theirs)?);
    let resolution_hz = calculated.resolution_hz;
    Ok(Some(DensityBeside {
        segment_s: segment as f64 * interval_s,
        resolution_hz,
        lines: paired(&lines(&calculated), &lines(&measured), resolution_hz),
        calculated: calculated.power,
        measured: measured.power,
    }))
}

/// A line of a density.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpectralLine {
    frequency_hz: f64,
    power: f64,
}

/// Lines that are higher than both neighbours, the strongest first, down to [`LEAST_POWER`] of it, without the mean.
fn lines(density: &Density) -> Vec<SpectralLine> {
    let top = |(line, three): (usize, &[f64])| match three {
        [before, at, after] if at > before && at >= after => {
            let [low, middle, high] = [before, at, after].map(|power| power.max(f64::MIN_POSITIVE).ln());
            let bend = low - 2.0 * middle + high;
            let between = if bend < 0.0 { 0.5 * (low - high) / bend } else { 0.0 };
            Some(SpectralLine { frequency_hz: (line as f64 + 1.0 + between) * density.resolution_hz, power: *at })
        }
        _ => None,
    };
    let mut lines: Vec<SpectralLine> = density.power.windows(3).enumerate().filter_map(top).collect();
    lines.sort_by(|a, b| b.power.total_cmp(&a.power));
    let least = lines.first().map_or(0.0, |highest| LEAST_POWER * highest.power);
    lines.retain(|line| line.power >= least);
    lines
}

/// The strongest of the calculated lines, each with the nearest measured one if that is the same, and the strongest of the
/// measured ones that are left, likewise.
fn paired(calculated: &[SpectralLine], measured: &[SpectralLine], resolution_hz: f64) -> Vec<LineBeside> {
    let same = |line: &SpectralLine, others: &[SpectralLine]| {
        let hz = line.frequency_hz;
        let apart = |other: &SpectralLine| (other.frequency_hz - hz).abs();
        let nearest = others.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.filter(|other| apart(other) <= (SAME_LINE * hz).max(resolution_hz)).map(|other| other.frequency_hz)
    };
    let mut found: Vec<LineBeside> = (calculated.iter().take(MOST_LINES))
        .map(|line| LineBeside::of(Some(line.frequency_hz), same(line, measured)))
        .collect();
    for line in measured.iter().take(MOST_LINES) {
        if !found.iter().any(|one| one.measured_hz == Some(line.frequency_hz)) {
            found.push(LineBeside::of(same(line, calculated), Some(line.frequency_hz)));
        }
    }
    let at = |line: &LineBeside| line.calculated_hz.or(line.measured_hz).unwrap_or(0.0);
    found.sort_by(|a, b| at(a).total_cmp(&at(b)));
    found
}

impl LineBeside {
    fn of(calculated_hz: Option<f64>, measured_hz: Option<f64>) -> Self {
        let difference = calculated_hz.zip(measured_hz).map(|(ours, theirs)| Compared::of(ours, theirs).difference);
        Self { calculated_hz, measured_hz, difference }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::{Measured, Treatment, beside};
    use std::f64::consts::TAU;

    const INTERVAL_S: f64 = 1e-4;

    /// Lines at two frequencies in Hz with their amplitudes.
    fn wave(lines: [[f64; 2]; 2], samples: usize) -> Vec<f64> {
        let at = |time_s: f64| lines.iter().map(|[hz, height]| height * (TAU * hz * time_s + hz).sin()).sum();
        (0..samples).map(|k| at(k as f64 * INTERVAL_S)).collect()
    }

    fn phase(kind: PhaseKind, from_s: f64, to_s: f64) -> Phase {
        Phase { kind, from_s, to_s }
    }

    fn compared(measured: Vec<f64>, had: &[Phase]) -> Phases {
        let calculated = wave([[44.3, 1.0], [181.7, 0.6]], 15_000);
        let times_s = (0..measured.len()).map(|k| k as f64 * INTERVAL_S).collect();
        let treatment = Treatment { low_pass_hz: None, offset_s: Some(0.0) };
        let both =
            beside((&calculated, INTERVAL_S), &Measured { times_s, values: measured }, treatment).expect("beside");
        phases(&both, INTERVAL_S, had).expect("phases")
    }

    #[test]
    fn lines_levels_and_frequencies_of_a_phase_are_those_of_both_signals() {
        let measured = wave([[42.9, 2.0], [310.2, 1.2]], 15_000);
        let found =
            compared(measured, &[phase(PhaseKind::Hammering, 0.3, 1.3), phase(PhaseKind::Extension, 0.01, 0.03)]);
        let [short, long] = found.phases.as_slice() else { panic!("{found:?}") };
        assert_eq!(
            (short.phase, short.density.as_ref(), long.phase),
            (PhaseKind::Extension, None, PhaseKind::Hammering)
        );
        // Root mean square of two sines over many periods.
        let level = (0.5_f64 * (1.0 + 0.36)).sqrt();
        assert!((long.rms.calculated / level - 1.0).abs() < 0.02, "{:?}", long.rms);
        assert!((long.rms.measured / (2.0 * level) - 1.0).abs() < 0.02 && (long.rms.difference + 0.5).abs() < 0.01);
        let frequency = long.frequency_hz.expect("frequency");
        assert_eq!((frequency.calculated, frequency.measured), (44.0, 43.0));
        let density = long.density.as_ref().expect("density");
        assert!(
            (density.resolution_hz - 2.0).abs() < 1e-9 && density.calculated.len() == 501,
            "{}",
            density.resolution_hz
        );
        let expected = [(Some(44.3), Some(42.9)), (Some(181.7), None), (None, Some(310.2))];
        assert_eq!(density.lines.len(), expected.len(), "{:?}", density.lines);
        for (line, (ours, theirs)) in density.lines.iter().zip(expected) {
            for (found, wanted) in [(line.calculated_hz, ours), (line.measured_hz, theirs)] {
                assert_eq!(found.is_some(), wanted.is_some(), "{line:?}");
                assert!(found.zip(wanted).is_none_or(|(a, b)| (a - b).abs() < 0.1), "{line:?}");
            }
        }
        assert!((density.lines[0].difference.expect("both") - (44.3 - 42.9) / 42.9).abs() < 3e-3);
        // Power of a density: half the square of each amplitude.
        let power = density.resolution_hz * density.calculated.iter().sum::<f64>();
        assert!((power / (level * level) - 1.0).abs() < 0.02, "{power}");
    }

    #[test]
    fn gaps_do_not_count_as_covered() {
        let wave = wave([[44.3, 1.0], [181.7, 0.6]], 15_000);
        let kept =
            |(k, value): (usize, &f64)| (!(6_000..11_000).contains(&k)).then_some((k as f64 * INTERVAL_S, *value));
        let (times_s, values) = wave.iter().enumerate().filter_map(kept).unzip();
        let treatment = Treatment { low_pass_hz: None, offset_s: Some(0.0) };
        let both = beside((&wave, INTERVAL_S), &Measured { times_s, values }, treatment).expect("beside");
        let had = [phase(PhaseKind::Extension, 0.7, 0.8), phase(PhaseKind::Hammering, 0.5, 1.5)];
        let found = phases(&both, INTERVAL_S, &had).expect("phases");
        let [hammering] = found.phases.as_slice() else { panic!("{found:?}") };
        assert_eq!(hammering.covered, 0.5);
        assert!((hammering.from_s - 0.5).abs() + (hammering.to_s - 1.5).abs() < 1e-9, "{hammering:?}");
        assert!((hammering.longest_s[0] - 1.1).abs() + (hammering.longest_s[1] - 1.5).abs() < 1e-9, "{hammering:?}");
        assert_eq!((hammering.rms.difference, hammering.peak.difference), (0.0, 0.0));
        assert_eq!(hammering.frequency_hz.map(|of| of.difference), Some(0.0));
        assert!(found.missing_phases.iter().any(|one| one.reason.starts_with("both have 0 samples")), "{found:?}");
    }

    #[test]
    fn phases_that_are_not_there_are_named() {
        let had = [
            phase(PhaseKind::Extension, 0.0, 0.04),
            phase(PhaseKind::FirstImpact, 0.04, 0.5),
            phase(PhaseKind::Hammering, 0.04, 1.5),
        ];
        let found = compared(wave([[44.3, 1.0], [181.7, 0.6]], 5_000)[..452].to_vec(), &had);
        let names = |of: &[PhaseKind]| of.to_vec();
        assert_eq!(found.phases.iter().map(|one| one.phase).collect::<Vec<_>>(), names(&[PhaseKind::Extension]));
        let missing: Vec<PhaseKind> = found.missing_phases.iter().map(|one| one.phase).collect();
        assert_eq!(missing, names(&[PhaseKind::FirstImpact, PhaseKind::PeriodicBlow, PhaseKind::Hammering]));
        assert_eq!(found.missing_phases[1].reason, "the row has none");
        assert!(found.missing_phases[2].reason.starts_with("both have 52 samples"), "{found:?}");
        assert_eq!(found.phases[0].covered, 1.0);
        assert_eq!((found.phases[0].rms.difference, found.phases[0].peak.difference), (0.0, 0.0));
    }
}
