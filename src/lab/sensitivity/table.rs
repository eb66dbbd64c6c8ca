//! The rows of a dataset as columns of numbers.

use std::collections::HashMap;

use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetReader, RowRecord, TableName};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};
use decore_study::DesignOutline;

/// A factor's values, row by row.
#[derive(Debug, Clone)]
pub struct FactorColumn {
    /// Name as in the study.
    pub name: String,
    /// Values; for names their place in the study's list.
    pub values: Vec<f64>,
    /// Whether its values are names, which have no order.
    pub nominal: bool,
    /// The names, by the numbers that stand for them; empty if it has none.
    pub names: Vec<String>,
}

/// An output's values, row by row.
#[derive(Debug, Clone)]
pub struct OutputColumn {
    /// Description of the column.
    pub description: ColumnDescription,
    /// Values; NaN for rows without one.
    pub values: Vec<f64>,
}

/// Rows of a dataset in their order.
#[derive(Debug, Clone)]
pub struct Table {
    /// Index of each row in the design, ascending.
    pub rows: Vec<u64>,
    /// Reason why a row is not done, as an index of [`Table::reasons`].
    pub faults: Vec<Option<usize>>,
    /// The different reasons.
    pub reasons: Vec<String>,
    /// Drawn factors, in the study's order.
    pub factors: Vec<FactorColumn>,
    /// The outputs.
    pub outputs: Vec<OutputColumn>,
}

impl FactorColumn {
    /// Whether it has different values.
    pub fn varies(&self) -> bool {
        differ(&self.values)
    }
}

/// Whether values are not all the same.
pub(super) fn differ(values: &[f64]) -> bool {
    values.windows(2).any(|pair| pair[0] != pair[1])
}

impl Table {
    /// Reads the drawn factors of the outline and these outputs.
    ///
    /// # Errors
    /// Those of reading; [`DatasetError::UnknownColumn`], [`DatasetError::NotANumber`].
    pub fn read(reader: &DatasetReader, outline: &DesignOutline, outputs: &[String]) -> Result<Self, DatasetError> {
        let mut codes = Vec::new();
        let mut table = Self {
            rows: Vec::new(),
            faults: Vec::new(),
            reasons: Vec::new(),
            factors: Vec::new(),
            outputs: Vec::new(),
        };
        let mut names = vec![RowRecord::row.name, RowOutcome::status.name, RowOutcome::reason.name];
        for factor in outline.factors.iter().filter(|factor| !factor.derived) {
            let of_it = |column: &&ColumnDescription| {
                column.group == ColumnGroup::Factor && column.subject.as_ref() == Some(&factor.name)
            };
            let Some(column) = reader.columns(TableName::Runs).iter().find(of_it) else { continue };
            names.push(&column.name);
            codes.push(Codes::new(&factor.values));
            let nominal = column.kind.is_text();
            table.factors.push(FactorColumn {
                name: factor.name.clone(),
                values: Vec::new(),
                nominal,
                names: Vec::new(),
            });
        }
        for output in outputs {
            let description = reader.column(TableName::Runs, output)?;
            if description.kind.is_text() {
                return Err(DatasetError::NotANumber { table: TableName::Runs.folder(), column: output.clone() });
            }
            names.push(&description.name);
            table.outputs.push(OutputColumn { description: description.clone(), values: Vec::new() });
        }
        reader.visit(TableName::Runs, &names, |cells| table.add(cells, &mut codes))?;
        for (column, codes) in table.factors.iter_mut().zip(codes).filter(|(column, _)| column.nominal) {
            column.names = codes.names();
        }
        Ok(table)
    }

    /// Adds the rows of another table of the same factors and outputs, `offset` added to their indices.
    pub fn append(&mut self, other: Self, offset: u64) {
        self.rows.extend(other.rows.iter().map(|row| row + offset));
        let reasons: Vec<usize> = other.reasons.into_iter().map(|reason| self.reason(reason)).collect();
        self.faults.extend(other.faults.iter().map(|fault| fault.map(|place| reasons[place])));
        for (column, other) in self.factors.iter_mut().zip(other.factors) {
            let mut code = |name: String| {
                let known = column.names.iter().position(|known| *known == name);
                known.unwrap_or_else(|| {
                    column.names.push(name);
                    column.names.len() - 1
                })
            };
            let codes: Vec<usize> = other.names.into_iter().map(&mut code).collect();
            let value =
                |value: f64| codes.get(value as usize).filter(|_| other.nominal).map_or(value, |code| *code as f64);
            column.values.extend(other.values.into_iter().map(value));
        }
        for (column, other) in self.outputs.iter_mut().zip(other.outputs) {
            column.values.extend(other.values);
        }
    }

    /// Leaves only the rows whose index in the design passes.
    pub fn retain(&mut self, passes: impl Fn(u64) -> bool) {
        let kept: Vec<bool> = self.rows.iter().map(|row| passes(*row)).collect();
        fn keep<T>(values: &mut Vec<T>, kept: &[bool]) {
            let mut kept = kept.iter();
            values.retain(|_| kept.next().copied().unwrap_or_default());
        }
        keep(&mut self.rows, &kept);
        keep(&mut self.faults, &kept);
        self.factors.iter_mut().for_each(|column| keep(&mut column.values, &kept));
        self.outputs.iter_mut().for_each(|column| keep(&mut column.values, &kept));
    }

    fn add(&mut self, cells: &[Cell<'_>], codes: &mut [Codes]) {
        let [Some(Value::Count(row)), Some(Value::Text(status)), reason, others @ ..] = cells else { return };
        self.rows.push(*row);
        let fault = (*status != RowStatus::Done.name()).then(|| match reason {
            Some(Value::Text(reason)) if !reason.is_empty() => format!("{status}: {reason}"),
            _ => (*status).to_owned(),
        });
        let fault = fault.map(|fault| self.reason(fault));
        self.faults.push(fault);
        let (factors, outputs) = others.split_at(self.factors.len().min(others.len()));
        for ((column, cell), codes) in self.factors.iter_mut().zip(factors).zip(codes) {
            column.values.push(codes.number(cell));
        }
        for (column, cell) in self.outputs.iter_mut().zip(outputs) {
            column.values.push(cell.and_then(|value| value.number()).unwrap_or(f64::NAN));
        }
    }

    /// The place of a reason among the different ones.
    fn reason(&mut self, fault: String) -> usize {
        self.reasons.iter().position(|known| *known == fault).unwrap_or_else(|| {
            self.reasons.push(fault);
            self.reasons.len() - 1
        })
    }
}

/// Numbers that stand for names: their places in the study's list, then in the order of their first row.
struct Codes(HashMap<String, usize>);

impl Codes {
    fn new(values: &[Value]) -> Self {
        let texts = values.iter().enumerate().filter_map(|(place, value)| match value {
            Value::Text(text) => Some((text.clone(), place)),
            _ => None,
        });
        Self(texts.collect())
    }

    /// The names in the order of their numbers.
    fn names(self) -> Vec<String> {
        let mut names: Vec<(String, usize)> = self.0.into_iter().collect();
        names.sort_by_key(|(_, number)| *number);
        names.into_iter().map(|(name, _)| name).collect()
    }

    fn number(&mut self, cell: &Cell<'_>) -> f64 {
        match cell {
            Some(Value::Text(text)) => {
                let next = self.0.len();
                *self.0.entry((*text).to_owned()).or_insert(next) as f64
            }
            other => other.and_then(|value| value.number()).unwrap_or(f64::NAN),
        }
    }
}
