//! Places at which a row could be run.

use std::collections::HashSet;

use super::climb::{LEAST_DISTANCE, is_apart};
use super::error::RefinementError;
use decore_math::random::{hash, uniform};
use decore_quantity::Value;
use decore_statistics::design::{Coordinate, Design, Distribution, Factor, Kind, Level, Sobol};
use decore_study::CheckedStudy;

/// Largest number of tried points per wanted candidate: constraints may leave few.
const MOST_TRIED: usize = 64;
/// Stream of the numbers by which candidates lie near a row.
const NEAR: u64 = 0x6e65_6172;

/// Strata of equal probability, the middles of whose outermost ones end the share of a distribution without ends in which rows are
/// proposed: a design of as many rows hardly has one farther out, and a model has nothing to go by there. For a normal distribution
/// these are 3.3 standard deviations to either side.
const STRATA: f64 = 1000.0;

/// Smallest distance along one factor between rows of a batch that follow peaks, as a share of its range. The expected value of a row makes
/// a nearby place the next peak, where a run would add no information.
const BESIDE: f64 = 0.05;

/// Smallest distance between the rows of a batch. It shrinks if the excluded places would take more than half of the ranges.
pub(super) fn beside(batch: usize, factors: usize) -> f64 {
    let most = 0.5 * (0.5 / batch as f64).powf(1.0 / factors as f64);
    BESIDE.min(most).max(LEAST_DISTANCE)
}

/// Collects candidates: none is a row already or so near to one that it would be its copy, each lies in the central share of all
/// distributions without ends, meets all constraints and describes a scene.
pub(super) struct Collector<'a> {
    study: &'a CheckedStudy,
    /// Rows that there are.
    taken: HashSet<Vec<String>>,
    /// Positions of the rows, as returned by [`Collector::place`].
    rows: Vec<Vec<f64>>,
    /// Positions of the rows that are chosen to run.
    chosen: Vec<Vec<f64>>,
    /// Smallest distance between them.
    beside: f64,
    /// Candidates, each once.
    seen: HashSet<Vec<String>>,
    /// Values of all factors, in the study's order, as cells of a table that read back the same.
    pub found: Vec<Vec<String>>,
    /// Positions in the ranges of the factors, 0 to 1.
    pub shares: Vec<Vec<f64>>,
}

/// Candidates around a place.
#[derive(Debug, Clone, Copy)]
pub struct Around {
    /// Number of candidates.
    pub count: usize,
    /// Largest distance, as a share of each factor's range.
    pub reach: f64,
}

impl<'a> Collector<'a> {
    pub fn new(study: &'a CheckedStudy, beside: f64) -> Self {
        let levels = (0..study.row_count()).filter_map(|row| study.design().row(row));
        let mut new = Self {
            study,
            taken: HashSet::new(),
            rows: Vec::new(),
            chosen: Vec::new(),
            beside,
            seen: HashSet::new(),
            found: Vec::new(),
            shares: Vec::new(),
        };
        for levels in levels {
            new.taken.insert(cells(&study.values_at(&levels)));
            new.rows.push(new.place(&levels));
        }
        new
    }

    /// So many Sobol' points, scrambled by the seed, and far enough from each other that each may be run; none where only rows are
    /// left.
    ///
    /// # Errors
    /// [`RefinementError::NoCandidates`] where none meets the constraints.
    pub fn fill(&mut self, count: usize, seed: u64) -> Result<(), RefinementError> {
        let points = Kind::Sobol(Sobol { rows: count * MOST_TRIED, scramble: true });
        let points = Design::new(points, self.study.design().factors().to_vec(), seed)?;
        let (mut spread, mut at_rows): (Vec<Vec<f64>>, bool) = (Vec::new(), false);
        for row in 0..count * MOST_TRIED {
            if spread.len() >= count {
                break;
            }
            let levels = self.central(&points.row(row).unwrap_or_default());
            let place = self.place(&levels);
            if !is_apart(&place, &self.rows, LEAST_DISTANCE) {
                at_rows = true;
            } else if is_apart(&place, &spread, LEAST_DISTANCE) && self.add(&levels)? {
                spread.push(place);
            }
        }
        match self.found.is_empty() && !at_rows {
            true => Err(RefinementError::NoCandidates { tried: count * MOST_TRIED }),
            false => Ok(()),
        }
    }

    /// So many points around a place, up to a share `reach` of each factor's range away.
    pub fn near(&mut self, place: &[Level], around: Around, seed: u64) -> Result<(), RefinementError> {
        let Around { count, reach } = around;
        for index in 0..count {
            let stream = hash(seed, NEAR, index as u64);
            let moved = |(factor, (level, Factor { distribution, .. })): (usize, (&Level, &Factor))| {
                let at = Coordinate::Value(*level).unit(distribution);
                let away = reach * (2.0 * uniform(seed, stream, factor as u64) - 1.0);
                Coordinate::Probability((at + away).clamp(0.0, 1.0)).level(distribution)
            };
            let factors = self.study.design().factors();
            let levels: Vec<Level> = place.iter().zip(factors).enumerate().map(moved).collect();
            self.add(&self.central(&levels))?;
        }
        Ok(())
    }

    /// The cells of a place by its shares of the ranges; `None` if no row may be run, or one is there.
    pub fn cells_at(&self, shares: &[f64]) -> Result<Option<Vec<String>>, RefinementError> {
        self.allowed(&self.levels_at(shares))
    }

    /// Takes a row to run, by its shares of the ranges. It and its neighbourhood are no candidates any more.
    pub fn take(&mut self, shares: &[f64]) {
        self.leave_out(shares, self.beside);
        let levels = self.levels_at(shares);
        self.taken.insert(cells(&self.study.values_at(&levels)));
        self.chosen.push(self.place(&levels));
    }

    /// A place that cannot be run: neither it nor its copies are candidates any more.
    pub fn discard(&mut self, shares: &[f64]) {
        self.leave_out(shares, LEAST_DISTANCE);
    }

    fn leave_out(&mut self, shares: &[f64], distance: f64) {
        let place = [self.place(&self.levels_at(shares))];
        let is_left = |shares: &Vec<f64>| is_apart(&self.place(&self.levels_at(shares)), &place, distance);
        let is_left: Vec<bool> = self.shares.iter().map(is_left).collect();
        let (mut found, mut shares) = (is_left.iter(), is_left.iter());
        self.found.retain(|_| found.next().is_some_and(|is_left| *is_left));
        self.shares.retain(|_| shares.next().is_some_and(|is_left| *is_left));
    }

    /// The candidates; the rows if there are none.
    pub fn places(&self) -> Vec<Vec<String>> {
        match self.found.is_empty() {
            true => (0..self.study.row_count()).map(|row| cells(&self.study.row_values(row))).collect(),
            false => self.found.clone(),
        }
    }

    /// Whether it is a candidate, and was none before.
    fn add(&mut self, levels: &[Level]) -> Result<bool, RefinementError> {
        let Some(cells) = self.allowed(levels)? else { return Ok(false) };
        if !self.seen.insert(cells.clone()) {
            return Ok(false);
        }
        let unit = |(level, factor): (&Level, &Factor)| Coordinate::Value(*level).unit(&factor.distribution);
        self.shares.push(levels.iter().zip(self.study.design().factors()).map(unit).collect());
        self.found.push(cells);
        Ok(true)
    }

    fn allowed(&self, levels: &[Level]) -> Result<Option<Vec<String>>, RefinementError> {
        let place = self.place(levels);
        let is_free = is_apart(&place, &self.rows, LEAST_DISTANCE) && is_apart(&place, &self.chosen, self.beside);
        if !is_free || !self.study.meets(levels)? || self.study.scene_at(levels).is_err() {
            return Ok(None);
        }
        Ok(Some(cells(&self.study.values_at(levels))).filter(|cells| !self.taken.contains(cells)))
    }

    /// Position of levels for distances between rows: shares of the ranges; for names their numbers, because all names are equally far
    /// apart.
    fn place(&self, levels: &[Level]) -> Vec<f64> {
        let at = |(level, factor): (&Level, &Factor)| match level {
            Level::Category(number) => *number as f64,
            level => Coordinate::Value(*level).unit(&factor.distribution),
        };
        levels.iter().zip(self.study.design().factors()).map(at).collect()
    }

    fn levels_at(&self, shares: &[f64]) -> Vec<Level> {
        let level = |(share, factor): (&f64, &Factor)| Coordinate::Probability(*share).level(&factor.distribution);
        self.central(&shares.iter().zip(self.study.design().factors()).map(level).collect::<Vec<Level>>())
    }

    /// Levels drawn into the central share of distributions without ends.
    fn central(&self, levels: &[Level]) -> Vec<Level> {
        let factors = self.study.design().factors();
        levels.iter().zip(factors).map(|(level, factor)| central(*level, &factor.distribution)).collect()
    }
}

/// A level, or the nearest one within the central share of a distribution without ends.
fn central(level: Level, distribution: &Distribution) -> Level {
    let Distribution::Normal { .. } = distribution else { return level };
    let tail = 0.5 / STRATA;
    match Coordinate::Value(level).unit(distribution) {
        share if share < tail => distribution.quantile(tail),
        share if share > 1.0 - tail => distribution.quantile(1.0 - tail),
        _ => level,
    }
}

fn cells(values: &[Value]) -> Vec<String> {
    values.iter().map(Value::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_batch_leave_half_of_the_ranges() {
        assert_eq!([beside(4, 4), beside(4, 1), beside(256, 6)], [0.05; 3]);
        assert!((beside(32, 1) - 1.0 / 128.0).abs() < 1e-12 && beside(256, 1) == LEAST_DISTANCE);
    }

    #[test]
    fn levels_stay_where_a_thousand_rows_lie() {
        let normal = Distribution::Normal { mean: 5.0, std_dev: 0.3 };
        let off = |level: Level| if let Level::Real(value) = level { (value - 5.0) / 0.3 } else { f64::NAN };
        for (share, expected) in [(0.0, -3.290_527), (0.5, 0.0), (0.999, 3.090_232), (1.0, 3.290_527)] {
            assert!((off(central(normal.quantile(share), &normal)) - expected).abs() < 1e-6, "{share}");
        }
        let uniform = Distribution::Uniform { low: 1.0, high: 2.0 };
        assert_eq!(central(uniform.quantile(1.0), &uniform), Level::Real(2.0));
    }
}
