//! Places of rows in the space of the factors, as numbers.

use super::error::RegressionError;

/// Rows by their factors, each scaled to [0, 1] over its range; of a factor of names, numbers that stand for them.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    values: Vec<f64>,
    nominal: Vec<bool>,
}

impl Points {
    /// Rows one after the other; `nominal`: for each factor, whether it has names, which have no order.
    ///
    /// # Errors
    /// [`RegressionError::Size`] where the values are no whole rows of at least one factor; [`RegressionError::NotFinite`].
    pub fn new(values: Vec<f64>, nominal: Vec<bool>) -> Result<Self, RegressionError> {
        let factors = nominal.len();
        if factors == 0 || !values.len().is_multiple_of(factors) {
            return Err(RegressionError::Size { what: "coordinates", found: values.len(), expected: factors });
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(place) => Err(RegressionError::NotFinite { row: place / factors, value: values[place] }),
            None => Ok(Self { values, nominal }),
        }
    }

    /// Number of factors.
    pub fn factors(&self) -> usize {
        self.nominal.len()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.factors()
    }

    /// For each factor, whether it has names.
    pub fn nominal(&self) -> &[bool] {
        &self.nominal
    }

    /// The coordinates of a row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.factors()..(row + 1) * self.factors()]
    }

    /// The points of these rows.
    pub fn select(&self, rows: &[usize]) -> Self {
        let values = rows.iter().flat_map(|row| self.row(*row)).copied().collect();
        Self { values, nominal: self.nominal.clone() }
    }

    /// These places and then others with the same factors.
    ///
    /// # Errors
    /// [`RegressionError::Size`] for another number of factors.
    pub fn with(&self, others: &Self) -> Result<Self, RegressionError> {
        if others.nominal != self.nominal {
            let (found, expected) = (others.factors(), self.factors());
            return Err(RegressionError::Size { what: "factors", found, expected });
        }
        Ok(Self { values: [&self.values[..], &others.values].concat(), nominal: self.nominal.clone() })
    }

    /// Squared distance of two places in the scaled ranges; of names 1 where they differ.
    pub fn squared_distance(&self, [a, b]: [&[f64]; 2]) -> f64 {
        (0..self.factors()).map(|factor| self.squared(factor, [a[factor], b[factor]])).sum()
    }

    /// Squared distance of two places along a factor: of names 1 where they differ.
    pub(super) fn squared(&self, factor: usize, [a, b]: [f64; 2]) -> f64 {
        match self.nominal[factor] {
            true => f64::from(u8::from(a != b)),
            false => (a - b) * (a - b),
        }
    }
}
