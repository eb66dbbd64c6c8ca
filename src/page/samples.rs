//! Signals as few bytes: whole steps, second differences, byte by byte, deflated.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

/// Steps from the least to the largest value of a signal.
const STEPS: f64 = 65_536.0;
/// Longest step of a position in m: values err by half of it.
const LONGEST_STEP_M: f64 = 1e-6;

/// Coding of a signal's numbers: `low + step * k`, `k` whole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Scale {
    pub low: f64,
    pub step: f64,
}

impl Scale {
    /// Returns the scale of values in `unit`: a 65536th of their range, for positions at most a micrometre. NaN and infinite values are
    /// ignored.
    fn of(values: &[f64], unit: &str) -> Self {
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        let step = (high - low) / STEPS;
        match step > 0.0 && step.is_finite() {
            true if unit == "m" => Self { low, step: step.min(LONGEST_STEP_M) },
            true => Self { low, step },
            // One value, or none.
            false => Self { low: if low.is_finite() { low } else { 0.0 }, step: 1.0 },
        }
    }
}

/// Signals and other numbers on their way into a page.
#[derive(Default)]
pub(super) struct Samples {
    bytes: Vec<u8>,
}

impl Samples {
    /// Adds a signal of `values` in `unit`: second differences of whole steps, the sign in the last bit, first all low bytes, then
    /// those above, four in all. Smooth signals have many zeros then.
    pub fn signal(&mut self, values: &[f64], unit: &str) -> Scale {
        let scale = Scale::of(values, unit);
        let (mut before, mut slope) = (0_i64, 0_i64);
        let words: Vec<u32> = (values.iter())
            .map(|value| {
                // A float that is cast saturates, NaN becomes 0.
                let steps = i64::from(((value - scale.low) / scale.step).round() as i32);
                let second = steps - before - slope;
                (slope, before) = (steps - before, steps);
                ((second << 1) ^ (second >> 63)) as u32
            })
            .collect();
        for byte in 0..4 {
            self.bytes.extend(words.iter().map(|word| word.to_le_bytes()[byte]));
        }
        scale
    }

    /// Adds numbers in single precision, at a multiple of four bytes; returns where they begin.
    pub fn numbers(&mut self, values: &[f64]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
        offset
    }

    /// All as a zlib stream, the same bytes on every machine.
    pub fn deflated(self) -> std::io::Result<Vec<u8>> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&self.bytes)?;
        encoder.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads a signal like the page's script.
    fn read(bytes: &[u8], scale: Scale) -> Vec<f64> {
        let count = bytes.len() / 4;
        let (mut before, mut slope) = (0_i64, 0_i64);
        (0..count)
            .map(|k| {
                let word = u32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[byte * count + k]));
                let second = i64::from(word >> 1) ^ -i64::from(word & 1);
                slope += second;
                before += slope;
                scale.low + scale.step * before as f64
            })
            .collect()
    }

    #[test]
    fn signals_err_by_half_a_step_at_most() {
        let wave = |k: usize| 0.13 * (k as f64 * 0.01).sin() + if k.is_multiple_of(97) { 0.05 } else { 0.0 };
        let values: Vec<f64> = (0..5000).map(wave).collect();
        for (unit, most) in [("m", 5.001e-7), ("N", 0.31 / 65_536.0 / 2.0 * 1.2)] {
            let mut samples = Samples::default();
            let scale = samples.signal(&values, unit);
            let worst =
                (read(&samples.bytes, scale).iter().zip(&values)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst <= most && worst > 0.5 * most, "{unit}: {worst}");
        }
        let mut samples = Samples::default();
        let scale = samples.signal(&[2.5; 7], "N");
        assert_eq!(read(&samples.bytes, scale), [2.5; 7]);
    }

    #[test]
    fn smooth_signals_take_few_bytes() {
        let values: Vec<f64> = (0..75_000).map(|k| 0.1 * (k as f64 * 2e-5 * 140.0).sin()).collect();
        let mut samples = Samples::default();
        samples.signal(&values, "m");
        let bytes = samples.deflated().expect("deflated").len();
        assert!(bytes < 75_000 / 4, "{bytes} bytes");
    }
}
