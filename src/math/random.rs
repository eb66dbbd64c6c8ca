//! Random numbers addressed by position: no state, so any row or replicate can be computed alone.

/// Mixes one word (the finaliser of SplitMix64: Steele, Lea, Flood, OOPSLA 2014, variant of Stafford).
pub const fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ (word >> 31)
}

/// Hash of an address (seed, stream, index): 64 bits that look independent for different addresses.
pub const fn hash(seed: u64, stream: u64, index: u64) -> u64 {
    mix(mix(mix(seed) ^ stream) ^ index)
}

/// The same as a number in [0, 1), a multiple of 2^-53.
pub fn uniform(seed: u64, stream: u64, index: u64) -> f64 {
    (hash(seed, stream, index) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A random word scaled to 0..`bound`.
pub fn below(word: u64, bound: u64) -> u64 {
    ((u128::from(word) * u128::from(bound)) >> 64) as u64
}

/// A stream of random numbers for algorithms that need many, one after the other (SplitMix64).
#[derive(Debug, Clone)]
pub struct Stream {
    key: u64,
    count: u64,
}

impl Stream {
    /// The stream that belongs to `key`.
    pub fn new(key: u64) -> Self {
        Self { key, count: 0 }
    }

    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.count += 1;
        mix(self.key.wrapping_add(self.count.wrapping_mul(0x9E37_79B9_7F4A_7C15)))
    }

    /// The next index below `bound` (at least 1).
    pub fn below(&mut self, bound: usize) -> usize {
        below(self.word(), bound as u64) as usize
    }

    /// Puts the entries into a random order.
    pub fn shuffle<T>(&mut self, entries: &mut [T]) {
        for last in (1..entries.len()).rev() {
            entries.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
