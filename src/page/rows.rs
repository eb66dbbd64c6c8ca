//! Rows and columns of a table on a page.

use std::collections::{BTreeMap, BTreeSet};

use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetReader, RowRecord, TableName};
use decore_model::metrics::{CastingMetrics, HammerMetrics, RunTotals};
use decore_model::run::RowOutcome;
use decore_quantity::Value;

/// Numbers that a page carries at most, about: with a page of 15 MB in view.
const MOST_VALUES: u64 = 2_400_000;
/// Rows at each end of a column that are kept whatever their index.
const EXTREMES: usize = 20;

/// Selected rows of a larger table: a sample by the hash of the index, and the extremes of numerical columns.
pub(super) struct KeptRows {
    /// Hashes from here on are left out.
    bound: u64,
    extremes: BTreeSet<u64>,
}

impl KeptRows {
    /// Looks through a table for the rows that are kept; `None`: all.
    pub fn of(reader: &DatasetReader, columns: &[&ColumnDescription], most: u64) -> Result<Option<Self>, DatasetError> {
        let rows: u64 = reader.parts(TableName::Runs).iter().map(|part| part.records).sum();
        if rows <= most {
            return Ok(None);
        }
        let bound = (u128::from(u64::MAX) * u128::from(most) / u128::from(rows)) as u64;
        let names: Vec<&str> =
            std::iter::once(RowRecord::row.name).chain(columns.iter().map(|column| column.name.as_str())).collect();
        let mut ends: Vec<[Vec<(f64, u64)>; 2]> = columns.iter().map(|_| [Vec::new(), Vec::new()]).collect();
        reader.visit(TableName::Runs, &names, |cells| {
            let [Some(Value::Count(row)), values @ ..] = cells else { return };
            for (ends, value) in ends.iter_mut().zip(values) {
                let number = value.and_then(|value| value.number()).filter(|number| !number.is_nan());
                for (list, sign) in ends.iter_mut().zip([1.0, -1.0]) {
                    number.into_iter().for_each(|number| insert(list, (sign * number, *row)));
                }
            }
        })?;
        let extremes = ends.iter().flatten().flatten().map(|(_, row)| *row).collect();
        Ok(Some(Self { bound, extremes }))
    }

    /// Whether a row is kept.
    pub fn has(&self, row: u64) -> bool {
        self.extremes.contains(&row) || hash(row) < self.bound
    }
}

/// A hash of an index: every part of a regular design is thinned alike.
fn hash(row: u64) -> u64 {
    let bytes = *blake3::hash(&row.to_le_bytes()).as_bytes();
    bytes.iter().take(8).fold(0, |word, byte| word << 8 | u64::from(*byte))
}

/// Keeps the least values, of equal ones the first.
fn insert(list: &mut Vec<(f64, u64)>, entry: (f64, u64)) {
    let place = list.partition_point(|other| other.0 <= entry.0);
    if place < EXTREMES {
        list.insert(place, entry);
        list.truncate(EXTREMES);
    }
}

/// The columns that a page of `rows` rows has room for, in the table's order: row, ending, factors and energy residual, the main
/// outputs, then outputs over all, of the run, of hammers and castings, at last the solver's.
pub(super) fn columns<'a>(all: &'a [ColumnDescription], rows: u64, main: &[&str]) -> Vec<&'a ColumnDescription> {
    let room = (MOST_VALUES / rows.max(1)).max(20) as usize;
    let rank = |column: &ColumnDescription| match column.group {
        _ if always(column) => 0,
        _ if main.contains(&column.name.as_str()) => 1,
        ColumnGroup::Aggregate | ColumnGroup::Run => 2,
        ColumnGroup::Hammer | ColumnGroup::Casting => {
            let main = |of: &str, is_main: bool| is_main && of == column.quantity;
            let hammer = HammerMetrics::QUANTITIES.iter().any(|one| main(one.name, one.main));
            let casting = CastingMetrics::QUANTITIES.iter().any(|one| main(one.name, one.main));
            if hammer || casting { 3 } else { 4 }
        }
        ColumnGroup::Core | ColumnGroup::Fixture => 4,
        _ => 5,
    };
    let mut by_rank: BTreeMap<(usize, usize), &ColumnDescription> = BTreeMap::new();
    for (place, column) in all.iter().enumerate() {
        by_rank.insert((rank(column), place), column);
    }
    let fits = |place: usize, rank: usize| rank == 0 || place < room;
    let mut chosen: Vec<(usize, &ColumnDescription)> = by_rank
        .into_iter()
        .enumerate()
        .filter(|(place, ((rank, _), _))| fits(*place, *rank))
        .map(|(_, ((_, place), column))| (place, column))
        .collect();
    chosen.sort_by_key(|(place, _)| *place);
    chosen.into_iter().map(|(_, column)| column).collect()
}

fn always(column: &ColumnDescription) -> bool {
    let named =
        [RowRecord::row.name, RowOutcome::status.name, RowOutcome::reason.name, RunTotals::energy_residual.name];
    column.group == ColumnGroup::Factor || named.contains(&column.name.as_str())
}

/// Whether a column holds numbers.
pub(super) fn is_number(column: &ColumnDescription) -> bool {
    !column.kind.is_text()
}
