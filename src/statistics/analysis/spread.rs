//! Tests whether rows repel each other, as in designs that fill space evenly.

use super::factor::{FactorValues, LEAST_ROWS, mean_ranks};
use decore_math::random::{Stream, hash};

/// Standard deviations below 0 that are no chance: of independent rows of 20 factors, 3 tables of 1000 are so far anywhere.
const SURPRISING: f64 = 4.5;
/// Share of the places of a grid from which on rows are taken for the grid's, not for draws.
const GRID_SHARE: f64 = 0.1;
/// Stream of the numbers that order the rows.
const ORDER: u64 = 1 << 35;

/// Whether neighbours in one factor differ more in another one than rows drawn independently do, or the rows are a good part of a
/// grid.
///
/// The output of the index by ranks (`GivenIndices::rank`) is here another factor, or its distance from the middle. A share
/// of variance is not negative; of n independent rows the index scatters by `1 / sqrt(n)`. Factors that depend on each other have
/// positive ones. Rows that are spread otherwise may pass.
pub fn spread(factors: &[FactorValues<'_>]) -> bool {
    let rows = factors.first().map_or(0, |factor| factor.values.len());
    if rows < LEAST_ROWS {
        return false;
    }
    let places: f64 = factors.iter().map(|factor| levels(factor.values) as f64).product();
    if factors.len() > 1 && rows as f64 > GRID_SHARE * places {
        return true;
    }
    let mut shuffled: Vec<usize> = (0..rows).collect();
    Stream::new(hash(0, ORDER, 0)).shuffle(&mut shuffled);
    let ranks: Vec<Vec<f64>> = factors.iter().map(|factor| mean_ranks(factor.values)).collect();
    let least = -SURPRISING / (rows as f64).sqrt();
    ranks.iter().enumerate().any(|(by, ordering)| {
        let mut order = shuffled.clone();
        // Stable: equal values stay in an order by chance.
        order.sort_by(|a, b| ordering[*a].total_cmp(&ordering[*b]));
        let others = ranks.iter().enumerate().filter(|(other, _)| *other != by);
        others.into_iter().any(|(_, other)| {
            let middle = rows as f64;
            let far: Vec<f64> = other.iter().map(|rank| (rank - middle).abs()).collect();
            [other, &far].into_iter().any(|values| neighbours_correlation(values, &order) < least)
        })
    })
}

/// Correlation of values with the next ones in an order, the last one's being the first; NaN if they do not vary.
fn neighbours_correlation(values: &[f64], order: &[usize]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let next = order.iter().skip(1).chain(order.first());
    let products: f64 = order.iter().zip(next).map(|(row, next)| (values[*row] - mean) * (values[*next] - mean)).sum();
    products / values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
}

/// Number of different values.
fn levels(values: &[f64]) -> usize {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    sorted.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;

    /// Digits of a row after the point, backwards: a column of Halton's points.
    fn radical_inverse(base: u64, row: u64) -> f64 {
        let (mut rest, mut place, mut value) = (row, 1.0, 0.0);
        while rest > 0 {
            place /= base as f64;
            value += place * (rest % base) as f64;
            rest /= base;
        }
        value
    }

    fn is_spread(columns: &[Vec<f64>]) -> bool {
        let factors: Vec<FactorValues<'_>> =
            columns.iter().map(|values| FactorValues { values, nominal: false }).collect();
        spread(&factors)
    }

    #[test]
    fn even_rows_are_told_from_drawn_ones() {
        let halton = |rows: u64| -> Vec<Vec<f64>> {
            [2, 3, 5].map(|base| (1..=rows).map(|row| radical_inverse(base, row)).collect()).into()
        };
        assert!(is_spread(&halton(300)) && is_spread(&halton(2000)));
        let crossed =
            [2, 600].map(|levels| (0..1200).map(move |row| f64::from(if levels == 2 { row % 2 } else { row / 2 })));
        assert!(is_spread(&crossed.map(Iterator::collect)));
        for seed in 0..50 {
            let drawn: Vec<Vec<f64>> =
                (0..4).map(|factor| (0..300).map(|row| uniform(seed, factor, row)).collect()).collect();
            assert!(!is_spread(&drawn), "seed {seed}");
            // Factors that depend on each other are drawn all the same.
            let sums = drawn[0].iter().zip(&drawn[1]).map(|(a, b)| a + 0.3 * b).collect();
            assert!(!is_spread(&[drawn[0].clone(), sums]), "seed {seed}");
        }
    }
}
