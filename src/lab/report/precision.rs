//! Duration that the rows of a dataset need for a wanted standard error.

use schemars::JsonSchema;
use serde::Serialize;

use super::numbers::number;
use decore_dataset::{ColumnDescription, ColumnGroup};
use decore_model::metrics::{ERRING, duration_for};
use decore_quantity::Cell;

/// Precision of an output over the rows that are done.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Precision {
    /// The output of a hammer.
    pub output: String,
    /// Values with a standard error, over all rows and hammers.
    pub count: u64,
    /// Values without one: too few blows, or a percussion that has not settled.
    pub without: u64,
    /// Values whose relative standard error is above the wanted one.
    pub above: u64,
    /// The value that needs the longest duration; null if no value has an error.
    pub worst: Option<WorstPrecision>,
}

/// The value of an output that needs the longest duration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct WorstPrecision {
    /// Index of the row in the design.
    pub row: u64,
    /// Relative standard error.
    pub relative_error: f64,
    /// Duration of the row, s.
    pub duration_s: f64,
    /// Duration that it needs for the wanted error, s.
    pub needed_s: f64,
}

/// A row and its duration in s.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowTime {
    pub row: u64,
    pub duration_s: f64,
}

/// Columns of outputs with their errors, and their statistics.
pub(super) struct Precisions<'a> {
    wanted: f64,
    found: Vec<Precision>,
    /// Place of the output, column of the value, column of its error.
    pairs: Vec<(usize, [&'a ColumnDescription; 2])>,
}

impl<'a> Precisions<'a> {
    /// The outputs of a table that have errors.
    pub fn of(columns: &'a [ColumnDescription], wanted: f64) -> Self {
        let mut precisions = Self { wanted, found: Vec::new(), pairs: Vec::new() };
        for (value, error) in ERRING {
            let of_hammers = |name: &'static str| {
                let named =
                    move |column: &&ColumnDescription| column.group == ColumnGroup::Hammer && column.quantity == name;
                columns.iter().filter(named)
            };
            let place = precisions.found.len();
            // Columns of one quantity come in the order of the hammers.
            let pairs = of_hammers(value).zip(of_hammers(error)).map(|(value, error)| (place, [value, error]));
            precisions.pairs.extend(pairs);
            precisions.found.push(Precision { output: value.to_owned(), count: 0, without: 0, above: 0, worst: None });
        }
        precisions
    }

    /// Names of the columns, in the order in which [`Precisions::row`] takes them.
    pub fn names(&self) -> impl Iterator<Item = &'a str> {
        self.pairs.iter().flat_map(|(_, pair)| pair.map(|column| column.name.as_str()))
    }

    /// Takes in a row; a value that the hammer does not have is left out.
    pub fn row(&mut self, RowTime { row, duration_s }: RowTime, cells: &[Cell<'_>]) {
        for ((place, _), cells) in self.pairs.iter().zip(cells.chunks(2)) {
            let (Some(found), [value, error]) = (self.found.get_mut(*place), cells) else { continue };
            let Some(value) = number(value) else { continue };
            let Some(error) = number(error) else {
                found.without += 1;
                continue;
            };
            found.count += 1;
            let needed_s = duration_for(self.wanted, duration_s, (value, error));
            found.above += u64::from(needed_s > duration_s);
            if found.worst.is_none_or(|worst| needed_s > worst.needed_s) {
                let relative_error = error / value.abs();
                found.worst = Some(WorstPrecision { row, relative_error, duration_s, needed_s });
            }
        }
    }

    /// Returns the result. Outputs without any value are left out.
    pub fn finish(self) -> Vec<Precision> {
        self.found.into_iter().filter(|found| found.count + found.without > 0).collect()
    }
}
