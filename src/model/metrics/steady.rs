//! Figures over the intervals from one periodic blow to the next: frequency, steady motion of the mount, delivered work, each
//! with its error.

use std::f64::consts::TAU;

use libm::exp;

use super::blow::Recorded;
use super::percussion::strokes;
use super::statistics::{LEAST_VALUES, error_of_mean, mean};
use decore_math::special::normal_cdf;

/// Time constants of the slowest mode of the mount after which a stroke's impact counts as decayed: the energy of that mode has fallen
/// to `exp(-5)`, 0.7 %, the energy of faster modes further.
const DECAYS: f64 = 5.0;
/// Time constants of that mode over which the motion must be seen for an error.
const MEMORY: f64 = 3.0;
/// Most blows by which the number of blows within a run may be uncertain.
const MOST_BLOWS: f64 = 1000.0;
/// Standard deviations of the time of the last blow that are looked at.
const REACH: f64 = 6.0;

/// Time from one periodic blow to the next of the same stroke.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    pub start_s: f64,
    pub stroke: usize,
    pub duration_s: f64,
    /// Integral of the mount's squared velocity, m2/s.
    pub arm_integral: f64,
    /// Work on the hammer's casting, J.
    pub work_j: f64,
    /// Work of all hammers, J.
    pub run_work_j: f64,
}

/// The intervals between periodic blows.
pub(super) fn intervals(periodic: &[&Recorded]) -> Vec<Interval> {
    let between = |pair: &[&Recorded]| Interval {
        start_s: pair[0].blow.start_time_s,
        stroke: pair[0].blow.stroke,
        duration_s: pair[1].blow.start_time_s - pair[0].blow.start_time_s,
        arm_integral: pair[1].arm_integral - pair[0].arm_integral,
        work_j: pair[1].work_before_j - pair[0].work_before_j,
        run_work_j: pair[1].run_work_before_j - pair[0].run_work_before_j,
    };
    strokes(periodic).flat_map(|stroke| stroke.windows(2).map(between).collect::<Vec<_>>()).collect()
}

/// A figure and its error; see [`error_of_mean`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sure {
    pub value: Option<f64>,
    pub error: Option<f64>,
}

/// Intervals over their time, in Hz.
pub(super) fn frequency(intervals: &[Interval]) -> Sure {
    let durations: Vec<f64> = intervals.iter().map(|interval| interval.duration_s).collect();
    let value = mean(&durations).filter(|mean| *mean > 0.0).map(f64::recip);
    Sure { value, error: error_of_mean(&durations).zip(value).map(|(error, value)| error * value * value) }
}

/// Root mean square of the mount's velocity over the intervals that begin when the impact of their stroke has decayed.
///
/// `impacts`: start of each stroke's impact, s. `decay_per_s`: rate at which the energy of the slowest mode decays that moves the
/// mount. No value with fewer than [`LEAST_VALUES`] intervals, no error over less than [`MEMORY`] time constants: batches of blows that
/// one and the same vibration outlives are not independent.
pub(super) fn arm(intervals: &[Interval], impacts: &[(usize, f64)], decay_per_s: f64) -> Sure {
    let impact_s = |stroke: usize| impacts.iter().find(|impact| impact.0 == stroke).map_or(0.0, |impact| impact.1);
    let decayed = |interval: &&Interval| (interval.start_s - impact_s(interval.stroke)) * decay_per_s >= DECAYS;
    let steady: Vec<&Interval> = intervals.iter().filter(decayed).collect();
    if steady.len() < LEAST_VALUES {
        return Sure::default();
    }
    let sum = |of: fn(&Interval) -> f64| steady.iter().map(|interval| of(interval)).sum::<f64>();
    let span_s = sum(|interval| interval.duration_s);
    let square = sum(|interval| interval.arm_integral).max(0.0) / span_s;
    // The error of a ratio of two sums is that of the mean of what each interval deviates from it.
    let deviations = steady.iter().map(|interval| interval.arm_integral - square * interval.duration_s);
    let deviations: Vec<f64> = deviations.map(|deviation| deviation * steady.len() as f64 / span_s).collect();
    let value = square.sqrt();
    let error = error_of_mean(&deviations).filter(|_| span_s * decay_per_s >= MEMORY);
    Sure { value: Some(value), error: error.map(|error| if value > 0.0 { 0.5 * error / value } else { 0.0 }) }
}

/// Time of the percussion that a run shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShownTime {
    /// From the first periodic blow to the end of each stroke, summed, s.
    pub span_s: f64,
    /// From the last periodic blow to the end, s.
    pub since_last_s: f64,
}

/// Standard error of the work delivered over a run, by the works of its intervals: mean +- 2 errors over runs that differ by
/// chance.
///
/// A run holds `K` blows of the works `w_i`. Works and intervals vary over the series; the time at which the last blow falls varies
/// by the sum of the intervals, and with it `K`, by nothing where the end of the run is far from a blow, by one where it is near.
/// `var(sum w) = var(A) + w^2 var(K) + 2 w cov(A, K)` with `A` the sum of the deviations of the works, all normally distributed.
pub(super) fn delivered(intervals: &[Interval], work: fn(&Interval) -> f64, shown: ShownTime) -> Option<f64> {
    let works: Vec<f64> = intervals.iter().map(work).collect();
    let durations: Vec<f64> = intervals.iter().map(|interval| interval.duration_s).collect();
    let (work_j, duration_s) = (mean(&works)?, mean(&durations).filter(|mean| *mean > 0.0)?);
    let blows = shown.span_s / duration_s;
    let of_works = error_of_mean(&works)?.powi(2) * blows * works.len() as f64;
    let of_times = error_of_mean(&durations)?.powi(2) * blows * works.len() as f64;
    let count = Count::of(of_times.sqrt() / duration_s, shown.since_last_s / duration_s);
    // Longer intervals make fewer blows.
    let with_times = -correlation(&works, &durations) * of_works.sqrt() * count.with_time;
    let square = of_works + work_j * work_j * count.variance + 2.0 * work_j * with_times;
    Some(square.max(0.0).sqrt())
}

/// The uncertain number of blows within a run.
struct Count {
    variance: f64,
    /// Covariance of the number with an earlier last blow, over the deviation of that blow's time.
    with_time: f64,
}

impl Count {
    /// `deviation`: standard deviation of the time of the last blow; `since`: time from that blow to the end; both in intervals.
    fn of(deviation: f64, since: f64) -> Self {
        if deviation <= 0.0 {
            return Self { variance: 0.0, with_time: 0.0 };
        }
        let reach = (REACH * deviation).min(MOST_BLOWS).ceil() as i64 + 1;
        // The count grows by `k` where the last blow is earlier by `k - since` to `k + 1 - since`.
        let [mut sum, mut square, mut with_time] = [0.0; 3];
        for blows in -reach..=reach {
            let (low, high) = ((blows as f64 - since) / deviation, (blows as f64 + 1.0 - since) / deviation);
            let probability = normal_cdf(high) - normal_cdf(low);
            sum += blows as f64 * probability;
            square += (blows * blows) as f64 * probability;
            with_time += blows as f64 * (density(low) - density(high));
        }
        Self { variance: (square - sum * sum).max(0.0), with_time }
    }
}

/// Correlation of the sums of two series, by the errors of the sum and the difference of both, each over its deviation.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let scaled = |values: &[f64]| -> Option<Vec<f64>> {
        let error = error_of_mean(values).filter(|error| *error > 0.0)?;
        Some(values.iter().map(|value| value / error).collect())
    };
    let Some((a, b)) = scaled(a).zip(scaled(b)) else { return 0.0 };
    let error = |sign: f64| {
        let values: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + sign * b).collect();
        error_of_mean(&values).unwrap_or_default().powi(2)
    };
    (0.25 * (error(1.0) - error(-1.0))).clamp(-1.0, 1.0)
}

/// Density of the standard normal distribution.
fn density(z: f64) -> f64 {
    exp(-0.5 * z * z) / TAU.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform numbers from -1/2 to 1/2.
    fn noise(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    /// Intervals of 45 ms that scatter by `jitter`, works of 6 J by 0.6 J, up to `end_s`: they, the work, and the time since the
    /// last blow.
    fn run(seed: u64, jitter: f64, end_s: f64) -> (Vec<Interval>, f64, f64) {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let (mut intervals, mut start_s, mut total_j) = (Vec::new(), 0.0, 0.0);
        loop {
            let (duration_s, work_j) = (0.045 * (1.0 + jitter * noise(&mut state)), 6.0 + 0.6 * noise(&mut state));
            total_j += work_j;
            if start_s + duration_s > end_s {
                return (intervals, total_j, end_s - start_s);
            }
            let arm_integral = 1e-5 * duration_s * (1.0 + noise(&mut state));
            intervals.push(Interval { start_s, stroke: 0, duration_s, arm_integral, work_j, run_work_j: work_j });
            start_s += duration_s;
        }
    }

    /// Two errors of the delivered work hold the mean over all runs in 95 % of them, whether the end of the run is near a blow
    /// (the number of blows differs by one) or between two; the stated error is near the deviation from run to run.
    #[test]
    fn analytic_delivered_work() {
        for (jitter, end_s) in [(0.02, 1.35), (0.02, 1.37), (0.2, 1.35), (0.2, 5.4)] {
            let runs: Vec<(Vec<Interval>, f64, f64)> = (1..=800).map(|seed| run(seed, jitter, end_s)).collect();
            let truth = runs.iter().map(|run| run.1).sum::<f64>() / 800.0;
            let deviation = (runs.iter().map(|run| (run.1 - truth).powi(2)).sum::<f64>() / 799.0).sqrt();
            let error = |run: &(Vec<Interval>, f64, f64)| {
                let shown = ShownTime { span_s: end_s, since_last_s: run.2 };
                delivered(&run.0, |interval| interval.work_j, shown).unwrap()
            };
            let held = runs.iter().filter(|run| (run.1 - truth).abs() <= 2.0 * error(run)).count() as f64 / 800.0;
            let stated = runs.iter().map(error).sum::<f64>() / 800.0 / deviation;
            println!("jitter {jitter}, end {end_s} s: held {held}, stated over true {stated}");
            assert!(
                (0.92..=1.0).contains(&held) && (0.8..1.7).contains(&stated),
                "{jitter}, {end_s}: {held}, {stated}"
            );
        }
    }

    /// The mount's figure starts five time constants after the impact; without intervals enough behind it there is none.
    #[test]
    fn analytic_arm() {
        let (mut intervals, ..) = run(1, 0.0, 4.0);
        for interval in &mut intervals {
            let decayed = exp(-4.0 * interval.start_s);
            interval.arm_integral = 1e-4 * interval.duration_s * (1.0 + 0.5 * decayed);
        }
        let found = arm(&intervals, &[(0, 0.0)], 4.0);
        let (value, error) = (found.value.unwrap(), found.error.unwrap());
        assert!((value / 1e-2 - 1.0).abs() < 5e-4 && error < 1e-4 && error > 0.0, "{value} {error}");
        let short = arm(&intervals[..40], &[(0, 0.0)], 4.0);
        assert!(short.value.is_some() && short.error.is_none());
        assert_eq!(arm(&intervals[..28], &[(0, 0.0)], 4.0), Sure::default());
        assert_eq!(arm(&intervals, &[(0, 0.0)], 0.0), Sure::default());
        // Another stroke begins anew.
        intervals.iter_mut().skip(28).for_each(|interval| interval.stroke = 1);
        assert_eq!(arm(&intervals, &[(0, 0.0), (1, 3.4)], 4.0), Sure::default());
    }

    /// A frequency's relative error is that of the mean interval.
    #[test]
    fn analytic_frequency() {
        let found = frequency(&run(3, 0.1, 9.0).0);
        let (value, error) = (found.value.unwrap(), found.error.unwrap());
        let expected = 0.1 / 12.0_f64.sqrt() / 200.0_f64.sqrt();
        assert!((value * 0.045 - 1.0).abs() < 4.0 * expected && (0.6..2.0).contains(&(error / value / expected)));
        assert_eq!(frequency(&[]), Sure::default());
    }
}
