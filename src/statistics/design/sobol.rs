//! Sobol' points, plain or scrambled after Owen, any of them computed alone.

use decore_math::random::hash;

/// Direction numbers of the first [`MAX_DIMENSIONS`] dimensions.
const TABLE: &str = include_str!("../../assets/joe_kuo.txt");
/// Most dimensions.
pub(super) const MAX_DIMENSIONS: usize = 1024;
/// Binary digits of a point, as many as a float holds.
const DIGITS: u32 = 52;
/// Digits scrambled by one hash.
const GROUP: u32 = 6;
/// Groups scrambled as a tree: 36 digits, below which no two points of 2^36 share their leading digits.
const GROUPS: u32 = 6;

/// A Sobol' sequence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SobolSequence {
    /// Direction numbers, [`DIGITS`] per dimension.
    directions: Vec<[u64; DIGITS as usize]>,
    /// Key of the scrambling.
    scramble: Option<u64>,
}

impl SobolSequence {
    /// The sequence in so many dimensions, at most [`MAX_DIMENSIONS`].
    pub(super) fn new(dimensions: usize, scramble: Option<u64>) -> Self {
        let lines = TABLE.lines().filter(|line| !line.starts_with('#'));
        Self { directions: lines.take(dimensions).map(directions).collect(), scramble }
    }

    /// Coordinate of point `index` along `dimension`, in [0, 1).
    ///
    /// Points come in the order of the Gray code (Antonov and Saleev), as in most programs.
    pub(super) fn at(&self, index: u64, dimension: usize) -> f64 {
        let mut gray = index ^ (index >> 1);
        let mut digits = 0;
        let Some(directions) = self.directions.get(dimension) else { return 0.0 };
        while gray != 0 {
            let bit = gray.trailing_zeros();
            digits ^= directions.get(bit as usize).copied().unwrap_or(0);
            gray &= gray - 1;
        }
        if let Some(key) = self.scramble {
            digits = owen(digits, hash(key, dimension as u64, 0));
        }
        digits as f64 * (1.0 / (1u64 << DIGITS) as f64)
    }
}

/// Nested uniform scrambling (Owen 1995): each digit is flipped by a random bit that belongs to all digits before it.
///
/// One hash of the digits before a group holds the bits of the group's whole binary tree (63 for 6 digits). Digits behind
/// the groups have no point to share them with: they are random.
fn owen(digits: u64, key: u64) -> u64 {
    let mut scrambled = 0;
    let mut left = DIGITS;
    for group in 0..GROUPS {
        let before = if left == DIGITS { 0 } else { digits >> left };
        let flips = hash(key, u64::from(group), before);
        left -= GROUP;
        let inner = (digits >> left) & ((1 << GROUP) - 1);
        // Node 1 is the tree's root, node 2 n + digit the child.
        let mut node = 1_u64;
        for depth in (0..GROUP).rev() {
            let digit = (inner >> depth) & 1;
            scrambled = (scrambled << 1) | (digit ^ ((flips >> node) & 1));
            node = 2 * node + digit;
        }
    }
    (scrambled << left) | (hash(key, u64::from(GROUPS), digits >> left) >> (64 - left))
}

/// Direction numbers of one line of the table: the recurrence of Bratley and Fox (1988).
fn directions(line: &str) -> [u64; DIGITS as usize] {
    let mut numbers = line.split_ascii_whitespace().filter_map(|word| word.parse::<u64>().ok());
    let polynomial = numbers.next().unwrap_or(1);
    let degree = (63 - polynomial.leading_zeros()) as usize;
    let first: Vec<u64> = numbers.collect();
    let mut directions = [0; DIGITS as usize];
    for index in 0..DIGITS as usize {
        let shift = DIGITS as usize - 1 - index;
        directions[index] = match first.get(index) {
            _ if degree == 0 => 1 << shift,
            Some(number) => number << shift,
            None => {
                let mut value = directions[index - degree] ^ (directions[index - degree] >> degree);
                for back in 1..degree {
                    if (polynomial >> (degree - back)) & 1 == 1 {
                        value ^= directions[index - back];
                    }
                }
                value
            }
        };
    }
    directions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scrambling_keeps_every_elementary_interval() {
        // 2^8 points: in every dimension each of 2^8 intervals holds exactly one point.
        let sobol = SobolSequence::new(20, Some(5));
        for dimension in 0..20 {
            let mut hit = [false; 256];
            for index in 0..256 {
                let cell = (sobol.at(index, dimension) * 256.0) as usize;
                assert!(!hit[cell], "dimension {dimension}: cell {cell} twice");
                hit[cell] = true;
            }
        }
    }

    #[test]
    fn scrambled_points_are_uniform_over_keys() {
        let n = 20_000;
        let mean = (0..n).map(|key| SobolSequence::new(2, Some(key)).at(3, 1)).sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < 4.0 * 0.2887 / (n as f64).sqrt(), "{mean}");
    }

    #[test]
    fn the_table_is_whole() {
        assert_eq!(SobolSequence::new(usize::MAX, None).directions.len(), MAX_DIMENSIONS);
    }
}
