//! PAWN (Pianosi and Wagener, Environ. Model. Softw. 67, 2015; 108, 2018): shift of an output's distribution if a factor is held in a
//! part of its range.

use super::estimate::quantile;
use super::factor::FactorValues;

/// Parts into which the values of a factor are cut.
const SLICES: usize = 10;

/// Kolmogorov-Smirnov distances between the output's distribution over all rows and over the rows in slices of a factor. There are ten
/// slices of equal probability (quantiles by linear interpolation; as in SALib, a largest value that occurs once belongs to no slice), or
/// one slice per name or value, for at most ten values.
///
/// A factor without effect has distances above 0 too: about `0.9 / sqrt(rows of a slice)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pawn {
    /// Median of the slices' distances.
    pub median: f64,
    /// Largest distance.
    pub maximum: f64,
}

/// PAWN indices of all factors.
pub(super) fn pawn(values: &[f64], factors: &[FactorValues<'_>]) -> Vec<Pawn> {
    let ranked = Ranked::new(values);
    factors.iter().map(|factor| ranked.pawn(*factor)).collect()
}

/// Rows in the order of an output.
struct Ranked {
    /// Rows by ascending output.
    order: Vec<usize>,
    /// End of each row's group of equal outputs, by place in the order.
    ends: Vec<usize>,
}

impl Ranked {
    fn new(values: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]).then(a.cmp(b)));
        let mut ends = vec![order.len(); order.len()];
        for place in (0..order.len().saturating_sub(1)).rev() {
            let equal = values[order[place]] == values[order[place + 1]];
            ends[place] = if equal { ends[place + 1] } else { place + 1 };
        }
        Self { order, ends }
    }

    fn pawn(&self, factor: FactorValues<'_>) -> Pawn {
        let slices = slices(factor);
        let count = slices.iter().flatten().max().map_or(0, |last| last + 1);
        let mut distances = self.distances(&slices, count);
        distances.sort_by(f64::total_cmp);
        Pawn { median: quantile(&distances, 0.5), maximum: distances.last().copied().unwrap_or(f64::NAN) }
    }

    /// Distance between the distributions of every slice with rows and of all rows.
    fn distances(&self, slices: &[Option<usize>], count: usize) -> Vec<f64> {
        let rows = self.order.len() as f64;
        let mut sizes = vec![0.0; count];
        slices.iter().flatten().for_each(|slice| sizes[*slice] += 1.0);
        let mut seen = vec![0.0; count];
        let mut far = vec![0.0_f64; count];
        let mut begin = 0;
        while begin < self.order.len() {
            let end = self.ends[begin];
            let members = || self.order[begin..end].iter().filter_map(|row| slices[*row]);
            // A distance is largest just before or at a value of the slice.
            members().for_each(|slice| {
                far[slice] = far[slice].max((seen[slice] / sizes[slice] - begin as f64 / rows).abs())
            });
            members().for_each(|slice| seen[slice] += 1.0);
            members()
                .for_each(|slice| far[slice] = far[slice].max((seen[slice] / sizes[slice] - end as f64 / rows).abs()));
            begin = end;
        }
        far.into_iter().zip(sizes).filter(|(_, size)| *size > 0.0).map(|(far, _)| far).collect()
    }
}

/// The slice of every row.
fn slices(factor: FactorValues<'_>) -> Vec<Option<usize>> {
    let mut sorted = factor.values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut levels = sorted.clone();
    levels.dedup();
    if factor.nominal || levels.len() <= SLICES {
        return factor.values.iter().map(|value| Some(levels.partition_point(|other| other < value))).collect();
    }
    let [.., before, top] = sorted[..] else { return vec![None; sorted.len()] };
    let edges: Vec<f64> = (0..=SLICES).map(|edge| quantile(&sorted, edge as f64 / SLICES as f64)).collect();
    let slice = |value: &f64| match edges.partition_point(|edge| edge <= value).checked_sub(1) {
        // Whole numbers have their top value in many rows, which SALib leaves out too.
        Some(SLICES) => (before == top).then_some(SLICES - 1),
        slice => slice,
    };
    factor.values.iter().map(slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The output is 1 where the factor has its top value: that slice's distribution is as far as it can be.
    #[test]
    fn the_top_value_of_a_list_is_a_slice() {
        for levels in [3, 15] {
            let values: Vec<f64> = (0..900).map(|row| f64::from(row % levels)).collect();
            let output: Vec<f64> = values.iter().map(|value| f64::from(*value == f64::from(levels - 1))).collect();
            let found = pawn(&output, &[FactorValues { values: &values, nominal: false }]).remove(0);
            let share = 1.0 / f64::from(levels);
            // Of 15 values the last of ten slices holds the top one and the one below it.
            let apart = if levels == 3 { 1.0 - share } else { 0.5 - share };
            assert!((found.maximum - apart).abs() < 1e-12, "{levels}: {found:?}");
        }
    }
}
