//! Reasons why there is no model.

use decore_math::linalg::LinalgError;

/// Reason why a table has no model, or a model no prediction.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegressionError {
    /// Fewer rows than a model takes; rows at one place are one.
    #[error("{found} different rows are too few: at least {least} are needed")]
    TooFew {
        /// Rows that there are.
        found: usize,
        /// Rows that are needed.
        least: usize,
    },
    /// All values are the same except for rounding.
    #[error("it is constant ({value}): there is nothing to model")]
    Constant {
        /// The value.
        value: f64,
    },
    /// A value or a coordinate is NaN or infinite.
    #[error("row {row} has a value that is {value}, where a finite number is needed")]
    NotFinite {
        /// Place in the table, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// Lists whose lengths do not belong together.
    #[error("{found} {what}, where {expected} are expected")]
    Size {
        /// Name of the counted items.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Expected number.
        expected: usize,
    },
    /// A parameter of a model that is out of its range.
    #[error("the parameter {name} is {value}, where {expected} is needed")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Permitted values.
        expected: &'static str,
    },
    /// A term of a polynomial stands on rows alone that are left out together: without them it is open.
    #[error("one of its terms depends on a single row or place, which cannot be left out for Q2")]
    Alone,
    /// A factorisation failed.
    #[error("the correlations of the rows: {0}")]
    Linalg(#[from] LinalgError),
}
