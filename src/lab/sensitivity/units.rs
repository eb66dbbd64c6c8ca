//! Blocks and trajectories: complete ones, and reasons why others are not.

use std::collections::BTreeMap;

use super::error::SensitivityError;
use super::result::{LeftOut, UnitName, Used};
use super::table::{OutputColumn, Table};

/// Reason for rows that are not run yet.
pub const NOT_RUN: &str = "not run yet";

/// Largest number of listed rows without an output.
const MOST_NAMED: usize = 1000;

/// The design's rows cut in units of one size.
#[derive(Debug, Clone, Copy)]
pub struct Units {
    /// Name of the units.
    pub name: UnitName,
    /// Rows of a unit.
    pub size: usize,
    /// Rows of the design.
    pub rows: u64,
}

/// The units of an output that can be used.
pub struct UsableUnits {
    /// Places in the table at which whole units start.
    pub starts: Vec<usize>,
    /// Number of complete ones, and reasons for the others.
    pub used: Used,
}

impl Units {
    /// Number of units of the design.
    fn count(self) -> u64 {
        self.rows / self.size as u64
    }

    /// First places of complete units.
    pub fn present(self, table: &Table) -> Vec<usize> {
        let size = self.size as u64;
        let mut starts = Vec::new();
        for (place, row) in table.rows.iter().enumerate() {
            let last = table.rows.get(place + self.size - 1);
            if row.is_multiple_of(size) && last == Some(&(row + size - 1)) {
                starts.push(place);
            }
        }
        starts
    }

    /// The units all of whose rows are done and have the output.
    pub fn whole(self, table: &Table, output: &OutputColumn) -> UsableUnits {
        let fault = |place: usize| match (table.faults[place], output.values[place]) {
            (Some(reason), _) => Some(table.reasons[reason].as_str()),
            (None, value) if value.is_nan() => Some("done, but without this output"),
            (None, value) if value.is_infinite() => Some("done, but the output is infinite"),
            _ => None,
        };
        let faults: Vec<Option<&str>> = (0..table.rows.len()).map(fault).collect();
        let starts = self.present(table).into_iter();
        let starts: Vec<usize> =
            starts.filter(|start| faults[*start..start + self.size].iter().all(Option::is_none)).collect();
        let mut left_out: BTreeMap<&str, LeftOut> = BTreeMap::new();
        for (row, reason) in table.rows.iter().zip(&faults).filter_map(|(row, fault)| fault.map(|fault| (row, fault))) {
            let entry = left_out.entry(reason).or_insert_with(|| LeftOut {
                reason: reason.to_owned(),
                count: 0,
                rows: Vec::new(),
            });
            entry.count += 1;
            if entry.rows.len() < MOST_NAMED {
                entry.rows.push(*row);
            }
        }
        let mut left_out: Vec<LeftOut> = left_out.into_values().collect();
        let missing = self.rows.saturating_sub(table.rows.len() as u64);
        if missing > 0 {
            left_out.push(LeftOut { reason: NOT_RUN.to_owned(), count: missing, rows: Vec::new() });
        }
        let used = Used { unit: self.name, whole: starts.len() as u64, of: self.count(), left_out };
        UsableUnits { starts, used }
    }

    /// Holds the factors of every unit that is there to the design: `expected` gives for a factor and a place in a unit the place
    /// whose value it has.
    ///
    /// # Errors
    /// [`SensitivityError::Layout`].
    pub fn check(
        self,
        table: &Table,
        unit: &'static str,
        expected: impl Fn(usize, usize) -> usize,
    ) -> Result<(), SensitivityError> {
        for start in self.present(table) {
            for (factor, column) in table.factors.iter().enumerate() {
                let values = &column.values[start..start + self.size];
                if (0..self.size).any(|place| values[place] != values[expected(factor, place)]) {
                    let first = table.rows[start];
                    let (last, factor) = (first + self.size as u64 - 1, column.name.clone());
                    return Err(SensitivityError::Layout { first, last, unit, factor });
                }
            }
        }
        Ok(())
    }

    /// The values of a column in these units, one unit after the other.
    pub fn gather(self, values: &[f64], starts: &[usize]) -> Vec<f64> {
        starts.iter().flat_map(|start| &values[*start..start + self.size]).copied().collect()
    }
}
