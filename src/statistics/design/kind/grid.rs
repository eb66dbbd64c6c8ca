//! Single rows, full factorials, one factor at a time.

use std::sync::Arc;

use super::super::coordinate::Coordinate;
use super::super::distribution::Distribution;
use super::super::error::DesignError;
use super::super::factor::Factor;
use super::super::options::{DesignOptions, Needs};
use super::points::{Points, Request, Specification, bounded};

/// One row; only for a design without factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Single;

impl Specification for Single {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        if !request.factors.is_empty() {
            return Err(DesignError::Factors("factors are given, but no kind of design"));
        }
        Ok(Arc::new(*self))
    }
}

impl Points for Single {
    fn rows(&self) -> usize {
        1
    }

    fn at(&self, _: usize) -> Vec<Coordinate> {
        Vec::new()
    }
}

/// Every combination of the factors' levels; the last factor changes fastest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FullFactorial;

impl Specification for FullFactorial {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let levels = request.factors.iter().enumerate().map(|(index, factor)| factor.level_count(index));
        let levels = levels.collect::<Result<Vec<u64>, _>>()?;
        let rows = levels.iter().try_fold(1_u64, |rows, levels| rows.checked_mul(*levels));
        let rows = rows.and_then(|rows| usize::try_from(rows).ok()).ok_or(DesignError::TooManyRows)?;
        Ok(Arc::new(Grid { levels, rows }))
    }
}

/// All combinations of levels.
#[derive(Debug)]
struct Grid {
    levels: Vec<u64>,
    rows: usize,
}

impl Points for Grid {
    fn rows(&self) -> usize {
        self.rows
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        let mut rest = row as u64;
        let mut coordinates: Vec<Coordinate> = Vec::with_capacity(self.levels.len());
        for &count in self.levels.iter().rev() {
            coordinates.push(Coordinate::Step { step: rest % count, count });
            rest /= count;
        }
        coordinates.reverse();
        coordinates
    }
}

/// The middle of all ranges, then each factor at each of its other levels (real ones: two levels unless given).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OneAtATime;

impl Specification for OneAtATime {
    fn of(_: &DesignOptions) -> Result<Self, Needs> {
        Ok(Self)
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        let levels = request.factors.iter().enumerate().map(|(index, factor)| Levels::of(index, factor));
        let levels = levels.collect::<Result<Vec<Levels>, _>>()?;
        bounded("kind", levels.iter().fold(0, |rows: u64, levels| rows.saturating_add(levels.count)))?;
        Ok(Arc::new(Departures::new(&levels)))
    }
}

/// The levels of a factor that is varied alone.
struct Levels {
    count: u64,
    real: bool,
    category: bool,
}

impl Levels {
    fn of(index: usize, factor: &Factor) -> Result<Self, DesignError> {
        let real = factor.distribution.value_count().is_none();
        let category = matches!(factor.distribution, Distribution::Categories { .. });
        let count = if real && factor.levels.is_none() { 2 } else { factor.level_count(index)? };
        Ok(Self { count, real, category })
    }
}

/// One factor at a time: the base first, then each factor at its other levels.
#[derive(Debug)]
struct Departures {
    base: Vec<Coordinate>,
    /// Factor and its coordinate, row 1 first.
    departures: Vec<(usize, Coordinate)>,
}

impl Departures {
    /// Real factors have their base in the middle of the range, others at the level in the middle (categories: the first).
    fn new(levels: &[Levels]) -> Self {
        let mut base = Vec::with_capacity(levels.len());
        let mut departures = Vec::new();
        for (factor, &Levels { count, real, category }) in levels.iter().enumerate() {
            let middle = if category { 0 } else { (count - 1) / 2 };
            base.push(if real { Coordinate::Share(0.5) } else { Coordinate::Step { step: middle, count } });
            let is_base = |step: u64| if real { 2 * step == count - 1 } else { step == middle };
            let steps = (0..count).filter(|step| !is_base(*step));
            departures.extend(steps.map(|step| (factor, Coordinate::Step { step, count })));
        }
        Self { base, departures }
    }
}

impl Points for Departures {
    fn rows(&self) -> usize {
        1 + self.departures.len()
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        let mut coordinates = self.base.clone();
        let departure = row.checked_sub(1).and_then(|index| self.departures.get(index));
        if let Some((factor, coordinate)) = departure
            && let Some(entry) = coordinates.get_mut(*factor)
        {
            *entry = *coordinate;
        }
        coordinates
    }
}
