//! Estimates with confidence intervals, by resampling.

use rayon::prelude::*;
use statrs::function::erf::erf_inv;

use decore_math::random::{Stream, below, hash};

/// A figure, and where it lies by its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// Ends of its interval; `None` if none was requested, or a replicate had no value.
    pub interval: Option<[f64; 2]>,
}

/// Halves of the rows at most, from which intervals come: the standard deviation of more is hardly sharper.
const MOST_HALVES: usize = 100;

/// Bootstrap for intervals: units (blocks, trajectories, rows) are drawn with replacement, as many as exist, and the figures computed again
/// (Efron and Tibshirani, *An Introduction to the Bootstrap*, 1993).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// Number of replicates; 0: no intervals.
    pub replicates: usize,
    /// Seed of the draws; every number, 0 included, is one.
    pub seed: u64,
    /// Probability of the interval, in (0, 1).
    pub level: f64,
}

impl Bootstrap {
    /// Default probability of an interval.
    pub const LEVEL: f64 = 0.95;
    /// Replicates at least, if there are any: the ends of fewer are no interval.
    pub const LEAST_REPLICATES: usize = 20;

    /// Number of draws of each of `units` in a replicate.
    fn weights(&self, replicate: usize, units: usize) -> Vec<f64> {
        let mut weights = vec![0.0; units];
        for draw in 0..units {
            let unit = below(hash(self.seed, replicate as u64, draw as u64), units as u64);
            weights[unit as usize] += 1.0;
        }
        weights
    }

    /// Figures with their intervals; `statistic` computes them for weights of the units, all 1 for the figures themselves.
    ///
    /// The ends of an interval are quantiles of the replicates.
    pub(super) fn estimates(&self, units: usize, statistic: &(dyn Fn(&[f64]) -> Vec<f64> + Sync)) -> Vec<Estimate> {
        let values = statistic(&vec![1.0; units]);
        let replicates: Vec<Vec<f64>> =
            (0..self.replicates).into_par_iter().map(|replicate| statistic(&self.weights(replicate, units))).collect();
        let estimate = |(index, value)| Estimate {
            value,
            interval: self.interval(replicates.iter().filter_map(|of| of.get(index)).copied().collect()),
        };
        values.into_iter().enumerate().map(estimate).collect()
    }

    /// Number of halves of the rows that intervals come from, where rows cannot be drawn twice: 100 at most.
    pub fn halves(&self) -> usize {
        self.replicates.min(MOST_HALVES)
    }

    /// Interval of a figure from its values for halves of the rows.
    pub(super) fn jackknife(&self, value: f64, halves: &[f64]) -> Option<[f64; 2]> {
        if halves.len() < 2 || halves.iter().any(|half| !half.is_finite()) {
            return None;
        }
        let count = halves.len() as f64;
        let mean = halves.iter().sum::<f64>() / count;
        let variance = halves.iter().map(|half| (half - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let reach = self.normal_reach() * variance.sqrt();
        Some([value - reach, value + reach])
    }

    /// Half the width of a normal distribution's interval, in standard deviations.
    fn normal_reach(&self) -> f64 {
        std::f64::consts::SQRT_2 * erf_inv(self.level)
    }

    fn interval(&self, mut replicates: Vec<f64>) -> Option<[f64; 2]> {
        if replicates.is_empty() || replicates.iter().any(|value| !value.is_finite()) {
            return None;
        }
        replicates.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - self.level);
        Some([tail, 1.0 - tail].map(|share| quantile(&replicates, share)))
    }
}

/// Quantile of ascending values, by linear interpolation between neighbours.
pub(super) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len().max(1) - 1) as f64;
    let index = place as usize;
    let at = |index: usize| sorted.get(index).or(sorted.last()).copied().unwrap_or(f64::NAN);
    at(index) + (place - index as f64) * (at(index + 1) - at(index))
}

/// Half of the rows, by chance.
pub(super) fn half(rows: usize, key: u64) -> Vec<bool> {
    let mut stream = Stream::new(key);
    let mut left = rows / 2;
    let mut chosen = vec![false; rows];
    for (row, chosen) in chosen.iter_mut().enumerate() {
        // Of the rows that are to come, each is as likely as the others.
        *chosen = stream.below(rows - row) < left;
        left -= usize::from(*chosen);
    }
    chosen
}
