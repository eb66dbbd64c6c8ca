//! Places at which a row could be run.

use std::collections::HashSet;

use super::error::RefinementError;
use crate::design::{Coordinate, Design, Factor, Kind, Level, Sobol};
use crate::quantity::Value;
use crate::random::{hash, uniform};
use crate::study::CheckedStudy;

/// Points tried for each candidate that is asked for, at most: constraints may leave few.
const MOST_TRIED: usize = 64;
/// Stream of the numbers by which candidates lie near a row.
const NEAR: u64 = 0x6e65_6172;

/// Collects candidates: none is a row already, each meets all constraints and describes a scene.
pub(super) struct Collector<'a> {
    study: &'a CheckedStudy,
    /// Rows that there are.
    taken: HashSet<Vec<String>>,
    /// Candidates, each once.
    seen: HashSet<Vec<String>>,
    /// Values of all factors, in the study's order, as cells of a table that read back the same.
    pub found: Vec<Vec<String>>,
    /// Where each of them lies in the ranges of the factors, 0 to 1.
    pub shares: Vec<Vec<f64>>,
}

/// Candidates around a place.
#[derive(Debug, Clone, Copy)]
pub struct Around {
    /// How many.
    pub count: usize,
    /// How far away, as a share of each factor's range.
    pub reach: f64,
}

impl<'a> Collector<'a> {
    pub fn new(study: &'a CheckedStudy) -> Self {
        let row = |row: usize| cells(&study.row_values(row));
        let taken = (0..study.row_count()).map(row).collect();
        Self { study, taken, seen: HashSet::new(), found: Vec::new(), shares: Vec::new() }
    }

    /// So many Sobol' points, scrambled by the seed.
    pub fn fill(&mut self, count: usize, seed: u64) -> Result<(), RefinementError> {
        let points = Kind::Sobol(Sobol { rows: count * MOST_TRIED, scramble: true });
        let points = Design::new(points, self.study.design().factors().to_vec(), seed)?;
        let all = self.found.len() + count;
        for row in 0..count * MOST_TRIED {
            if self.found.len() >= all {
                break;
            }
            self.add(points.row(row).unwrap_or_default())?;
        }
        match self.found.is_empty() {
            true => Err(RefinementError::NoCandidates { tried: count * MOST_TRIED }),
            false => Ok(()),
        }
    }

    /// So many points around a place, up to a share `reach` of each factor's range away.
    pub fn near(&mut self, place: &[Level], around: Around, seed: u64) -> Result<(), RefinementError> {
        let factors = self.study.design().factors().to_vec();
        let Around { count, reach } = around;
        for index in 0..count {
            let stream = hash(seed, NEAR, index as u64);
            let moved = |(factor, (level, Factor { distribution, .. })): (usize, (&Level, &Factor))| {
                let at = Coordinate::Value(*level).unit(distribution);
                let away = reach * (2.0 * uniform(seed, stream, factor as u64) - 1.0);
                Coordinate::Probability((at + away).clamp(0.0, 1.0)).level(distribution)
            };
            self.add(place.iter().zip(&factors).enumerate().map(moved).collect())?;
        }
        Ok(())
    }

    /// The cells of a place by its shares of the ranges; `None` where no row may be run, or one is there.
    pub fn cells_at(&self, shares: &[f64]) -> Result<Option<Vec<String>>, RefinementError> {
        let factors = self.study.design().factors();
        let level = |(share, factor): (&f64, &Factor)| Coordinate::Probability(*share).level(&factor.distribution);
        self.allowed(&shares.iter().zip(factors).map(level).collect::<Vec<Level>>())
    }

    /// A row that is to be run: no candidate any more.
    pub fn take(&mut self, row: &[String]) {
        if let Some(place) = self.found.iter().position(|found| found == row) {
            self.found.remove(place);
            self.shares.remove(place);
        }
        self.taken.insert(row.to_vec());
    }

    fn add(&mut self, levels: Vec<Level>) -> Result<(), RefinementError> {
        if let Some(cells) = self.allowed(&levels)? {
            let unit = |(level, factor): (&Level, &Factor)| Coordinate::Value(*level).unit(&factor.distribution);
            if self.seen.insert(cells.clone()) {
                self.shares.push(levels.iter().zip(self.study.design().factors()).map(unit).collect());
                self.found.push(cells);
            }
        }
        Ok(())
    }

    fn allowed(&self, levels: &[Level]) -> Result<Option<Vec<String>>, RefinementError> {
        if !self.study.meets(levels)? || self.study.scene_at(levels).is_err() {
            return Ok(None);
        }
        Ok(Some(cells(&self.study.values_at(levels))).filter(|cells| !self.taken.contains(cells)))
    }
}

fn cells(values: &[Value]) -> Vec<String> {
    values.iter().map(Value::to_string).collect()
}
