//! Indices of any data: rows of factors and outputs, however they were chosen.

use super::error::{AnalysisError, check_values};
use super::estimate::{Bootstrap, Estimate, half};
use super::factor::{FactorValues, LEAST_ROWS};
use super::hsic::{Hsic, hsic};
use super::pawn::{Pawn, pawn};
use crate::random::hash;

/// Stream of the numbers that order equal values.
const TIES: u64 = 1 << 32;

/// Indices of one factor for one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenIndices {
    /// First-order Sobol' index by ranks (Gamboa, Gremaud, Klein and Lagnoux, Bernoulli 28, 2022, after Chatterjee):
    /// `(mean(Y Y_next) - mean(Y)^2) / V`, `Y_next` the output of the row with the next larger value of the factor, that of the
    /// largest being the first; V the unbiased variance. Equal values are put in a random order.
    pub rank: Estimate,
    /// Correlation ratio of classes: `1 - (1 - eta^2) (n - 1) / (n - c)`, `eta^2` the share of the variance between c classes, which
    /// are the names, or hold equal numbers of rows by the factor's ranks (Kelley's unbiased one; 0 where nothing depends).
    pub correlation_ratio: Estimate,
    /// Distances of distributions.
    pub pawn: Pawn,
    /// Dependence by kernels.
    pub hsic: Hsic,
}

/// Indices of every factor for an output.
///
/// Intervals of the first two are those of a normal distribution with the standard deviation that halves of the rows, drawn
/// without replacement, 100 at most, have (the delete-half jackknife: Shao and Wu, Ann. Stat. 17, 1989): rows drawn twice would be each other's
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
    let of = |(factor, pawn): (&FactorValues<'_>, Pawn)| {
        let sorted = Sorted::new(values, *factor, bootstrap.seed);
        let [rank, correlation_ratio] = sorted.estimates(bootstrap);
        GivenIndices { rank, correlation_ratio, pawn, hsic: hsic(values, *factor) }
    };
    Ok(factors.iter().zip(pawn(values, factors)).map(of).collect())
}

/// An output in the order of a factor.
struct Sorted {
    /// Centred outputs.
    values: Vec<f64>,
    /// Class of each value; of names only.
    classes: Option<Vec<f64>>,
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
            classes: factor.nominal.then(|| order.iter().map(|(row, _)| factor.values[*row]).collect()),
        }
    }

    /// Rank index and correlation ratio.
    fn estimates(&self, bootstrap: &Bootstrap) -> [Estimate; 2] {
        let all = vec![true; self.values.len()];
        let figures = self.figures(&all);
        let halves: Vec<[f64; 2]> = (0..bootstrap.halves())
            .map(|replicate| self.figures(&half(self.values.len(), hash(bootstrap.seed, replicate as u64, 0))))
            .collect();
        [0, 1].map(|index| {
            let replicates: Vec<f64> = halves.iter().map(|of| of[index]).collect();
            Estimate { value: figures[index], interval: bootstrap.jackknife(figures[index], &replicates) }
        })
    }

    fn figures(&self, chosen: &[bool]) -> [f64; 2] {
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
        [rank, self.correlation_ratio(&places, (mean, squares))]
    }

    fn correlation_ratio(&self, places: &[usize], (mean, squares): (f64, f64)) -> f64 {
        let bins = (2.0 * (places.len() as f64).cbrt()).round() as usize;
        let class = |index: usize| match &self.classes {
            Some(classes) => classes[places[index]],
            None => (index * bins / places.len()) as f64,
        };
        let (mut between, mut classes, mut begin) = (0.0, 0, 0);
        while begin < places.len() {
            let end = (begin..places.len()).find(|index| class(*index) != class(begin)).unwrap_or(places.len());
            let sum: f64 = places[begin..end].iter().map(|place| self.values[*place] - mean).sum();
            between += sum * sum / (end - begin) as f64;
            classes += 1;
            begin = end;
        }
        let count = places.len() as f64;
        1.0 - (1.0 - between / squares) * (count - 1.0) / (count - f64::from(classes))
    }
}
