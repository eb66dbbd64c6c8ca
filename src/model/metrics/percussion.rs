//! What a series of blows is: regular, irregular, not yet settled, stopped, or never felt by the casting.

use libm::log;
use schemars::JsonSchema;
use serde::Serialize;

use super::blow::{BlowKind, Recorded};
use super::statistics::{correlation_time, mean, variance};
use crate::scene::OutputSettings;
use decore_quantity::named;

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
        /// Energies, intervals or works still follow a trend, their scatter comes and goes, or there are fewer than four periodic
        /// blows to tell.
        Unsettled = "unsettled",
        /// No period up to `outputs.longest_period_blows` fits.
        Aperiodic = "aperiodic",
        /// Energies, intervals and works repeat after some blows, beyond doubt.
        Periodic = "periodic",
    }
}

/// Fewest periodic blows whose kind of motion is judged.
const LEAST_BLOWS: usize = 4;
/// Standard errors beyond which a trend counts.
const SIGNIFICANT: f64 = 3.0;
/// Standard errors of the differences between blows that must fit below the agreement of a periodic percussion.
const SURE: f64 = 2.0;
/// Share of the mean square of the first half of the differences that the second half keeps at most where they die away.
const DYING: f64 = 0.25;
/// Parts of a series whose scatter is compared, fewest differences in each, and times the root of the number of blows that the
/// logarithm of the ratio of their squared differences may be: of series whose scatter stays, one in fifty is beyond it.
const PARTS: usize = 3;
/// See [`PARTS`].
const LEAST_PART: usize = 4;
/// See [`PARTS`].
const CHANGING: f64 = 18.0;
/// Least share of the mean energy against which works are compared: the work of a blow on a heavy casting may be near 0.
const LEAST_WORK_SHARE: f64 = 0.1;
/// Times the agreement of energies and intervals to which works repeat: they depend on the motion of the casting and the machine at the
/// blow, and settle later.
const WORK_AGREEMENT: f64 = 3.0;
/// Usual intervals of blows that the last third of the gated time must span for silence to mean something.
const DUE_INTERVALS: f64 = 2.0;

impl Percussion {
    /// Whether the hammer strikes its casting to the end of the run.
    pub fn strikes(self) -> bool {
        self >= Self::Unsettled
    }

    /// Whether its means have errors: it neither stops nor changes during the run.
    pub fn is_sure(self) -> bool {
        self >= Self::Aperiodic
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
    let series = StrokeFigure::all(&periodic);
    let agreement = settings.periodic_agreement;
    if periodic.len() < LEAST_BLOWS || series.iter().any(|figure| figure.drifts(agreement)) {
        return (Percussion::Unsettled, None);
    }
    let fits = |period: &usize| series.iter().all(|figure| figure.repeats(*period, agreement));
    match (1..=settings.longest_period_blows).find(fits) {
        Some(period) => (Percussion::Periodic, Some(period as u64)),
        None if series.iter().any(|figure| figure.changes(agreement)) => (Percussion::Unsettled, None),
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

/// A figure of the periodic blows, stroke by stroke.
struct StrokeFigure {
    strokes: Vec<Vec<f64>>,
    /// Size against which differences are judged: of energies and intervals their mean, of works a multiple of it.
    scale: f64,
}

impl StrokeFigure {
    /// Energies, intervals and works.
    fn all(blows: &[&Recorded]) -> [Self; 3] {
        let of = |values: &dyn Fn(&[&Recorded]) -> Vec<f64>| strokes(blows).map(values).collect::<Vec<Vec<f64>>>();
        let scale = |strokes: &[Vec<f64>]| mean(&strokes.concat()).unwrap_or_default().abs();
        let each = |value: fn(&Recorded) -> f64| {
            of(&|stroke: &[&Recorded]| stroke.iter().map(|recorded| value(recorded)).collect())
        };
        let (energies, durations) = (each(|recorded| recorded.blow.energy_j), of(&intervals));
        let works = each(|recorded| recorded.blow.work_j);
        let (energy, duration, work) = (scale(&energies), scale(&durations), scale(&works));
        [
            Self { strokes: energies, scale: energy },
            Self { strokes: durations, scale: duration },
            Self { strokes: works, scale: WORK_AGREEMENT * work.max(LEAST_WORK_SHARE * energy) },
        ]
    }

    /// Squared differences between values that are `lag` apart.
    fn squares(&self, lag: usize) -> Vec<f64> {
        let of = |values: &Vec<f64>| {
            values.iter().zip(values.iter().skip(lag)).map(|(a, b)| (b - a) * (b - a)).collect::<Vec<f64>>()
        };
        self.strokes.iter().flat_map(of).collect()
    }

    /// Whether values a period apart differ by no more than `agreement` in root mean square, beyond doubt: the standard errors of
    /// the mean square must fit below it too, unless the differences die away, which a scatter that stays does not.
    fn repeats(&self, period: usize, agreement: f64) -> bool {
        let squares = self.squares(period);
        let allowed = (agreement * self.scale).powi(2);
        let Some(square) = mean(&squares).filter(|square| squares.len() >= 2 && *square <= allowed) else {
            // One pair agrees by chance.
            return false;
        };
        let error = (variance(&squares).unwrap_or_default() / (squares.len() - 1) as f64).sqrt();
        let (early, late) = squares.split_at(squares.len() / 2);
        let [early, late] = [early, late].map(|half| mean(half).unwrap_or_default());
        square + SURE * error <= allowed || late <= DYING * early
    }

    /// Whether the longest stroke follows a line whose rise over the series is beyond `agreement` of the scale and beyond doubt.
    fn drifts(&self, agreement: f64) -> bool {
        let Some(longest) = self.strokes.iter().max_by_key(|stroke| stroke.len()) else { return false };
        let Line { rise, error } = Line::through(longest);
        rise.abs() > agreement * self.scale && rise.abs() > SIGNIFICANT * error
    }

    /// Whether the scatter of the longest stroke comes and goes: values that creep for a while and jump about for another have
    /// means over many runs, not over one of these.
    fn changes(&self, agreement: f64) -> bool {
        let Some(longest) = self.strokes.iter().max_by_key(|stroke| stroke.len()) else { return false };
        let squares: Vec<f64> = longest.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).collect();
        let length = squares.len() / PARTS;
        if length < LEAST_PART {
            return false;
        }
        let parts = (0..PARTS).filter_map(|part| mean(&squares[part * length..(part + 1) * length]));
        let (least, largest) = parts.fold((f64::INFINITY, 0.0_f64), |(a, b), part| (a.min(part), b.max(part)));
        let noticed = largest > (agreement * self.scale).powi(2);
        noticed && log(largest / least.max(f64::MIN_POSITIVE)) > CHANGING / (longest.len() as f64).sqrt()
    }
}

/// The line of least squares over a series.
struct Line {
    /// From the first value to the last.
    rise: f64,
    /// Standard error of the rise; the values about the line are correlated.
    error: f64,
}

impl Line {
    /// No rise for fewer than three values.
    fn through(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let Some(centre) = mean(values).filter(|_| values.len() >= 3) else {
            return Self { rise: 0.0, error: 0.0 };
        };
        let middle = 0.5 * (n - 1.0);
        let at = || values.iter().enumerate().map(|(i, value)| (i as f64 - middle, value - centre));
        let spread: f64 = at().map(|(x, _)| x * x).sum();
        let slope = at().map(|(x, y)| x * y).sum::<f64>() / spread;
        let rest: Vec<f64> = at().map(|(x, y)| y - slope * x).collect();
        let square: f64 = rest.iter().map(|rest| rest * rest).sum();
        let plain = (n - 1.0) * (square / (n - 2.0) / spread).sqrt();
        Self { rise: (n - 1.0) * slope, error: plain * correlation_time(&rest).max(1.0).sqrt() }
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
        Recorded { blow, gated_s: t, ..Recorded::default() }
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

    /// Works decide as well: energies and intervals that repeat do not make a percussion periodic whose works scatter. Works near 0
    /// are compared with a share of the energy.
    #[test]
    fn analytic_works_repeat_too() {
        let working = |work: &dyn Fn(usize) -> f64| {
            let mut blows = series(30, |_| 0.045, |_| 12.0);
            blows.iter_mut().enumerate().for_each(|(n, recorded)| recorded.blow.work_j = work(n));
            kind(&blows, 1.35)
        };
        let wave = |n: usize| (n as f64 * 2.399).sin();
        assert_eq!(working(&|_| 6.0), (Percussion::Periodic, Some(1)));
        assert_eq!(working(&|n| 6.0 + (n % 2) as f64), (Percussion::Periodic, Some(2)));
        assert_eq!(working(&|n| 6.0 * (1.0 + 0.06 * wave(n))), (Percussion::Aperiodic, None));
        assert_eq!(working(&|n| 0.004 * wave(n)), (Percussion::Periodic, Some(1)));
        assert_eq!(working(&|n| 6.0 + 0.05 * n as f64), (Percussion::Unsettled, None));
    }

    /// Just below the agreement a scatter that stays is not periodic, one that dies away is.
    #[test]
    fn analytic_periods_are_beyond_doubt() {
        let wave = |n: usize| (n as f64 * 2.399).sin();
        let scattered = |size: f64| kind(&series(30, |_| 0.045, |n| 12.0 * (1.0 + size * wave(n))), 1.35).0;
        // Three blows apart, where they are least, differences are 0.62 of the size in root mean square.
        let kinds = [0.003, 0.0148, 0.02].map(scattered);
        assert_eq!(kinds, [Percussion::Periodic, Percussion::Aperiodic, Percussion::Aperiodic]);
        let dying = |n: usize| 12.0 * (1.0 + 0.35 * wave(n) * (-(n as f64) / 2.0).exp());
        assert_eq!(kind(&series(30, |_| 0.045, dying), 1.35).0, Percussion::Periodic);
    }

    /// Blows that creep in the first two thirds and jump about in the last have not settled.
    #[test]
    fn analytic_scatter_that_comes_and_goes() {
        let wave = |n: usize| (n as f64 * 2.399).sin();
        let burst = |n: usize| 12.0 + if n < 20 { 0.02 } else { 2.0 } * wave(n);
        assert_eq!(kind(&series(30, |_| 0.045, burst), 1.35).0, Percussion::Unsettled);
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
