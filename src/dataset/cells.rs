//! The cells of a row as bytes.
//!
//! A reader gets one column with its getter. A writer needs all columns of a row, on a thread whose caches are full of the row's
//! simulation. There a struct writes all its quantities at once.

use std::ops::Range;

use super::column::{Column, Get, Source};
use decore_model::integrate::Counters;
use decore_model::metrics::{Aggregates, Blow, CastingMetrics, HammerMetrics, RunTotals};
use decore_quantity::put_cell;

/// All quantities of a struct, which write themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StructColumns {
    Counters,
    Aggregates,
    Hammer(usize),
    Casting(usize),
    Totals,
    Blow,
}

impl StructColumns {
    /// Group of a column.
    fn of(column: &Column) -> Option<Self> {
        match column.get {
            Get::Counters(_) => Some(Self::Counters),
            Get::Aggregates(_) => Some(Self::Aggregates),
            Get::Hammer(index, _) => Some(Self::Hammer(index)),
            Get::Casting(index, _) => Some(Self::Casting(index)),
            Get::Totals(_) => Some(Self::Totals),
            Get::Blow(_) => Some(Self::Blow),
            _ => None,
        }
    }

    /// Number of columns.
    fn columns(self) -> usize {
        match self {
            Self::Counters => Counters::QUANTITIES.len(),
            Self::Aggregates => Aggregates::QUANTITIES.len(),
            Self::Hammer(_) => HammerMetrics::QUANTITIES.len(),
            Self::Casting(_) => CastingMetrics::QUANTITIES.len(),
            Self::Totals => RunTotals::QUANTITIES.len(),
            Self::Blow => Blow::QUANTITIES.len(),
        }
    }

    /// Appends its cells; `None` if the row has no such struct.
    fn put(self, source: &Source<'_>, bytes: &mut Vec<u8>) -> Option<()> {
        match self {
            Self::Counters => source.outcome().counters.put_cells(bytes),
            Self::Aggregates => source.aggregates.as_ref()?.put_cells(bytes),
            Self::Hammer(index) => source.metrics()?.hammers.get(index)?.put_cells(bytes),
            Self::Casting(index) => source.metrics()?.castings.get(index)?.put_cells(bytes),
            Self::Totals => source.metrics()?.totals.put_cells(bytes),
            Self::Blow => source.blow?.put_cells(bytes),
        }
        Some(())
    }
}

/// Columns of a table that are written in one way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Segment {
    /// All columns of a struct.
    Whole(StructColumns),
    /// Each by its getter.
    Each(Range<usize>),
}

impl Segment {
    /// The segments of a table with these columns.
    pub fn of(columns: &[Column]) -> Vec<Self> {
        let mut segments = Vec::new();
        let mut first = 0;
        for run in columns.chunk_by(|one, next| StructColumns::of(one) == StructColumns::of(next)) {
            let range = first..first + run.len();
            first = range.end;
            let whole = run.first().and_then(StructColumns::of).filter(|whole| whole.columns() == run.len());
            segments.push(whole.map_or(Self::Each(range), Self::Whole));
        }
        segments
    }

    /// Appends the segment's cells of one row.
    pub fn put(&self, columns: &[Column], source: &Source<'_>, bytes: &mut Vec<u8>) {
        match self {
            Self::Whole(whole) => {
                if whole.put(source, bytes).is_none() {
                    (0..whole.columns()).for_each(|_| put_cell(bytes, None));
                }
            }
            Self::Each(range) => {
                let columns = columns.get(range.clone()).unwrap_or_default();
                columns.iter().for_each(|column| put_cell(bytes, column.cell(source)));
            }
        }
    }
}
