//! A row as bytes, for the journal and as the source of parts.
//!
//! Every row takes this form: new rows, rows from the journal of a killed run, and rows from a part that must be rewritten. That is why
//! all of them give the same files.

use super::column::{Column, Source};
use super::columns::{Columns, TableName};
use super::error::DatasetError;
use super::info::{DatasetInfo, RowRecord};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, CellColumn, FREE_TAG, Value, put_cell, take_cells};

/// Tag before the cells of an instant of `signals`.
const INSTANT: u8 = FREE_TAG;
/// Size of a number: its tag and eight bytes.
const CELL_BYTES: usize = 9;
/// Usual size of a row's texts.
const TEXT_BYTES: usize = 256;

/// A row of all tables as bytes: its index, and its cells of `runs`, `timings`, `blows` and `signals`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredRow {
    row: u64,
    failed: bool,
    bytes: Vec<u8>,
}

impl StoredRow {
    /// The row of a record, whose blows are given in the table's form.
    pub fn new(info: &DatasetInfo, columns: &Columns, record: &RowRecord) -> Self {
        let failed = record.outcome.status != RowStatus::Done;
        let mut writer = RowWriter::with_room(record.row, failed, room(columns, record));
        let mut source = Source::new(info, record);
        columns.put(TableName::Runs, &source, &mut writer.bytes);
        columns.put(TableName::Timings, &source, &mut writer.bytes);
        for blow in record.outcome.metrics.iter().flat_map(|metrics| &metrics.blows) {
            source.blow = Some(blow);
            columns.put(TableName::Blows, &source, &mut writer.bytes);
        }
        for instant in record.outcome.metrics.iter().flat_map(|metrics| &metrics.signals) {
            source.instant = Some(instant);
            writer.instant();
            columns.put(TableName::Signals, &source, &mut writer.bytes);
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

    /// Appends the row's cells to the columns of the tables; `None` if the bytes do not hold whole rows of these.
    pub fn append_to(&self, tables: &mut TableColumns) -> Option<()> {
        let mut rest = self.bytes.get(9..)?;
        take_cells(&mut rest, &mut tables.runs)?;
        take_cells(&mut rest, &mut tables.timings)?;
        while let Some((first, behind)) = rest.split_first() {
            let columns = match *first {
                INSTANT => {
                    rest = behind;
                    &mut tables.signals
                }
                _ => &mut tables.blows,
            };
            // Bytes that no column takes are no row.
            if columns.is_empty() {
                return None;
            }
            take_cells(&mut rest, columns)?;
        }
        Some(())
    }
}

/// The columns of all tables, which rows are appended to.
#[derive(Debug, Clone, PartialEq)]
pub struct TableColumns {
    /// Of `runs`.
    pub runs: Vec<CellColumn>,
    /// Of `blows`.
    pub blows: Vec<CellColumn>,
    /// Of `timings`.
    pub timings: Vec<CellColumn>,
    /// Of `signals`; none if none are recorded.
    pub signals: Vec<CellColumn>,
}

impl TableColumns {
    /// Empty columns.
    pub fn new(columns: &Columns) -> Self {
        let empty =
            |columns: &[Column]| columns.iter().map(|column| CellColumn::new(column.description.kind)).collect();
        Self {
            runs: empty(&columns.runs),
            blows: empty(&columns.blows),
            timings: empty(&columns.timings),
            signals: empty(&columns.signals),
        }
    }
}

/// The bytes of a record's cells, but for long texts: asked for at once, as a row that grows is copied again and again.
fn room(columns: &Columns, record: &RowRecord) -> usize {
    let (blows, instants) =
        record.outcome.metrics.as_ref().map_or((0, 0), |metrics| (metrics.blows.len(), metrics.signals.len()));
    let cells = columns.runs.len() + columns.timings.len() + blows * columns.blows.len();
    TEXT_BYTES + CELL_BYTES * cells + (1 + CELL_BYTES * columns.signals.len()) * instants
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
        Self::with_room(row, failed, TEXT_BYTES)
    }

    /// Begins a row that will take about `bytes`.
    fn with_room(row: u64, failed: bool, bytes: usize) -> Self {
        let mut bytes = Vec::with_capacity(bytes);
        bytes.extend_from_slice(&row.to_le_bytes());
        bytes.push(u8::from(failed));
        Self { row, failed, bytes }
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

/// Whether the cells of a row of `runs` show that the row is not done.
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
    use decore_model::integrate::Counters;
    use decore_model::metrics::{Blow, CastingMetrics, HammerMetrics, RunMetrics, RunTotals};
    use decore_quantity::Kind;

    /// The end of a row without outputs.
    fn outcome() -> RowOutcome {
        RowOutcome {
            status: RowStatus::Invalid,
            reason: "none".to_owned(),
            time_reached_s: 0.5,
            modes: 3,
            states: 7,
            metrics: None,
            counters: Counters { steps: 9, ..Counters::default() },
            wall_time_s: 0.1,
            numerical_twin_wall_time_s: None,
        }
    }

    /// Outputs of two hammers and a casting, with a blow of each.
    fn metrics() -> RunMetrics {
        let hammer = |x: u64| HammerMetrics {
            first_impact_time_s: Some(0.1 * x as f64),
            contact_count: x,
            delivered_work_j: x as f64,
            ..HammerMetrics::default()
        };
        RunMetrics {
            hammers: vec![hammer(2), hammer(3)],
            castings: vec![CastingMetrics { peak_velocity_m_s: 0.7, ..CastingMetrics::default() }],
            blows: [0, 1].map(|hammer| Blow { hammer, energy_j: 5.0 + hammer as f64, ..Blow::default() }).to_vec(),
            totals: RunTotals { delivered_work_j: 5.0, ..RunTotals::default() },
            ..RunMetrics::default()
        }
    }

    /// Columns of these kinds.
    fn tables(runs: &[Kind], timings: &[Kind], blows: &[Kind]) -> TableColumns {
        let [runs, timings, blows] =
            [runs, timings, blows].map(|kinds| kinds.iter().copied().map(CellColumn::new).collect());
        TableColumns { runs, blows, timings, signals: Vec::new() }
    }

    #[test]
    fn cells_come_back_bit_by_bit() {
        let mut writer = RowWriter::new(7, true);
        let values = [Value::Real(-0.1), Value::Text("Gußteil"), Value::Integer(-3), Value::Count(u64::MAX)];
        let [first, rest @ ..] = values.map(Some);
        let cells: Vec<Cell<'_>> = [first, None].into_iter().chain(rest).collect();
        cells.iter().for_each(|cell| writer.cell(*cell));
        let stored = StoredRow::from_bytes(writer.finish().bytes().to_vec()).expect("a row");
        assert_eq!((stored.row(), stored.failed()), (7, true));
        let mut found = tables(&[Kind::Real, Kind::Real], &[Kind::Text], &[Kind::Integer]);
        let mut expected = found.clone();
        stored.append_to(&mut found).expect("whole");
        expected.runs.iter_mut().zip(&cells).for_each(|(column, cell)| column.push(*cell));
        expected.timings[0].push(cells[2]);
        // Two blows, the second of another kind than its column.
        cells[3..].iter().for_each(|cell| expected.blows[0].push(*cell));
        assert_eq!(found, expected);
    }

    /// Structs write the same cells as the columns' getters, in the columns' order.
    #[test]
    fn a_row_is_the_cells_of_its_columns() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let info = DatasetInfo {
            hammers: names(&["a", "b"]),
            castings: names(&["c"]),
            twins: 1,
            numerical_twins: true,
            ..DatasetInfo::empty()
        };
        let columns = Columns::new(&info).expect("unique");
        for metrics in [Some(metrics()), None] {
            let record = RowRecord { row: 4, factors: Vec::new(), outcome: RowOutcome { metrics, ..outcome() } };
            let mut found = TableColumns::new(&columns);
            StoredRow::new(&info, &columns, &record).append_to(&mut found).expect("whole");
            let mut source = Source::new(&info, &record);
            let mut blows = vec![Vec::new(); columns.blows.len()];
            for blow in record.outcome.metrics.iter().flat_map(|metrics| &metrics.blows) {
                source.blow = Some(blow);
                blows.iter_mut().zip(&columns.blows).for_each(|(cells, column)| {
                    cells.push(column.cell(&source).map(|value| value.to_string()));
                });
            }
            let texts = |cells: &CellColumn| -> Vec<_> {
                cells.cells().map(|cell| cell.map(|value| value.to_string())).collect()
            };
            let single = |columns: &[Column]| -> Vec<Vec<_>> {
                columns.iter().map(|column| vec![column.cell(&source).map(|value| value.to_string())]).collect()
            };
            assert_eq!(found.runs.iter().map(texts).collect::<Vec<_>>(), single(&columns.runs));
            assert_eq!(found.timings.iter().map(texts).collect::<Vec<_>>(), single(&columns.timings));
            assert_eq!(found.blows.iter().map(texts).collect::<Vec<_>>(), blows);
        }
    }

    #[test]
    fn bytes_cut_short_are_no_row() {
        let mut writer = RowWriter::new(1, false);
        writer.cell(Some(Value::Text("long enough")));
        let bytes = writer.finish().bytes().to_vec();
        for length in 0..bytes.len() {
            let row = StoredRow::from_bytes(bytes[..length].to_vec());
            let mut tables = tables(&[Kind::Text], &[], &[Kind::Text]);
            assert!(row.and_then(|row| row.append_to(&mut tables)).is_none(), "{length} bytes");
        }
    }
}
