//! Random numbers of METIS, in place of the C library's. Each system has another generator, and other draws would change the order, the
//! sums of a factorisation and so the last bits of every figure. This is the generator of the GNU library, an additive feedback of 31
//! words (`x_i = x_(i-3) + x_(i-31)`), so the order is the same as on Linux.

/// Words of the state.
const WORDS: usize = 31;
/// Distance of the second word in the sum.
const SEPARATION: usize = 3;
/// Number of draws that are skipped after seeding.
const DISCARDED: usize = 10 * WORDS;

/// Generator; before seeding, all its words are equal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Generator {
    words: [u32; WORDS],
    at: usize,
}

impl Generator {
    /// Before it is seeded.
    pub const UNSEEDED: Self = Self { words: [1; WORDS], at: 0 };

    /// Seeded as by C's `srand`.
    pub fn seeded(seed: u32) -> Self {
        // The minimal standard generator of Park and Miller fills the words; it takes no zero.
        let mut word = i64::from(seed.max(1) as i32);
        let words = std::array::from_fn(|i| {
            if i > 0 {
                word = (16_807 * word) % 2_147_483_647;
                word += if word < 0 { 2_147_483_647 } else { 0 };
            }
            word as u32
        });
        let mut generator = Self { words, at: 0 };
        (0..DISCARDED).for_each(|_| _ = generator.draw());
        generator
    }

    /// A whole number from 0 to 2^31 - 1.
    pub fn draw(&mut self) -> u32 {
        let sum = (self.at + SEPARATION) % WORDS;
        self.words[sum] = self.words[sum].wrapping_add(self.words[self.at]);
        self.at = (self.at + 1) % WORDS;
        self.words[sum] >> 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers that a C program on Linux prints after `srand`.
    #[test]
    fn draws_are_those_of_gnu() {
        for (seed, expected) in [(1, [1_804_289_383, 846_930_886]), (42, [71_876_166, 708_592_740])] {
            let mut generator = Generator::seeded(seed);
            assert_eq!([generator.draw(), generator.draw()], expected, "seed {seed}");
        }
    }
}
