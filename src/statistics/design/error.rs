//! Reasons why a design cannot be built.

/// Most rows of a design: a millisecond each would take a day.
pub const MOST_ROWS: usize = 100_000_000;

/// Reason why a design cannot be built. `factor` is the factor's index.
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
    /// A parameter of a distribution does not fit.
    #[error("`{parameter}` is {found}, expected {expected}")]
    Parameter {
        /// Index of the factor.
        factor: usize,
        /// Name of the parameter.
        parameter: &'static str,
        /// Found value.
        found: f64,
        /// Expected value.
        expected: &'static str,
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
    /// A kind of design that cannot take such a factor.
    #[error("{expected}")]
    FactorKind {
        /// Index of the factor.
        factor: usize,
        /// Requirement of the kind of design.
        expected: &'static str,
    },
    /// No row at all.
    #[error("a design needs at least one row")]
    NoRows,
    /// A setting of the kind does not fit; the key's name comes first.
    #[error("{message}")]
    Setting {
        /// Name of the setting.
        key: &'static str,
        /// The fault and its remedy.
        message: String,
    },
    /// A design of several rows without factors, or the other way round.
    #[error("{0}")]
    Factors(&'static str),
    /// More than [`MOST_ROWS`] rows.
    #[error(
        "the design has more than {MOST_ROWS} rows, the most: take fewer rows, levels or points, or several studies"
    )]
    TooManyRows,
    /// The rank correlations cannot be had.
    #[error("{0}")]
    Correlation(String),
    /// The constraints leave too little.
    #[error("{0}")]
    Unsatisfiable(String),
    /// A constraint cannot be evaluated.
    #[error("a constraint cannot be evaluated: {0}")]
    Constraint(String),
}

impl DesignError {
    /// Index of the factor at fault, where it is one factor's.
    pub fn factor(&self) -> Option<usize> {
        match self {
            Self::NotFinite { factor, .. }
            | Self::EmptyRange { factor, .. }
            | Self::NotPositive { factor, .. }
            | Self::Parameter { factor, .. }
            | Self::NoCategories { factor }
            | Self::LevelsNeeded { factor }
            | Self::FactorKind { factor, .. }
            | Self::Levels { factor, .. } => Some(*factor),
            _ => None,
        }
    }

    pub(super) fn setting(key: &'static str, message: impl Into<String>) -> Self {
        Self::Setting { key, message: message.into() }
    }
}
