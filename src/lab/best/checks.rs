//! Rows that prove a proposal.

use super::error::BestError;
use super::model::Models;
use super::task::{Added, Purpose};
use decore_dataset::{DatasetReader, RowRecord, TableName};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};

/// The rows of the last proposal.
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
    /// Reads the last rows that were added as checks.
    pub fn read(reader: &DatasetReader, models: &Models, added: &[Added]) -> Result<Self, BestError> {
        let last = added.last();
        let same =
            |row: &&Added| row.purpose == Purpose::Check && last.is_some_and(|last| last.question == row.question);
        let count = added.iter().rev().take_while(same).count();
        let first = (added.len() - count) as u64;
        let mut names = vec![RowRecord::row.name, RowOutcome::status.name];
        let places: Vec<std::ops::Range<usize>> = (models.wanted.iter())
            .map(|wanted| {
                let from = names.len() - 2;
                names.extend(wanted.columns().iter().map(String::as_str));
                from..names.len() - 2
            })
            .collect();
        let mut found = Self {
            count,
            held: 0,
            failed: count,
            values: vec![Vec::new(); places.len()],
            rows: [first, first + count as u64 - 1],
        };
        reader.visit(TableName::Runs, &names, |cells| found.take(cells, models, (first, &places)))?;
        found.values.iter_mut().for_each(|values| values.sort_by(f64::total_cmp));
        Ok(found)
    }

    fn take(&mut self, cells: &[Cell<'_>], models: &Models, (first, places): (u64, &[std::ops::Range<usize>])) {
        let [Some(Value::Count(row)), Some(Value::Text(status)), cells @ ..] = cells else { return };
        if *row < first || *status != RowStatus::Done.name() {
            return;
        }
        let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).unwrap_or(f64::NAN);
        let numbers: Vec<f64> = cells.iter().map(number).collect();
        let values: Vec<f64> =
            models.wanted.iter().zip(places).map(|(wanted, place)| wanted.value(&numbers[place.clone()])).collect();
        if values.iter().any(|value| value.is_nan()) {
            return;
        }
        self.failed -= 1;
        self.held += usize::from(models.wanted.iter().zip(&values).all(|(wanted, value)| wanted.holds(*value)));
        self.values.iter_mut().zip(values).for_each(|(all, value)| all.push(value));
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
