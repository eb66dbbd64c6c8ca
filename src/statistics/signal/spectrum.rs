//! Amplitudes of the frequencies in a part of a signal.

use super::transform::RealTransform;

/// Amplitude spectrum of a real signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Distance between two lines in Hz: one over the signal's length.
    pub resolution_hz: f64,
    /// Amplitude of each line in the signal's unit, from 0 Hz on up to half the sampling rate.
    pub amplitudes: Vec<f64>,
}

impl Spectrum {
    /// The spectrum of `n` samples `x_j`, one every `interval_s`, as they are (a rectangular window):
    /// `A_k = w |sum_j x_j exp(-2 pi i j k / n)| / n`, `w = 2` but for the mean (`k = 0`) and half the sampling rate, where it is 1.
    /// A sine of amplitude `a` that fits the length a whole number of times has one line, of height `a`.
    ///
    /// The transform is the portable one, the same on every processor.
    pub fn of(values: &[f64], interval_s: f64) -> Self {
        let n = values.len();
        if n == 0 {
            return Self { resolution_hz: 0.0, amplitudes: Vec::new() };
        }
        let weight = |line: usize| if line == 0 || 2 * line == n { 1.0 } else { 2.0 };
        let lines = RealTransform::of(n).lines(values.iter().copied());
        Self {
            resolution_hz: 1.0 / (n as f64 * interval_s),
            amplitudes: (0..).zip(lines).map(|(line, value)| weight(line) * value.norm() / n as f64).collect(),
        }
    }

    /// The lines up to `most_hz`.
    pub fn up_to(&self, most_hz: f64) -> &[f64] {
        let lines = (most_hz / self.resolution_hz + 1e-9).floor().max(0.0) as usize + 1;
        &self.amplitudes[..lines.min(self.amplitudes.len())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Lines that fit the length have their amplitudes, all others are zero; of even, odd and prime lengths.
    #[test]
    fn analytic_lines() {
        for n in [7919_usize, 7500, 75_000, 1125] {
            let lines = [(0_usize, -0.7), (3, 1.25), (22, 0.013), (n / 3, 2.0)];
            let sample = |j: usize| -> f64 {
                let part =
                    |(line, a): &(usize, f64)| a * (TAU * (j * line % n) as f64 / n as f64 + 0.4 * *line as f64).cos();
                lines.iter().map(part).sum()
            };
            let values: Vec<f64> = (0..n).map(sample).collect();
            let spectrum = Spectrum::of(&values, 2e-5);
            assert!((spectrum.resolution_hz * n as f64 * 2e-5 - 1.0).abs() < 1e-14);
            assert_eq!(spectrum.amplitudes.len(), n / 2 + 1);
            for (line, amplitude) in spectrum.amplitudes.iter().enumerate() {
                let known = lines.iter().find(|(at, _)| *at == line).map_or(0.0, |(_, a): &(usize, f64)| a.abs());
                assert!((amplitude - known).abs() < 1e-10, "{n} samples, line {line}: {amplitude}, not {known}");
            }
        }
        // Half the sampling rate is a line of its own.
        let highest: Vec<f64> = (0..8).map(|j| if j % 2 == 0 { 0.5 } else { -0.5 }).collect();
        let spectrum = Spectrum::of(&highest, 0.125);
        assert!((spectrum.amplitudes[4] - 0.5).abs() < 1e-15);
        assert_eq!((spectrum.up_to(2.0).len(), spectrum.up_to(9.0).len()), (3, 5));
    }
}
