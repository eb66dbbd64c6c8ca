//! Verification of a dataset. It changes nothing.

use std::collections::BTreeSet;
use std::path::Path;

use super::columns::{Columns, TableName};
use super::consistency::check_manifests;
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::journal;
use super::lock::Lock;
use super::manifest::{Manifest, RowSpan, TablePart, find, gaps};
use super::parquet_file::Opened;
use super::reader::open_part;
use super::rebuild::{known, strays};
use decore_quantity::Value;

/// Result of a verification.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// The study, as the manifest has it.
    pub study: DatasetInfo,
    /// Rows that the dataset is to hold.
    pub rows: u64,
    /// Rows that are in whole parts.
    pub rows_done: u64,
    /// Rows that only the journal has.
    pub rows_in_journal: u64,
    /// Parts that were read.
    pub parts: u64,
    /// Size in bytes.
    pub bytes: u64,
    /// Damaged, missing or foreign files, a sentence each; empty for a complete dataset.
    pub faults: Vec<String>,
}

/// Checks the manifests, every part's checksum, metadata and rows, and that no other files are in the tables' folders.
///
/// # Errors
/// [`DatasetError::InUse`] while a sweep writes; [`DatasetError::Missing`], [`DatasetError::Version`] or the system's.
pub fn verify(folder: &Path) -> Result<Verification, DatasetError> {
    if Lock::is_taken(folder) {
        return Err(DatasetError::InUse { path: folder.to_owned(), owner: "a sweep that runs".to_owned() });
    }
    let known = known(folder)?;
    let manifest = &known.manifest;
    let mut faults = known.notes;
    faults.extend(strays(folder, manifest)?.iter().map(ToString::to_string));
    faults.extend(check_manifests(folder, manifest, &known.timings).err().map(|error| error.to_string()));
    let (mut parts, mut bytes) = (0, 0);
    let columns = Columns::new(&manifest.study)?;
    let kept = ExpectedParts { folder, manifest, columns: &columns };
    let mut journaled = BTreeSet::new();
    journal::visit(folder, &mut |row| _ = journaled.insert(row.row()))?;
    let rows_in_journal = journaled.iter().filter(|row| !manifest.has(**row)).count() as u64;
    for runs in &manifest.runs {
        let mut wrong = Vec::new();
        for table in columns.tables() {
            let part = match table {
                TableName::Runs => Some(runs),
                TableName::Blows => find(&manifest.blows, runs.first_row),
                TableName::Timings => find(&known.timings.timings, runs.first_row),
                TableName::Signals => find(&manifest.signals, runs.first_row),
            };
            let Some(part) = part else {
                wrong.push(format!("no part of {} for the rows from {}", table.folder(), runs.first_row));
                continue;
            };
            (parts, bytes) = (parts + 1, bytes + part.bytes);
            let checked = open_part(folder, part).and_then(|opened| kept.check((table, part), opened));
            wrong.extend(checked.err().map(|error| error.to_string()));
        }
        let mut rows = manifest.rows_of(runs.first_row).into_iter().flat_map(|span| span.first..span.end);
        if !wrong.is_empty() && rows.all(|row| journaled.contains(&row)) {
            // A process that ends between two renames leaves such a block; as after damage from outside, nothing of it is lost.
            wrong = vec![format!(
                "the parts with the rows from {} do not match the manifest, because a process ended while it replaced \
                 them; the journal has all their rows: run the same `decore run` again to store them",
                runs.first_row
            )];
        }
        faults.append(&mut wrong);
    }
    for gap in gaps(manifest.range, &manifest.done) {
        faults.push(format!("rows {} to {} are in no part", gap.first, gap.end - 1));
    }
    let (rows, rows_done) = (manifest.range.len(), manifest.rows_done);
    Ok(Verification { study: known.manifest.study, rows, rows_done, rows_in_journal, parts, bytes, faults })
}

/// Expected properties of parts.
struct ExpectedParts<'a> {
    folder: &'a Path,
    manifest: &'a Manifest,
    columns: &'a Columns,
}

impl ExpectedParts<'_> {
    /// Holds a part to the study's metadata and to the rows that the manifest has of its block.
    fn check(&self, (table, part): (TableName, &TablePart), opened: Opened) -> Result<(), DatasetError> {
        let path = self.folder.join(&part.file);
        let descriptions = self.columns.describe(table);
        opened.check_study(&self.manifest.study, table, &descriptions)?;
        let mut rows = BTreeSet::new();
        let (mut records, mut others) = (0, 0);
        opened.visit(&descriptions, &mut |cells| {
            records += 1;
            match cells.first() {
                Some(Some(Value::Count(row))) => _ = rows.insert(*row),
                _ => others += 1,
            }
        })?;
        let wanted: BTreeSet<u64> =
            self.manifest.rows_of(part.first_row).into_iter().flat_map(|RowSpan { first, end }| first..end).collect();
        // A run without blows is in no row of theirs, one whose signals are not kept in none of these; the other tables have each
        // row once.
        let is_covered = match table {
            TableName::Blows | TableName::Signals => rows.is_subset(&wanted),
            TableName::Runs | TableName::Timings => rows == wanted && records == wanted.len() as u64,
        };
        if is_covered && others == 0 && records == part.records {
            return Ok(());
        }
        Err(DatasetError::Damaged {
            path,
            found: format!("{records} records of {} rows", rows.len()),
            expected: format!("{} records of the {} rows of its block", part.records, wanted.len()),
        })
    }
}
