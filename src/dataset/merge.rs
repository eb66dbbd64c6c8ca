//! Merges shards into one dataset, byte for byte the dataset of an unsharded run.

use std::fs;
use std::path::{Path, PathBuf};

use super::columns::TableName;
use super::difference::differences;
use super::error::DatasetError;
use super::lock::Lock;
use super::manifest::{Manifest, RowSpan, TablePart, find, gaps};
use super::reader::DatasetReader;
use super::reader::check_part;
use super::recovery::{BlockParts, read_parts};
use super::store::columns_of;
use super::target::place;
use super::writer::{DatasetWriter, Existing};

/// Result of a merge.
#[derive(Debug)]
pub struct Merged {
    /// The manifest of the whole.
    pub manifest: Manifest,
    /// Lost rows and files kept aside, in words.
    pub notes: Vec<String>,
}

/// Verifies shards (one study, undamaged, complete, no gap, no overlap) and writes the dataset of all their rows.
///
/// A merge that was interrupted continues when it is repeated with [`Existing::Resume`]. The shards stay as they are.
///
/// Timings that are lost or damaged become nulls.
///
/// # Errors
/// [`DatasetError::Shards`] for shards that do not make a whole; [`DatasetError::Damaged`]; [`DatasetError::InUse`]; the
/// reader's and the writer's. Everything is verified before anything is written.
pub fn merge(shards: &[PathBuf], output: &Path, existing: Existing) -> Result<Merged, DatasetError> {
    refuse_input(shards, output)?;
    let mut readers = Vec::with_capacity(shards.len());
    for folder in shards {
        readers.push(open(folder)?);
    }
    // An empty shard comes before the one that begins where it does.
    readers.sort_by_key(|reader| (reader.manifest().range.first, reader.manifest().range.end));
    verify(&readers)?;
    let Some(info) = readers.first().map(|reader| reader.manifest().study.clone()) else {
        return Err(DatasetError::Shards {
            problem: "no shards were given".to_owned(),
            advice: "name the folder of every shard",
        });
    };
    let columns = columns_of(&info)?;
    let reruns = readers.iter().flat_map(|reader| reader.manifest().reruns.clone());
    let mut writer = DatasetWriter::copy(output, &info, reruns.collect(), existing)?;
    let mut notes = Vec::new();
    for reader in &readers {
        let blocks = blocks(reader);
        let untimed: u64 = blocks.iter().filter(|parts| parts.timings.is_none()).map(|parts| parts.runs.records).sum();
        if untimed > 0 {
            let folder = reader.folder().display();
            notes.push(format!(
                "{folder}: the wall times of {untimed} rows are lost or damaged: nulls in the table of timings"
            ));
        }
        for parts in blocks {
            let mut rows = Vec::new();
            read_parts(reader.folder(), &columns, parts, &mut |row| rows.push(row))?;
            rows.retain(|row| writer.needs(row.row()));
            rows.into_iter().try_for_each(|row| writer.accept(row))?;
        }
    }
    notes.extend_from_slice(writer.notes());
    let manifest = writer.finish()?;
    if manifest.complete {
        return Ok(Merged { manifest, notes });
    }
    let missing = gaps(manifest.range, &manifest.done);
    let problem =
        missing.first().map_or_else(String::new, |gap| format!("no part has rows {} to {}", gap.first, gap.end - 1));
    Err(DatasetError::Shards { problem, advice: "run the shards again: they compute what is missing" })
}

/// The output is none of the shards and none lies within the other, by whatever path: replacing would take rows away before
/// they are read.
fn refuse_input(shards: &[PathBuf], output: &Path) -> Result<(), DatasetError> {
    let target = place(output);
    let overlaps = |shard: &&PathBuf| {
        fs::canonicalize(shard).is_ok_and(|shard| shard.starts_with(&target) || target.starts_with(&shard))
    };
    let Some(shard) = shards.iter().find(overlaps) else { return Ok(()) };
    let problem = format!("the output {} is the shard {}, or one is in the other", output.display(), shard.display());
    Err(DatasetError::Shards { problem, advice: "give a folder of its own: the shards stay as they are" })
}

fn open(folder: &Path) -> Result<DatasetReader, DatasetError> {
    if Lock::is_taken(folder) {
        return Err(DatasetError::InUse { path: folder.to_owned(), owner: "a shard that still runs".to_owned() });
    }
    DatasetReader::open(folder)
}

fn verify(readers: &[DatasetReader]) -> Result<(), DatasetError> {
    let Some(first) = readers.first() else {
        return Ok(());
    };
    let mut next = 0;
    for reader in readers {
        let manifest = reader.manifest();
        let name = reader.folder().display();
        let differences = differences(&first.manifest().study, &manifest.study);
        if !differences.is_empty() {
            let problem = format!(
                "{} and {name} are shards of different studies. Differences:\n  {}\n",
                first.folder().display(),
                differences.join("\n  ")
            );
            return Err(DatasetError::Shards { problem, advice: "run the shards with the same study and program" });
        }
        let missing = gaps(manifest.range, &manifest.done);
        if let Some(gap) = missing.first() {
            let problem = format!("{name} lacks rows {} to {}", gap.first, gap.end - 1);
            return Err(DatasetError::Shards { problem, advice: "run that shard again: it continues" });
        }
        contiguous(next, manifest.range, reader)?;
        next = manifest.range.end;
        if let Some(damage) =
            [TableName::Runs, TableName::Blows, TableName::Signals].into_iter().flat_map(|t| reader.damage_of(t)).next()
        {
            return Err(damage);
        }
    }
    let rows = first.manifest().study.rows;
    contiguous(next, RowSpan { first: rows, end: rows }, first)
}

/// Checks that a shard begins where the previous one ended.
fn contiguous(next: u64, range: RowSpan, reader: &DatasetReader) -> Result<(), DatasetError> {
    let problem = match range.first.cmp(&next) {
        std::cmp::Ordering::Equal => return Ok(()),
        std::cmp::Ordering::Greater => format!("no shard has rows {next} to {}", range.first - 1),
        std::cmp::Ordering::Less => {
            let end = next.min(range.end.max(range.first + 1));
            format!("rows {} to {} of {} are in another shard too", range.first, end - 1, reader.folder().display())
        }
    };
    Err(DatasetError::Shards { problem, advice: "give the folders of all shards 1/n to n/n, each once" })
}

/// The parts of each block of a shard, without timings that are damaged.
fn blocks<'a>(reader: &'a DatasetReader) -> Vec<BlockParts<'a>> {
    let of_block = |runs: &'a TablePart| {
        let timings = find(reader.parts(TableName::Timings), runs.first_row);
        let timings = timings.filter(|part| check_part(reader.folder(), part).is_ok());
        Some(BlockParts { timings, ..BlockParts::find(reader.manifest(), &[], runs.first_row)? })
    };
    reader.parts(TableName::Runs).iter().filter_map(of_block).collect()
}
