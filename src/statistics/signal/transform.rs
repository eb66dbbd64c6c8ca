//! Discrete Fourier transform with the algorithms of rustfft that signals need.
//!
//! The library's planner chooses among all its algorithms. They are generic, so all would be compiled here, only to transform lengths with
//! factors of 7 to 31 or some large primes faster than Bluestein's algorithm.

use std::f64::consts::TAU;
use std::sync::Arc;

use rustfft::algorithm::butterflies::{Butterfly3, Butterfly5};
use rustfft::algorithm::{BluesteinsAlgorithm, MixedRadix, Radix4};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

const DIRECTION: FftDirection = FftDirection::Forward;

/// The transform `X_k = sum_j x_j exp(-2 pi i j k / n)` of signals of `n` samples.
pub(super) struct Transform(Arc<dyn Fft<f64>>);

impl Transform {
    /// Plan for this number of samples, at least 1.
    pub fn of(samples: usize) -> Self {
        let twos = samples.trailing_zeros();
        let mut transform: Arc<dyn Fft<f64>> = Arc::new(Radix4::new(1 << twos, DIRECTION));
        let mut left = samples >> twos;
        let small: [Arc<dyn Fft<f64>>; 2] =
            [Arc::new(Butterfly3::new(DIRECTION)), Arc::new(Butterfly5::new(DIRECTION))];
        for factor in small {
            while left.is_multiple_of(factor.len()) {
                left /= factor.len();
                transform = Arc::new(MixedRadix::new(factor.clone(), transform));
            }
        }
        if left == 1 {
            return Self(transform);
        }
        // Of no factors but 2, and 3 once where that is shorter.
        let least = 2 * samples - 1;
        let (twos, three) = (least.next_power_of_two(), 3 * least.div_ceil(3).next_power_of_two());
        Self(Arc::new(BluesteinsAlgorithm::new(samples, Self::of(twos.min(three)).0)))
    }

    /// Transforms `n` numbers.
    pub fn run(&self, mut values: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
        self.0.process(&mut values);
        values
    }
}

/// The same of real samples: lines from 0 Hz up to half the sampling rate, of which those above are the conjugates.
pub(super) struct RealTransform {
    samples: usize,
    /// Of as many samples; where their number is even, of pairs of them as complex numbers.
    transform: Transform,
}

impl RealTransform {
    /// Plan for this number of samples, at least 1.
    pub fn of(samples: usize) -> Self {
        let length = if samples.is_multiple_of(2) { samples / 2 } else { samples };
        Self { samples, transform: Transform::of(length) }
    }

    /// Transforms `n` samples into `n / 2 + 1` lines.
    ///
    /// With `Z` the transform of `x_2j + i x_(2j + 1)` and `m = n / 2`: `(Z_k + Z_(m-k)*) / 2` is that of the even samples,
    /// `(Z_k - Z_(m-k)*) / 2i` that of the odd ones, which come half a turn of line `m` later.
    pub fn lines(&self, samples: impl Iterator<Item = f64>) -> Vec<Complex<f64>> {
        let (n, mut samples) = (self.samples, samples);
        if !n.is_multiple_of(2) {
            let mut lines = self.transform.run(samples.map(Complex::from).collect());
            lines.truncate(n / 2 + 1);
            return lines;
        }
        let pairs = std::iter::from_fn(|| Some(Complex::new(samples.next()?, samples.next()?)));
        let pairs = self.transform.run(pairs.collect());
        let line = |k: usize| {
            let (own, mirrored) = (pairs[k % pairs.len()], pairs[(pairs.len() - k) % pairs.len()].conj());
            let turn: Complex<f64> = Complex::cis(-TAU * k as f64 / n as f64);
            0.5 * ((own + mirrored) - Complex::<f64>::I * turn * (own - mirrored))
        };
        (0..=pairs.len()).map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every length up to 200, and longer ones of each kind, against the sum itself.
    #[test]
    fn analytic_sums() {
        for n in (1..=200).chain([512, 625, 720, 729, 997, 1125, 1344]) {
            let values: Vec<Complex<f64>> =
                (0..n).map(|j| Complex::new((0.7 * j as f64).sin(), (j % 5) as f64)).collect();
            let turn = |j: usize, k: usize| Complex::cis(-TAU * (j * k % n) as f64 / n as f64);
            for (k, line) in Transform::of(n).run(values.clone()).into_iter().enumerate() {
                let sum: Complex<f64> = values.iter().enumerate().map(|(j, value)| value * turn(j, k)).sum();
                assert!((line - sum).norm() < 1e-13 * n as f64, "{n} samples, line {k}: {line}, not {sum}");
            }
            let lines = RealTransform::of(n).lines(values.iter().map(|value| value.re));
            assert_eq!(lines.len(), n / 2 + 1);
            for (k, line) in lines.into_iter().enumerate() {
                let sum: Complex<f64> = values.iter().enumerate().map(|(j, value)| value.re * turn(j, k)).sum();
                assert!((line - sum).norm() < 1e-13 * n as f64, "{n} real samples, line {k}: {line}, not {sum}");
            }
        }
    }
}
