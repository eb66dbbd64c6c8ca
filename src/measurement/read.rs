//! A measured channel out of a file.

use std::path::Path;

use super::error::MeasurementError;
use crate::study::{TableRow, column_rows};

/// A unit in which channels are recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its name, e.g. `mm/s`.
    pub name: &'static str,
    /// The SI unit of the same quantity.
    pub si: &'static str,
    /// SI units in one of it.
    pub factor: f64,
}

/// The units that are known.
pub const UNITS: [Unit; 11] = [
    Unit { name: "m/s", si: "m/s", factor: 1.0 },
    Unit { name: "mm/s", si: "m/s", factor: 1e-3 },
    Unit { name: "um/s", si: "m/s", factor: 1e-6 },
    Unit { name: "in/s", si: "m/s", factor: 0.0254 },
    Unit { name: "m", si: "m", factor: 1.0 },
    Unit { name: "mm", si: "m", factor: 1e-3 },
    Unit { name: "Pa", si: "Pa", factor: 1.0 },
    Unit { name: "kPa", si: "Pa", factor: 1e3 },
    Unit { name: "bar", si: "Pa", factor: 1e5 },
    Unit { name: "N", si: "N", factor: 1.0 },
    Unit { name: "kN", si: "N", factor: 1e3 },
];

/// The unit of a name.
pub fn unit(name: &str) -> Option<Unit> {
    UNITS.into_iter().find(|unit| unit.name == name)
}

/// A measured channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Times of the samples in s, by the measurement's own clock, rising.
    pub times_s: Vec<f64>,
    /// Values in SI units.
    pub values: Vec<f64>,
}

/// Reads channels of a CSV or Parquet file, each a column in a unit, with the column of their times in s.
///
/// # Errors
/// [`MeasurementError::File`] for a file, a column or a number that is not there; [`MeasurementError::Order`].
pub fn read(file: &Path, time: &str, channels: &[(&str, Unit)]) -> Result<Vec<Measured>, MeasurementError> {
    let columns: Vec<&str> = std::iter::once(time).chain(channels.iter().map(|(column, _)| *column)).collect();
    let rows = column_rows(file, &columns).map_err(MeasurementError::File)?;
    let numbers = |cell: usize| -> Result<Vec<f64>, MeasurementError> {
        let fault = |(at, row)| fault(file, (at, row), (cell, columns[cell]));
        rows.iter().enumerate().map(|(at, row)| number(row, cell).ok_or_else(|| fault((at, row)))).collect()
    };
    let times_s = numbers(0)?;
    for (pair, row) in times_s.windows(2).zip(rows.iter().skip(1)) {
        if let [before_s, time_s] = *pair
            && time_s <= before_s
        {
            let place = format!("{}, {}", file.display(), row.place);
            return Err(MeasurementError::Order { place, time_s, before_s });
        }
    }
    let channel = |(place, (_, unit)): (usize, &(&str, Unit))| {
        let values = numbers(place + 1)?.into_iter().map(|value| unit.factor * value).collect();
        Ok(Measured { times_s: times_s.clone(), values })
    };
    channels.iter().enumerate().map(channel).collect()
}

fn number(row: &TableRow, cell: usize) -> Option<f64> {
    row.cells.get(cell)?.parse::<f64>().ok().filter(|number| number.is_finite())
}

fn fault(file: &Path, (at, row): (usize, &TableRow), (cell, column): (usize, &str)) -> MeasurementError {
    let found = row.cells.get(cell).map_or("nothing", String::as_str);
    let hint = if found.is_empty() {
        "a sample that is missing is left out with its time"
    } else if found.replacen(',', ".", 1).parse::<f64>().is_ok_and(f64::is_finite) {
        "a comma is read as the decimal point between semicolons or tabs, where no number has a point"
    } else if at == 0 {
        "a row of units under the header is to be taken out"
    } else {
        "a sample that is missing is left out with its time"
    };
    let file = file.display();
    let place = &row.place;
    MeasurementError::File(format!("{file}, {place}, column `{column}`: expected a number, found `{found}` ({hint})"))
}
