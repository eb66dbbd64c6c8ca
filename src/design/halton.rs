//! Halton points, plain or with scrambled digits, any of them computed alone.

use super::permutation::{Permutation, hash};

/// Digits scrambled: beyond them a float holds none, whatever the base.
const MAX_DIGITS: u64 = 54;

/// A Halton sequence: van der Corput sequences in the first primes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Halton {
    bases: Vec<u64>,
    /// Key of the scrambling.
    scramble: Option<u64>,
}

impl Halton {
    pub(super) fn new(dimensions: usize, scramble: Option<u64>) -> Self {
        let mut bases: Vec<u64> = Vec::with_capacity(dimensions);
        let mut candidate = 2;
        while bases.len() < dimensions {
            if bases.iter().take_while(|prime| *prime * *prime <= candidate).all(|prime| candidate % prime != 0) {
                bases.push(candidate);
            }
            candidate += 1;
        }
        Self { bases, scramble }
    }

    /// Coordinate of point `index` along `dimension`, in [0, 1).
    ///
    /// Scrambled, every digit goes through a random permutation of its own that belongs to (dimension, position), the
    /// endless zeros included (Owen, arXiv:1706.02808).
    pub(super) fn at(&self, index: u64, dimension: usize) -> f64 {
        let Some(&base) = self.bases.get(dimension) else { return 0.0 };
        let mut rest = index;
        let mut weight = 1.0 / base as f64;
        let mut value = 0.0;
        match self.scramble {
            None => {
                while rest > 0 {
                    value += (rest % base) as f64 * weight;
                    weight /= base as f64;
                    rest /= base;
                }
            }
            Some(key) => {
                for position in 0..MAX_DIGITS {
                    if weight < f64::EPSILON / 4.0 {
                        break;
                    }
                    let permutation = Permutation::new(hash(key, dimension as u64, position), base);
                    value += permutation.at(rest % base) as f64 * weight;
                    weight /= base as f64;
                    rest /= base;
                }
            }
        }
        // Rounding of the sum may reach 1.
        value.min(1.0 - f64::EPSILON / 2.0)
    }
}
