//! Factors of rows that were chosen in any way.

/// Rows below which nothing is said.
pub(super) const LEAST_ROWS: usize = 20;

/// A factor's values, row by row.
#[derive(Debug, Clone, Copy)]
pub struct FactorValues<'a> {
    /// The values; of names, numbers that stand for them.
    pub values: &'a [f64],
    /// Whether they are names, which have no order.
    pub nominal: bool,
}
