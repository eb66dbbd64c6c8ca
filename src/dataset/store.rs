//! Puts blocks of rows in place as parts: what is in place is whole.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::columns::{Columns, TableName};
use super::durable::{StagedFile, failed_to, sync_folder};
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::manifest::{MANIFEST_NAME, Manifest, Part, TIMINGS_NAME, TimingsManifest, part_file, to_json};
use super::parquet_file::TableBuilder;
use super::record::{ColumnCounts, StoredRow};

/// Folder of the grown dataset while it is written, below the dataset's.
pub const GROWING: &str = ".growing";
/// Folder for files that are not yet in place, on the same file system as the tables.
pub const STAGING: &str = ".staging";

/// Rows of one block, by index.
pub type Block = BTreeMap<u64, StoredRow>;

/// The parts and manifests of a dataset.
pub struct Store {
    folder: PathBuf,
    columns: Arc<Columns>,
    manifest: Manifest,
    timings: TimingsManifest,
}

impl Store {
    /// The store of a dataset whose manifests are known; makes its folders and puts the manifests in place.
    ///
    /// # Errors
    /// The system's.
    pub fn open(
        folder: &Path,
        columns: Arc<Columns>,
        (manifest, timings): (Manifest, TimingsManifest),
    ) -> Result<Self, DatasetError> {
        for name in TableName::ALL.map(TableName::folder).into_iter().chain([STAGING]) {
            let path = folder.join(name);
            fs::create_dir_all(&path).map_err(failed_to("create", &path))?;
        }
        let store = Self { folder: folder.to_owned(), columns, manifest, timings };
        store.put_manifests_in_place(&store.manifest, &store.timings)?;
        Ok(store)
    }

    /// The manifest of what is in place.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Writes the parts of a block: all files are staged and synced first, then renamed into place, then the manifests.
    ///
    /// # Errors
    /// The system's or the Parquet library's; what was in place is in place still, and every file that is there is whole.
    pub fn put_block(&mut self, block: &Block) -> Result<(), DatasetError> {
        let Some(first) = block.keys().next() else {
            return Ok(());
        };
        let per_part = self.manifest.study.rows_per_part;
        let first_row = first / per_part * per_part;
        let failed = block.values().filter(|row| row.failed()).count() as u64;
        let mut parts = Vec::with_capacity(TableName::ALL.len());
        let mut files = Vec::with_capacity(TableName::ALL.len());
        for builder in self.tables(block)? {
            let (table, builder) = builder;
            let (part, file) = self.stage_part(table, builder, (first_row, failed))?;
            parts.push(part);
            files.push((table.folder(), file));
        }
        let (mut manifest, mut timings) = (self.manifest.clone(), self.timings.clone());
        if let Ok([part_of_timings, blows, runs]) = <[Part; 3]>::try_from(parts) {
            timings.put(part_of_timings);
            manifest.put_block(block.keys().copied(), runs, blows);
        }
        for (folder, file) in files {
            file.put_in_place()?;
            sync_folder(&self.folder.join(folder))?;
        }
        self.put_manifests_in_place(&manifest, &timings)?;
        (self.manifest, self.timings) = (manifest, timings);
        Ok(())
    }

    /// The tables of a block in the order in which they are put in place: a run that a reader sees has its blows.
    fn tables(&self, block: &Block) -> Result<[(TableName, TableBuilder); 3], DatasetError> {
        let builder = |table| TableBuilder::new(table, self.columns.describe(table));
        let [mut timings, mut blows, mut runs] =
            [TableName::Timings, TableName::Blows, TableName::Runs].map(|table| (table, builder(table)));
        let counts = ColumnCounts::of(&self.columns);
        for row in block.values() {
            let whole = row.visit(&counts, &mut |table, index, cell| match table {
                TableName::Runs => runs.1.append(index, cell),
                TableName::Blows => blows.1.append(index, cell),
                TableName::Timings => timings.1.append(index, cell),
            });
            whole.ok_or_else(|| DatasetError::Record {
                row: row.row(),
                what: "cells of the journal".to_owned(),
                found: format!("{} bytes of other columns", row.bytes().len()),
                expected: "the columns of the manifest's study".to_owned(),
            })?;
        }
        Ok([timings, blows, runs])
    }

    fn stage_part(
        &self,
        table: TableName,
        builder: TableBuilder,
        (first_row, failed): (u64, u64),
    ) -> Result<(Part, StagedFile), DatasetError> {
        let file = part_file(table, first_row);
        let target = self.folder.join(&file);
        let (bytes, records) = builder
            .encode(&self.manifest.study)
            .map_err(|source| DatasetError::Parquet { path: target.clone(), source })?;
        let blake3 = blake3::hash(&bytes).to_hex().to_string();
        let part = Part { file, first_row, records, failed, bytes: bytes.len() as u64, blake3 };
        Ok((part, StagedFile::write(&self.folder.join(STAGING), &target, &bytes)?))
    }

    fn put_manifests_in_place(&self, manifest: &Manifest, timings: &TimingsManifest) -> Result<(), DatasetError> {
        let staging = self.folder.join(STAGING);
        let [manifest_path, timings_path] = [MANIFEST_NAME, TIMINGS_NAME].map(|name| self.folder.join(name));
        let timings = StagedFile::write(&staging, &timings_path, &to_json(timings, &timings_path)?)?;
        let manifest = StagedFile::write(&staging, &manifest_path, &to_json(manifest, &manifest_path)?)?;
        timings.put_in_place()?;
        manifest.put_in_place()?;
        sync_folder(&self.folder)
    }
}

/// The columns of a study.
///
/// # Errors
/// [`DatasetError::DuplicateColumn`]; [`DatasetError::Setting`] if there are no rows per part.
pub fn columns_of(info: &DatasetInfo) -> Result<Arc<Columns>, DatasetError> {
    if info.rows_per_part == 0 {
        return Err(DatasetError::Setting { key: "rows_per_part", found: 0, expected: "at least 1" });
    }
    Ok(Arc::new(Columns::new(info)?))
}

/// Removes a file or folder; one that is not there is fine.
///
/// # Errors
/// The system's.
pub fn remove(path: &Path) -> Result<(), DatasetError> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(failed_to("remove", path)(error)),
        _ => Ok(()),
    }
}
