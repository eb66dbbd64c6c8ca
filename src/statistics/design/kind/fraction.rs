//! Regular two-level fractions: minimum aberration up to 15 factors, sufficient resolution beyond; and their confounded effects.

use std::collections::BTreeMap;

use super::super::error::DesignError;

/// Most factors of a fractional factorial's words.
const MAX_BASIC_FACTORS: u32 = 30;
/// More basic factors are used without further words only: the search for words would take minutes.
const MAX_SEARCHED_FACTORS: u32 = 12;
/// Highest resolution that is looked for.
pub(super) const MAX_RESOLUTION: u32 = 8;
/// Most factors beyond the basic ones whose words' products are counted.
const MAX_COUNTED: usize = 20;

/// Fractions of least aberration (Fries and Hunter, Technometrics 22, 1980): of their size they have the fewest words of the
/// shortest length, of these the fewest of the next, and so on.
///
/// Factors, basic factors, and the products that give the other factors, one bit per basic factor. Found by our own search for the numbers
/// of words in the tables of Chen, Sun and Wu (Int. Stat. Rev. 61, 1993) and Groemping (J. Stat. Softw. 56, 2014). Sizes that no resolution
/// needs are left out.
const LEAST_ABERRATION: [(usize, u32, &[u64]); 50] = [
    (3, 2, &[0x3]),
    (4, 3, &[0x7]),
    (5, 3, &[0x6, 0x7]),
    (5, 4, &[0xf]),
    (6, 3, &[0x3, 0x6, 0x7]),
    (6, 4, &[0xb, 0xe]),
    (6, 5, &[0x1f]),
    (7, 3, &[0x3, 0x5, 0x6, 0x7]),
    (7, 4, &[0x7, 0xd, 0xe]),
    (7, 6, &[0x3f]),
    (8, 4, &[0x7, 0xb, 0xd, 0xe]),
    (8, 6, &[0xf, 0x3e]),
    (8, 7, &[0x7f]),
    (9, 4, &[0x3, 0x5, 0x9, 0xe, 0xf]),
    (9, 5, &[0xf, 0x13, 0x15, 0x19]),
    (9, 7, &[0x2f, 0x57]),
    (9, 8, &[0xff]),
    (10, 4, &[0x5, 0x6, 0x7, 0xb, 0xc, 0xf]),
    (10, 5, &[0xb, 0xe, 0x17, 0x1a, 0x1d]),
    (10, 7, &[0x1e, 0x27, 0x4b]),
    (10, 8, &[0x3f, 0xda]),
    (10, 9, &[0x1ff]),
    (11, 4, &[0x3, 0x5, 0x9, 0xa, 0xd, 0xe, 0xf]),
    (11, 5, &[0x7, 0xd, 0xe, 0x13, 0x15, 0x1c]),
    (11, 7, &[0x1f, 0x2d, 0x47, 0x7b]),
    (11, 8, &[0x9b, 0xbc, 0xef]),
    (11, 9, &[0xcf, 0x1f1]),
    (11, 10, &[0x3ff]),
    (12, 4, &[0x3, 0x6, 0x7, 0x9, 0xb, 0xc, 0xd, 0xe]),
    (12, 5, &[0x7, 0xb, 0xd, 0x13, 0x15, 0x16, 0x1a]),
    (12, 8, &[0x1f, 0x6b, 0xb3, 0xe5]),
    (12, 10, &[0x7f, 0x3ad]),
    (13, 4, &[0x3, 0x5, 0x6, 0x7, 0x9, 0xa, 0xb, 0xd, 0xf]),
    (13, 5, &[0xb, 0xe, 0x13, 0x16, 0x19, 0x1a, 0x1c, 0x1f]),
    (13, 8, &[0x27, 0x78, 0x9e, 0xd3, 0xed]),
    (13, 9, &[0x5d, 0xeb, 0x12f, 0x19e]),
    (13, 10, &[0xaf, 0x1f6, 0x27c]),
    (13, 11, &[0x36d, 0x4bf]),
    (14, 4, &[0x3, 0x5, 0x6, 0x7, 0x9, 0xa, 0xb, 0xd, 0xe, 0xf]),
    (14, 5, &[0x7, 0xb, 0xd, 0xe, 0x13, 0x15, 0x16, 0x1a, 0x1c]),
    (14, 8, &[0x1e, 0x2f, 0x5b, 0xb9, 0xcc, 0xfe]),
    (14, 9, &[0x3f, 0xcd, 0x166, 0x19e, 0x1f5]),
    (14, 10, &[0xb7, 0x179, 0x25e, 0x3d3]),
    (14, 11, &[0x7f, 0x6d3, 0x70f]),
    (15, 4, &[0x3, 0x5, 0x6, 0x7, 0x9, 0xa, 0xb, 0xc, 0xd, 0xe, 0xf]),
    (15, 5, &[0x7, 0xb, 0xd, 0x13, 0x15, 0x16, 0x19, 0x1a, 0x1c, 0x1f]),
    (15, 8, &[0x2d, 0x47, 0x5c, 0x99, 0xae, 0xca, 0xff]),
    (15, 9, &[0x6e, 0x9b, 0x10f, 0x13c, 0x1cc, 0x1f9]),
    (15, 10, &[0x1b9, 0x1d7, 0x27d, 0x2a7, 0x34b]),
    (15, 11, &[0x19f, 0x26f, 0x4f5, 0x7a3]),
];

/// A two-level fraction of `2^basic` rows: column j is the product of the basic factors in its word.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fraction {
    basic: u32,
    /// One bit per basic factor.
    words: Vec<u64>,
}

impl Fraction {
    /// The smallest fraction known in which no effect of `resolution` minus k factors is confused with one of k: up to 15 factors
    /// the one of least aberration.
    ///
    /// Beyond, basic factors come first; the others get, in their turn, a word that is no product of fewer than
    /// `resolution - 1` columns chosen before (a lexicographic code), short words before long ones: a long word rules out
    /// more of the others. Among fractions of the same size that of the highest resolution is taken.
    pub(super) fn new(factors: usize, resolution: u32) -> Result<Self, DesignError> {
        if !(3..=MAX_RESOLUTION).contains(&resolution) {
            let message = format!("the resolution is {resolution}, expected 3 to {MAX_RESOLUTION}");
            return Err(DesignError::setting("resolution", message));
        }
        let most = LEAST_ABERRATION.iter().map(|(factors, ..)| *factors).max().unwrap_or(0);
        if factors <= most {
            let of_size = LEAST_ABERRATION.iter().filter(|(count, ..)| *count == factors);
            let mut fractions = of_size.map(|(_, basic, generators)| Self::generated(*basic, generators));
            let found = fractions.find(|fraction| fraction.resolution() >= Some(resolution as usize));
            return Ok(found.unwrap_or_else(|| Self::generated(factors as u32, &[])));
        }
        let smallest = (1..=MAX_BASIC_FACTORS.min(factors as u32))
            .find_map(|basic| words(factors, basic, resolution).map(|words| Self { basic, words }));
        let Some(smallest) = smallest else {
            let message = format!("{factors} factors are too many for a fraction of resolution {resolution}");
            return Err(DesignError::setting("resolution", message));
        };
        let better =
            (resolution + 1..=MAX_RESOLUTION).map_while(|higher| words(factors, smallest.basic, higher)).last();
        Ok(better.map_or(smallest.clone(), |words| Self { words, ..smallest }))
    }

    fn generated(basic: u32, generators: &[u64]) -> Self {
        Self { basic, words: (0..basic).map(|bit| 1 << bit).chain(generators.iter().copied()).collect() }
    }

    fn word_lengths(&self) -> Option<Vec<usize>> {
        word_lengths(self.words.get(self.basic as usize..).unwrap_or(&[]), self.words.len())
    }

    fn resolution(&self) -> Option<usize> {
        shortest(&self.word_lengths()?)
    }

    pub(super) fn rows(&self) -> usize {
        1 << self.basic
    }

    /// Whether the factor is at its upper level.
    pub(super) fn is_high(&self, row: u64, column: usize) -> bool {
        let word = self.words.get(column).copied().unwrap_or(0);
        // A product of an even number of lower levels is the upper one.
        (!row & word).count_ones().is_multiple_of(2)
    }
}

fn words(factors: usize, basic: u32, resolution: u32) -> Option<Vec<u64>> {
    let mut chosen: Vec<u64> = (0..basic).map(|bit| 1 << bit).collect();
    if factors <= chosen.len() {
        chosen.truncate(factors);
        return Some(chosen);
    }
    if basic > MAX_SEARCHED_FACTORS {
        return None;
    }
    let mut candidates: Vec<u64> = (1..1_u64 << basic).filter(|word| word.count_ones() + 1 >= resolution).collect();
    candidates.sort_by_key(|word| (word.count_ones(), *word));
    for word in candidates {
        if !is_product(&chosen, word, resolution - 2) {
            chosen.push(word);
        }
        if chosen.len() == factors {
            return Some(chosen);
        }
    }
    None
}

/// Whether a word is the product of at most `most` columns.
fn is_product(columns: &[u64], word: u64, most: u32) -> bool {
    match (word, most) {
        (0, _) => true,
        (_, 0) => false,
        _ => (0..columns.len()).any(|index| {
            let (column, rest) = (columns[index], &columns[index + 1..]);
            is_product(rest, word ^ column, most - 1)
        }),
    }
}

/// Confounded effects of a regular two-level fraction. Factors are given by index; products use the levels -1 and 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Aliases {
    /// Factors that are products of others, with these.
    pub generators: Vec<(usize, Vec<usize>)>,
    /// Number of products of factors that are 1 in every row, by their number of factors (the word length pattern, from length 0);
    /// `None` if there are too many to count.
    pub word_lengths: Option<Vec<usize>>,
    /// Confounded effects of one or two factors, main effects first; clear effects are left out.
    pub chains: Vec<Vec<Vec<usize>>>,
}

impl Aliases {
    pub(super) fn of(fraction: &Fraction) -> Self {
        let words = &fraction.words;
        let basic = (fraction.basic as usize).min(words.len());
        let factors_of = |word: u64| (0..basic).filter(|bit| word >> bit & 1 == 1).collect::<Vec<usize>>();
        let mut effects: BTreeMap<u64, Vec<Vec<usize>>> = BTreeMap::new();
        for (index, word) in words.iter().enumerate() {
            effects.entry(*word).or_default().push(vec![index]);
        }
        for (second, word) in words.iter().enumerate() {
            for (first, other) in words.iter().enumerate().take(second) {
                effects.entry(word ^ other).or_default().push(vec![first, second]);
            }
        }
        let mut chains: Vec<Vec<Vec<usize>>> = effects.into_values().filter(|chain| chain.len() > 1).collect();
        chains.iter_mut().for_each(|chain| chain.sort_by_key(|effect| (effect.len(), effect.clone())));
        chains.sort_by_key(|chain| chain.first().map(|effect| (effect.len(), effect.clone())));
        Self {
            generators: (basic..words.len()).map(|factor| (factor, factors_of(words[factor]))).collect(),
            word_lengths: fraction.word_lengths(),
            chains,
        }
    }

    /// Length of the shortest word; `None` if there is none, or words were not counted.
    pub fn resolution(&self) -> Option<usize> {
        shortest(self.word_lengths.as_ref()?)
    }
}

fn shortest(word_lengths: &[usize]) -> Option<usize> {
    (1..word_lengths.len()).find(|length| word_lengths[*length] > 0)
}

/// Counts the products of the generators' words by length, including the factors that they generate.
fn word_lengths(generators: &[u64], factors: usize) -> Option<Vec<usize>> {
    if generators.len() > MAX_COUNTED {
        return None;
    }
    let mut lengths = vec![0; factors + 1];
    lengths[0] = 1;
    let (mut product, mut chosen) = (0_u64, 0_u64);
    for step in 1_u64..1 << generators.len() {
        // In the order of the Gray code one generator comes in or leaves at a time.
        let index = step.trailing_zeros();
        product ^= generators[index as usize];
        chosen ^= 1 << index;
        lengths[(product.count_ones() + chosen.count_ones()) as usize] += 1;
    }
    Some(lengths)
}
