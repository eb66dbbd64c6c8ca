//! Chosen signals averaged over intervals: what is kept of a long run.

use super::signals::SignalRecorder;
use crate::integrate::{Observer, Step};
use crate::scene::Scene;
use crate::system::{Coupled, CoupledModel};

/// Longest interval in s between the instants at which signals are read: short contacts last some 1e-4 s.
const FINEST_S: f64 = 2e-5;

/// Which signals are averaged, and over what.
#[derive(Debug, Clone, PartialEq)]
pub struct MeanSettings {
    /// Interval of the means in s, positive.
    pub interval_s: f64,
    /// The signals, by their places in [`signal_list`](super::signal_list).
    pub signals: Vec<usize>,
}

impl MeanSettings {
    /// Instants per interval at which signals are read: even, and no further than 2e-5 s apart.
    pub fn instants(&self) -> usize {
        2 * ((self.interval_s / (2.0 * FINEST_S)).ceil() as usize).max(1)
    }
}

/// Records means of signals: the value at `k interval_s` is the mean from half an interval before it to half an interval after it,
/// by the trapezoidal rule over [`MeanSettings::instants`]; at both ends of the run that of the half that lies within.
///
/// The mean is a filter without phase. Its gain at the frequency f is `sin(pi f T) / (pi f T)` with the interval T: 0.64 at half the
/// sampling rate, 0 at multiples of the rate; the mean of a force times the interval is its impulse. Memory: the means, and one
/// interval of the signals.
pub struct MeanRecorder {
    settings: MeanSettings,
    inner: SignalRecorder,
    /// Index of the first instant that is held, and of the next mean.
    first: usize,
    next: usize,
    /// Time and means, instant by instant.
    means: Vec<Vec<f64>>,
}

impl MeanRecorder {
    /// Prepares the recording of `scene`, from which `model` was built.
    pub fn new(model: &CoupledModel, scene: &Scene, settings: MeanSettings) -> Self {
        let interval_s = settings.interval_s / settings.instants() as f64;
        // Time is the first signal.
        let kept = |signal| signal == 0 || settings.signals.contains(&signal);
        let inner = SignalRecorder::of(model, scene, interval_s, kept);
        Self { settings, inner, first: 0, next: 0, means: Vec::new() }
    }

    /// Time in s and the means, instant by instant, in the order of the settings.
    pub fn into_means(mut self) -> Vec<Vec<f64>> {
        self.take(true);
        self.means
    }

    /// Takes the means whose intervals are over; `ended`: also those that the end of the run cuts.
    fn take(&mut self, ended: bool) {
        let per = self.settings.instants();
        let held = self.first + self.inner.recorded(0).len();
        loop {
            let centre = self.next * per;
            let end = if ended { (centre + per / 2 + 1).min(held) } else { centre + per / 2 + 1 };
            if centre >= held || end > held {
                break;
            }
            let begin = centre.saturating_sub(per / 2);
            let (from, to) = (begin - self.first, end - self.first);
            let mean = |signal: &usize| mean(self.inner.recorded(*signal).get(from..to).unwrap_or(&[]));
            let time_s = self.next as f64 * self.settings.interval_s;
            self.means.push([time_s].into_iter().chain(self.settings.signals.iter().map(mean)).collect());
            self.next += 1;
            // The last instant of an interval is the first one of the next.
            self.inner.forget(end - 1 - self.first);
            self.first = end - 1;
        }
    }
}

/// Mean of values at equal distances, by the trapezoidal rule; that of one value is itself.
fn mean(values: &[f64]) -> f64 {
    match values {
        [] => f64::NAN,
        [only] => *only,
        [first, inner @ .., last] => (0.5 * (first + last) + inner.iter().sum::<f64>()) / (values.len() - 1) as f64,
    }
}

impl Observer<Coupled> for MeanRecorder {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        self.inner.step(system, step);
        self.take(false);
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

#[cfg(test)]
mod tests {
    use super::{MeanSettings, mean};

    #[test]
    fn instants_are_even_and_near_enough() {
        let instants = |interval_s: f64| MeanSettings { interval_s, signals: Vec::new() }.instants();
        assert_eq!([1e-3, 1e-4, 3e-5, 1e-6].map(instants), [50, 6, 2, 2]);
    }

    /// The integral of a line is exact, and that of a sine has the gain of the filter.
    #[test]
    fn means_are_integrals() {
        assert_eq!(mean(&[1.0, 2.0, 3.0, 4.0, 5.0]), 3.0);
        assert_eq!((mean(&[7.0]), mean(&[1.0, 2.0])), (7.0, 1.5));
        // A cosine around its top, at a quarter of the sampling rate.
        let turn = std::f64::consts::FRAC_PI_4;
        let values: Vec<f64> = (-500..=500).map(|place| (turn * f64::from(place) / 500.0).cos()).collect();
        assert!((mean(&values) - turn.sin() / turn).abs() < 1e-6);
    }
}
