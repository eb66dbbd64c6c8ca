//! Outputs that are the same in all rows: they need no model.

use super::goal::Limit;
use super::progress::OutputProgress;
use crate::surrogate::{Model, OutputSurrogate, SurrogateError};
use decore_dataset::{DatasetReader, RowRecord, TableName};
use decore_quantity::Cell;
use decore_statistics::regression::{RegressionError, check};

/// An output that is the same in all rows that have it.
pub(super) struct Constant {
    /// Column of the output.
    pub output: String,
    /// Unit.
    pub unit: String,
    /// Constant value.
    pub value: f64,
    /// The rows that have it, by their places in the model, ascending.
    pub rows: Vec<usize>,
}

impl Constant {
    /// Reads an output without a model, if the reason is that it is constant.
    ///
    /// # Errors
    /// Those of reading.
    pub fn read(
        reader: &DatasetReader,
        model: &Model,
        figures: &OutputSurrogate,
    ) -> Result<Option<Self>, SurrogateError> {
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).filter(|number| number.is_finite());
        reader.visit(TableName::Runs, &[RowRecord::row.name, &figures.output], |cells| {
            let row = number(&cells[0]).and_then(|row| model.rows.binary_search(&(row as u64)).ok());
            if let Some((row, value)) = row.zip(number(&cells[1])) {
                rows.push(row);
                values.push(value);
            }
        })?;
        Ok(match check(&model.points.select(&rows), &values) {
            Err(RegressionError::Constant { value }) => {
                Some(Self { output: figures.output.clone(), unit: figures.unit.clone(), value, rows })
            }
            _ => None,
        })
    }

    /// Whether a row, by its place in the model, has it within the limit.
    pub fn holds(&self, limit: &Limit, row: usize) -> bool {
        self.rows.binary_search(&row).is_ok() && limit.holds(self.value)
    }

    /// Progress of a constant output: complete.
    pub fn progress(&self) -> OutputProgress {
        OutputProgress {
            output: self.output.clone(),
            unit: self.unit.clone(),
            used: self.rows.len() as u64,
            constant: Some(self.value),
            q2: 1.0,
            width: 0.0,
        }
    }
}
