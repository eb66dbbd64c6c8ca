//! Random permutations, evaluated one element at a time.

use decore_math::random::{below, mix};

/// Rounds of the network; each round moves both halves. Eight leave no correlation that the tests could see.
const ROUNDS: u64 = 8;

/// A pseudo-random permutation of 0..n, evaluated one element at a time.
///
/// A Feistel network on the rectangle a x b with a b >= n and addition around its sides; elements that leave 0..n are sent through
/// again until they return (cycle walking), which keeps the map one to one. `a b - n < sqrt(n) + 1`, so this is rare.
#[derive(Debug, Clone, Copy)]
pub(super) struct Permutation {
    key: u64,
    count: u64,
    width: u64,
    height: u64,
}

impl Permutation {
    /// Permutation of 0..`count` (at least 1) that belongs to `key`.
    pub(super) fn new(key: u64, count: u64) -> Self {
        let count = count.max(1);
        let mut width = (count as f64).sqrt() as u64;
        while u128::from(width) * u128::from(width) < u128::from(count) {
            width += 1;
        }
        let height = count.div_ceil(width);
        Self { key, count, width, height }
    }

    /// Image of `index`, which must lie below the count; larger ones are taken modulo it.
    pub(super) fn at(&self, index: u64) -> u64 {
        let mut element = index % self.count;
        loop {
            element = self.pass(element);
            if element < self.count {
                return element;
            }
        }
    }

    fn pass(&self, element: u64) -> u64 {
        let (mut left, mut right) = (element % self.width, element / self.width);
        for round in 0..ROUNDS {
            left = shift(left, mix(self.key ^ (right << 8) ^ (2 * round)), self.width);
            right = shift(right, mix(self.key ^ (left << 8) ^ (2 * round + 1)), self.height);
        }
        right * self.width + left
    }
}

/// `value` moved on by a part of `modulus` in proportion to `word`, around the end: no division, no overflow, as both
/// halves of the network are below 2^33.
fn shift(value: u64, word: u64, modulus: u64) -> u64 {
    let sum = value + below(word, modulus);
    if sum >= modulus { sum - modulus } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::hash;

    #[test]
    fn every_size_is_one_to_one() {
        for count in (1..200).chain([1000, 4097]) {
            let permutation = Permutation::new(7, count);
            let mut hit = vec![false; count as usize];
            for index in 0..count {
                let image = permutation.at(index) as usize;
                assert!(!hit[image], "{count}: {image} twice");
                hit[image] = true;
            }
        }
    }

    #[test]
    fn small_permutations_are_all_equally_likely() {
        // 24 permutations of four elements, 24000 keys: chi squared with 23 degrees of freedom, 99.9 % below 49.7.
        let mut counts = std::collections::BTreeMap::new();
        for key in 0..24_000 {
            let permutation = Permutation::new(hash(key, 0, 0), 4);
            *counts.entry([0, 1, 2, 3].map(|i| permutation.at(i))).or_insert(0u32) += 1;
        }
        assert_eq!(counts.len(), 24);
        let chi: f64 = counts.values().map(|&n| (f64::from(n) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi < 49.7, "chi squared {chi}");
    }
}
