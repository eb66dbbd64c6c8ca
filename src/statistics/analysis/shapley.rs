//! Shapley effects: shares of the variance that add up to 1 even where factors depend on each other (Owen, 2014; Song, Nelson and
//! Staum, 2016; Iooss and Prieur, 2019).

use rayon::prelude::*;

use super::error::{AnalysisError, check_values, normalised};
use super::estimate::{Bootstrap, Estimate, half};
use super::factor::{FactorValues, LEAST_ROWS, mean_ranks};
use decore_math::random::{Stream, hash};

/// Rows at most.
const MOST_ROWS: usize = 2000;
/// Largest product of pairs of rows and sets of factors, which determines the time.
const MOST_WORK: f64 = 2e9;
/// Factors of Shapley effects at most: twice the sets with each more.
pub const MOST_SHAPLEY_FACTORS: usize = 14;
/// Rows whose sums are found at a time, whatever the number of threads.
const CHUNK: usize = 64;
/// Stream of the numbers that order the rows.
const ORDER: u64 = 1 << 33;

/// Rows of which Shapley effects of so many factors come, at most: 2000, fewer from nine factors on.
pub fn shapley_rows(factors: usize) -> usize {
    let sets = 2.0_f64.powi(factors.min(MOST_SHAPLEY_FACTORS) as i32);
    MOST_ROWS.min((MOST_WORK / sets).sqrt() as usize)
}

/// Shapley effects of all factors for an output.
///
/// The effect of factor i is the mean, over all orders of the factors, of `Var(E[Y | those up to i]) - Var(E[Y | those before])`,
/// over `Var(Y)`. `E[Var(Y | factors)]` is the mean variance of the outputs of a row and its two nearest neighbours in those factors
/// (Broto, Bachoc and Depecker, SIAM/ASA J. Uncertain. Quantif. 8, 2020), distances being those of ranks, names as far from each
/// other as the ends of a range, equal distances decided by chance. Of all factors together the variance is that of Y, as a run's
/// outputs follow from its factors.
///
/// Intervals are as in [`super::given()`]. From more rows than [`shapley_rows()`], as many are chosen at random.
///
/// The rows must be independent draws. Quasi-random points and factorials repel each other: a row's neighbours in some factors then differ
/// more in the others than any two rows ([`super::spread()`]).
///
/// # Errors
/// [`AnalysisError::TooFew`] for fewer than 20 rows, [`AnalysisError::Factors`] for more than 14 factors,
/// [`AnalysisError::NotFinite`], [`AnalysisError::Constant`].
pub fn shapley(
    values: &[f64],
    factors: &[FactorValues<'_>],
    bootstrap: &Bootstrap,
) -> Result<Vec<Estimate>, AnalysisError> {
    if values.len() < LEAST_ROWS {
        return Err(AnalysisError::TooFew { unit: "rows", found: values.len(), least: LEAST_ROWS });
    }
    if factors.len() > MOST_SHAPLEY_FACTORS {
        return Err(AnalysisError::Factors { found: factors.len(), most: MOST_SHAPLEY_FACTORS });
    }
    check_values(values)?;
    let (values, most) = (normalised(values), shapley_rows(factors.len()));
    // In an order by chance, ties between neighbours are decided by chance.
    let mut order: Vec<usize> = (0..values.len()).collect();
    Stream::new(hash(bootstrap.seed, ORDER, 0)).shuffle(&mut order);
    order.truncate(most);
    let sample = Sample {
        values: order.iter().map(|row| values[*row]).collect(),
        columns: factors.iter().map(|factor| RankColumn::new(*factor, &order)).collect(),
    };
    let all: Vec<usize> = (0..order.len()).collect();
    let effects = sample.effects(&all);
    let halves: Vec<Vec<f64>> = (0..bootstrap.halves())
        .map(|replicate| {
            let chosen = half(order.len(), hash(bootstrap.seed, replicate as u64, 0));
            sample.effects(&all.iter().copied().filter(|row| chosen[*row]).collect::<Vec<usize>>())
        })
        .collect();
    let estimate = |(factor, value): (usize, &f64)| {
        let of: Vec<f64> = halves.iter().map(|half| half[factor]).collect();
        Estimate { value: *value, interval: bootstrap.jackknife(*value, &of) }
    };
    Ok(effects.iter().enumerate().map(estimate).collect())
}

/// Rows in an order by chance.
struct Sample {
    values: Vec<f64>,
    columns: Vec<RankColumn>,
}

/// A factor as distances take it: whole numbers, so that sums of squares are exact in any order.
struct RankColumn {
    ranks: Vec<i64>,
    nominal: bool,
}

impl RankColumn {
    fn new(factor: FactorValues<'_>, order: &[usize]) -> Self {
        let values: Vec<f64> = order.iter().map(|row| factor.values[*row]).collect();
        // Whole numbers, as twice a mean rank is one.
        let ranks = mean_ranks(&values).into_iter().map(|rank| rank as i64).collect();
        Self { ranks, nominal: factor.nominal }
    }

    /// Squared distance of two rows.
    fn squared(&self, a: usize, b: usize) -> i64 {
        let apart = self.ranks[a] - self.ranks[b];
        match (self.nominal, apart) {
            (false, apart) => apart * apart,
            (true, 0) => 0,
            (true, _) => 4 * (self.ranks.len() * self.ranks.len()) as i64,
        }
    }
}

impl Sample {
    /// Shapley effects of all factors from these rows.
    fn effects(&self, rows: &[usize]) -> Vec<f64> {
        let count = rows.len() as f64;
        let mean = rows.iter().map(|row| self.values[*row]).sum::<f64>() / count;
        let variance = rows.iter().map(|row| (self.values[*row] - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let sets = 1_usize << self.columns.len();
        let places: Vec<usize> = (0..rows.len()).collect();
        let chunks: Vec<Vec<f64>> = places.par_chunks(CHUNK).map(|chunk| self.local_variances(rows, chunk)).collect();
        let mut explained = vec![0.0; sets];
        for chunk in chunks {
            explained.iter_mut().zip(chunk).for_each(|(sum, part)| *sum += part);
        }
        for share in &mut explained {
            *share = 1.0 - *share / count / variance;
        }
        (explained[0], explained[sets - 1]) = (0.0, 1.0);
        (0..self.columns.len()).map(|factor| shapley_value(&explained, (factor, self.columns.len()))).collect()
    }

    /// For every set of factors, as bits, the sum over these places of the variance of a row's output and its neighbours'.
    fn local_variances(&self, rows: &[usize], places: &[usize]) -> Vec<f64> {
        let mut sums = vec![0.0; 1 << self.columns.len()];
        let mut squared = vec![0_i64; rows.len()];
        for place in places {
            let row = rows[*place];
            squared.fill(0);
            let mut set = 0_usize;
            // From one set to the next, one factor comes in or goes out (Gray's code).
            for step in 1..sums.len() {
                let factor = step.trailing_zeros() as usize;
                set ^= 1 << factor;
                let column = &self.columns[factor];
                let sign = if set >> factor & 1 == 1 { 1 } else { -1 };
                squared.iter_mut().zip(rows).for_each(|(sum, other)| *sum += sign * column.squared(row, *other));
                let [near, next] = nearest(&squared, *place).map(|place| self.values[rows[place]]);
                sums[set] += variance_of_three([self.values[row], near, next]);
            }
        }
        sums
    }
}

/// The two places at the least distances but for `own`; of equal ones those that follow it, around the end.
fn nearest(squared: &[i64], own: usize) -> [usize; 2] {
    let mut found = [(i64::MAX, own); 2];
    for place in (own + 1..squared.len()).chain(0..own) {
        let distance = squared[place];
        if distance < found[1].0 {
            found[1] = (distance, place);
            if distance < found[0].0 {
                found.swap(0, 1);
            }
        }
    }
    found.map(|(_, place)| place)
}

/// Unbiased variance.
fn variance_of_three(values: [f64; 3]) -> f64 {
    let mean = values.iter().sum::<f64>() / 3.0;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 2.0
}

/// Mean gain of a factor over all orders of the factors; `explained`: the share of every set, by its bits.
fn shapley_value(explained: &[f64], (factor, factors): (usize, usize)) -> f64 {
    // Of the orders, 1 / (factors (factors - 1 over size)) have exactly a given set of this size before the factor.
    let mut weights = vec![1.0 / factors as f64; factors];
    for size in 1..factors {
        weights[size] = weights[size - 1] * size as f64 / (factors - size) as f64;
    }
    let without = (0..explained.len()).filter(|set| set >> factor & 1 == 0);
    without.map(|set| weights[set.count_ones() as usize] * (explained[set | 1 << factor] - explained[set])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;

    #[test]
    fn effects_do_not_depend_on_the_size_of_an_output() {
        let columns: Vec<Vec<f64>> =
            (0..2).map(|factor| (0..200).map(|row| uniform(3, factor, row)).collect()).collect();
        let factors: Vec<FactorValues<'_>> =
            columns.iter().map(|values| FactorValues { values, nominal: false }).collect();
        let bootstrap = Bootstrap { replicates: 20, seed: 0, level: 0.95 };
        let effects = |output: &dyn Fn(f64) -> f64| {
            let values: Vec<f64> = columns[0].iter().map(|value| output(*value)).collect();
            shapley(&values, &factors, &bootstrap).expect("effects")
        };
        let plain = effects(&|x| x);
        let outputs: [&dyn Fn(f64) -> f64; 3] = [&|x| 1e9 + 1e-3 * x, &|x| 1e300 * x, &|x| 1e-170 * x];
        for output in outputs {
            for (found, plain) in effects(output).iter().zip(&plain) {
                assert!(
                    (found.value - plain.value).abs() < 1e-3 && found.interval.is_some(),
                    "{found:?} for {plain:?}"
                );
            }
        }
    }
}
