//! What a series of blows is: regular, irregular, not yet settled, stopped, or never felt by the casting.

use schemars::JsonSchema;
use serde::Serialize;

use super::blow::{BlowKind, Recorded};
use crate::quantity::named;
use crate::scene::OutputSettings;

named! {
    /// Kind of motion of a hammer's percussion, the least sound first.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
    pub enum Percussion {
        /// No blow of the percussion at all.
        #[default]
        None = "none",
        /// Blows, but none that reaches the casting.
        Blank = "blank",
        /// In the last third of the time with the gate open, blows come at less than half the rate of the rest (the share is
        /// `outputs.stall_rate_share`).
        Stalled = "stalled",
        /// Energies or intervals still follow a trend, or there are fewer than four periodic blows to tell.
        Unsettled = "unsettled",
        /// No period up to `outputs.longest_period_blows` fits.
        Aperiodic = "aperiodic",
        /// Energies and intervals repeat after some blows.
        Periodic = "periodic",
    }
}

/// Fewest periodic blows whose kind of motion is judged.
const LEAST_BLOWS: usize = 4;
/// Standard errors beyond which a trend counts.
const SIGNIFICANT: f64 = 3.0;
/// Usual intervals of blows that the last third of the gated time must span for silence to mean something.
const DUE_INTERVALS: f64 = 2.0;

impl Percussion {
    /// Whether the hammer strikes its casting to the end of the run.
    pub fn strikes(self) -> bool {
        self >= Self::Unsettled
    }
}

/// Judges one hammer's blows, in the order of time, over `gated_s` seconds with its gate open: the kind, and the period in
/// blows of a periodic one.
pub(super) fn judge(blows: &[Recorded], gated_s: f64, settings: &OutputSettings) -> (Percussion, Option<u64>) {
    let percussion = || blows.iter().filter(|recorded| recorded.blow.kind.is_percussion());
    let struck: Vec<&Recorded> = percussion().filter(|recorded| recorded.blow.kind != BlowKind::Blank).collect();
    let periodic: Vec<&Recorded> =
        struck.iter().copied().filter(|recorded| recorded.blow.kind == BlowKind::Periodic).collect();
    if percussion().next().is_none() {
        return (Percussion::None, None);
    }
    if struck.is_empty() {
        return (Percussion::Blank, None);
    }
    if stalls(&struck, gated_s, settings.stall_rate_share) {
        return (Percussion::Stalled, None);
    }
    if periodic.len() < LEAST_BLOWS || drifts(&periodic, settings.periodic_agreement) {
        return (Percussion::Unsettled, None);
    }
    let fits = |period: &usize| repeats(&periodic, *period, settings.periodic_agreement);
    match (1..=settings.longest_period_blows).find(fits) {
        Some(period) => (Percussion::Periodic, Some(period as u64)),
        None => (Percussion::Aperiodic, None),
    }
}

/// Whether blows come in the last third of the gated time at less than `share` of the rate before.
fn stalls(struck: &[&Recorded], gated_s: f64, share: f64) -> bool {
    let late = struck.iter().filter(|recorded| recorded.gated_s > gated_s * 2.0 / 3.0).count() as f64;
    let early = struck.len() as f64 - late;
    let usual_s = struck.last().map_or(0.0, |last| last.gated_s / struck.len() as f64);
    // The rest is twice as long as the last third.
    gated_s / 3.0 >= DUE_INTERVALS * usual_s && late < share * 0.5 * early
}

/// Whether blows a period apart have the same energies and intervals, to `agreement` of their means in root mean square.
fn repeats(blows: &[&Recorded], period: usize, agreement: f64) -> bool {
    let energies = strokes(blows).map(|stroke| stroke.iter().map(|recorded| recorded.blow.energy_j).collect());
    let energies: Vec<Vec<f64>> = energies.collect();
    let intervals: Vec<Vec<f64>> = strokes(blows).map(intervals).collect();
    let same = |series: &[Vec<f64>]| {
        let pairs = || series.iter().flat_map(|values| values.iter().zip(values.iter().skip(period)));
        let (count, values) = (pairs().count(), series.iter().map(Vec::len).sum::<usize>());
        let mean = series.iter().flatten().sum::<f64>() / values as f64;
        let square = pairs().map(|(a, b)| (b - a) * (b - a)).sum::<f64>() / count as f64;
        // One pair agrees by chance; a NaN of nothing agrees with nothing.
        count >= 2 && square.sqrt() <= agreement * mean.abs()
    };
    same(&energies) && same(&intervals)
}

/// Whether energies or intervals of the longest stroke follow a line whose rise over the series is beyond `agreement` of the
/// mean and beyond doubt.
fn drifts(blows: &[&Recorded], agreement: f64) -> bool {
    let longest = strokes(blows).max_by_key(|stroke| stroke.len()).unwrap_or_default();
    let energies: Vec<f64> = longest.iter().map(|recorded| recorded.blow.energy_j).collect();
    [energies, intervals(longest)].iter().any(|values| {
        let Line { rise, error, mean } = Line::through(values);
        rise.abs() > agreement * mean.abs() && rise.abs() > SIGNIFICANT * error
    })
}

/// The line of least squares over a series.
struct Line {
    /// From the first value to the last.
    rise: f64,
    /// Standard error of the rise.
    error: f64,
    /// Mean of the series.
    mean: f64,
}

impl Line {
    /// No rise for fewer than three values.
    fn through(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        if values.len() < 3 {
            return Self { rise: 0.0, error: 0.0, mean };
        }
        let middle = 0.5 * (n - 1.0);
        let at = || values.iter().enumerate().map(|(i, value)| (i as f64 - middle, value - mean));
        let spread: f64 = at().map(|(x, _)| x * x).sum();
        let slope = at().map(|(x, y)| x * y).sum::<f64>() / spread;
        let rest: f64 = at().map(|(x, y)| (y - slope * x).powi(2)).sum();
        Self { rise: (n - 1.0) * slope, error: (n - 1.0) * (rest / (n - 2.0) / spread).sqrt(), mean }
    }
}

/// The blows of each stroke.
pub(super) fn strokes<'r, 'a>(blows: &'r [&'a Recorded]) -> impl Iterator<Item = &'r [&'a Recorded]> {
    blows.chunk_by(|a, b| a.blow.stroke == b.blow.stroke)
}

fn intervals(stroke: &[&Recorded]) -> Vec<f64> {
    stroke.windows(2).map(|pair| pair[1].blow.start_time_s - pair[0].blow.start_time_s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::blow::Blow;

    /// Blows every `interval(n)` seconds with energies `energy(n)`, all struck, the first five settling.
    fn series(count: usize, interval: impl Fn(usize) -> f64, energy: impl Fn(usize) -> f64) -> Vec<Recorded> {
        let mut t = 0.0;
        let blow = |n: usize| {
            t += interval(n);
            let kind = if n < 5 { BlowKind::Settling } else { BlowKind::Periodic };
            recorded(kind, 0, (t, energy(n)))
        };
        (0..count).map(blow).collect()
    }

    fn recorded(kind: BlowKind, stroke: usize, (t, energy_j): (f64, f64)) -> Recorded {
        let blow = Blow { stroke, kind, start_time_s: t, energy_j, ..Blow::default() };
        Recorded { blow, gated_s: t, arm_integral: 0.0 }
    }

    fn kind(blows: &[Recorded], gated_s: f64) -> (Percussion, Option<u64>) {
        judge(blows, gated_s, &OutputSettings::default())
    }

    #[test]
    fn analytic_kinds_of_motion() {
        let steady = |_: usize| 0.045;
        let wave = |n: usize| (n as f64 * 2.399).sin();
        assert_eq!(kind(&[], 1.0), (Percussion::None, None));
        assert_eq!(kind(&series(30, steady, |_| 12.0), 1.35), (Percussion::Periodic, Some(1)));
        for period in 2..=4 {
            let cycle = |n: usize| 12.0 + (n % period) as f64;
            let expected = (Percussion::Periodic, Some(period as u64));
            assert_eq!(kind(&series(30, steady, cycle), 1.35), expected);
            assert_eq!(kind(&series(30, |n| 0.045 + 0.003 * (n % period) as f64, |_| 12.0), 1.5), expected);
        }
        assert_eq!(kind(&series(30, steady, |n| 12.0 + (n % 5) as f64), 1.35), (Percussion::Aperiodic, None));
        assert_eq!(kind(&series(30, steady, |n| 12.0 + wave(n)), 1.35), (Percussion::Aperiodic, None));
        assert_eq!(kind(&series(30, |n| 0.045 + 0.005 * wave(n), |_| 12.0), 1.35), (Percussion::Aperiodic, None));
        // A trend of 1 % of the mean is none; one of 10 % is, also where single steps are below 1 %.
        assert_eq!(kind(&series(30, steady, |n| 12.0 + 0.002 * n as f64), 1.35), (Percussion::Periodic, Some(1)));
        assert_eq!(kind(&series(30, steady, |n| 12.0 + 0.05 * n as f64), 1.35), (Percussion::Unsettled, None));
        assert_eq!(kind(&series(8, steady, |_| 12.0), 0.36), (Percussion::Unsettled, None));
    }

    /// Blows that end at half of the gated time, or become rare; a run that is too short to tell does not stall.
    #[test]
    fn analytic_stalls() {
        let half = series(15, |_| 0.045, |_| 12.0);
        assert_eq!(kind(&half, 1.35).0, Percussion::Stalled);
        assert_eq!(kind(&half, 0.70).0, Percussion::Periodic);
        let rare = series(24, |n| if n < 20 { 0.045 } else { 0.15 }, |_| 12.0);
        assert_eq!(kind(&rare, 1.5).0, Percussion::Stalled);
        let one = series(1, |_| 0.036, |_| 12.0);
        assert_eq!((kind(&one, 0.086).0, kind(&one, 1.0).0), (Percussion::Unsettled, Percussion::Stalled));
    }

    /// A pause of the supply is no interval; a hammer that never reaches its casting is blank.
    #[test]
    fn analytic_strokes_and_blanks() {
        let mut blows = series(15, |_| 0.045, |_| 12.0);
        for n in 0..15 {
            let kind = if n < 5 { BlowKind::Settling } else { BlowKind::Periodic };
            let mut blow = recorded(kind, 1, (3.0 + 0.045 * n as f64, 12.0));
            blow.gated_s = 0.7 + 0.045 * n as f64;
            blows.push(blow);
        }
        assert_eq!(kind(&blows, 1.4), (Percussion::Periodic, Some(1)));
        let blank: Vec<Recorded> = (0..9).map(|n| recorded(BlowKind::Blank, 0, (0.045 * n as f64, 7.0))).collect();
        assert_eq!(kind(&blank, 0.4), (Percussion::Blank, None));
        assert!(Percussion::Unsettled.strikes() && !Percussion::Stalled.strikes());
    }
}
