//! Everything that can be checked of a dataset, without changing it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::columns::{Columns, TableName};
use super::durable::failed_to;
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::journal;
use super::lock::Lock;
use super::manifest::{Manifest, Part, RowSpan, find, gaps, part_first_row};
use super::parquet_file::{check_study, visit_rows};
use super::rebuild::known;
use crate::quantity::Value;

/// What a verification found.
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
    /// Their bytes.
    pub bytes: u64,
    /// What is damaged, missing or foreign, a sentence each; empty for a dataset that is whole.
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
    let (mut parts, mut bytes) = (0, 0);
    let columns = Columns::new(&manifest.study)?;
    for runs in &manifest.runs {
        let found = [Some(runs), find(&manifest.blows, runs.first_row), find(&known.timings.timings, runs.first_row)];
        for (table, part) in TableName::ALL.into_iter().zip(found) {
            let Some(part) = part else {
                faults.push(format!("no part of {} for the rows from {}", table.folder(), runs.first_row));
                continue;
            };
            (parts, bytes) = (parts + 1, bytes + part.bytes);
            let checked =
                check_part(folder, part).and_then(|()| check_contents(folder, (manifest, part), &columns, table));
            faults.extend(checked.err().map(|error| error.to_string()));
        }
    }
    for gap in gaps(manifest.range, &manifest.done) {
        faults.push(format!("rows {} to {} are in no part", gap.first, gap.end - 1));
    }
    let (rows_in_journal, _) = journal::count(folder, &|row| !manifest.has(row))?;
    let (rows, rows_done) = (manifest.range.len(), manifest.rows_done);
    Ok(Verification { study: known.manifest.study, rows, rows_done, rows_in_journal, parts, bytes, faults })
}

/// Holds a part to the study's metadata and to the rows that the manifest has of its block.
fn check_contents(
    folder: &Path,
    (manifest, part): (&Manifest, &Part),
    columns: &Columns,
    table: TableName,
) -> Result<(), DatasetError> {
    let path = folder.join(&part.file);
    let descriptions = columns.describe(table);
    check_study(&path, &manifest.study, (table, &descriptions))?;
    let mut rows = BTreeSet::new();
    let (mut records, mut others) = (0, 0);
    visit_rows(&path, &descriptions, &mut |cells| {
        records += 1;
        match cells.first() {
            Some(Some(Value::Count(row))) => _ = rows.insert(*row),
            _ => others += 1,
        }
    })?;
    let wanted: BTreeSet<u64> =
        manifest.rows_of(part.first_row).into_iter().flat_map(|RowSpan { first, end }| first..end).collect();
    // A run without blows is in no row of theirs; the other tables have each row once.
    let is_covered = match table {
        TableName::Blows => rows.is_subset(&wanted),
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

/// Compares a part's length and checksum with the manifest's.
///
/// # Errors
/// [`DatasetError::Damaged`] or the system's.
pub fn check_part(folder: &Path, part: &Part) -> Result<(), DatasetError> {
    let path = folder.join(&part.file);
    let bytes = fs::read(&path).map_err(failed_to("read", &path))?;
    let hash = blake3::hash(&bytes).to_hex().to_string();
    if bytes.len() as u64 == part.bytes && hash == part.blake3 {
        return Ok(());
    }
    Err(DatasetError::Damaged {
        path,
        found: format!("{} bytes, BLAKE3 {hash}", bytes.len()),
        expected: format!("{} bytes, BLAKE3 {}", part.bytes, part.blake3),
    })
}

/// Files in the tables' folders that are no parts of the dataset: whoever reads all files of a folder reads them too.
///
/// A part that no manifest lists is none of them: a sweep that was killed leaves it, and the next run puts it in place.
///
/// # Errors
/// The system's.
pub fn strays(folder: &Path, manifest: &Manifest) -> Result<Vec<DatasetError>, DatasetError> {
    let is_part = |table: TableName, path: &PathBuf| {
        let first_row = path.file_name().and_then(|name| part_first_row(table, name.to_str()?));
        first_row.is_some_and(|first_row| {
            first_row % manifest.study.rows_per_part == 0
                && !manifest.block(first_row).intersection(manifest.range).is_empty()
        })
    };
    // Readers pass over such names.
    let is_hidden = |path: &PathBuf| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    let mut found = Vec::new();
    for table in TableName::ALL {
        let folder = folder.join(table.folder());
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        for entry in entries {
            let path = entry.map_err(failed_to("read the folder", &folder))?.path();
            if !is_part(table, &path) && !is_hidden(&path) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found.into_iter().map(|path| DatasetError::Stray { path }).collect())
}
