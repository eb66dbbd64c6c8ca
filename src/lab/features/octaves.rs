//! Root mean squares in the octave bands of IEC 61260-1, base ten.

use std::f64::consts::PI;

use decore_statistics::signal::Spectrum;

/// Nominal midband frequencies in Hz, from the band with the exact one of `1000 G^-5` Hz up.
const NOMINAL_HZ: [f64; 10] = [31.5, 63.0, 125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 16_000.0];
/// Number of bands.
pub(super) const BANDS: usize = NOMINAL_HZ.len();
/// Place of the band around 1000 Hz.
const REFERENCE: f64 = 5.0;
/// Fewest spectral lines of a band.
pub(super) const LEAST_LINES: usize = 10;
/// Upper edge of the highest band, over half the sampling rate: there the means have 0.76 of the amplitude.
pub(super) const HIGHEST: f64 = 0.8;

/// An octave band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Octave {
    /// Nominal midband frequency in Hz.
    pub nominal_hz: f64,
    /// Exponents of the octave ratio `G = 10^0.3` at its edges, `1000 G^x` Hz.
    pub edges: [f64; 2],
}

impl Octave {
    /// All bands, by frequency.
    pub fn all() -> [Self; BANDS] {
        std::array::from_fn(|place| {
            let middle = place as f64 - REFERENCE;
            Self { nominal_hz: NOMINAL_HZ[place], edges: [middle - 0.5, middle + 0.5] }
        })
    }

    /// Edges in Hz. No line of a spectrum lies on an edge if its resolution is a ratio of whole numbers.
    pub fn edges_hz(self) -> [f64; 2] {
        self.edges.map(|exponent| libm::pow(10.0, 3.0 + 0.3 * exponent))
    }

    /// Root mean square of a signal within the band, from the spectrum of its means over `interval_s`, one every `interval_s`: by
    /// Parseval's theorem the root of the sum of `a^2 / 2` over the lines, `a` being a line's amplitude over the gain
    /// `sin(pi f T) / (pi f T)` of the means. `None` beyond 0.8 of half the sampling rate and for fewer than ten lines.
    pub fn rms(self, spectrum: &Spectrum, interval_s: f64) -> Option<f64> {
        let [low_hz, high_hz] = self.edges_hz();
        if high_hz > HIGHEST * 0.5 / interval_s {
            return None;
        }
        let [first, end] = [low_hz, high_hz].map(|edge| (edge / spectrum.resolution_hz).ceil() as usize);
        let lines = spectrum.amplitudes.get(first..end).filter(|lines| lines.len() >= LEAST_LINES)?;
        let power = |(line, amplitude): (usize, &f64)| {
            let angle = PI * line as f64 * spectrum.resolution_hz * interval_s;
            let corrected = amplitude * angle / libm::sin(angle);
            0.5 * corrected * corrected
        };
        Some((first..end).zip(lines).map(power).sum::<f64>().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The edges that IEC 61260-1 prints for the bands around 31.5 and 1000 Hz, and no gap between bands.
    #[test]
    fn bands_are_those_of_the_standard() {
        let bands = Octave::all();
        let [first, thousand] = [bands[0], bands[5]].map(Octave::edges_hz);
        for (found, printed) in first.into_iter().chain(thousand).zip([22.387, 44.668, 707.95, 1412.5]) {
            assert!((found / printed - 1.0).abs() < 5e-5, "{found}, not {printed}");
        }
        for band in bands {
            let [low, high] = band.edges_hz();
            let exact = (low * high).sqrt();
            assert!((exact / band.nominal_hz - 1.0).abs() < 0.02, "{exact} Hz is not around {}", band.nominal_hz);
        }
        assert!(bands.windows(2).all(|pair| pair[0].edges_hz()[1] == pair[1].edges_hz()[0]));
    }

    /// Of means over intervals of sines that fit the length, each band has the root mean square of its sine before the means.
    #[test]
    fn a_sine_has_its_root_mean_square() {
        let (interval_s, n) = (1e-3, 1000_usize);
        let sines = [(32_usize, 0.3), (61, 0.02), (125, 1.7), (354, 0.5)];
        let sample = |k: usize| -> f64 {
            let mean = |(hz, amplitude): &(usize, f64)| {
                let angle = PI * *hz as f64 * interval_s;
                amplitude * angle.sin() / angle * (2.0 * PI * (hz * k % n) as f64 / n as f64).cos()
            };
            4.0 + sines.iter().map(mean).sum::<f64>()
        };
        let values: Vec<f64> = (0..n).map(sample).collect();
        let spectrum = Spectrum::of(&values, interval_s);
        let found = Octave::all().map(|band| band.rms(&spectrum, interval_s));
        for ((_, amplitude), found) in sines.iter().zip(found) {
            let (found, expected) = (found.expect("resolved"), amplitude / 2.0_f64.sqrt());
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
        // The next one ends at 708 Hz, beyond 400 Hz.
        assert_eq!(found[4..], [None; 6]);
        // The lowest is 22.28 Hz wide: of 0.46 s it has ten lines, of 0.4 s eight.
        let of = |n: usize| Octave::all()[0].rms(&Spectrum::of(&values[..n], interval_s), interval_s);
        assert!(of(460).is_some() && of(400).is_none());
    }
}
