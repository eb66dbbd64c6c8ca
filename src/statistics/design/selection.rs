//! Selection of a design's points by constraints.

use super::error::DesignError;
use super::group::{GroupSpan, kept};
use super::kind::Points;

/// Points looked at before the share that passes is judged.
const JUDGED: usize = 20_000;
/// Points per one that passes, at most.
const MOST_PER_ROW: usize = 1000;

/// Numbers of examined and of accepted points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct Acceptance {
    /// Points looked at.
    pub tried: usize,
    /// Points that passed.
    pub accepted: usize,
}

impl Acceptance {
    /// Share of the points that passed.
    pub fn rate(&self) -> f64 {
        self.accepted as f64 / self.tried.max(1) as f64
    }
}

/// Blocks of rows that stay, by their number in the design.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Selection {
    block: usize,
    kept: Vec<usize>,
    tried: usize,
}

impl Selection {
    /// Keeps the blocks of `points` all of whose rows pass; endless designs give as many blocks as were requested.
    ///
    /// The kept blocks do not depend on the wanted number, so a longer design starts with the shorter one.
    pub(super) fn choose(
        points: &dyn Points,
        mut accept: impl FnMut(usize) -> Result<bool, DesignError>,
    ) -> Result<Self, DesignError> {
        let block = points.block();
        let wanted = points.rows() / block;
        let mut selection = Self { block, kept: Vec::new(), tried: 0 };
        while selection.kept.len() < wanted && (points.is_endless() || selection.tried < wanted) {
            let first = selection.tried * block;
            let mut passes = true;
            for row in first..first + block {
                passes = accept(row)?;
                if !passes {
                    break;
                }
            }
            if passes {
                selection.kept.push(selection.tried);
            }
            selection.tried += 1;
            let few = selection.tried / MOST_PER_ROW > selection.kept.len();
            if points.is_endless() && selection.tried >= JUDGED && few {
                break;
            }
        }
        let (kept, tried) = (selection.kept.len(), selection.tried);
        if kept == 0 || (points.is_endless() && kept < wanted) {
            let what = if block == 1 { "points" } else { "blocks of rows that belong together" };
            return Err(DesignError::Unsatisfiable(format!(
                "{kept} of {tried} {what} meet the constraints: they contradict each other or the ranges, or permit \
                 less than a thousandth of the points; check each constraint, or narrow the ranges"
            )));
        }
        Ok(selection)
    }

    pub(super) fn rows(&self) -> usize {
        self.kept.len() * self.block
    }

    pub(super) fn index(&self, row: usize) -> Option<usize> {
        Some(self.kept.get(row / self.block)? * self.block + row % self.block)
    }

    /// Groups of the remaining rows, from the groups of all rows. Blocks are groups, of which all or no rows remain.
    pub(super) fn groups(&self, spans: &[GroupSpan]) -> Vec<GroupSpan> {
        match self.block {
            1 => kept(spans, &self.kept),
            _ => spans.iter().map(|span| GroupSpan { rows: self.rows() as u64, ..*span }).collect(),
        }
    }

    pub(super) fn acceptance(&self) -> Acceptance {
        Acceptance { tried: self.tried, accepted: self.kept.len() }
    }
}
