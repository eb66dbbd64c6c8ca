//! Finds the best decision among many, by the predictions of the models.

use super::error::BestError;
use super::model::{Expected, Models};
use super::space::{Decision, Space};
use crate::refinement::is_apart;

/// Decisions over the whole ranges.
const SPREAD: usize = 512;
/// Boxes about the best decisions at several places, as shares of the ranges, one after the other.
const REACHES: [f64; 4] = [0.2, 0.07, 0.02, 0.006];
/// Decisions in each box.
const NEAR: usize = 96;
/// Places with the best decisions, about which boxes are laid.
const CENTRES: usize = 3;
/// Least distance between places, as a share of a range.
const ELSEWHERE: f64 = 0.15;

/// Decisions with their predictions.
pub(super) struct Pool<'a> {
    pub space: &'a Space<'a>,
    pub models: &'a Models,
    /// The decisions that were run, then all others.
    pub all: Vec<Expected>,
    /// Number of decisions that were run.
    pub run: usize,
    /// Factors that tell places apart: factors that move a hammer, if there are any, otherwise all.
    movers: Vec<usize>,
}

/// Merit of a decision under some limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Merit {
    /// Whether the limits hold at the stated confidence.
    pub holds: bool,
    /// The goal, larger is better.
    pub goal: f64,
    /// Share of runs that hold the limits, with the model's error on the bad side.
    pub share: f64,
    /// Largest violation of a limit by the expected values, as a share of the limit; 0 if they are within all limits.
    pub lack: f64,
}

impl Merit {
    /// Whether it is better than another one. Where limits do not hold, the share decides, then how far off they are; of equal goals the
    /// share too.
    pub fn beats(&self, other: &Self) -> bool {
        let key = |merit: &Self| match merit.holds {
            true => (1, [merit.goal, merit.share, 0.0]),
            false => (0, [merit.share, -merit.lack, merit.goal]),
        };
        let ((a, mine), (b, theirs)) = (key(self), key(other));
        let values = mine.iter().zip(&theirs).map(|(one, other)| one.total_cmp(other));
        values.fold(a.cmp(&b), std::cmp::Ordering::then).is_gt()
    }
}

impl<'a> Pool<'a> {
    /// Decisions that were run, decisions over the whole ranges, and near the best ones.
    pub fn new(space: &'a Space<'a>, models: &'a Models, run: &[Decision]) -> Result<Self, BestError> {
        let all = models.expected(space, &[run, &space.spread(SPREAD)?].concat())?;
        let mut pool = Self { space, models, all, run: run.len(), movers: movers(space) };
        pool.zoom(&models.bounds(), 0)?;
        Ok(pool)
    }

    /// Adds decisions near those that are best under these limits, at several places.
    pub fn zoom(&mut self, bounds: &[f64], stream: u64) -> Result<(), BestError> {
        for (stage, reach) in REACHES.into_iter().enumerate() {
            let order = self.ranked(bounds, (usize::MAX, 0.0)).into_iter();
            for (number, centre) in self.elsewhere(order, &[], CENTRES).into_iter().enumerate() {
                let stream = 1000 * stream + 10 * stage as u64 + number as u64;
                let near = self.space.near(&self.all[centre].decision, (NEAR, reach), stream)?;
                self.all.extend(self.models.expected(self.space, &near)?);
            }
        }
        Ok(())
    }

    pub fn merit(&self, of: &Expected, bounds: &[f64]) -> Merit {
        let share = of.held(&self.models.wanted, bounds, self.models.caution());
        let lack = of.lack(&self.models.wanted, bounds);
        Merit { holds: share >= self.models.confidence, goal: self.models.sign() * of.goal(), share, lack }
    }

    /// The best decision under these limits, whether it holds them or not.
    pub fn best(&self, bounds: &[f64]) -> (usize, Merit) {
        let mut merits = self.all.iter().map(|of| self.merit(of, bounds)).enumerate();
        // A pool holds at least one decision.
        let first =
            merits.next().unwrap_or((0, Merit { holds: false, goal: f64::NAN, share: 0.0, lack: f64::INFINITY }));
        merits.fold(first, |best, next| if next.1.beats(&best.1) { next } else { best })
    }

    /// The best decisions under these limits that lie apart, the best first.
    pub fn ranked(&self, bounds: &[f64], (count, apart): (usize, f64)) -> Vec<usize> {
        let merits: Vec<Merit> = self.all.iter().map(|of| self.merit(of, bounds)).collect();
        let mut order: Vec<usize> = (0..merits.len()).collect();
        order.sort_by(|a, b| match (merits[*a].beats(&merits[*b]), merits[*b].beats(&merits[*a])) {
            (true, _) => std::cmp::Ordering::Less,
            (_, true) => std::cmp::Ordering::Greater,
            _ => a.cmp(b),
        });
        self.apart(order, (count, apart))
    }

    /// The first of some decisions that lie apart.
    pub fn apart(&self, order: Vec<usize>, (count, apart): (usize, f64)) -> Vec<usize> {
        let (mut chosen, mut places) = (Vec::new(), Vec::new());
        for one in order {
            let place = self.space.place(&self.all[one].decision);
            if chosen.len() < count && is_apart(&place, &places, apart) {
                chosen.push(one);
                places.push(place);
            }
        }
        chosen
    }

    /// The first of some decisions that lie at other places than the `taken` ones and each other.
    pub fn elsewhere(&self, order: impl Iterator<Item = usize>, taken: &[Decision], count: usize) -> Vec<usize> {
        let place_of = |decision: &Decision| {
            let place = self.space.place(decision);
            self.movers.iter().map(|mover| place[*mover]).collect::<Vec<f64>>()
        };
        let mut taken: Vec<Vec<f64>> = taken.iter().map(place_of).collect();
        let is_elsewhere = |one: &usize| {
            let place = place_of(&self.all[*one].decision);
            let is_elsewhere = is_apart(&place, &taken, ELSEWHERE);
            taken.extend(is_elsewhere.then_some(place));
            is_elsewhere
        };
        order.filter(is_elsewhere).take(count).collect()
    }
}

fn movers(space: &Space<'_>) -> Vec<usize> {
    let moves = |place: &usize| {
        let is_place = |path: &String| {
            path.starts_with("hammer.") && ["rail_position_m", "mount", "rail"].iter().any(|end| path.ends_with(end))
        };
        space.info(*place).paths().iter().any(is_place)
    };
    let all = 0..space.decisions.len();
    let movers: Vec<usize> = all.clone().filter(moves).collect();
    if movers.is_empty() { all.collect() } else { movers }
}
