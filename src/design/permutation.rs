//! Random numbers addressed by position: no state, so any row can be computed alone.

/// Rounds of the network; each round moves both halves. Eight leave no correlation that the tests could see.
const ROUNDS: u64 = 8;

/// Mixes one word (the finaliser of SplitMix64: Steele, Lea, Flood, OOPSLA 2014, variant of Stafford).
const fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ (word >> 31)
}

/// Hash of an address (seed, stream, index): 64 bits that look independent for different addresses.
pub(super) const fn hash(seed: u64, stream: u64, index: u64) -> u64 {
    mix(mix(mix(seed) ^ stream) ^ index)
}

/// The same as a number in [0, 1), a multiple of 2^-53.
pub(super) fn uniform(seed: u64, stream: u64, index: u64) -> f64 {
    (hash(seed, stream, index) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

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

/// A random word scaled to 0..`bound`.
pub(super) fn below(word: u64, bound: u64) -> u64 {
    ((u128::from(word) * u128::from(bound)) >> 64) as u64
}

/// A stream of random numbers for algorithms that need many, one after the other (SplitMix64).
#[derive(Debug, Clone)]
pub(super) struct Stream {
    key: u64,
    count: u64,
}

impl Stream {
    /// The stream that belongs to `key`.
    pub(super) fn new(key: u64) -> Self {
        Self { key, count: 0 }
    }

    /// The next word.
    pub(super) fn word(&mut self) -> u64 {
        self.count += 1;
        mix(self.key.wrapping_add(self.count.wrapping_mul(0x9E37_79B9_7F4A_7C15)))
    }

    /// The next index below `bound` (at least 1).
    pub(super) fn below(&mut self, bound: usize) -> usize {
        below(self.word(), bound as u64) as usize
    }

    /// Puts the entries into a random order.
    pub(super) fn shuffle<T>(&mut self, entries: &mut [T]) {
        for last in (1..entries.len()).rev() {
            entries.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn uniform_numbers_have_their_moments() {
        let n = 100_000;
        let mean = (0..n).map(|i| uniform(1, 2, i)).sum::<f64>() / n as f64;
        let square = (0..n).map(|i| uniform(1, 2, i).powi(2)).sum::<f64>() / n as f64;
        // Four standard deviations: 0.2887 / sqrt(n) and 0.2981 / sqrt(n).
        assert!((mean - 0.5).abs() < 4.0 * 0.2887 / (n as f64).sqrt());
        assert!((square - 1.0 / 3.0).abs() < 4.0 * 0.2981 / (n as f64).sqrt());
    }
}
