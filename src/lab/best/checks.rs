//! Runs of a decision.

use super::model::Models;
use std::ops::Range;

/// Runs of a decision.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Checks {
    /// Number of rows.
    pub count: usize,
    /// Rows that are done and hold all limits.
    pub held: usize,
    /// Rows that are not done, or lack a value.
    pub failed: usize,
    /// Values of the rows that have all of them: the goal, then each limit; ascending.
    pub values: Vec<Vec<f64>>,
    /// First and last row in the dataset of added rows.
    pub rows: [u64; 2],
}

impl Checks {
    /// No row of these has been read yet. `values`: number of values of the goal and the limits.
    pub fn unread(rows: &Range<usize>, values: usize) -> Self {
        let count = rows.len();
        let ends = [rows.start as u64, rows.end as u64 - 1];
        Self { count, held: 0, failed: count, values: vec![Vec::new(); values], rows: ends }
    }

    /// Takes the values of a row that is done: the goal, then each limit.
    pub fn take(&mut self, values: &[f64], models: &Models) {
        if values.iter().any(|value| value.is_nan()) {
            return;
        }
        self.failed -= 1;
        self.held += usize::from(models.wanted.iter().zip(values).all(|(wanted, value)| wanted.holds(*value)));
        self.values.iter_mut().zip(values).for_each(|(all, value)| all.push(*value));
    }

    /// Whether so large a share of them holds all limits.
    pub fn are_held(&self, confidence: f64) -> bool {
        self.held as f64 >= confidence * self.count as f64 - 1e-9
    }

    /// Mean of a value over the rows that have it.
    pub fn mean(&self, place: usize) -> f64 {
        self.values[place].iter().sum::<f64>() / self.values[place].len().max(1) as f64
    }

    /// The value below which a share of the rows lie.
    pub fn quantile(&self, place: usize, share: f64) -> f64 {
        let values = &self.values[place];
        let at = (share * values.len() as f64 - 1e-9).ceil().max(1.0) as usize;
        values.get(at.min(values.len()).saturating_sub(1)).copied().unwrap_or(f64::NAN)
    }
}
