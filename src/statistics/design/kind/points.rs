//! Interface of a kind of design: it makes points, and gives their rows.

use std::fmt;
use std::sync::Arc;

use super::super::constraint::Conditions;
use super::super::coordinate::Coordinate;
use super::super::correlation::Correlation;
use super::super::distribution::Distribution;
use super::super::error::DesignError;
use super::super::factor::Factor;
use super::super::group::GroupSpan;
use super::super::options::{DesignOptions, Needs};
use super::fraction::Aliases;
use super::growth::Growth;

/// Most rows that a number in the study alone puts into memory.
const MOST_STATED_ROWS: usize = 1_000_000;

/// A kind of design as requested.
pub(in crate::design) trait Specification: Sized {
    /// Reads the keys of a study.
    fn of(keys: &DesignOptions) -> Result<Self, Needs>;

    /// Makes it ready to give rows.
    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError>;

    /// The number by which it grows; `None` where more rows are other rows.
    fn growth(&self) -> Option<Growth> {
        None
    }
}

/// Request for points; at least one factor, unless there is a single row.
#[derive(Clone, Copy)]
pub(in crate::design) struct Request<'a> {
    pub factors: &'a [Factor],
    pub seed: u64,
    pub correlation: Option<&'a Correlation>,
}

/// A design that is ready to give rows.
pub(in crate::design) trait Points: fmt::Debug + Send + Sync {
    /// Number of rows.
    fn rows(&self) -> usize;

    /// Coordinates of a row, one per factor. Rows past the last are defined for endless designs only.
    fn at(&self, row: usize) -> Vec<Coordinate>;

    /// Whether points are probabilities that a copula can correlate.
    fn is_sampled(&self) -> bool {
        false
    }

    /// Whether its factors can have rank correlations.
    fn takes_correlation(&self) -> bool {
        self.is_sampled()
    }

    /// Rows that belong together and are left out together.
    fn block(&self) -> usize {
        1
    }

    /// Groups of dependent rows; see [`GroupSpan`].
    fn groups(&self) -> Vec<GroupSpan> {
        Vec::new()
    }

    /// Whether there are points past the last row to take instead of rows left out.
    fn is_endless(&self) -> bool {
        self.is_sampled() || self.block() > 1
    }

    /// Whether every row is computed alone, without a table of all.
    fn is_open(&self) -> bool {
        true
    }

    /// Confounded effects of a regular fraction.
    fn aliases(&self) -> Option<Aliases> {
        None
    }

    /// The same with its rows made to fit the constraints; `None` if rows that do not fit are left out instead.
    fn constrained(
        &self,
        _correlation: Option<&Correlation>,
        _conditions: Conditions<'_>,
    ) -> Option<Result<Arc<dyn Points>, DesignError>> {
        None
    }
}

/// Rows that are kept in memory although no file lists them.
pub(super) fn bounded(key: &'static str, rows: u64) -> Result<(), DesignError> {
    if rows <= MOST_STATED_ROWS as u64 {
        return Ok(());
    }
    Err(DesignError::setting(
        key,
        format!("{rows} rows of this kind are too many, expected {MOST_STATED_ROWS} at most"),
    ))
}

/// Rows of that many blocks.
pub(super) fn blocks(count: usize, block: usize) -> Result<usize, DesignError> {
    count.checked_mul(block).ok_or(DesignError::TooManyRows)
}

/// Refuses lists of values.
pub(super) fn numbers_only(factors: &[Factor]) -> Result<(), DesignError> {
    match factors.iter().position(|factor| matches!(factor.distribution, Distribution::Categories { .. })) {
        Some(factor) => Err(DesignError::FactorKind {
            factor,
            expected: "this kind of design needs ranges, no lists of values: put the list into another part of a product",
        }),
        None => Ok(()),
    }
}
