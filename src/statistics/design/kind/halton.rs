//! Halton points, plain or with scrambled digits, any of them computed alone.

use std::sync::Arc;

use super::super::permutation::Permutation;
use decore_math::random::hash;

/// Digits scrambled: beyond them a float holds none, whatever the base.
const MAX_DIGITS: u64 = 54;

/// A Halton sequence: van der Corput sequences in the first primes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HaltonSequence {
    bases: Vec<u64>,
    /// By dimension; `None` without scrambling.
    digits: Option<Arc<Vec<Digits>>>,
}

/// Scrambled digits of one dimension by position, the most significant first.
#[derive(Debug, Clone, PartialEq)]
struct Digits {
    permuted: Vec<Vec<u32>>,
    /// Sum of the positions from this one on if all digits there are zero.
    zeros: Vec<f64>,
}

impl HaltonSequence {
    /// With a key every digit goes through a random permutation of its own that belongs to (dimension, position), the endless
    /// zeros included (Owen, arXiv:1706.02808).
    pub(super) fn new(dimensions: usize, scramble: Option<u64>) -> Self {
        let mut bases: Vec<u64> = Vec::with_capacity(dimensions);
        let mut candidate = 2;
        while bases.len() < dimensions {
            if bases.iter().take_while(|prime| *prime * *prime <= candidate).all(|prime| candidate % prime != 0) {
                bases.push(candidate);
            }
            candidate += 1;
        }
        let digits = |key: u64| {
            let of = |(dimension, base): (usize, &u64)| Digits::new(*base, |at| hash(key, dimension as u64, at));
            Arc::new(bases.iter().enumerate().map(of).collect())
        };
        let digits = scramble.map(digits);
        Self { bases, digits }
    }

    /// Coordinate of point `index` along `dimension`, in [0, 1).
    pub(super) fn at(&self, index: u64, dimension: usize) -> f64 {
        let Some(&base) = self.bases.get(dimension) else { return 0.0 };
        let value = match self.digits.as_ref().and_then(|digits| digits.get(dimension)) {
            None => radical_inverse(index, base),
            Some(digits) => digits.at(index, base),
        };
        // Rounding of the sum may reach 1.
        value.min(1.0 - f64::EPSILON / 2.0)
    }
}

/// The digits of `index` behind the point, mirrored.
fn radical_inverse(index: u64, base: u64) -> f64 {
    let (mut rest, mut weight, mut value) = (index, 1.0 / base as f64, 0.0);
    while rest > 0 {
        value += (rest % base) as f64 * weight;
        weight /= base as f64;
        rest /= base;
    }
    value
}

impl Digits {
    fn new(base: u64, key: impl Fn(u64) -> u64) -> Self {
        let (mut permuted, mut weights, mut weight): (Vec<Vec<u32>>, Vec<f64>, f64) =
            (Vec::new(), Vec::new(), 1.0 / base as f64);
        for position in 0..MAX_DIGITS {
            if weight < f64::EPSILON / 4.0 {
                break;
            }
            let permutation = Permutation::new(key(position), base);
            permuted.push((0..base).map(|digit| permutation.at(digit) as u32).collect());
            weights.push(weight);
            weight /= base as f64;
        }
        let mut zeros = vec![0.0; permuted.len()];
        let mut sum = 0.0;
        for ((zero, digits), weight) in zeros.iter_mut().zip(&permuted).zip(&weights).rev() {
            sum += digits.first().map_or(0.0, |digit| f64::from(*digit)) * weight;
            *zero = sum;
        }
        Self { permuted, zeros }
    }

    fn at(&self, index: u64, base: u64) -> f64 {
        let (mut rest, mut weight, mut value) = (index, 1.0 / base as f64, 0.0);
        for (digits, zeros) in self.permuted.iter().zip(&self.zeros) {
            if rest == 0 {
                return value + zeros;
            }
            value += digits.get((rest % base) as usize).map_or(0.0, |digit| f64::from(*digit)) * weight;
            weight /= base as f64;
            rest /= base;
        }
        value
    }
}
