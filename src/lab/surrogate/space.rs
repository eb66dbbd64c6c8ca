//! The space of a study's factors, and the places of rows in it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::SurrogateError;
use crate::sensitivity::FactorColumn;
use decore_math::number::ln;
use decore_statistics::regression::{Points, RegressionError};
use decore_study::FactorOutline;

/// Share of a range by which rounding may leave it.
const ROUNDING: f64 = 1e-9;
/// Share of the rows' span by which a value may exceed it: designs that fill a range leave such gaps at its ends.
const BEYOND: f64 = 0.1;

/// Times the distance between rows up to which a place counts as among them.
const AMONG: f64 = 1.5;

/// Distance from the nearest row, in scaled factors, up to which a place is among these: a multiple of the second largest between a row
/// and its nearest other one, as a single row far from all others makes nothing between known. `None` for fewer than three places.
pub(super) fn covered_distance(points: &Points) -> Option<f64> {
    let own = |row: usize| nearest(points, points.row(row), Some(row));
    let mut distances: Vec<f64> = (0..points.rows()).map(own).filter(|distance| distance.is_finite()).collect();
    distances.sort_by(f64::total_cmp);
    let second = distances.len().checked_sub(2).filter(|place| *place > 0).map(|place| distances[place]);
    second.map(|distance| twelve_digits(AMONG * distance))
}

/// Distance of a place from the nearest row at another place, in scaled factors; `own`: a row that does not count.
pub(super) fn nearest(points: &Points, place: &[f64], own: Option<usize>) -> f64 {
    let others = (0..points.rows()).filter(|row| Some(*row) != own);
    let squared = others.map(|row| points.squared_distance([points.row(row), place]));
    squared.filter(|squared| own.is_none() || *squared > ROUNDING * ROUNDING).fold(f64::INFINITY, f64::min).sqrt()
}

/// A factor of a surrogate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FactorSpace {
    /// Name as in the study.
    pub name: String,
    /// Unit of its values; empty for names.
    pub unit: String,
    /// The names that it chooses from, by their numbers; empty for a range.
    pub names: Vec<String>,
    /// Ends of the range: in the study, or of the rows. Scaled to 0 and 1; 0 and 1 themselves for names.
    pub range: [f64; 2],
    /// Whether its logarithm is scaled.
    pub logarithmic: bool,
    /// Smallest and largest value of the models' rows; null for names, and in files of older models.
    #[serde(default)]
    pub covered: Option<[f64; 2]>,
    /// The names that none of these rows has.
    #[serde(default)]
    pub unseen: Vec<String>,
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
        let (name, unit) = (outline.name.clone(), unit.to_owned());
        let mut found = Self { name, unit, names, range, logarithmic, covered: None, unseen: Vec::new() };
        found.cover(&column.values);
        found
    }

    /// Records the range of rows' values.
    pub(super) fn cover(&mut self, values: &[f64]) {
        let seen = |number: usize| values.contains(&(number as f64));
        let names = self.names.iter().enumerate();
        self.unseen = names.filter(|(number, _)| !seen(*number)).map(|(_, name)| name.clone()).collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.covered = (self.names.is_empty() && low <= high).then(|| [low, high].map(twelve_digits));
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

    /// Whether a value is outside the range, or far from the rows: a name that no row has, or a number beyond the rows by more than a tenth
    /// of their span.
    pub(super) fn is_outside(&self, value: f64) -> bool {
        if !self.names.is_empty() {
            return self.names.get(value as usize).is_none_or(|name| self.unseen.contains(name));
        }
        let [low, high] = self.range;
        let slack = ROUNDING * (high - low).max(low.abs()).max(high.abs());
        let far = self.covered.is_some_and(|covered| {
            let [first, last] = covered.map(|end| self.scaled(end));
            let slack = BEYOND * (last - first) + ROUNDING;
            !(first - slack..=last + slack).contains(&self.scaled(value))
        });
        far || !(low - slack..=high + slack).contains(&value)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn space(names: &[&str], logarithmic: bool) -> FactorSpace {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let (name, unit) = ("factor".to_owned(), String::new());
        FactorSpace { name, unit, names, range: [1.0, 100.0], logarithmic, covered: None, unseen: Vec::new() }
    }

    #[test]
    fn what_no_row_is_near_lies_outside() {
        let mut names = space(&["steel", "rubber", "wood"], false);
        names.cover(&[0.0, 2.0, 0.0]);
        assert_eq!([0.0, 1.0, 2.0].map(|number| names.is_outside(number)), [false, true, false]);
        let mut numbers = space(&[], false);
        assert!(!numbers.is_outside(99.0) && numbers.is_outside(101.0));
        numbers.cover(&[10.0, 50.0, 30.0]);
        assert_eq!([5.0, 7.0, 30.0, 53.0, 55.0].map(|x| numbers.is_outside(x)), [true, false, false, false, true]);
        let mut logarithms = space(&[], true);
        logarithms.cover(&[1.0, 10.0]);
        assert_eq!([1.0, 12.0, 13.0].map(|x| logarithms.is_outside(x)), [false, false, true]);
    }
}
