//! Rows of a sweep with a numerical twin.

use crate::Study;
use decore_math::random::{below, hash};
use decore_model::scene::NumericalTwin;

/// Rows of which one is drawn.
const ROWS: u64 = 100;
/// Stream of the random numbers that draw it: the letters `twin`.
const STREAM: u64 = 0x7477_696e;

/// Whether a study draws this row for a numerical twin, which most rows do not have.
pub(super) fn is_drawn(study: &Study, row: u64) -> bool {
    study.numerical_twin() == NumericalTwin::Sample && is_sampled(study.seed(), row)
}

/// Whether a row is in the sample: row 0, so that every sweep has one, and one row of every further hundred, drawn by the seed. The
/// number of rows does not matter: a sweep that grows keeps its sample.
fn is_sampled(seed: u64, row: u64) -> bool {
    let (hundred, place) = (row / ROWS, row % ROWS);
    place == if hundred == 0 { 0 } else { below(hash(seed, STREAM, hundred), ROWS) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_row_of_every_hundred_is_drawn() {
        for seed in 0..5 {
            let sample: Vec<u64> = (0..10_000).filter(|row| is_sampled(seed, *row)).collect();
            assert_eq!((sample.len(), sample[0]), (100, 0));
            assert!(sample.iter().enumerate().all(|(hundred, row)| row / 100 == hundred as u64));
            let places: std::collections::BTreeSet<u64> = sample.iter().map(|row| row % 100).collect();
            assert!(places.len() > 50, "a stride would meet the same levels of a grid again and again");
        }
        assert!((100..200).any(|row| is_sampled(1, row) != is_sampled(2, row)));
    }
}
