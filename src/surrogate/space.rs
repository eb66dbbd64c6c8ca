//! The space of a study's factors, and the places of rows in it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::SurrogateError;
use crate::number::ln;
use crate::regression::{Points, RegressionError};
use crate::sensitivity::FactorColumn;
use crate::study::FactorOutline;

/// Share of a range by which rounding may leave it.
const ROUNDING: f64 = 1e-9;

/// A factor of a surrogate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FactorSpace {
    /// Name as in the study.
    pub name: String,
    /// Unit of its values; empty for names.
    pub unit: String,
    /// The names that it chooses from, by their numbers; empty for a range.
    pub names: Vec<String>,
    /// Ends of its range: the study's, or what its rows span. Scaled to 0 and 1; 0 and 1 themselves for names.
    pub range: [f64; 2],
    /// Whether its logarithm is scaled.
    pub logarithmic: bool,
}

impl FactorSpace {
    /// From the study and the rows.
    pub(super) fn new(outline: &FactorOutline, column: &FactorColumn, unit: &str) -> Self {
        let names = column.names.clone();
        let low = column.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = column.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = match outline.range {
            _ if column.nominal => [0.0, 1.0],
            Some(range) => range,
            None => [low, high].map(twelve_digits),
        };
        let logarithmic = outline.logarithmic && range[0] > 0.0;
        Self { name: outline.name.clone(), unit: unit.to_owned(), names, range, logarithmic }
    }

    /// The place of a value in the range, 0 to 1; of a name its number.
    pub(super) fn scaled(&self, value: f64) -> f64 {
        if !self.names.is_empty() {
            return value;
        }
        let of = |value: f64| if self.logarithmic { ln(value) } else { value };
        let [low, high] = self.range.map(of);
        if high > low { (of(value) - low) / (high - low) } else { 0.0 }
    }

    /// The value that a cell holds; of a name its number.
    ///
    /// # Errors
    /// What the cell should be, in words.
    pub(super) fn read(&self, cell: &str) -> Result<f64, String> {
        if !self.names.is_empty() {
            let number = self.names.iter().position(|name| name == cell);
            return number.map(|number| number as f64).ok_or_else(|| {
                let known = self.names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                format!("`{cell}` is none of the names that the model knows: {known}")
            });
        }
        let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| format!("`{cell}` is no number"))?;
        match self.logarithmic && value <= 0.0 {
            true => Err(format!("{value} has no logarithm, in which the model sees this factor: expected more than 0")),
            false => Ok(value),
        }
    }

    /// Whether a value lies outside the range.
    pub(super) fn is_outside(&self, value: f64) -> bool {
        let [low, high] = self.range;
        let slack = ROUNDING * (high - low).max(low.abs()).max(high.abs());
        self.names.is_empty() && !(low - slack..=high + slack).contains(&value)
    }
}

/// A number that any reader of decimal numbers reads alike.
pub(super) fn twelve_digits(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Rows of values as places in the space.
///
/// # Errors
/// Those of [`Points::new`].
pub(super) fn places(factors: &[FactorSpace], rows: &[Vec<f64>]) -> Result<Points, RegressionError> {
    let scaled =
        |row: &Vec<f64>| factors.iter().zip(row).map(|(factor, value)| factor.scaled(*value)).collect::<Vec<f64>>();
    let nominal = factors.iter().map(|factor| !factor.names.is_empty()).collect();
    Points::new(rows.iter().flat_map(scaled).collect(), nominal)
}

/// Places of rows, each with a text per factor: a number, or a name.
///
/// # Errors
/// [`SurrogateError::Table`] for a text that is no value of its factor.
pub fn text_places(factors: &[FactorSpace], rows: &[Vec<String>]) -> Result<Points, SurrogateError> {
    let read = |(cell, factor): (&String, &FactorSpace)| {
        factor.read(cell).map_err(|message| SurrogateError::Table(format!("factor `{}`: {message}", factor.name)))
    };
    let row = |row: &Vec<String>| row.iter().zip(factors).map(read).collect::<Result<Vec<f64>, SurrogateError>>();
    let values = rows.iter().map(row).collect::<Result<Vec<_>, _>>()?;
    let named = |source| SurrogateError::Regression { output: "the factors".to_owned(), source };
    places(factors, &values).map_err(named)
}
