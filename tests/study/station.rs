//! Interface points of the built-in station, for tests of studies without its matrices.

use decore::study::PointTable;

/// Rail R1 to R9 along y, table T1 to T9 on a grid of 0.125 m.
pub fn station_points() -> PointTable {
    let rail = (0..9).map(|i| (format!("R{}", i + 1), [0.36, f64::from(i - 4) / 10.0, 1.605]));
    let table = (0..9).map(|i| {
        let (x, y) = (f64::from(i / 3 - 1), f64::from(i % 3 - 1));
        (format!("T{}", i + 1), [0.36 + 0.125 * x, 0.125 * y, 0.41])
    });
    rail.chain(table).collect()
}
