//! A row as bytes: what the journal holds, and what the parts are encoded from.
//!
//! Every row goes through these bytes, whether it was just computed, comes from the journal of a killed run, or from a part
//! that must be written anew: that is why all of them give the same files.

use super::columns::{Column, Columns, Source, TableName};
use super::error::DatasetError;
use super::info::{DatasetInfo, RowRecord};
use crate::quantity::{Cell, FREE_TAG, Value, put_cell, take_cell};
use crate::run::{RowOutcome, RowStatus};

/// What stands before the cells of an instant of `signals`.
const INSTANT: u8 = FREE_TAG;

/// A row of all tables as bytes: its index, its cells of `runs`, of `timings`, those of its blows, and of the instants of its signals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredRow {
    row: u64,
    failed: bool,
    bytes: Vec<u8>,
}

impl StoredRow {
    /// The row of a record, whose blows are given in the table's form.
    pub fn new(info: &DatasetInfo, columns: &Columns, record: &RowRecord) -> Self {
        let mut writer = RowWriter::new(record.row, record.outcome.status != RowStatus::Done);
        let mut source = Source::new(info, record);
        writer.cells(&columns.runs, &source);
        writer.cells(&columns.timings, &source);
        for blow in record.outcome.metrics.iter().flat_map(|metrics| &metrics.blows) {
            source.blow = Some(blow);
            writer.cells(&columns.blows, &source);
        }
        for instant in record.outcome.metrics.iter().flat_map(|metrics| &metrics.signals) {
            source.instant = Some(instant);
            writer.instant();
            writer.cells(&columns.signals, &source);
        }
        writer.finish()
    }

    /// Index of the row in the design.
    pub fn row(&self) -> u64 {
        self.row
    }

    /// Whether the row ended with another status than done.
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// The bytes, as [`StoredRow::from_bytes`] takes them.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The row that has these bytes; `None` if they are none.
    pub fn from_bytes(bytes: Vec<u8>) -> Option<Self> {
        let row = u64::from_le_bytes(bytes.get(..8)?.try_into().ok()?);
        let failed = *bytes.get(8)? != 0;
        Some(Self { row, failed, bytes })
    }

    /// Calls `take` with every cell and its table, in the order of the columns; `None` if the bytes do not hold whole rows
    /// of the tables with these numbers of columns.
    pub fn visit(&self, columns: &ColumnCounts, take: &mut dyn FnMut(TableName, usize, Cell<'_>)) -> Option<()> {
        let mut rest = self.bytes.get(9..)?;
        for (table, count) in [(TableName::Runs, columns.runs), (TableName::Timings, columns.timings)] {
            for index in 0..count {
                take(table, index, take_cell(&mut rest)?);
            }
        }
        while let Some(first) = rest.first() {
            let (table, count) = match *first {
                INSTANT => (TableName::Signals, columns.signals),
                _ => (TableName::Blows, columns.blows),
            };
            if table == TableName::Signals {
                rest = rest.get(1..)?;
            }
            // Bytes that no column takes are no row.
            if count == 0 {
                return None;
            }
            for index in 0..count {
                take(table, index, take_cell(&mut rest)?);
            }
        }
        Some(())
    }
}

/// Numbers of columns of the tables.
#[derive(Debug, Clone, Copy)]
pub struct ColumnCounts {
    /// Of `runs`.
    pub runs: usize,
    /// Of `blows`.
    pub blows: usize,
    /// Of `timings`.
    pub timings: usize,
    /// Of `signals`.
    pub signals: usize,
}

impl ColumnCounts {
    /// Counts the columns.
    pub fn of(columns: &Columns) -> Self {
        Self {
            runs: columns.runs.len(),
            blows: columns.blows.len(),
            timings: columns.timings.len(),
            signals: columns.signals.len(),
        }
    }
}

/// Builds the bytes of a row.
pub struct RowWriter {
    row: u64,
    failed: bool,
    bytes: Vec<u8>,
}

impl RowWriter {
    /// Begins a row.
    pub fn new(row: u64, failed: bool) -> Self {
        let mut bytes = Vec::with_capacity(1024);
        bytes.extend_from_slice(&row.to_le_bytes());
        bytes.push(u8::from(failed));
        Self { row, failed, bytes }
    }

    fn cells(&mut self, columns: &[Column], source: &Source<'_>) {
        columns.iter().for_each(|column| self.cell(column.cell(source)));
    }

    /// Begins an instant of the table of signals, whose cells follow.
    pub fn instant(&mut self) {
        self.bytes.push(INSTANT);
    }

    /// Adds a cell; they come in the order runs, timings, blow by blow, instant by instant.
    pub fn cell(&mut self, cell: Cell<'_>) {
        put_cell(&mut self.bytes, cell);
    }

    /// The row.
    pub fn finish(self) -> StoredRow {
        StoredRow { row: self.row, failed: self.failed, bytes: self.bytes }
    }
}

/// Whether the cells of a row of `runs` with these columns say that the row is not done.
pub fn cells_say_failed(names: &[&str], cells: &[Cell<'_>]) -> bool {
    let status = names.iter().zip(cells).find(|(name, _)| **name == RowOutcome::status.name);
    status.is_none_or(|(_, cell)| *cell != Some(Value::Text(RowStatus::Done.name())))
}

/// Holds a record to the shape that the columns were made for: a value without column would be lost silently.
///
/// # Errors
/// [`DatasetError::Record`].
pub fn check_record(info: &DatasetInfo, record: &RowRecord) -> Result<(), DatasetError> {
    let misfit = |what: &str, found: String, expected: String| {
        Err(DatasetError::Record { row: record.row, what: what.to_owned(), found, expected })
    };
    let count = |what: &str, found: usize, expected: usize| match found == expected {
        true => Ok(()),
        false => misfit(what, found.to_string(), expected.to_string()),
    };
    count("number of factors", record.factors.len(), info.factors.len())?;
    for (value, factor) in record.factors.iter().zip(&info.factors) {
        if value.kind() != factor.kind {
            let what = format!("type of factor `{}`", factor.name);
            return misfit(&what, format!("{:?}", value.kind()), format!("{:?}", factor.kind));
        }
    }
    let Some(metrics) = &record.outcome.metrics else {
        return Ok(());
    };
    count("number of hammers", metrics.hammers.len(), info.hammers.len())?;
    count("number of castings", metrics.castings.len(), info.castings.len())?;
    let cells = if info.signals.is_empty() { 0 } else { 1 + info.signals.len() };
    metrics.signals.iter().try_for_each(|instant| count("number of signals and time", instant.len(), cells))?;
    if let Some(blow) = metrics.blows.iter().find(|blow| blow.hammer >= info.hammers.len()) {
        return misfit("index of a blow's hammer", blow.hammer.to_string(), format!("below {}", info.hammers.len()));
    }
    if let Some(blow) = metrics.blows.iter().find(|blow| blow.casting >= info.castings.len()) {
        return misfit("index of a blow's casting", blow.casting.to_string(), format!("below {}", info.castings.len()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_back_bit_by_bit() {
        let mut writer = RowWriter::new(7, true);
        let values = [Value::Real(-0.1), Value::Text("Gußteil"), Value::Integer(-3), Value::Count(u64::MAX)];
        let [first, rest @ ..] = values.map(Some);
        let cells: Vec<Cell<'_>> = [first, None].into_iter().chain(rest).collect();
        cells.iter().for_each(|cell| writer.cell(*cell));
        let stored = StoredRow::from_bytes(writer.finish().bytes().to_vec()).expect("a row");
        assert_eq!((stored.row(), stored.failed()), (7, true));
        let mut found = Vec::new();
        let counts = ColumnCounts { runs: 2, timings: 1, blows: 1, signals: 0 };
        stored
            .visit(&counts, &mut |table, index, cell| found.push(format!("{table:?} {index} {cell:?}")))
            .expect("whole");
        let tables = ["Runs 0", "Runs 1", "Timings 0", "Blows 0", "Blows 0"];
        let expected: Vec<String> = tables.iter().zip(cells).map(|(table, cell)| format!("{table} {cell:?}")).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn bytes_cut_short_are_no_row() {
        let mut writer = RowWriter::new(1, false);
        writer.cell(Some(Value::Text("long enough")));
        let bytes = writer.finish().bytes().to_vec();
        let counts = ColumnCounts { runs: 1, timings: 0, blows: 1, signals: 0 };
        for length in 0..bytes.len() {
            let row = StoredRow::from_bytes(bytes[..length].to_vec());
            assert!(row.and_then(|row| row.visit(&counts, &mut |_, _, _| {})).is_none(), "{length} bytes");
        }
    }
}
