//! Marginal distributions of factors: quantiles, distribution functions, ranges.

use std::sync::Arc;

use libm::{exp, log, log10};

use super::DesignError;
use decore_math::special::{beta_cdf, beta_quantile, normal_cdf, normal_quantile};

/// Tail probability at which a distribution without ends is cut where a design needs a range (grids, axial points).
const TAIL: f64 = 0.005;

/// Domain of a factor.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Real number, uniform in [low, high].
    Uniform {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Real number whose logarithm is uniform in [log low, log high]; `low` must be positive.
    LogUniform {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Real number, normal. Where a design needs a range, it is the one between the 0.5 % and 99.5 % quantiles.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, positive.
        std_dev: f64,
    },
    /// Real number, normal before all outside [low, high] is cut off.
    TruncatedNormal {
        /// Mean of the normal distribution that is cut.
        mean: f64,
        /// Standard deviation of the normal distribution that is cut, positive.
        std_dev: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Real number, triangular in [low, high] with the most likely value `mode`.
    Triangular {
        /// Lower end.
        low: f64,
        /// Most likely value, in [low, high].
        mode: f64,
        /// Upper end.
        high: f64,
    },
    /// Real number, beta distributed in [low, high]: density proportional to `t^(alpha-1) (1-t)^(beta-1)`.
    Beta {
        /// First shape, positive.
        alpha: f64,
        /// Second shape, positive.
        beta: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Real number as observed: quantiles are interpolated linearly between the ascending observations.
    Empirical {
        /// Observations, ascending, at least two different ones.
        sorted: Arc<[f64]>,
    },
    /// Integer, all of low..=high equally likely.
    Integer {
        /// Smallest value.
        low: i64,
        /// Largest value.
        high: i64,
    },
    /// Integer from low to high, 1 or more: a real number rounded whose logarithm is uniform in [log (low - 1/2),
    /// log (high + 1/2)].
    LogInteger {
        /// Smallest value.
        low: i64,
        /// Largest value.
        high: i64,
    },
    /// One of so many categories, equally likely.
    Categories {
        /// Number of categories.
        count: usize,
    },
}

/// Digits of a decimal number that a user types or expects.
const DECIMAL_DIGITS: i32 = 12;
/// Decimal places that any number is looked at with.
const MOST_PLACES: i32 = 320;
/// Rounding of a level, as a share of the larger end of its range.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Value of a factor in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// Of a real factor.
    Real(f64),
    /// Of an integer factor.
    Integer(i64),
    /// Index of a category, from 0.
    Category(usize),
}

impl Distribution {
    /// An empirical distribution of observations in any order.
    pub fn empirical(mut observations: Vec<f64>) -> Self {
        observations.sort_by(f64::total_cmp);
        Self::Empirical { sorted: observations.into() }
    }

    pub(super) fn check(&self, factor: usize) -> Result<(), DesignError> {
        let parameter = |parameter, found, expected| Err(DesignError::Parameter { factor, parameter, found, expected });
        match *self {
            Self::Uniform { low, high } => check_range(factor, low, high),
            Self::LogUniform { low, high } => {
                check_range(factor, low, high)?;
                if low <= 0.0 { Err(DesignError::NotPositive { factor, low }) } else { Ok(()) }
            }
            Self::Normal { mean, std_dev } | Self::TruncatedNormal { mean, std_dev, .. } => {
                if !mean.is_finite() {
                    return parameter("mean", mean, "a finite number");
                }
                if !(std_dev > 0.0 && std_dev.is_finite()) {
                    return parameter("std_dev", std_dev, "a positive number");
                }
                let Self::TruncatedNormal { low, high, .. } = *self else { return Ok(()) };
                check_range(factor, low, high)?;
                // Further out the distribution function has no digits left to interpolate.
                let nearest = (mean.clamp(low, high) - mean).abs() / std_dev;
                if nearest > 30.0 {
                    return parameter("mean", mean, "a mean within 30 standard deviations of the range");
                }
                Ok(())
            }
            Self::Triangular { low, mode, high } => {
                check_range(factor, low, high)?;
                if (low..=high).contains(&mode) { Ok(()) } else { parameter("mode", mode, "a value in the range") }
            }
            Self::Beta { alpha, beta, low, high } => {
                check_range(factor, low, high)?;
                for (name, shape) in [("alpha", alpha), ("beta", beta)] {
                    if !(1e-3..=1e6).contains(&shape) {
                        return parameter(name, shape, "a shape from 0.001 to 1e6");
                    }
                }
                Ok(())
            }
            Self::Empirical { ref sorted } => match (sorted.first(), sorted.last()) {
                (Some(&low), Some(&high)) => check_range(factor, low, high),
                _ => Err(DesignError::NoCategories { factor }),
            },
            Self::LogInteger { low, .. } if low < 1 => Err(DesignError::NotPositive { factor, low: low as f64 }),
            Self::Integer { low, high } | Self::LogInteger { low, high } if low > high => {
                let (low, high) = (low as f64, high as f64);
                Err(DesignError::EmptyRange { factor, low, high })
            }
            Self::Categories { count: 0 } => Err(DesignError::NoCategories { factor }),
            Self::Integer { .. } | Self::LogInteger { .. } | Self::Categories { .. } => Ok(()),
        }
    }

    /// Number of different values; `None` for real ones.
    pub fn value_count(&self) -> Option<u64> {
        match *self {
            Self::Integer { low, high } | Self::LogInteger { low, high } => Some(high.abs_diff(low).saturating_add(1)),
            Self::Categories { count } => Some(count as u64),
            _ => None,
        }
    }

    /// Number of different values where all are equally likely; `None` for others.
    pub(super) fn even_count(&self) -> Option<u64> {
        self.value_count().filter(|_| !matches!(self, Self::LogInteger { .. }))
    }

    /// Ends of a real distribution: its own, or the 0.5 % and 99.5 % quantiles where it has none. `None` for others.
    pub fn range(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Uniform { low, high }
            | Self::LogUniform { low, high }
            | Self::TruncatedNormal { low, high, .. }
            | Self::Triangular { low, high, .. }
            | Self::Beta { low, high, .. } => Some((low, high)),
            Self::Normal { mean, std_dev } => {
                let reach = std_dev * normal_quantile(1.0 - TAIL);
                Some((mean - reach, mean + reach))
            }
            Self::Empirical { ref sorted } => Some((*sorted.first()?, *sorted.last()?)),
            Self::Integer { .. } | Self::LogInteger { .. } | Self::Categories { .. } => None,
        }
    }

    /// Level at `share` in [0, 1] of the range: linear (geometric for logarithmic distributions), whatever the
    /// probabilities; discrete ones are rounded to the nearest value. A level that differs by rounding alone from a decimal number of
    /// few digits is that number: 0.08, not 0.07999999999999999.
    pub fn at_share(&self, share: f64) -> Level {
        match (self, self.range()) {
            (Self::LogUniform { low, high }, _) => Level::Real(decimal(geometric(*low, *high, share), [*low, *high])),
            (Self::LogInteger { low, high }, _) => {
                Level::Integer(whole(geometric(*low as f64, *high as f64, share), [*low, *high]))
            }
            (_, Some((low, high))) => {
                // Rounding errs alike from both ends: symmetric ranges have symmetric levels.
                let value = low * (1.0 - share) + high * share;
                Level::Real(decimal(value.clamp(low, high), [low, high]))
            }
            (_, None) => {
                let last = self.value_count().unwrap_or(1) - 1;
                self.discrete(((share * last as f64).round() as u64).min(last))
            }
        }
    }

    /// Returns the position of a level in the range, in [0, 1]. Inverse of [`Distribution::at_share`]; discrete levels lie in the middle of
    /// their steps.
    pub fn share(&self, level: Level) -> f64 {
        match (self, level, self.range()) {
            (Self::LogUniform { low, high }, Level::Real(value), _) => {
                ((log(value) - log(*low)) / (log(*high) - log(*low))).clamp(0.0, 1.0)
            }
            (_, Level::Real(value), Some((low, high))) if high > low => ((value - low) / (high - low)).clamp(0.0, 1.0),
            _ => self.cdf(level),
        }
    }

    /// Quantile: the level below which the share `probability` in [0, 1] of the distribution lies.
    ///
    /// Finite and within the ends even at 0 and 1: the tails of a normal distribution are cut at probabilities of 2^-53.
    pub fn quantile(&self, probability: f64) -> Level {
        if let Some(count) = self.even_count() {
            return self.discrete(((probability * count as f64) as u64).min(count - 1));
        }
        let u = probability.clamp(0.0, 1.0);
        let value = match *self {
            Self::LogUniform { low, high } => return Level::Real(geometric(low, high, u)),
            Self::LogInteger { low, high } => {
                return Level::Integer(whole(geometric(low as f64 - 0.5, high as f64 + 0.5, u), [low, high]));
            }
            Self::Normal { mean, std_dev } => {
                let half_step = f64::EPSILON / 2.0;
                return Level::Real(mean + std_dev * normal_quantile(u.clamp(half_step, 1.0 - half_step)));
            }
            Self::TruncatedNormal { mean, std_dev, low, high } => {
                let (a, b) = ((low - mean) / std_dev, (high - mean) / std_dev);
                // The upper tail is mirrored, where the distribution function keeps its digits.
                let inner =
                    |a: f64, b: f64, u: f64| normal_quantile(normal_cdf(a) + u * (normal_cdf(b) - normal_cdf(a)));
                mean + std_dev * if a > 0.0 { -inner(-b, -a, 1.0 - u) } else { inner(a, b, u) }
            }
            Self::Triangular { low, mode, high } => {
                let peak = (mode - low) / (high - low);
                if u < peak {
                    low + (u * (high - low) * (mode - low)).sqrt()
                } else {
                    high - ((1.0 - u) * (high - low) * (high - mode)).sqrt()
                }
            }
            Self::Beta { alpha, beta, low, high } => low + (high - low) * beta_quantile(alpha, beta, u),
            Self::Empirical { ref sorted } => interpolate(sorted, u),
            Self::Uniform { low, high } => low + (high - low) * u,
            Self::Integer { .. } | Self::Categories { .. } => 0.0,
        };
        let (low, high) = self.range().unwrap_or((value, value));
        Level::Real(value.clamp(low, high))
    }

    /// Distribution function at a level, in [0, 1]; for discrete ones the middle of the value's step.
    pub fn cdf(&self, level: Level) -> f64 {
        let x = match (level, self) {
            (Level::Category(index), _) => {
                return (index as f64 + 0.5) / self.value_count().unwrap_or(1) as f64;
            }
            (Level::Integer(value), Self::Integer { low, .. }) => {
                return (value.abs_diff(*low) as f64 + 0.5) / self.value_count().unwrap_or(1) as f64;
            }
            (Level::Integer(value), Self::LogInteger { low, high }) => {
                let [low, high] = [*low as f64 - 0.5, *high as f64 + 0.5].map(log);
                let [below, above] = [value as f64 - 0.5, value as f64 + 0.5].map(|end| log(end.max(0.5)));
                return ((0.5 * (below + above) - low) / (high - low)).clamp(0.0, 1.0);
            }
            (Level::Integer(value), _) => value as f64,
            (Level::Real(value), _) => value,
        };
        let share = match *self {
            Self::Uniform { low, high } => (x - low) / (high - low),
            Self::LogUniform { low, high } => log(x.max(low) / low) / log(high / low),
            Self::Normal { mean, std_dev } => normal_cdf((x - mean) / std_dev),
            Self::TruncatedNormal { mean, std_dev, low, high } => {
                let [a, z, b] = [low, x.clamp(low, high), high].map(|end| (end - mean) / std_dev);
                let share = |a: f64, z: f64, b: f64| (normal_cdf(z) - normal_cdf(a)) / (normal_cdf(b) - normal_cdf(a));
                if a > 0.0 { 1.0 - share(-b, -z, -a) } else { share(a, z, b) }
            }
            Self::Triangular { low, mode, high } if x < mode => (x - low).powi(2) / ((high - low) * (mode - low)),
            Self::Triangular { low, mode, high } if x < high => {
                1.0 - (high - x).powi(2) / ((high - low) * (high - mode))
            }
            Self::Beta { alpha, beta, low, high } => beta_cdf(alpha, beta, ((x - low) / (high - low)).clamp(0.0, 1.0)),
            Self::Empirical { ref sorted } => position(sorted, x),
            _ => 1.0,
        };
        share.clamp(0.0, 1.0)
    }

    /// The discrete value number `index`, from 0.
    pub(super) fn discrete(&self, index: u64) -> Level {
        match *self {
            Self::Integer { low, .. } | Self::LogInteger { low, .. } => {
                Level::Integer(low.wrapping_add_unsigned(index))
            }
            _ => Level::Category(index as usize),
        }
    }
}

fn check_range(factor: usize, low: f64, high: f64) -> Result<(), DesignError> {
    if !(low.is_finite() && high.is_finite() && (high - low).is_finite()) {
        return Err(DesignError::NotFinite { factor, low, high });
    }
    if low >= high { Err(DesignError::EmptyRange { factor, low, high }) } else { Ok(()) }
}

/// The whole number nearest to a real one, within the ends.
fn whole(value: f64, [low, high]: [i64; 2]) -> i64 {
    (value.round() as i64).clamp(low, high)
}

/// `count` different whole numbers from `low` to `high`, ends included, the one number `step`: each as near to equal ratios as
/// those before it leave.
pub(super) fn whole_geometric([low, high]: [i64; 2], step: u64, count: u64) -> i64 {
    let mut value = low;
    for taken in 0..step {
        let left = count - 1 - taken;
        let next = geometric(value as f64, high as f64, 1.0 / left as f64);
        // Enough values must remain for the levels to come.
        value = whole(next, [value + 1, high.saturating_sub_unsigned(left - 1)]);
    }
    value
}

/// Point at `share` between two positive ends on a logarithmic scale.
fn geometric(low: f64, high: f64, share: f64) -> f64 {
    exp(log(low) + share * (log(high) - log(low))).clamp(low, high)
}

/// The decimal number of twelve digits of the larger end that a value differs from by rounding alone; otherwise the value.
fn decimal(value: f64, [low, high]: [f64; 2]) -> f64 {
    let size = low.abs().max(high.abs());
    if size == 0.0 || !size.is_finite() {
        return value;
    }
    let places = (DECIMAL_DIGITS - 1).saturating_sub(log10(size).floor() as i32).clamp(0, MOST_PLACES) as usize;
    let near = format!("{value:.places$}").parse().map_or(value, |near: f64| near + 0.0);
    if (near - value).abs() <= ROUNDING * size && (low..=high).contains(&near) { near } else { value }
}

/// Value at `share` in [0, 1] along ascending observations.
fn interpolate(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len().max(1) - 1) as f64;
    let index = place as usize;
    let at = |index: usize| sorted.get(index).or(sorted.last()).copied().unwrap_or(0.0);
    at(index) + (place - index as f64) * (at(index + 1) - at(index))
}

/// Inverse of [`interpolate`].
fn position(sorted: &[f64], x: f64) -> f64 {
    let last = (sorted.len().max(2) - 1) as f64;
    let above = sorted.partition_point(|value| *value <= x);
    match (above.checked_sub(1).and_then(|below| sorted.get(below)), sorted.get(above)) {
        (None, _) => 0.0,
        (_, None) => 1.0,
        (Some(low), Some(high)) => ((above - 1) as f64 + (x - low) / (high - low)) / last,
    }
}
