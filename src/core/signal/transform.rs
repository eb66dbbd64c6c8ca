//! The discrete Fourier transform, from those of rustfft's algorithms that signals need.
//!
//! Its planner chooses among all it has, and as they are generic all would be compiled into this package: a seventh of its code, to
//! transform lengths with factors of 7 to 31 or large primes faster than Bluestein's algorithm does.

use std::sync::Arc;

use rustfft::algorithm::butterflies::{Butterfly3, Butterfly5};
use rustfft::algorithm::{BluesteinsAlgorithm, MixedRadix, Radix4};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

const DIRECTION: FftDirection = FftDirection::Forward;

/// The transform `X_k = sum_j x_j exp(-2 pi i j k / n)` of signals of `n` samples.
pub(super) struct Transform(Arc<dyn Fft<f64>>);

impl Transform {
    /// That of a length, not 0.
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
        let inner = Radix4::new((2 * samples - 1).next_power_of_two(), DIRECTION);
        Self(Arc::new(BluesteinsAlgorithm::new(samples, Arc::new(inner))))
    }

    /// Transforms `n` numbers.
    pub fn run(&self, mut values: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
        self.0.process(&mut values);
        values
    }

    /// The lines of `n` samples from 0 Hz up to half the sampling rate; those above are their conjugates.
    pub fn lines(&self, samples: impl Iterator<Item = f64>) -> Vec<Complex<f64>> {
        let mut lines = self.run(samples.map(Complex::from).collect());
        lines.truncate(lines.len() / 2 + 1);
        lines
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

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
        }
    }
}
