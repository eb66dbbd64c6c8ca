//! What a dataset already has when a sweep goes on: whole parts, parts of blocks that are not full, the journal.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::columns::{Columns, TableName};
use super::error::DatasetError;
use super::journal;
use super::manifest::{Manifest, Part, RowSpan, TimingsManifest};
use super::parquet_file::visit_rows;
use super::reader::check_part;
use super::record::{RowWriter, StoredRow, cells_say_failed};
use super::store::{Block, remove};
use crate::quantity::Value;

/// What is there.
pub struct Recovered {
    /// Manifests of the parts that are whole and undamaged.
    pub manifest: Manifest,
    /// The same of the timings.
    pub timings: TimingsManifest,
    /// Rows of blocks that are not full, by the block's number.
    pub pending: BTreeMap<u64, Block>,
    /// Those of them that only a part has: they belong into the journal before the part is written anew.
    pub only_in_parts: BTreeSet<u64>,
    /// What was damaged; its rows are to be computed again.
    pub damaged: Vec<DatasetError>,
}

/// Checks every part against its checksum, takes the damaged ones out of the manifests, and collects the rows of the blocks
/// that are not full.
///
/// # Errors
/// The system's.
pub fn recover(
    folder: &Path,
    columns: &Columns,
    manifests: (Manifest, TimingsManifest),
) -> Result<Recovered, DatasetError> {
    let (manifest, timings) = manifests;
    let mut recovered = Recovered::nothing(manifest, timings);
    let mut bad = recovered.check(folder);
    let per_part = recovered.manifest.study.rows_per_part;
    let listed: Vec<u64> = recovered.manifest.runs.iter().map(|part| part.first_row).collect();
    for first_row in listed.into_iter().filter(|first_row| !bad.contains(first_row)).collect::<Vec<_>>() {
        if recovered.is_full(first_row) {
            continue;
        }
        match read_block(folder, columns, &recovered, first_row) {
            Ok(block) => {
                recovered.only_in_parts.extend(block.keys());
                recovered.pending.insert(first_row / per_part, block);
            }
            Err(error) => {
                recovered.damaged.push(error);
                bad.insert(first_row);
            }
        }
    }
    let range = recovered.manifest.range;
    let Recovered { manifest, pending, only_in_parts, .. } = &mut recovered;
    journal::recover(folder, &mut |row| {
        let first_row = row.row() / per_part * per_part;
        let has_part = !bad.contains(&first_row) && is_full(manifest, first_row);
        if !has_part && (range.first..range.end).contains(&row.row()) {
            only_in_parts.remove(&row.row());
            pending.entry(row.row() / per_part).or_default().insert(row.row(), row);
        }
    })?;
    // A row of the design that the journal still has needs no computing, even if its part is damaged.
    recovered.forget(folder, bad)?;
    Ok(recovered)
}

impl Recovered {
    /// A dataset that begins.
    pub fn nothing(manifest: Manifest, timings: TimingsManifest) -> Self {
        Self { manifest, timings, pending: BTreeMap::new(), only_in_parts: BTreeSet::new(), damaged: Vec::new() }
    }

    /// First rows of the blocks with damaged or missing parts.
    fn check(&mut self, folder: &Path) -> BTreeSet<u64> {
        let mut bad = BTreeSet::new();
        let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
        let parts = self.manifest.runs.iter().chain(&self.manifest.blows).chain(&self.timings.timings);
        for part in parts {
            *counts.entry(part.first_row).or_default() += 1;
            if let Err(error) = check_part(folder, part) {
                self.damaged.push(error);
                bad.insert(part.first_row);
            }
        }
        // A block counts only with all its parts; timings that are ahead of the manifest are written again.
        bad.extend(
            counts.into_iter().filter(|(_, count)| *count != TableName::ALL.len()).map(|(first_row, _)| first_row),
        );
        bad
    }

    fn is_full(&self, first_row: u64) -> bool {
        is_full(&self.manifest, first_row)
    }

    /// Takes blocks out of the manifests; their files go when the manifests are in place.
    fn forget(&mut self, folder: &Path, blocks: BTreeSet<u64>) -> Result<(), DatasetError> {
        for first_row in blocks {
            // Gone at once, so that no reader of the folder trips over a damaged file until it is written anew.
            for part in self.parts_of(first_row) {
                remove(&folder.join(&part.file))?;
            }
            self.manifest.remove_block(first_row);
            self.timings.timings.retain(|part| part.first_row != first_row);
        }
        Ok(())
    }

    fn parts_of(&self, first_row: u64) -> Vec<Part> {
        let parts = self.manifest.runs.iter().chain(&self.manifest.blows).chain(&self.timings.timings);
        parts.filter(|part| part.first_row == first_row).cloned().collect()
    }
}

/// Whether the manifest has all rows of a block that the dataset is to hold.
fn is_full(manifest: &Manifest, first_row: u64) -> bool {
    let wanted = manifest.block(first_row).intersection(manifest.range);
    let part = manifest.runs.iter().find(|part| part.first_row == first_row);
    part.is_some_and(|part| part.records == wanted.len())
}

/// The rows of a block's parts.
fn read_block(folder: &Path, columns: &Columns, recovered: &Recovered, first_row: u64) -> Result<Block, DatasetError> {
    let mut block = Block::new();
    let parts = [&recovered.manifest.runs, &recovered.timings.timings, &recovered.manifest.blows];
    let parts = parts.map(|parts| parts.iter().find(|part| part.first_row == first_row));
    if let [Some(runs), Some(timings), Some(blows)] = parts {
        read_parts(folder, columns, [runs, timings, blows], &mut |row| {
            block.insert(row.row(), row);
        })?;
    }
    Ok(block)
}

/// Calls `take` for every row of the parts of runs, timings and blows of one block.
///
/// # Errors
/// [`DatasetError::Damaged`] if the tables have not the same rows, or the reader's.
pub fn read_parts(
    folder: &Path,
    columns: &Columns,
    parts: [&Part; 3],
    take: &mut dyn FnMut(StoredRow),
) -> Result<(), DatasetError> {
    let mut rows: BTreeMap<u64, RowWriter> = BTreeMap::new();
    let tables = [TableName::Runs, TableName::Timings, TableName::Blows];
    for (table, part) in tables.into_iter().zip(parts) {
        let path = folder.join(&part.file);
        let descriptions = columns.describe(table);
        let names: Vec<&str> = descriptions.iter().map(|column| column.name.as_str()).collect();
        let mut strays = 0;
        visit_rows(&path, &descriptions, &mut |cells| {
            let row = match cells.first() {
                Some(Some(Value::Count(row))) => *row,
                _ => return strays += 1,
            };
            if table == TableName::Runs {
                rows.insert(row, RowWriter::new(row, cells_say_failed(&names, cells)));
            }
            match rows.get_mut(&row) {
                Some(writer) => cells.iter().for_each(|cell| writer.cell(*cell)),
                None => strays += 1,
            }
        })?;
        if strays > 0 {
            return Err(DatasetError::Damaged {
                path,
                found: format!("{strays} rows that the table of runs does not have"),
                expected: "rows of the same runs in all tables".to_owned(),
            });
        }
    }
    rows.into_values().for_each(|row| take(row.finish()));
    Ok(())
}

/// The rows of `range` that are neither in whole parts nor pending.
pub fn rows_left(manifest: &Manifest, pending: &BTreeMap<u64, Block>) -> Vec<RowSpan> {
    let mut there: Vec<RowSpan> = manifest.done.clone();
    there.extend(pending.values().flat_map(|block| block.keys()).map(|row| RowSpan { first: *row, end: row + 1 }));
    there.sort_unstable_by_key(|span| span.first);
    super::manifest::gaps(manifest.range, &there)
}
