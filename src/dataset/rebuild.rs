//! Rebuilds lost or damaged manifests from the parts.
//!
//! The metadata of every part of the table of timings describes its block: the study, and the block's parts of `runs` and `blows` with
//! their checksums. They are stored there because the bytes of the other two tables depend only on the study. A lost manifest is the sum
//! of these descriptions. Parts without a description do not count. Before the first part, the journal describes the dataset.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::columns::{Columns, TableName};
use super::difference::is_same_study;
use super::durable::failed_to;
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::journal;
use super::manifest::{
    BlockFiles, FORMAT_VERSION, Manifest, Rerun, RowSpan, TablePart, TimingsManifest, fingerprint, part_file,
    part_first_row, read_bytes,
};
use super::parquet_file::Opened;

/// Description of its block in a part of the table of timings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlockDescription {
    format_version: u32,
    study: DatasetInfo,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    reruns: Vec<Rerun>,
    range: RowSpan,
    done: Vec<RowSpan>,
    #[serde(flatten)]
    files: BlockFiles,
}

/// The manifests of a folder.
pub struct Known {
    /// `manifest.json`, read or rebuilt.
    pub manifest: Manifest,
    /// `timings.json`, or its remaining entries.
    pub timings: TimingsManifest,
    /// Losses, in words.
    pub notes: Vec<String>,
    /// Parts of `runs` and `blows` in the folder without a checksum, after the loss of the manifest.
    pub unvouched: Vec<(u64, PathBuf)>,
}

impl BlockDescription {
    /// The block of these parts in a manifest that has it.
    pub fn new(manifest: &Manifest, files: BlockFiles) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            study: manifest.study.clone(),
            reruns: manifest.reruns.clone(),
            range: manifest.range,
            done: manifest.rows_of(files.runs.first_row),
            files,
        }
    }

    /// As text for a file's metadata.
    ///
    /// # Errors
    /// [`DatasetError::Manifest`], should a value not be writable as JSON.
    pub fn to_text(&self) -> Result<String, DatasetError> {
        serde_json::to_string(self)
            .map_err(|source| DatasetError::Manifest { path: self.files.runs.file.clone().into(), source })
    }

    fn of(part: &Opened) -> Option<Self> {
        let found: Self = serde_json::from_str(part.block_text()?).ok()?;
        (found.format_version == FORMAT_VERSION).then_some(found)
    }
}

/// Reads the manifests of the dataset in `folder`, or rebuilds them.
///
/// # Errors
/// [`DatasetError::Missing`] or [`DatasetError::Lost`] if there is no `manifest.json` or a damaged one, and neither parts nor journal
/// describe the dataset; the system's.
pub fn known(folder: &Path) -> Result<Known, DatasetError> {
    let mut notes = Vec::new();
    let mut unvouched = Vec::new();
    let manifest = match Manifest::read(folder) {
        Err(error) if error.is_lost_manifest() => {
            let manifest = match (manifest_of_parts(folder, journal::described(folder))?, error) {
                (Some(manifest), _) => manifest,
                (None, missing @ DatasetError::Missing { .. }) => return Err(missing),
                (None, damaged) => return Err(DatasetError::Lost { damage: Box::new(damaged) }),
            };
            let in_parts = manifest.rows_done;
            let in_journal = journal::count(folder, &|row| !manifest.has(row))?.0;
            notes.push(match in_parts {
                0 => format!(
                    "manifest.json was lost or damaged, and was rebuilt from the journal with {in_journal} rows"
                ),
                _ => format!("manifest.json was lost or damaged, and was rebuilt from the parts with {in_parts} rows"),
            });
            unvouched = unlisted(folder, &manifest)?;
            manifest
        }
        found => found?,
    };
    let timings = match TimingsManifest::read(folder) {
        Err(error) if error.is_lost_manifest() => {
            notes.push("timings.json was lost or damaged, and was rebuilt from the parts".to_owned());
            timings_of_parts(folder, &manifest)?
        }
        found => found?,
    };
    Ok(Known { manifest, timings, notes, unvouched })
}

/// Rebuilds the manifest from the parts of timings and from the beginning in the journal. `None` if nothing describes it, or if the
/// descriptions belong to several datasets.
fn manifest_of_parts(folder: &Path, begun: Option<Manifest>) -> Result<Option<Manifest>, DatasetError> {
    let mut manifest = begun;
    for (first_row, path) in part_files(folder, TableName::Timings)? {
        let part = read_bytes(&path).and_then(|bytes| Opened::new(path, bytes));
        let block = part.ok().and_then(|part| BlockDescription::of(&part));
        let Some(block) = block.filter(|block| block.files.runs.first_row == first_row) else { continue };
        let manifest = manifest.get_or_insert_with(|| Manifest::new(block.study.clone(), block.range));
        if manifest.range != block.range || !is_same_study(&manifest.study, &block.study) {
            return Ok(None);
        }
        block.reruns.into_iter().for_each(|rerun| manifest.note_rerun(rerun));
        manifest.put_block(block.done.iter().flat_map(|span| span.first..span.end), block.files);
    }
    Ok(manifest)
}

/// Readable timings of the manifest's blocks.
///
/// # Errors
/// [`DatasetError::DuplicateColumn`], or the system's.
pub fn timings_of_parts(folder: &Path, manifest: &Manifest) -> Result<TimingsManifest, DatasetError> {
    let columns = Columns::new(&manifest.study)?.describe(TableName::Timings);
    let mut timings = TimingsManifest::default();
    for runs in &manifest.runs {
        let file = part_file(TableName::Timings, runs.first_row);
        let path = folder.join(&file);
        let Ok(contents) = read_bytes(&path) else { continue };
        let (bytes, blake3) = fingerprint(&contents);
        let Ok(part) = Opened::new(path, contents) else { continue };
        let mut records = 0;
        let whole = BlockDescription::of(&part).is_some_and(|block| block.files.runs == *runs)
            && part.visit(&columns, &mut |_| records += 1).is_ok()
            && records == runs.records;
        if whole {
            timings.put(TablePart { file, first_row: runs.first_row, records, failed: runs.failed, bytes, blake3 });
        }
    }
    Ok(timings)
}

/// Parts of `runs` and `blows` that the manifest does not list.
fn unlisted(folder: &Path, manifest: &Manifest) -> Result<Vec<(u64, PathBuf)>, DatasetError> {
    let mut found = part_files(folder, TableName::Runs)?;
    found.extend(part_files(folder, TableName::Blows)?);
    found.extend(part_files(folder, TableName::Signals)?);
    found.retain(|(first_row, _)| !manifest.runs.iter().any(|part| part.first_row == *first_row));
    Ok(found)
}

/// The files of a table's folder that have the name of a part, with the first row of its block.
fn part_files(folder: &Path, table: TableName) -> Result<Vec<(u64, PathBuf)>, DatasetError> {
    let folder = folder.join(table.folder());
    let Ok(entries) = fs::read_dir(&folder) else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(failed_to("read the folder", &folder))?.path();
        let first_row = path.file_name().and_then(|name| part_first_row(table, name.to_str()?));
        found.extend(first_row.map(|first_row| (first_row, path)));
    }
    found.sort();
    Ok(found)
}

/// Foreign files in the tables' folders: readers of all files of a folder would read them too.
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
    for table in TableName::KNOWN {
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
