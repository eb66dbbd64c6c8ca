//! Position of a point along one factor, before the factor's distribution turns it into a value.

use super::distribution::{Distribution, Level, whole_geometric};

/// Place of a row along one factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coordinate {
    /// A probability in [0, 1]: the value is the quantile.
    Probability(f64),
    /// A stratum of equal probability and the place within it, in [0, 1).
    ///
    /// Kept apart from [`Coordinate::Probability`] because whole strata go to integers and categories.
    Stratum {
        /// Index of the stratum, from 0.
        stratum: u64,
        /// Number of strata.
        strata: u64,
        /// Place within the stratum.
        place: f64,
    },
    /// A level of a grid, ends included.
    Step {
        /// Index of the level, from 0.
        step: u64,
        /// Number of levels.
        count: u64,
    },
    /// A share of the range, in [0, 1].
    Share(f64),
    /// A value given by the user.
    Value(Level),
}

impl Coordinate {
    /// The factor's value there.
    pub fn level(&self, distribution: &Distribution) -> Level {
        match *self {
            Self::Probability(probability) => distribution.quantile(probability),
            Self::Share(share) => distribution.at_share(share),
            Self::Value(level) => level,
            Self::Step { step, count } => grid_level(distribution, step, count),
            Self::Stratum { stratum, strata, place } => stratum_level(distribution, (stratum, strata), place),
        }
    }

    /// The coordinate in the unit cube in which designs are measured.
    ///
    /// Real factors: the probability, or the share of the range where the design works with shares. Integers and
    /// categories: the middle of the value's step.
    pub fn unit(&self, distribution: &Distribution) -> f64 {
        if distribution.value_count().is_some() {
            return distribution.cdf(self.level(distribution));
        }
        match *self {
            Self::Probability(share) | Self::Share(share) => share,
            Self::Stratum { stratum, strata, place } => (stratum as f64 + place) / strata as f64,
            Self::Step { step, count } => step as f64 / (count.max(2) - 1) as f64,
            Self::Value(level) => distribution.cdf(level),
        }
    }
}

/// Value in a stratum, at `place` in [0, 1) within it.
fn stratum_level(distribution: &Distribution, (stratum, strata): (u64, u64), place: f64) -> Level {
    let Some(values) = distribution.even_count() else {
        return distribution.quantile((stratum as f64 + place) / strata as f64);
    };
    let first = |stratum: u128| (stratum * u128::from(values) / u128::from(strata)) as u64;
    // Fewer values than strata: whole strata go to values, so that counts differ by one at most. More values: each stratum
    // chooses among its own, so that no value comes twice.
    let start = first(u128::from(stratum));
    let own = first(u128::from(stratum) + 1).saturating_sub(start).max(1);
    distribution.discrete(start + ((place * own as f64) as u64).min(own - 1))
}

/// Value at level `step` of `count`, ends included.
fn grid_level(distribution: &Distribution, step: u64, count: u64) -> Level {
    let Some(values) = distribution.value_count() else {
        return distribution.at_share(step as f64 / (count.max(2) - 1) as f64);
    };
    match *distribution {
        // More levels than values cannot all be different.
        Distribution::LogInteger { .. } if count > values => {
            return distribution.at_share(step as f64 / (count.max(2) - 1) as f64);
        }
        Distribution::LogInteger { low, high } if count < values => {
            return Level::Integer(whole_geometric([low, high], step, count));
        }
        _ => {}
    }
    let last = u128::from(values - 1);
    let steps = u128::from(count.max(2) - 1);
    // Rounded to the nearest value, halves upwards.
    distribution.discrete(((2 * u128::from(step) * last + steps) / (2 * steps)) as u64)
}
