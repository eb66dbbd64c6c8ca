//! Designs for sensitivity indices: Morris trajectories, Saltelli's blocks; every row computed alone.

use super::super::coordinate::Coordinate;
use super::super::permutation::{Permutation, below, hash};
use super::super::sobol::Sobol;

/// Morris trajectories (Technometrics 33, 1991): rows `t (k + 1)` to `t (k + 1) + k` are trajectory t, in which each of the
/// k factors moves once, by `levels / 2` of the `levels - 1` steps of its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Morris {
    pub factors: u64,
    /// Levels of the grid, even.
    pub levels: u64,
    pub seed: u64,
}

impl Morris {
    pub(super) fn at(&self, row: u64, factor: u64) -> Coordinate {
        let (trajectory, step) = (row / (self.factors + 1), row % (self.factors + 1));
        let key = hash(self.seed, trajectory, 0);
        let turn = Permutation::new(key, self.factors).at(factor);
        // The start lies in the lower or the upper half, so that the jump stays on the grid.
        let jump = self.levels / 2;
        let word = hash(key, 1, factor);
        let start = below(word, self.levels);
        let end = if start < jump { start + jump } else { start - jump };
        Coordinate::Step { step: if turn < step { end } else { start }, count: self.levels }
    }
}

/// Saltelli's design for Sobol' indices: blocks of `k + 2` rows (A, A with one factor of B each, B), or `2 k + 2` with second
/// order (also B with one factor of A each, before B). A and B are the halves of Sobol' points in 2 k dimensions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Saltelli {
    pub factors: usize,
    pub second_order: bool,
    pub points: Sobol,
}

impl Saltelli {
    pub(super) fn block(&self) -> usize {
        if self.second_order { 2 * self.factors + 2 } else { self.factors + 2 }
    }

    pub(super) fn at(&self, row: u64, factor: usize) -> f64 {
        let block = self.block() as u64;
        let (point, place) = (row / block, (row % block) as usize);
        let mixed = place.checked_sub(1).filter(|mixed| *mixed < block as usize - 2);
        let from_b = match mixed {
            None => place != 0,
            Some(mixed) if mixed < self.factors => factor == mixed,
            Some(mixed) => factor != mixed - self.factors,
        };
        self.points.at(point, factor + if from_b { self.factors } else { 0 })
    }
}
