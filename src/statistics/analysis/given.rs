//! Indices for any data: rows of factors and outputs from any design.

use super::error::{AnalysisError, check_values, normalised};
use super::estimate::{Bootstrap, Estimate, half};
use super::factor::{FactorValues, LEAST_ROWS};
use super::hsic::{Hsic, hsic};
use super::pawn::{Pawn, pawn};
use decore_math::random::hash;

/// Stream of the numbers that order equal values.
const TIES: u64 = 1 << 32;

/// Indices of one factor for one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenIndices {
    /// First-order Sobol' index by ranks (Gamboa, Gremaud, Klein and Lagnoux, Bernoulli 28, 2022, after Chatterjee):
    /// `(mean(Y Y_next) - mean(Y)^2) / V`, `Y_next` the output of the row with the next larger value of the factor, that of the
    /// largest being the first; V the unbiased variance. Equal values are put in a random order.
    /// Of independent rows only, as [`super::shapley()`].
    pub rank: Estimate,
    /// Correlation ratio of classes: `1 - (1 - eta^2) (n - 1) / (n - c)`, `eta^2` the share of the variance between c classes, which
    /// are the names or values, or of more than `2 n^(1/3)` values so many classes by the factor's mean ranks, equal values being in
    /// one (Kelley's unbiased one; 0 if nothing depends).
    pub correlation_ratio: Estimate,
    /// The same without the correction, `eta^2`. Where rows are laid out evenly in all factors, so are those of each class, whose
    /// means then scatter far less than those of independent rows: the correction would take away what is not there.
    pub even_correlation_ratio: Estimate,
    /// Distances of distributions.
    pub pawn: Pawn,
    /// Dependence by kernels.
    pub hsic: Hsic,
}

/// Indices of every factor for an output.
///
/// Intervals of the first three are those of a normal distribution with the standard deviation that halves of the rows, drawn
/// without replacement, 100 at most, have (the delete-half jackknife: Shao and Wu, Ann. Stat. 17, 1989): rows drawn twice would be each
/// other's
/// neighbours.
///
/// # Errors
/// [`AnalysisError::TooFew`] for fewer than 20 rows, [`AnalysisError::NotFinite`], [`AnalysisError::Constant`].
pub fn given(
    values: &[f64],
    factors: &[FactorValues<'_>],
    bootstrap: &Bootstrap,
) -> Result<Vec<GivenIndices>, AnalysisError> {
    if values.len() < LEAST_ROWS {
        return Err(AnalysisError::TooFew { unit: "rows", found: values.len(), least: LEAST_ROWS });
    }
    check_values(values)?;
    let distances = pawn(values, factors);
    let values = normalised(values);
    let of = |(factor, pawn): (&FactorValues<'_>, Pawn)| {
        let sorted = Sorted::new(&values, *factor, bootstrap.seed);
        let [rank, correlation_ratio, even_correlation_ratio] = sorted.estimates(bootstrap);
        GivenIndices {
            rank,
            correlation_ratio,
            even_correlation_ratio,
            pawn,
            hsic: hsic(&values, *factor, bootstrap.seed),
        }
    };
    Ok(factors.iter().zip(distances).map(of).collect())
}

/// An output in the order of a factor.
struct Sorted {
    /// Centred outputs.
    values: Vec<f64>,
    /// The factor's values, ascending.
    levels: Vec<f64>,
    /// Whether each of them is a class.
    nominal: bool,
}

impl Sorted {
    fn new(values: &[f64], factor: FactorValues<'_>, seed: u64) -> Self {
        let mut order: Vec<(usize, u64)> = (0..values.len()).map(|row| (row, hash(seed, TIES, row as u64))).collect();
        order.sort_by(|(a, tie_a), (b, tie_b)| {
            factor.values[*a].total_cmp(&factor.values[*b]).then(tie_a.cmp(tie_b)).then(a.cmp(b))
        });
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Self {
            values: order.iter().map(|(row, _)| values[*row] - mean).collect(),
            levels: order.iter().map(|(row, _)| factor.values[*row]).collect(),
            nominal: factor.nominal,
        }
    }

    /// Rank index, correlation ratio, and that without correction.
    fn estimates(&self, bootstrap: &Bootstrap) -> [Estimate; 3] {
        let all = vec![true; self.values.len()];
        let figures = self.figures(&all);
        let halves: Vec<[f64; 3]> = (0..bootstrap.halves())
            .map(|replicate| self.figures(&half(self.values.len(), hash(bootstrap.seed, replicate as u64, 0))))
            .collect();
        [0, 1, 2].map(|index| {
            let replicates: Vec<f64> = halves.iter().map(|of| of[index]).collect();
            Estimate { value: figures[index], interval: bootstrap.jackknife(figures[index], &replicates) }
        })
    }

    fn figures(&self, chosen: &[bool]) -> [f64; 3] {
        let kept = |index: &usize| chosen[*index];
        let places: Vec<usize> = (0..self.values.len()).filter(kept).collect();
        let count = places.len() as f64;
        let mean = places.iter().map(|place| self.values[*place]).sum::<f64>() / count;
        let value = |place: usize| self.values[place] - mean;
        let squares: f64 = places.iter().map(|place| value(*place).powi(2)).sum();
        let next = places.iter().skip(1).chain(places.first());
        let products: f64 = places.iter().zip(next).map(|(place, next)| value(*place) * value(*next)).sum();
        // The unbiased variance, as its square mean is of centred values.
        let rank = products / count / (squares / (count - 1.0));
        let [corrected, plain] = self.correlation_ratios(&places, (mean, squares));
        [rank, corrected, plain]
    }

    /// Correlation ratio, and that without correction.
    fn correlation_ratios(&self, places: &[usize], (mean, squares): (f64, f64)) -> [f64; 2] {
        let classes = self.classes(places);
        let (mut between, mut begin) = (0.0, 0);
        for end in &classes {
            let sum: f64 = places[begin..*end].iter().map(|place| self.values[*place] - mean).sum();
            between += sum * sum / (end - begin) as f64;
            begin = *end;
        }
        let count = places.len() as f64;
        let plain = between / squares;
        [1.0 - (1.0 - plain) * (count - 1.0) / (count - classes.len() as f64), plain]
    }

    /// The ends of the classes of rows in the factor's order.
    fn classes(&self, places: &[usize]) -> Vec<usize> {
        let bins = (2.0 * (places.len() as f64).cbrt()).round() as usize;
        let level = |index: usize| self.levels[places[index]];
        let ends = (1..=places.len()).filter(|end| *end == places.len() || level(*end) != level(end - 1));
        let levels: Vec<usize> = ends.collect();
        if self.nominal || levels.len() <= bins {
            return levels;
        }
        // Equal values, by the middle of their places.
        let begins = [0].into_iter().chain(levels.iter().copied());
        let class = |(begin, end): (usize, &usize)| (begin + end - 1) / 2 * bins / places.len();
        let classes: Vec<usize> = begins.zip(&levels).map(class).collect();
        let last = |level: &usize| classes.get(level + 1) != classes.get(*level);
        (0..levels.len()).filter(last).map(|level| levels[level]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::random::uniform;

    const NO_INTERVALS: Bootstrap = Bootstrap { replicates: 0, seed: 0, level: 0.95 };

    /// A whole number decides an output: its share is 1 however rows are cut into classes.
    #[test]
    fn equal_values_are_in_one_class() {
        for levels in [3, 60_u64] {
            let factor: Vec<f64> = (0..2000).map(|row| (uniform(1, 0, row) * levels as f64).floor()).collect();
            let inert: Vec<f64> = (0..2000).map(|row| uniform(1, 1, row)).collect();
            let values: Vec<f64> = factor.iter().map(|level| if level % 2.0 == 0.0 { 0.0 } else { 1.0 }).collect();
            let factors = [&factor, &inert].map(|values| FactorValues { values, nominal: false });
            let found = given(&values, &factors, &NO_INTERVALS).expect("indices");
            let [share, none] = [0, 1].map(|factor| found[factor].correlation_ratio.value);
            // Of 60 levels, 25 classes hold two or three, whose parities are mixed.
            assert!(
                share > if levels == 3 { 0.999_999 } else { 0.0 } && none.abs() < 0.03,
                "{levels}: {share}, {none}"
            );
        }
    }

    /// Finds the influence in a factorial of 4000 rows whose order repeats with every fourth row.
    #[test]
    fn dependence_by_kernels_does_not_alias_with_the_order_of_rows() {
        let decisive: Vec<f64> = (0..4000).map(|row| f64::from(row % 4)).collect();
        let inert: Vec<f64> = (0..4000).map(|row| f64::from(row / 4)).collect();
        let factors = [&decisive, &inert].map(|values| FactorValues { values, nominal: false });
        let found = given(&decisive, &factors, &NO_INTERVALS).expect("indices");
        assert!(found[0].hsic.r2 > 0.99 && found[0].hsic.p_value < 1e-12, "{:?}", found[0].hsic);
        assert!(found[1].hsic.p_value > 1e-3, "{:?}", found[1].hsic);
    }

    /// Halton's points: the share of a factor without effect is 0, not less; that of a sum of two is known.
    #[test]
    fn analytic_shares_of_even_rows() {
        let inverse = |base: u64, mut rest: u64| {
            let (mut place, mut value) = (1.0, 0.0);
            while rest > 0 {
                place /= base as f64;
                value += place * (rest % base) as f64;
                rest /= base;
            }
            value
        };
        let columns = [2, 3, 5].map(|base| (1..=2000).map(|row| inverse(base, row)).collect::<Vec<f64>>());
        let values: Vec<f64> = columns[0].iter().zip(&columns[1]).map(|(a, b)| 10.0 * a + 2.0 * b).collect();
        let factors = [0, 1, 2].map(|factor| FactorValues { values: &columns[factor], nominal: false });
        let found = given(&values, &factors, &Bootstrap { replicates: 100, ..NO_INTERVALS }).expect("indices");
        for (found, truth) in found.iter().zip([100.0 / 104.0, 4.0 / 104.0, 0.0]) {
            let Estimate { value, interval } = found.even_correlation_ratio;
            let [low, high] = interval.expect("an interval");
            assert!(low <= truth && truth <= high && (value - truth).abs() < 0.005, "{value} for {truth}");
        }
        assert!(found[2].correlation_ratio.value < -0.005, "{:?}", found[2]);
    }

    #[test]
    fn the_size_of_an_output_does_not_matter() {
        let columns: Vec<Vec<f64>> =
            (0..2).map(|factor| (0..300).map(|row| uniform(2, factor, row)).collect()).collect();
        let factors: Vec<FactorValues<'_>> =
            columns.iter().map(|values| FactorValues { values, nominal: false }).collect();
        let plain = given(&columns[0], &factors, &NO_INTERVALS).expect("indices");
        for size in [1e300, 1e-170] {
            let values: Vec<f64> = columns[0].iter().map(|value| value * size).collect();
            for (found, plain) in given(&values, &factors, &NO_INTERVALS).expect("indices").iter().zip(&plain) {
                let figures = |of: &GivenIndices| [of.rank.value, of.correlation_ratio.value, of.hsic.r2];
                for (found, plain) in figures(found).into_iter().zip(figures(plain)) {
                    assert!((found - plain).abs() < 1e-9, "{size:e}: {found} for {plain}");
                }
            }
        }
    }
}
