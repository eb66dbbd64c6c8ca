//! Sobol' indices: shares of an output's variance due to factors alone, together with others, and in pairs.

use schemars::JsonSchema;
use serde::Serialize;

use super::error::{AnalysisError, check_values, normalised};
use super::estimate::{Bootstrap, Estimate};
use decore_quantity::named;

named! {
    /// Estimators; on one table they differ by the uncertainty of the number of base points (1e-2 for some hundreds).
    ///
    /// With `A`, `B` the outputs at the two base points of a block, `E_i` at A with factor i of B, `C_i` at B with factor i of A, `n`
    /// blocks, means over the blocks:
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
    pub enum Estimator {
        /// As SALib computes them (Saltelli et al., Comput. Phys. Commun. 181, 2010; Sobol' et al., 2007):
        /// `S1_i = mean((B - mu) (E_i - A)) / V`, `ST_i = mean((A - E_i)^2) / (2 V)`,
        /// `S2_ij = mean((C_i - mu) (E_j - mu) - (A - mu) (B - mu)) / V - S1_i - S1_j`, V the variance of A and B together, mu the mean
        /// of the whole table.
        #[default]
        Salib = "salib",
        /// Jansen (Comput. Phys. Commun. 117, 1999) as OpenTURNS computes it: `S1_i = 1 - sum((E_i - B)^2) / ((2 n - 1) V)`,
        /// `ST_i = sum((E_i - A)^2) / ((2 n - 1) V)`, V the unbiased variance of A.
        Jansen = "jansen",
        /// Martinez (2011) as in OpenTURNS: `S1_i` is the correlation of `E_i` and B, `ST_i` is 1 minus the correlation of `E_i` and A.
        Martinez = "martinez",
    }
}

/// Rows of a table that has the blocks of a Saltelli design one after the other: A, `E_1` to `E_k`, with second order `C_1` to
/// `C_k`, B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SaltelliBlocks {
    /// Number of factors, k.
    pub factors: usize,
    /// Whether the rows `C_i` are there.
    pub second_order: bool,
}

/// Share of the variance due to a pair of factors beyond each alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairIndex {
    /// The factors, by their index, the lower one first.
    pub factors: [usize; 2],
    /// The index S2.
    pub index: Estimate,
}

/// Sobol' indices of one output.
#[derive(Debug, Clone, PartialEq)]
pub struct SobolIndices {
    /// First-order indices S1, by factor.
    pub first: Vec<Estimate>,
    /// Total indices ST, by factor.
    pub total: Vec<Estimate>,
    /// Second-order indices S2; empty if the design does not serve them.
    pub second: Vec<PairIndex>,
}

impl SaltelliBlocks {
    /// Rows of a block.
    pub fn size(&self) -> usize {
        if self.second_order { 2 * self.factors + 2 } else { self.factors + 2 }
    }

    /// The pairs of factors, each once.
    fn pairs(self) -> impl Iterator<Item = [usize; 2]> {
        (0..self.factors).flat_map(move |low| (low + 1..self.factors).map(move |high| [low, high]))
    }
}

/// Sobol' indices of an output, given for the rows of `blocks`.
///
/// # Errors
/// [`AnalysisError::Length`] for part of a block, [`AnalysisError::TooFew`] for fewer than two,
/// [`AnalysisError::NotFinite`], [`AnalysisError::Constant`].
pub fn sobol(
    values: &[f64],
    blocks: SaltelliBlocks,
    estimator: Estimator,
    bootstrap: &Bootstrap,
) -> Result<SobolIndices, AnalysisError> {
    let size = blocks.size();
    if !values.len().is_multiple_of(size) {
        return Err(AnalysisError::Length { rows: values.len(), unit: "blocks", size });
    }
    let count = values.len() / size;
    if count < 2 {
        return Err(AnalysisError::TooFew { unit: "blocks", found: count, least: 2 });
    }
    check_values(values)?;
    let values = &normalised(values)[..];
    let table = CentredOutput { values, blocks, mean: values.iter().sum::<f64>() / values.len() as f64 };
    let mut estimates = bootstrap.estimates(count, &|weights| table.indices(estimator, weights)).into_iter();
    let first = estimates.by_ref().take(blocks.factors).collect();
    let total = estimates.by_ref().take(blocks.factors).collect();
    let second = blocks.pairs().zip(estimates).map(|(factors, index)| PairIndex { factors, index }).collect();
    Ok(SobolIndices { first, total, second })
}

/// An output's values with their centre.
struct CentredOutput<'a> {
    values: &'a [f64],
    blocks: SaltelliBlocks,
    mean: f64,
}

/// Weighted sums over the blocks, of centred values.
struct BlockSums {
    count: f64,
    a: f64,
    b: f64,
    aa: f64,
    bb: f64,
    ab: f64,
    factors: Vec<FactorSums>,
    /// Of `C_i E_j` for the pairs (i, j).
    pairs: Vec<f64>,
}

/// The same for one factor, `e` standing for `E_i`.
#[derive(Debug, Clone, Copy, Default)]
struct FactorSums {
    e: f64,
    ee: f64,
    ea: f64,
    eb: f64,
    /// Of `B (E_i - A)`.
    b_gain: f64,
    /// Of `(E_i - A)^2`.
    from_a: f64,
    /// Of `(E_i - B)^2`.
    from_b: f64,
}

impl BlockSums {
    fn new(blocks: SaltelliBlocks) -> Self {
        let pairs = if blocks.second_order { blocks.pairs().count() } else { 0 };
        let factors = vec![FactorSums::default(); blocks.factors];
        Self { count: 0.0, a: 0.0, b: 0.0, aa: 0.0, bb: 0.0, ab: 0.0, factors, pairs: vec![0.0; pairs] }
    }

    /// Adds a block's values.
    fn add(&mut self, weight: f64, block: &[f64], mean: f64) {
        let [a, mixed @ .., b] = block else { return };
        let (a, b) = (a - mean, b - mean);
        self.count += weight;
        self.a += weight * a;
        self.b += weight * b;
        self.aa += weight * a * a;
        self.bb += weight * b * b;
        self.ab += weight * a * b;
        for (sums, e) in self.factors.iter_mut().zip(mixed) {
            let e = e - mean;
            sums.e += weight * e;
            sums.ee += weight * e * e;
            sums.ea += weight * e * a;
            sums.eb += weight * e * b;
            sums.b_gain += weight * b * (e - a);
            sums.from_a += weight * (e - a) * (e - a);
            sums.from_b += weight * (e - b) * (e - b);
        }
        let (exchanged, back) = mixed.split_at(self.factors.len());
        let mut pairs = self.pairs.iter_mut();
        for (low, c) in back.iter().enumerate() {
            for (e, sum) in exchanged[low + 1..].iter().zip(pairs.by_ref()) {
                *sum += weight * (c - mean) * (e - mean);
            }
        }
    }

    /// First-order and total index of a factor.
    fn first_and_total(&self, sums: &FactorSums, estimator: Estimator) -> [f64; 2] {
        let n = self.count;
        match estimator {
            Estimator::Salib => [sums.b_gain / n, 0.5 * sums.from_a / n].map(|share| share / self.variance(estimator)),
            Estimator::Jansen => {
                let [from_a, from_b] =
                    [sums.from_a, sums.from_b].map(|sum| sum / (2.0 * n - 1.0) / self.variance(estimator));
                [1.0 - from_b, from_a]
            }
            Estimator::Martinez => {
                let correlation = |square: f64, product: f64, sum: f64| {
                    let spread = (sums.ee - sums.e * sums.e / n) * (square - sum * sum / n);
                    (product - sums.e * sum / n) / spread.sqrt()
                };
                [correlation(self.bb, sums.eb, self.b), 1.0 - correlation(self.aa, sums.ea, self.a)]
            }
        }
    }

    /// The variance that is shared out.
    fn variance(&self, estimator: Estimator) -> f64 {
        match estimator {
            Estimator::Salib => {
                let mean = (self.a + self.b) / (2.0 * self.count);
                (self.aa + self.bb) / (2.0 * self.count) - mean * mean
            }
            Estimator::Jansen | Estimator::Martinez => (self.aa - self.a * self.a / self.count) / (self.count - 1.0),
        }
    }

    /// The mean of `C_i E_j` for a pair's sum; OpenTURNS takes the unbiased one.
    fn pair_mean(&self, sum: f64, estimator: Estimator) -> f64 {
        match estimator {
            Estimator::Salib => sum / self.count,
            Estimator::Jansen | Estimator::Martinez => sum / (self.count - 1.0),
        }
    }
}

impl CentredOutput<'_> {
    /// S1 of all factors, ST of all, S2 of all pairs, with this weight for each block.
    fn indices(&self, estimator: Estimator, weights: &[f64]) -> Vec<f64> {
        let mut sums = BlockSums::new(self.blocks);
        for (block, weight) in self.values.chunks_exact(self.blocks.size()).zip(weights) {
            if *weight != 0.0 {
                sums.add(*weight, block, self.mean);
            }
        }
        let shares: Vec<[f64; 2]> = sums.factors.iter().map(|factor| sums.first_and_total(factor, estimator)).collect();
        let variance = sums.variance(estimator);
        let second = self.blocks.pairs().zip(&sums.pairs).map(|([low, high], sum)| {
            let together = (sums.pair_mean(*sum, estimator) - sums.ab / sums.count) / variance;
            together - shares[low][0] - shares[high][0]
        });
        [0, 1].into_iter().flat_map(|order| shares.iter().map(move |share| share[order])).chain(second).collect()
    }
}
