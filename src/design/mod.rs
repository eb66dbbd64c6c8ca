//! Designs of experiments: which values the factors take in which row.
//!
//! Everything is a pure function of (design, row): no row needs the rows before it, so rows may run in any order, on any
//! number of threads, and be found again after an interruption. Factors are numbers or indices of categories here; what
//! they drive is the study's business.

mod permutation;

use permutation::{Permutation, hash, uniform};

/// What a factor varies over.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// Integer, all of low..=high equally likely.
    Integer {
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

/// One factor of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// What it varies over.
    pub distribution: Distribution,
    /// Number of levels in a grid, ends included. Needed there for real factors; integers and categories default to all
    /// their values. Not used by a Latin hypercube.
    pub levels: Option<usize>,
}

/// How the rows are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One row; only for a design without factors.
    Single,
    /// Every combination of the factors' levels; the last factor changes fastest.
    FullFactorial,
    /// Latin hypercube: every factor's range is cut into `rows` strata of equal probability and each is hit once.
    ///
    /// Integers and categories take each of their values `floor(rows / n)` or `ceil(rows / n)` times.
    LatinHypercube {
        /// Number of rows.
        rows: usize,
        /// Place of a point within its stratum.
        placement: Placement,
    },
}

/// Place of a point within its stratum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Placement {
    /// Uniform at random.
    #[default]
    Random,
    /// In the stratum's middle.
    Centred,
}

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

/// Why a design cannot be built. `factor` is the factor's index.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// An end is not finite.
    #[error("the range's ends must be finite numbers, they are {low} and {high}")]
    NotFinite {
        /// Index of the factor.
        factor: usize,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// The range is empty.
    #[error("the range [{low}, {high}] is empty: the lower end comes first and is the smaller one")]
    EmptyRange {
        /// Index of the factor.
        factor: usize,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A logarithmic range must be positive.
    #[error("a logarithmic range needs positive ends, the lower one is {low}")]
    NotPositive {
        /// Index of the factor.
        factor: usize,
        /// Lower end.
        low: f64,
    },
    /// A factor without values.
    #[error("there are no values to choose from")]
    NoCategories {
        /// Index of the factor.
        factor: usize,
    },
    /// A grid needs levels.
    #[error("a full factorial needs `levels` (2 or more) for a range of real numbers")]
    LevelsNeeded {
        /// Index of the factor.
        factor: usize,
    },
    /// More levels than values, or too few levels.
    #[error("{levels} levels do not fit: expected 2 to {most}")]
    Levels {
        /// Index of the factor.
        factor: usize,
        /// Levels asked for.
        levels: usize,
        /// The most there can be.
        most: u64,
    },
    /// No row at all.
    #[error("a design needs at least one row")]
    NoRows,
    /// A design of several rows without factors, or the other way round.
    #[error("{0}")]
    Factors(&'static str),
    /// The number of rows does not fit a machine word.
    #[error("the design has too many rows to count: reduce the levels")]
    TooManyRows,
}

impl DesignError {
    /// Index of the factor at fault, where it is one factor's.
    pub fn factor(&self) -> Option<usize> {
        match self {
            Self::NotFinite { factor, .. }
            | Self::EmptyRange { factor, .. }
            | Self::NotPositive { factor, .. }
            | Self::NoCategories { factor }
            | Self::LevelsNeeded { factor }
            | Self::Levels { factor, .. } => Some(*factor),
            Self::NoRows | Self::Factors(_) | Self::TooManyRows => None,
        }
    }
}

/// A checked design.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    kind: Kind,
    factors: Vec<Factor>,
    seed: u64,
    rows: usize,
}

impl Design {
    /// Checks the factors and counts the rows.
    ///
    /// # Errors
    /// [`DesignError`] for a factor or kind that gives no design.
    pub fn new(kind: Kind, factors: Vec<Factor>, seed: u64) -> Result<Self, DesignError> {
        for (index, factor) in factors.iter().enumerate() {
            factor.distribution.check(index)?;
        }
        let rows = match kind {
            Kind::Single if factors.is_empty() => 1,
            Kind::Single => {
                return Err(DesignError::Factors("factors are given, but no kind of design"));
            }
            _ if factors.is_empty() => {
                return Err(DesignError::Factors("a design needs at least one factor"));
            }
            Kind::FullFactorial => count_combinations(&factors)?,
            Kind::LatinHypercube { rows: 0, .. } => return Err(DesignError::NoRows),
            Kind::LatinHypercube { rows, .. } => rows,
        };
        Ok(Self { kind, factors, seed, rows })
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.rows
    }

    /// How the rows are chosen.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The factors, in order.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Seed of the random numbers.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Values of all factors in this row; `None` past the last row.
    pub fn row(&self, row: usize) -> Option<Vec<Level>> {
        if row >= self.rows {
            return None;
        }
        Some(match self.kind {
            Kind::Single => Vec::new(),
            Kind::FullFactorial => self.grid_row(row),
            Kind::LatinHypercube { placement, .. } => self.hypercube_row(row, placement),
        })
    }

    fn grid_row(&self, row: usize) -> Vec<Level> {
        let mut rest = row as u64;
        let mut levels: Vec<Level> = self
            .factors
            .iter()
            .rev()
            .map(|factor| {
                // `new` has made sure that every factor has its levels.
                let count = factor.level_count(0).unwrap_or(1);
                let step = rest % count;
                rest /= count;
                factor.distribution.grid_level(step, count)
            })
            .collect();
        levels.reverse();
        levels
    }

    fn hypercube_row(&self, row: usize, placement: Placement) -> Vec<Level> {
        let (row, rows) = (row as u64, self.rows as u64);
        let level = |(index, factor): (usize, &Factor)| {
            // Two streams per factor: one for the permutation, one for the places within the strata.
            let stream = 2 * index as u64;
            let stratum = Permutation::new(hash(self.seed, stream, 0), rows).at(row);
            let place = match placement {
                Placement::Random => uniform(self.seed, stream + 1, row),
                Placement::Centred => 0.5,
            };
            factor.distribution.stratum_level(stratum, rows, place)
        };
        self.factors.iter().enumerate().map(level).collect()
    }
}

impl Factor {
    /// Number of levels in a grid; `index` is for the error.
    fn level_count(&self, index: usize) -> Result<u64, DesignError> {
        match (self.distribution.value_count(), self.levels) {
            (Some(all), None) => Ok(all),
            (None, None) => Err(DesignError::LevelsNeeded { factor: index }),
            (all, Some(levels)) => {
                let most = all.unwrap_or(u64::MAX);
                let wanted = levels as u64;
                if wanted < 2.min(most) || wanted > most {
                    return Err(DesignError::Levels { factor: index, levels, most });
                }
                Ok(wanted)
            }
        }
    }
}

impl Distribution {
    fn check(&self, factor: usize) -> Result<(), DesignError> {
        match *self {
            Self::Uniform { low, high } | Self::LogUniform { low, high } => {
                if !(low.is_finite() && high.is_finite() && (high - low).is_finite()) {
                    return Err(DesignError::NotFinite { factor, low, high });
                }
                if low >= high {
                    return Err(DesignError::EmptyRange { factor, low, high });
                }
                if matches!(self, Self::LogUniform { .. }) && low <= 0.0 {
                    return Err(DesignError::NotPositive { factor, low });
                }
                Ok(())
            }
            Self::Integer { low, high } if low > high => {
                let (low, high) = (low as f64, high as f64);
                Err(DesignError::EmptyRange { factor, low, high })
            }
            Self::Categories { count: 0 } => Err(DesignError::NoCategories { factor }),
            Self::Integer { .. } | Self::Categories { .. } => Ok(()),
        }
    }

    /// Number of different values; `None` for real ones.
    fn value_count(&self) -> Option<u64> {
        match *self {
            Self::Uniform { .. } | Self::LogUniform { .. } => None,
            Self::Integer { low, high } => Some(high.abs_diff(low).saturating_add(1)),
            Self::Categories { count } => Some(count as u64),
        }
    }

    /// Value below which the share `probability` in [0, 1] of a real distribution lies; never outside its range.
    fn real(low: f64, high: f64, probability: f64) -> f64 {
        (low + (high - low) * probability).clamp(low, high)
    }

    /// The discrete value number `index`, from 0.
    fn discrete(&self, index: u64) -> Level {
        match *self {
            Self::Integer { low, .. } => Level::Integer(low.wrapping_add_unsigned(index)),
            _ => Level::Category(index as usize),
        }
    }

    /// Value at level `step` of `count`, ends included.
    fn grid_level(&self, step: u64, count: u64) -> Level {
        let share = step as f64 / (count.max(2) - 1) as f64;
        match *self {
            Self::Uniform { low, high } => Level::Real(Self::real(low, high, share)),
            Self::LogUniform { low, high } => Level::Real(geometric(low, high, share)),
            Self::Integer { .. } | Self::Categories { .. } => {
                let last = u128::from(self.value_count().unwrap_or(1) - 1);
                let steps = u128::from(count.max(2) - 1);
                // Rounded to the nearest value, halves upwards.
                let index = (2 * u128::from(step) * last + steps) / (2 * steps);
                self.discrete(index as u64)
            }
        }
    }

    /// Value in stratum `stratum` of `strata`, at `place` in [0, 1) within it.
    fn stratum_level(&self, stratum: u64, strata: u64, place: f64) -> Level {
        let probability = (stratum as f64 + place) / strata as f64;
        match *self {
            Self::Uniform { low, high } => Level::Real(Self::real(low, high, probability)),
            Self::LogUniform { low, high } => Level::Real(geometric(low, high, probability)),
            Self::Integer { .. } | Self::Categories { .. } => {
                let (count, strata) = (u128::from(self.value_count().unwrap_or(1)), u128::from(strata));
                let first = |stratum: u128| (stratum * count / strata) as u64;
                // Fewer values than strata: whole strata go to values, so that counts differ by one at most. More values:
                // each stratum chooses among its own, so that no value comes twice.
                let start = first(u128::from(stratum));
                let own = first(u128::from(stratum) + 1).saturating_sub(start).max(1);
                let chosen = ((place * own as f64) as u64).min(own - 1);
                self.discrete(start + chosen)
            }
        }
    }
}

/// Point at `share` between two positive ends on a logarithmic scale.
fn geometric(low: f64, high: f64, share: f64) -> f64 {
    (low.ln() + share * (high.ln() - low.ln())).exp().clamp(low, high)
}

fn count_combinations(factors: &[Factor]) -> Result<usize, DesignError> {
    let mut rows = 1_usize;
    for (index, factor) in factors.iter().enumerate() {
        let levels = usize::try_from(factor.level_count(index)?).map_err(|_| DesignError::TooManyRows)?;
        rows = rows.checked_mul(levels).ok_or(DesignError::TooManyRows)?;
    }
    Ok(rows)
}
