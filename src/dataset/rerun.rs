//! Re-runs of rows with other budgets: their selection, and the treatment of the old rows.
//!
//! Budgets (steps, wall time, retries) decide when a row stops early. A row that reached no budget gives the same result under other
//! budgets, so it stays in the dataset. The journal first gets each re-run row, then a copy of the other rows of
//! its block. The block's part stays until all chosen rows of the block have ended. In a full block, the journal is always newer than the
//! part.

use std::path::Path;

use super::columns::Columns;
use super::error::DatasetError;
use super::manifest::{RowSpan, union};
use super::recovery::{Recovered, read_block};
use super::store::Block;

/// Rows to be run again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RerunSelection {
    /// All rows with another status than done.
    Failed,
    /// These rows, existing or not: ascending, without overlap.
    Rows(Vec<RowSpan>),
}

impl Recovered {
    /// Chooses rows to re-run, ascending, with gaps between the spans. All rows of their blocks become pending.
    ///
    /// Memory is taken for all rows of the blocks that have a chosen one.
    ///
    /// # Errors
    /// The reader's.
    pub fn choose(
        &mut self,
        folder: &Path,
        columns: &Columns,
        chosen: &RerunSelection,
    ) -> Result<Vec<RowSpan>, DatasetError> {
        let range = self.manifest.range;
        let concerns = |block: RowSpan| match chosen {
            RerunSelection::Failed => true,
            RerunSelection::Rows(rows) => rows.iter().any(|span| !span.intersection(block).is_empty()),
        };
        let parts = self.manifest.runs.iter().filter(|part| *chosen != RerunSelection::Failed || part.failed > 0);
        let blocks: Vec<u64> = parts
            .map(|part| part.first_row)
            .filter(|first_row| concerns(self.manifest.block(*first_row)))
            .filter(|first_row| !self.pending.contains_key(&(first_row / self.manifest.study.rows_per_part)))
            .collect();
        for first_row in blocks {
            let block = read_block(folder, columns, self, first_row)?;
            self.only_in_parts.extend(block.keys());
            self.pending.insert(first_row / self.manifest.study.rows_per_part, block);
        }
        Ok(union(match chosen {
            RerunSelection::Failed => {
                let failed = self.pending.values().flat_map(Block::values).filter(|row| row.failed());
                failed.map(|row| RowSpan { first: row.row(), end: row.row() + 1 }).collect::<Vec<_>>()
            }
            RerunSelection::Rows(rows) => rows.iter().map(|span| span.intersection(range)).collect(),
        }))
    }
}
