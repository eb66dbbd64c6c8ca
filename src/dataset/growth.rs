//! Growth of a dataset whose study got more rows: existing rows stay, under the new study's name.
//!
//! The parts of the grown study are written into a separate folder, block by block, from the rows of the old parts and the journal, and
//! moved into place when they are complete. Every file contains the name of its study, so unchanged blocks are encoded again too. A grown
//! dataset has the same bytes as one that ran in one go.

use std::fs::File;
use std::path::Path;

use super::difference::has_same_columns;
use super::durable::{failed_to, sync_folder};
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::lock::Lock;
use super::manifest::Manifest;
use super::rebuild::known;
use super::recovery::{BlockParts, Recovered, read_parts, recover};
use super::settled::{READY, settle, settle_locked};
use super::store::{GROWING, columns_of};
use super::writer::{DatasetWriter, Existing};

/// State of a dataset before it grew.
#[derive(Debug)]
pub struct Growth {
    /// Rows of the design before.
    pub rows_before: u64,
    /// Damaged parts; their rows must be computed again.
    pub damaged: Vec<DatasetError>,
    /// Further losses, in words.
    pub notes: Vec<String>,
}

/// Makes the dataset in `folder` one of the study `info`, if that is its study with rows added after the last one.
///
/// `rows_hash`: [`DatasetInfo::rows_hash`] of the first rows of `info`'s study, by their number. `None`: the folder was left as
/// it is, because it holds no dataset, one of an unchanged study, of a shard, or of another study. A growth that was
/// interrupted is completed or undone first.
///
/// Takes the room of the dataset on the disk a second time while it lasts.
///
/// # Errors
/// [`DatasetError::InUse`]; the reader's and the writer's. The dataset is then still the old one, or the next call completes
/// the new one.
pub fn grow(
    folder: &Path,
    info: &DatasetInfo,
    rows_hash: &dyn Fn(u64) -> String,
) -> Result<Option<Growth>, DatasetError> {
    settle(folder)?;
    match known(folder) {
        Ok(known) if has_grown(&known.manifest, info, rows_hash) => {}
        // Other commands report the damage when they open the dataset.
        _ => return Ok(None),
    }
    let _lock = Lock::take(folder)?;
    // Another process may have written until the lock was taken.
    let known = known(folder)?;
    let columns = columns_of(&known.manifest.study)?;
    let mut recovered = recover(folder, &columns, known)?;
    let growth = Growth {
        rows_before: recovered.manifest.study.rows,
        damaged: std::mem::take(&mut recovered.damaged),
        notes: std::mem::take(&mut recovered.notes),
    };
    let growing = folder.join(GROWING);
    let reruns = recovered.manifest.reruns.clone();
    copy_rows(folder, recovered, DatasetWriter::copy(&growing, info, reruns, Existing::Refuse)?)?;
    let ready = growing.join(READY);
    File::create(&ready).and_then(|file| file.sync_all()).map_err(failed_to("create", &ready))?;
    sync_folder(&growing)?;
    settle_locked(folder)?;
    Ok(Some(growth))
}

/// Whether `info` is the study of the manifest with rows added.
fn has_grown(manifest: &Manifest, info: &DatasetInfo, rows_hash: &dyn Fn(u64) -> String) -> bool {
    let before = &manifest.study;
    let frame = |info: &DatasetInfo| {
        let DatasetInfo { frame_hash, program_version, inputs, settings, .. } = info.clone();
        (frame_hash, program_version, inputs, settings)
    };
    let whole = manifest.range.first == 0 && manifest.range.end == before.rows;
    whole
        && !before.frame_hash.is_empty()
        && frame(before) == frame(info)
        && has_same_columns(before, info)
        && before.rows < info.rows
        && before.rows_hash == rows_hash(before.rows)
}

/// Hands all rows of a dataset to the writer of another one.
fn copy_rows(folder: &Path, recovered: Recovered, mut writer: DatasetWriter) -> Result<(), DatasetError> {
    let Recovered { manifest, timings, pending, .. } = recovered;
    let columns = columns_of(&manifest.study)?;
    for runs in &manifest.runs {
        if pending.contains_key(&(runs.first_row / manifest.study.rows_per_part)) {
            continue;
        }
        if let Some(parts) = BlockParts::find(&manifest, &timings.timings, runs.first_row) {
            let mut rows = Vec::new();
            read_parts(folder, &columns, parts, &mut |row| rows.push(row))?;
            rows.into_iter().try_for_each(|row| writer.accept(row))?;
        }
    }
    let mut left = pending.into_values().flat_map(std::collections::BTreeMap::into_values);
    left.try_for_each(|row| writer.accept(row))?;
    writer.finish().map(|_| ())
}
