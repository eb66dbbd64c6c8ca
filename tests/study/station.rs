//! Interface points of the built-in station, for tests of studies without its matrices.

use decore_study::{CheckedStudy, PointTable, Study, StudyError};

/// Rail R1 to R9 along y, table T1 to T9 on a grid of 0.125 m.
pub fn station_points() -> PointTable {
    let rail = (0..9).map(|i| (format!("R{}", i + 1), [0.36, f64::from(i - 4) / 10.0, 1.605]));
    let table = (0..9).map(|i| {
        let (x, y) = (f64::from(i / 3 - 1), f64::from(i % 3 - 1));
        (format!("T{}", i + 1), [0.36 + 0.125 * x, 0.125 * y, 0.41])
    });
    rail.chain(table).collect()
}

/// A study held to the station.
pub fn checked(study: &Study) -> Result<CheckedStudy, StudyError> {
    CheckedStudy::new(study.clone(), station_points())
}

/// The rows of a sound study.
#[track_caller]
pub fn rows(study: &Study) -> CheckedStudy {
    checked(study).unwrap_or_else(|error| panic!("{error}"))
}
