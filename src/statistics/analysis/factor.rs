//! Factors of arbitrary rows.

use statrs::function::erf::erfc;
use statrs::function::gamma::checked_gamma_ur;

use decore_math::random::{Stream, hash};

/// Smallest number of rows for a test.
pub(super) const LEAST_ROWS: usize = 20;

/// A factor's values, row by row.
#[derive(Debug, Clone, Copy)]
pub struct FactorValues<'a> {
    /// The values; of names, numbers that stand for them.
    pub values: &'a [f64],
    /// Whether they are names, which have no order.
    pub nominal: bool,
}

/// Spearman's rank correlation, with mean ranks for equal values. NaN if one of both does not vary.
pub fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let [a, b] = [a, b].map(mean_ranks);
    let centre = |ranks: &[f64]| ranks.iter().sum::<f64>() / ranks.len() as f64;
    let (mean_a, mean_b) = (centre(&a), centre(&b));
    let product = |x: &[f64], y: &[f64], [mean_x, mean_y]: [f64; 2]| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum()
    };
    let squares = product(&a, &a, [mean_a, mean_a]) * product(&b, &b, [mean_b, mean_b]);
    product(&a, &b, [mean_a, mean_b]) / squares.sqrt()
}

/// Probability of a rank correlation of this size or a larger one, were both independent: Fisher's transform, whose variance is
/// `1.06 / (n - 3)` for ranks (Fieller, Hartley and Pearson, Biometrika 44, 1957).
pub fn rank_correlation_p_value(correlation: f64, rows: usize) -> f64 {
    let deviations = correlation.abs().min(1.0).atanh() * ((rows as f64 - 3.0).max(0.0) / 1.06).sqrt();
    erfc(deviations / std::f64::consts::SQRT_2)
}

/// Difference of the values between groups.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupDifference {
    /// Share of the ranks' variance that lies between the groups, without the bias of their number.
    pub share: f64,
    /// Probability of a larger difference were there none.
    pub p_value: f64,
}

/// Kruskal and Wallis' test of groups by ranks (J. Am. Stat. Assoc. 47, 1952): `H = (n - 1)` times the share of the ranks' variance
/// between c groups, equal values having their mean rank; its distribution is taken as chi-squared with `c - 1` degrees of
/// freedom. `None` for one group or values that do not vary.
pub fn kruskal_wallis(groups: &[f64], values: &[f64]) -> Option<GroupDifference> {
    let ranks = mean_ranks(values);
    let n = ranks.len() as f64;
    let mean = ranks.iter().sum::<f64>() / n;
    let squares: f64 = ranks.iter().map(|rank| (rank - mean).powi(2)).sum();
    let mut names = groups.to_vec();
    names.sort_by(f64::total_cmp);
    names.dedup();
    let mut sums = vec![(0.0, 0.0); names.len()];
    for (group, rank) in groups.iter().zip(&ranks) {
        let (sum, count) = &mut sums[names.partition_point(|name| name < group)];
        *sum += rank - mean;
        *count += 1.0;
    }
    let between = sums.iter().map(|(sum, count)| sum * sum / count).sum::<f64>() / squares;
    let freedom = names.len() as f64 - 1.0;
    if freedom < 1.0 || n <= freedom + 1.0 || !between.is_finite() {
        return None;
    }
    let share = 1.0 - (1.0 - between) * (n - 1.0) / (n - 1.0 - freedom);
    let p_value = checked_gamma_ur(0.5 * freedom, 0.5 * (n - 1.0) * between).unwrap_or(f64::NAN);
    Some(GroupDifference { share, p_value })
}

/// At most so many of the rows, ascending, drawn without replacement by `key`. Every k-th row would not do: the rows of a design
/// repeat with periods of their own.
pub fn drawn_rows(rows: usize, most: usize, key: u64) -> Vec<usize> {
    let mut drawn: Vec<usize> = (0..rows).collect();
    if rows > most {
        Stream::new(hash(key, 0, 0)).shuffle(&mut drawn);
        drawn.truncate(most);
        drawn.sort_unstable();
    }
    drawn
}

/// Twice the rank of every value, of equal values their mean.
pub(super) fn mean_ranks(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = |value: &f64| {
        let [below, upto] = [sorted.partition_point(|x| x < value), sorted.partition_point(|x| x <= value)];
        (below + upto) as f64
    };
    values.iter().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;

    #[test]
    fn probabilities_of_chance_are_uniform() {
        let below = |p_value: &dyn Fn(u64) -> f64| (0..400).filter(|seed| p_value(*seed) < 0.1).count();
        let column = |seed: u64, stream: u64| (0..60).map(move |row| uniform(seed, stream, row)).collect::<Vec<f64>>();
        let ranks = |seed| rank_correlation_p_value(rank_correlation(&column(seed, 0), &column(seed, 1)), 60);
        let groups = |seed| {
            let names: Vec<f64> = column(seed, 0).iter().map(|value| (3.0 * value).floor()).collect();
            kruskal_wallis(&names, &column(seed, 1)).expect("groups").p_value
        };
        // 40 of 400, which scatter by 6.
        for count in [below(&ranks), below(&groups)] {
            assert!((22..=58).contains(&count), "{count}");
        }
        assert!(rank_correlation_p_value(1.0, 25) < 1e-12);
    }
}
