//! Contents of a dataset when a sweep continues: complete parts, parts of incomplete blocks, the journal.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::columns::{Columns, TableName};
use super::error::DatasetError;
use super::journal::{self, Salvage};
use super::manifest::{Manifest, RowSpan, TablePart, TimingsManifest, find, part_file};
use super::reader::{check_part, open_part};
use super::rebuild::Known;
use super::record::{RowWriter, StoredRow, cells_say_failed};
use super::store::{Block, DAMAGED, remove, set_aside};
use decore_quantity::Value;

/// Existing rows and parts.
pub struct Recovered {
    /// Manifests of the parts that are whole and undamaged.
    pub manifest: Manifest,
    /// The same of the timings.
    pub timings: TimingsManifest,
    /// Rows of blocks that are not full, by the block's number.
    pub pending: BTreeMap<u64, Block>,
    /// Rows that exist only in a part. They must go into the journal before the part is rewritten.
    pub only_in_parts: BTreeSet<u64>,
    /// Rows to run, ascending, if only some of the missing ones are run.
    pub chosen: Option<Vec<RowSpan>>,
    /// Damaged files; their rows must be computed again.
    pub damaged: Vec<DatasetError>,
    /// Further losses, in words.
    pub notes: Vec<String>,
}

/// Damaged blocks of rows, by their first row, with their faults.
type Bad = BTreeMap<u64, Vec<DatasetError>>;

/// Checks every part against its checksum, takes the damaged ones out of the manifests, and collects the rows of the blocks
/// that are not full.
///
/// Computed rows are not removed: damaged files go to [`DAMAGED`], unless the journal has all their rows.
///
/// # Errors
/// The system's.
pub fn recover(folder: &Path, columns: &Columns, known: Known) -> Result<Recovered, DatasetError> {
    let mut recovered = Recovered { notes: known.notes, ..Recovered::nothing(known.manifest, known.timings) };
    let untimed = recovered.drop_lost_timings(folder);
    let mut bad = recovered.check(folder);
    for (first_row, path) in known.unvouched {
        bad.entry(first_row).or_default().push(DatasetError::Unvouched { path });
    }
    let per_part = recovered.manifest.study.rows_per_part;
    let listed: Vec<u64> = recovered.manifest.runs.iter().map(|part| part.first_row).collect();
    for first_row in listed.into_iter().filter(|first_row| !bad.contains_key(first_row)).collect::<Vec<_>>() {
        if is_full(&recovered.manifest, first_row) {
            continue;
        }
        match read_block(folder, columns, &recovered, first_row) {
            Ok(block) => {
                recovered.only_in_parts.extend(block.keys());
                recovered.pending.insert(first_row / per_part, block);
            }
            Err(error) => bad.entry(first_row).or_default().push(error),
        }
    }
    let range = recovered.manifest.range;
    let Recovered { manifest, pending, only_in_parts, .. } = &mut recovered;
    let mut newer: BTreeMap<u64, Block> = BTreeMap::new();
    let mut journaled = BTreeSet::new();
    let salvage = journal::recover(folder, &manifest.study, &mut |row| {
        if !(range.first..range.end).contains(&row.row()) {
            return;
        }
        journaled.insert(row.row());
        let block = row.row() / per_part;
        let first_row = block * per_part;
        if !bad.contains_key(&first_row) && is_full(manifest, first_row) {
            supersede(newer.entry(block).or_default(), row);
        } else {
            only_in_parts.remove(&row.row());
            supersede(pending.entry(block).or_default(), row);
        }
    })?;
    recovered.take_note(folder, salvage)?;
    recovered.note_untimed(&untimed, &journaled);
    for (block, rows) in newer {
        let old = read_block(folder, columns, &recovered, block * per_part)?;
        recovered.renew(block, old, rows);
    }
    recovered.forget(folder, bad)?;
    Ok(recovered)
}

impl Recovered {
    /// A dataset that begins.
    pub fn nothing(manifest: Manifest, timings: TimingsManifest) -> Self {
        Self {
            manifest,
            timings,
            pending: BTreeMap::new(),
            only_in_parts: BTreeSet::new(),
            chosen: None,
            damaged: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Full blocks without timings: theirs become nulls, unless they are written again.
    pub fn untimed(&self) -> Vec<u64> {
        let per_part = self.manifest.study.rows_per_part;
        let full = self.manifest.runs.iter().map(|part| part.first_row).filter(|row| is_full(&self.manifest, *row));
        let full = full.filter(|first_row| !self.pending.contains_key(&(first_row / per_part)));
        full.filter(|first_row| find(&self.timings.timings, *first_row).is_none()).collect()
    }

    /// Merges re-run rows of the journal into a full block. If a process ended between writing a part and truncating its journal, the
    /// journal still has rows of the part.
    fn renew(&mut self, block: u64, old: Block, rows: Block) {
        let mut whole = old.clone();
        let journaled: Vec<u64> = rows.keys().copied().collect();
        rows.into_values().for_each(|row| supersede(&mut whole, row));
        if whole != old {
            self.only_in_parts.extend(whole.keys().filter(|row| !journaled.contains(row)));
            self.pending.insert(block, whole);
        }
    }

    /// Removes damaged or missing timings, which are no reason to compute a row again. Returns their rows.
    fn drop_lost_timings(&mut self, folder: &Path) -> Vec<RowSpan> {
        // Timings that are ahead of the manifest are written again with the block.
        self.timings
            .timings
            .retain(|part| find(&self.manifest.runs, part.first_row).is_some() && check_part(folder, part).is_ok());
        let lost = self.manifest.runs.iter().filter(|part| find(&self.timings.timings, part.first_row).is_none());
        lost.flat_map(|part| self.manifest.rows_of(part.first_row)).collect()
    }

    /// Notes how many of the rows without timings have lost them. A process that ends between two renames leaves the timings of
    /// a block ahead of their manifest: the journal has the same ones.
    fn note_untimed(&mut self, untimed: &[RowSpan], journaled: &BTreeSet<u64>) {
        let rows = untimed.iter().flat_map(|span| span.first..span.end).filter(|row| !journaled.contains(row)).count();
        if rows > 0 {
            self.notes.push(format!(
                "the wall times of {rows} rows are lost or damaged: nulls in the table of timings; the rows themselves are kept"
            ));
        }
    }

    /// Records damaged frames of the journal, and moves files with rows of another study out of it.
    fn take_note(&mut self, folder: &Path, salvage: Salvage) -> Result<(), DatasetError> {
        self.notes.extend(salvage.notes);
        for path in salvage.foreign {
            set_aside(&path, &folder.join(DAMAGED))?;
            let shown = path.display();
            self.notes.push(format!("{shown}: it holds rows of another study, and is kept in the folder .damaged"));
        }
        Ok(())
    }

    /// The blocks with damaged or missing parts.
    fn check(&self, folder: &Path) -> Bad {
        let mut bad = Bad::new();
        let Manifest { runs, blows, signals, .. } = &self.manifest;
        for part in runs.iter().chain(blows).chain(signals) {
            if let Err(error) = check_part(folder, part) {
                bad.entry(part.first_row).or_default().push(error);
            }
        }
        bad
    }

    /// Takes blocks out of the manifests, and their files out of the tables, so that no reader of the folder trips over them.
    fn forget(&mut self, folder: &Path, blocks: Bad) -> Result<(), DatasetError> {
        for (first_row, errors) in blocks {
            let known = self.manifest.rows_of(first_row);
            // Of a block that no manifest knows, all rows may have been there.
            let all = self.manifest.block(first_row).intersection(self.manifest.range);
            let wanted = if known.is_empty() { vec![all] } else { known };
            let pending = self.pending.get(&(first_row / self.manifest.study.rows_per_part));
            let has = |row: u64| pending.is_some_and(|block| block.contains_key(&row));
            // A process that ends between two renames leaves such a block too: the journal has its rows.
            let is_lost = !wanted.into_iter().flat_map(|span| span.first..span.end).all(has);
            for table in TableName::KNOWN {
                let path = folder.join(part_file(table, first_row));
                if is_lost { set_aside(&path, &folder.join(DAMAGED))? } else { remove(&path)? }
            }
            if is_lost {
                self.damaged.extend(errors);
            }
            self.manifest.remove_block(first_row);
            self.timings.timings.retain(|part| part.first_row != first_row);
        }
        Ok(())
    }
}

/// Replaces a row in its block, except a done row by one that is not done: a budget does not discard a computed row.
pub fn supersede(block: &mut Block, row: StoredRow) {
    if row.failed() && block.get(&row.row()).is_some_and(|known| !known.failed()) {
        return;
    }
    block.insert(row.row(), row);
}

/// Whether the manifest has all rows of a block that the dataset is to hold.
fn is_full(manifest: &Manifest, first_row: u64) -> bool {
    let wanted = manifest.block(first_row).intersection(manifest.range);
    find(&manifest.runs, first_row).is_some_and(|part| part.records == wanted.len())
}

/// The parts of one block.
#[derive(Clone, Copy)]
pub struct BlockParts<'a> {
    /// Of the table of runs.
    pub runs: &'a TablePart,
    /// Of the table of blows.
    pub blows: &'a TablePart,
    /// Of the table of timings; lost ones give nulls.
    pub timings: Option<&'a TablePart>,
    /// Of the table of signals, if there is one.
    pub signals: Option<&'a TablePart>,
}

impl<'a> BlockParts<'a> {
    /// Parts of a block; `None` unless the manifest has all parts that depend only on the study.
    pub fn find(manifest: &'a Manifest, timings: &'a [TablePart], first_row: u64) -> Option<Self> {
        let (runs, blows) = (find(&manifest.runs, first_row)?, find(&manifest.blows, first_row)?);
        let signals = find(&manifest.signals, first_row);
        let found = Self { runs, blows, timings: find(timings, first_row), signals };
        (signals.is_some() || manifest.study.signals.is_empty()).then_some(found)
    }
}

/// The rows of a block's parts.
///
/// # Errors
/// The reader's.
pub fn read_block(
    folder: &Path,
    columns: &Columns,
    recovered: &Recovered,
    first_row: u64,
) -> Result<Block, DatasetError> {
    let mut block = Block::new();
    let Recovered { manifest, timings, .. } = recovered;
    if let Some(parts) = BlockParts::find(manifest, &timings.timings, first_row) {
        read_parts(folder, columns, parts, &mut |row| {
            block.insert(row.row(), row);
        })?;
    }
    Ok(block)
}

/// Calls `take` for every row of the parts of one block.
///
/// # Errors
/// [`DatasetError::Damaged`] if the tables have not the same rows, or the reader's.
pub fn read_parts(
    folder: &Path,
    columns: &Columns,
    parts: BlockParts<'_>,
    take: &mut dyn FnMut(StoredRow),
) -> Result<(), DatasetError> {
    let mut rows: BTreeMap<u64, RowWriter> = BTreeMap::new();
    let tables = [
        (TableName::Runs, Some(parts.runs)),
        (TableName::Timings, parts.timings),
        (TableName::Blows, Some(parts.blows)),
    ];
    let signals = parts.signals.map(|part| (TableName::Signals, Some(part)));
    for (table, part) in tables.into_iter().chain(signals) {
        let descriptions = columns.describe(table);
        let Some(part) = part else {
            // In the order of the columns: the row's index, then the lost ones.
            for (row, writer) in &mut rows {
                writer.cell(Some(Value::Count(*row)));
                descriptions.iter().skip(1).for_each(|_| writer.cell(None));
            }
            continue;
        };
        let path = folder.join(&part.file);
        let names: Vec<&str> = descriptions.iter().map(|column| column.name.as_str()).collect();
        let mut strays = 0;
        open_part(folder, part)?.visit(&descriptions, &mut |cells| {
            let row = match cells.first() {
                Some(Some(Value::Count(row))) => *row,
                _ => return strays += 1,
            };
            if table == TableName::Runs {
                rows.insert(row, RowWriter::new(row, cells_say_failed(&names, cells)));
            }
            match rows.get_mut(&row) {
                Some(writer) => {
                    if table == TableName::Signals {
                        writer.instant();
                    }
                    cells.iter().for_each(|cell| writer.cell(*cell));
                }
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
