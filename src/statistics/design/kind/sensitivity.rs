//! Designs for sensitivity indices: Morris trajectories, Saltelli's blocks; every row computed alone.

use std::sync::Arc;

use super::super::coordinate::Coordinate;
use super::super::error::DesignError;
use super::super::factor::Factor;
use super::super::group::{GroupKind, GroupSpan};
use super::super::options::{DesignOptions, Needs, count};
use super::super::permutation::Permutation;
use super::super::sobol::SobolSequence;
use super::growth::Growth;
use super::points::{Points, Request, Specification, blocks};
use super::sampled::sobol;
use decore_math::random::{below, hash};

/// Default number of Morris trajectories.
const TRAJECTORIES: u64 = 10;
/// Default number of levels of the Morris grid.
const MORRIS_LEVELS: u64 = 4;

/// Morris trajectories, `factors + 1` rows each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Morris {
    /// Number of trajectories.
    pub trajectories: usize,
    /// Levels of the grid, even.
    pub levels: u64,
}

impl Specification for Morris {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        let trajectories = count(keys.trajectories.unwrap_or(TRAJECTORIES));
        Ok(Self { trajectories, levels: keys.morris_levels.unwrap_or(MORRIS_LEVELS) })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let Request { factors, seed, .. } = request;
        let levels = self.levels;
        if levels < 2 || !levels.is_multiple_of(2) {
            let message = format!("a Morris design has an even number of levels, not {levels}");
            return Err(DesignError::setting("morris_levels", message));
        }
        let short = |factor: &Factor| factor.distribution.value_count().is_some_and(|count| count < 2);
        if let Some(factor) = factors.iter().position(short) {
            return Err(DesignError::FactorKind { factor, expected: "a factor with a single value cannot move" });
        }
        let rows = blocks(self.trajectories, factors.len() + 1)?;
        Ok(Arc::new(Trajectories { factors: factors.len() as u64, levels, seed, rows }))
    }

    fn growth(&self) -> Option<Growth> {
        Some(Growth { key: "trajectories", count: self.trajectories, doubles: false })
    }
}

/// Morris trajectories (Technometrics 33, 1991): rows `t (k + 1)` to `t (k + 1) + k` are trajectory t, in which each of the
/// k factors moves once, by `levels / 2` of the `levels - 1` steps of its range.
#[derive(Debug)]
struct Trajectories {
    factors: u64,
    /// Levels of the grid, even.
    levels: u64,
    seed: u64,
    rows: usize,
}

impl Trajectories {
    fn coordinate(&self, row: u64, factor: u64) -> Coordinate {
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

impl Points for Trajectories {
    fn rows(&self) -> usize {
        self.rows
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        (0..self.factors).map(|factor| self.coordinate(row as u64, factor)).collect()
    }

    fn block(&self) -> usize {
        self.factors as usize + 1
    }

    fn groups(&self) -> Vec<GroupSpan> {
        vec![GroupSpan::whole(GroupKind::Trajectory, self.rows, self.block())]
    }
}

/// Saltelli's design for Sobol' indices, `factors + 2` rows per base point (`2 factors + 2` with second order).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Saltelli {
    /// Number of base points.
    pub base: usize,
    /// Whether second-order indices are wanted.
    pub second_order: bool,
}

impl Specification for Saltelli {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        let base = keys.base_points.map(count).ok_or(Needs::Number("base_points"))?;
        Ok(Self { base, second_order: keys.second_order.unwrap_or(false) })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let factors = request.factors.len();
        let points = sobol(2 * factors, Some(request.seed))?;
        let block = if self.second_order { 2 * factors + 2 } else { factors + 2 };
        Ok(Arc::new(Blocks { factors, block, points, rows: blocks(self.base, block)? }))
    }

    fn growth(&self) -> Option<Growth> {
        Some(Growth { key: "base_points", count: self.base, doubles: true })
    }
}

/// Saltelli's design for Sobol' indices: blocks of `k + 2` rows (A, A with one factor of B each, B), or `2 k + 2` with second
/// order (also B with one factor of A each, before B). A and B are the halves of Sobol' points in 2 k dimensions.
#[derive(Debug)]
struct Blocks {
    factors: usize,
    block: usize,
    points: SobolSequence,
    rows: usize,
}

impl Blocks {
    fn probability(&self, row: u64, factor: usize) -> f64 {
        let block = self.block as u64;
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

impl Points for Blocks {
    fn rows(&self) -> usize {
        self.rows
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        (0..self.factors).map(|factor| Coordinate::Probability(self.probability(row as u64, factor))).collect()
    }

    fn block(&self) -> usize {
        self.block
    }

    fn groups(&self) -> Vec<GroupSpan> {
        vec![GroupSpan::whole(GroupKind::BasePoint, self.rows, self.block)]
    }
}
