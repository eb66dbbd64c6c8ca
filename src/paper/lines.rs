//! Lines of the arm's spectrum by window and span of time.

use std::f64::consts::TAU;

use super::error::PaperError;
use super::quoted::{ARM_DOMINANT_HZ, SHIFTED_BELOW_HZ};
use decore_statistics::signal::{Spectrum, dominant_frequency_hz};

/// Distance in Hz within which a line counts as the one looked for.
const NEAR_HZ: f64 = 1.5;

/// Window of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Window {
    /// The signal as it is.
    Rectangular,
    /// `1 - cos` over the span, scaled so that a line keeps its height.
    Hann,
}

impl Window {
    pub const ALL: [Self; 2] = [Self::Rectangular, Self::Hann];

    pub fn name(self) -> &'static str {
        match self {
            Self::Rectangular => "rectangular",
            Self::Hann => "Hann",
        }
    }

    fn applied(self, values: &[f64]) -> Vec<f64> {
        let weight = |index: usize| match self {
            Self::Rectangular => 1.0,
            Self::Hann => 1.0 - (TAU * index as f64 / values.len() as f64).cos(),
        };
        values.iter().enumerate().map(|(index, value)| weight(index) * value).collect()
    }
}

/// Lines of the arm's velocity over a span of time.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArmLines {
    pub window: Window,
    /// Begin and end of the span from the start of the simulation, s.
    pub span_s: [f64; 2],
    /// Frequency of the highest line above those that the paper sets apart, Hz.
    pub strongest_hz: f64,
    /// Amplitude at the frequency of the blows, m/s.
    pub at_blows_m_s: f64,
    /// Amplitude at the frequency that dominates the paper's calculation, m/s.
    pub at_dominant_m_s: f64,
}

impl ArmLines {
    /// Lines of `values`, one every `interval_s` over `span_s`, of a hammer that strikes at `blows_hz`.
    pub fn of(window: Window, span_s: [f64; 2], values: (&[f64], f64), blows_hz: f64) -> Result<Self, PaperError> {
        let (values, interval_s) = values;
        let Spectrum { resolution_hz, mut amplitudes } = Spectrum::of(&window.applied(values), interval_s);
        let [at_blows_m_s, at_dominant_m_s] = [blows_hz, ARM_DOMINANT_HZ[0]].map(|wanted_hz| {
            let lines = amplitudes.iter().enumerate();
            let near = lines.filter(|(line, _)| (*line as f64 * resolution_hz - wanted_hz).abs() <= NEAR_HZ);
            near.map(|(_, amplitude)| *amplitude).fold(0.0, f64::max)
        });
        let apart = amplitudes.iter_mut().enumerate();
        let apart = apart.filter(|(line, _)| *line as f64 * resolution_hz < SHIFTED_BELOW_HZ);
        apart.for_each(|(_, amplitude)| *amplitude = 0.0);
        let strongest_hz =
            dominant_frequency_hz(&amplitudes, resolution_hz).ok_or(PaperError::Missing("vibration of the arm"))?;
        Ok(Self { window, span_s, strongest_hz, at_blows_m_s, at_dominant_m_s })
    }

    /// Height of the blows' line over that of the paper's strongest one.
    pub fn ratio(&self) -> f64 {
        self.at_blows_m_s / self.at_dominant_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lines keep their heights under either window; one that fades loses by the Hann window, which is zero at the beginning.
    #[test]
    fn analytic_heights() {
        let sample = |index: usize, fading: f64| {
            let t = 1e-3 * index as f64;
            0.3 * (TAU * 22.0 * t).sin() + 0.2 * (-fading * t).exp() * (TAU * 44.0 * t).cos()
        };
        for window in Window::ALL {
            let values: Vec<f64> = (0..2000).map(|index| sample(index, 0.0)).collect();
            let lines = ArmLines::of(window, [0.0, 2.0], (&values, 1e-3), 22.0).expect("lines");
            assert!((lines.at_blows_m_s - 0.3).abs() < 1e-9 && (lines.at_dominant_m_s - 0.2).abs() < 1e-9, "{lines:?}");
            assert!((lines.strongest_hz - 22.0).abs() < 1e-9);
        }
        let values: Vec<f64> = (0..2000).map(|index| sample(index, 5.0)).collect();
        let [as_is, hann] = Window::ALL
            .map(|window| ArmLines::of(window, [0.0, 2.0], (&values, 1e-3), 22.0).expect("lines").at_dominant_m_s);
        assert!(hann < 0.5 * as_is, "{hann} and {as_is}");
    }
}
