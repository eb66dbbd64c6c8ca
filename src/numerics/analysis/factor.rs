//! Factors of rows that were chosen in any way.

/// Rows below which nothing is said.
pub(super) const LEAST_ROWS: usize = 20;

/// A factor's values, row by row.
#[derive(Debug, Clone, Copy)]
pub struct FactorValues<'a> {
    /// The values; of names, numbers that stand for them.
    pub values: &'a [f64],
    /// Whether they are names, which have no order.
    pub nominal: bool,
}

/// Rank correlation of Spearman: that of the ranks, mean ones where values are equal. NaN where one of both does not vary.
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
