//! Reads a measured channel from a file.

use std::path::Path;

use super::error::MeasurementError;
use decore_study::{TableRow, column_rows};

/// A unit in which channels and their times are recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name, e.g. `mm/s`.
    pub name: &'static str,
    /// The SI unit of the same quantity.
    pub si: &'static str,
    /// SI units in one of it; negative with the sign turned.
    pub factor: f64,
}

/// The units that are known: of each quantity that signals have, and of time. `g` is the standard acceleration of gravity.
pub const UNITS: [Unit; 26] = [
    of("m/s", "m/s", 1.0),
    of("mm/s", "m/s", 1e-3),
    of("um/s", "m/s", 1e-6),
    of("in/s", "m/s", 0.0254),
    of("m", "m", 1.0),
    of("mm", "m", 1e-3),
    of("um", "m", 1e-6),
    of("in", "m", 0.0254),
    of("m/s2", "m/s2", 1.0),
    of("mm/s2", "m/s2", 1e-3),
    of("g", "m/s2", 9.80665),
    of("Pa", "Pa", 1.0),
    of("kPa", "Pa", 1e3),
    of("MPa", "Pa", 1e6),
    of("bar", "Pa", 1e5),
    of("N", "N", 1.0),
    of("kN", "N", 1e3),
    of("N s", "N s", 1.0),
    of("J", "J", 1.0),
    of("kJ", "J", 1e3),
    of("rad", "rad", 1.0),
    of("mrad", "rad", 1e-3),
    of("deg", "rad", std::f64::consts::PI / 180.0),
    of("s", "s", 1.0),
    of("ms", "s", 1e-3),
    of("us", "s", 1e-6),
];

const fn of(name: &'static str, si: &'static str, factor: f64) -> Unit {
    Unit { name, si, factor }
}

/// The unit of a name; with a minus before it the sign is turned.
pub fn unit(name: &str) -> Option<Unit> {
    let (plain, sign) = name.strip_prefix('-').map_or((name, 1.0), |plain| (plain, -1.0));
    UNITS.into_iter().find(|unit| unit.name == plain).map(|unit| Unit { factor: sign * unit.factor, ..unit })
}

/// A measured channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Times of the samples in s, by the measurement's own clock, rising.
    pub times_s: Vec<f64>,
    /// Values in SI units.
    pub values: Vec<f64>,
}

/// Reads channels of a CSV or Parquet file, each a column in a unit, with the column of their times, in a unit too.
///
/// # Errors
/// [`MeasurementError::File`] for a file, a column or a number that is not there; [`MeasurementError::Order`].
pub fn read(file: &Path, time: (&str, Unit), channels: &[(&str, Unit)]) -> Result<Vec<Measured>, MeasurementError> {
    let columns: Vec<&str> = std::iter::once(&time).chain(channels).map(|(column, _)| *column).collect();
    let rows = column_rows(file, &columns).map_err(MeasurementError::File)?;
    let numbers = |cell: usize, unit: Unit| -> Result<Vec<f64>, MeasurementError> {
        let fault = |(at, row)| fault(file, (at, row), (cell, columns[cell]));
        rows.iter().enumerate().map(|(at, row)| number(row, cell, unit).ok_or_else(|| fault((at, row)))).collect()
    };
    let times_s = numbers(0, time.1)?;
    for (pair, row) in times_s.windows(2).zip(rows.iter().skip(1)) {
        if let [before_s, time_s] = *pair
            && time_s <= before_s
        {
            let place = format!("{}, {}", file.display(), row.place);
            return Err(MeasurementError::Order { place, time_s, before_s });
        }
    }
    let channel = |(place, (_, unit)): (usize, &(&str, Unit))| {
        Ok(Measured { times_s: times_s.clone(), values: numbers(place + 1, *unit)? })
    };
    channels.iter().enumerate().map(channel).collect()
}

/// A cell in SI units; `None` if it is not a number, or out of range.
fn number(row: &TableRow, cell: usize, unit: Unit) -> Option<f64> {
    let number = row.cells.get(cell)?.parse::<f64>().ok()?;
    Some(unit.factor * number).filter(|number| number.is_finite())
}

fn fault(file: &Path, (at, row): (usize, &TableRow), (cell, column): (usize, &str)) -> MeasurementError {
    let found = row.cells.get(cell).map_or("nothing", String::as_str);
    let hint = if found.is_empty() {
        "a sample that is missing is left out with its time"
    } else if found.replacen(',', ".", 1).parse::<f64>().is_ok_and(f64::is_finite) {
        "a comma is read as the decimal point between semicolons or tabs, where no number has a point"
    } else if at == 0 {
        "remove a row of units below the header"
    } else {
        "a sample that is missing is left out with its time"
    };
    let file = file.display();
    let place = &row.place;
    MeasurementError::File(format!("{file}, {place}, column `{column}`: expected a number, found `{found}` ({hint})"))
}
