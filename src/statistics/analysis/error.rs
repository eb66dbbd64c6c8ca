//! Reasons why there are no indices.

/// Reason why a table has no indices.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AnalysisError {
    /// A value is NaN or infinite.
    #[error("the value of row {row} is {value}, where a finite number is needed")]
    NotFinite {
        /// Place in the table, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// All values are the same except for rounding: there is no variance to share out.
    #[error("it is constant ({value}): there is no variance to share out")]
    Constant {
        /// The value.
        value: f64,
    },
    /// Too few units (blocks, trajectories, rows).
    #[error("{found} {unit} are too few: at least {least} are needed")]
    TooFew {
        /// Units, in the plural.
        unit: &'static str,
        /// Number found.
        found: usize,
        /// Smallest permitted number.
        least: usize,
    },
    /// The table does not consist of whole blocks or trajectories.
    #[error("{rows} rows are not a whole number of {unit} of {size} rows")]
    Length {
        /// Rows of the table.
        rows: usize,
        /// Required units, in the plural.
        unit: &'static str,
        /// Rows of one of them.
        size: usize,
    },
    /// More factors than there is time for.
    #[error("{found} factors are too many: at most {most}, as the time doubles with each")]
    Factors {
        /// Number found.
        found: usize,
        /// Largest permitted number.
        most: usize,
    },
    /// From one row of a trajectory to the next, another number of factors than one changes.
    #[error("rows {row} and {} differ in {changed} factors, where a trajectory changes one at a time", row + 1)]
    NoTrajectory {
        /// The first of the two rows.
        row: usize,
        /// Number of factors that change.
        changed: usize,
    },
}

/// The range of finite values that are not all the same.
///
/// # Errors
/// [`AnalysisError::NotFinite`]; [`AnalysisError::Constant`] where they differ by rounding at most.
pub(super) fn check_values(values: &[f64]) -> Result<(), AnalysisError> {
    if let Some((row, &value)) = values.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        return Err(AnalysisError::NotFinite { row, value });
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let rounding = 4.0 * f64::EPSILON * low.abs().max(high.abs());
    if high - low > rounding { Ok(()) } else { Err(AnalysisError::Constant { value: high }) }
}

/// Finite values that differ, moved and scaled to [-1, 1]: indices do not depend on either, sums of squares far from 0 or beyond
/// 1e154 do.
pub(super) fn normalised(values: &[f64]) -> Vec<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (middle, reach) = (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
    values.iter().map(|value| (value - middle) / reach).collect()
}
