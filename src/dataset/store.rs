//! Stores blocks of rows as parts. Only complete files are moved into place.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::iter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::columns::{Columns, TableName};
use super::durable::{StagedFile, failed_to, make_folder, rename, sync_folder};
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::lock::DatasetDir;
use super::manifest::{
    BlockFiles, MANIFEST_NAME, Manifest, TIMINGS_NAME, TablePart, TimingsManifest, part_file, to_sealed_json,
};
use super::parquet_file::FileFormat;
use super::rebuild::BlockDescription;
use super::record::{StoredRow, TableColumns};
use decore_quantity::{CellColumn, Value};

/// Folder for files that are not yet in place, on the same file system as the tables.
pub const STAGING: &str = ".staging";

/// Folder of the grown dataset while it is written, below the dataset's.
pub const GROWING: &str = ".growing";
/// Folder for parts that no longer match the manifest.
pub const DAMAGED: &str = ".damaged";
/// Folder for replaced datasets, until the new one is complete.
pub const REPLACED: &str = ".replaced";

/// Rows of one block, by index.
pub type Block = BTreeMap<u64, StoredRow>;

/// The format of a table's parts.
struct TableFormat {
    table: TableName,
    file: FileFormat,
}

/// Formats of all tables.
struct Formats {
    runs: TableFormat,
    blows: TableFormat,
    timings: TableFormat,
    signals: Option<TableFormat>,
}

impl Formats {
    fn new(info: &DatasetInfo, columns: &Columns, folder: &Path) -> Result<Self, DatasetError> {
        let format = |table: TableName| match FileFormat::of_table(info, table, &columns.describe(table)) {
            Ok(file) => Ok(TableFormat { table, file }),
            Err(source) => Err(DatasetError::Parquet { path: folder.join(table.folder()), source }),
        };
        Ok(Self {
            runs: format(TableName::Runs)?,
            blows: format(TableName::Blows)?,
            timings: format(TableName::Timings)?,
            signals: (!columns.signals.is_empty()).then(|| format(TableName::Signals)).transpose()?,
        })
    }
}

/// The parts and manifests of a dataset.
pub struct Store {
    folder: PathBuf,
    place: DatasetDir,
    columns: Arc<Columns>,
    formats: Formats,
    manifest: Manifest,
    timings: TimingsManifest,
}

/// The rows of a part.
#[derive(Clone, Copy)]
struct PartRows {
    first_row: u64,
    /// Number of rows that are not done.
    failed: u64,
}

/// A part that is written and not yet in place.
struct StagedPart {
    table: TableName,
    part: TablePart,
    file: StagedFile,
}

impl Store {
    /// The store of a dataset whose manifests are known; makes its folders and puts the manifests in place.
    ///
    /// # Errors
    /// The system's.
    pub fn open(
        place: DatasetDir,
        columns: Arc<Columns>,
        manifest: Manifest,
        timings: TimingsManifest,
    ) -> Result<Self, DatasetError> {
        let folder = place.path().to_owned();
        for name in columns.tables().map(TableName::folder).chain([STAGING]) {
            let path = folder.join(name);
            make_folder(&path)?;
        }
        let formats = Formats::new(&manifest.study, &columns, &folder)?;
        let store = Self { folder, place, columns, formats, manifest, timings };
        store.put_manifests_in_place(&store.manifest, &store.timings)?;
        Ok(store)
    }

    /// Manifest of the stored parts.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Whether the dataset's folder is still the one that was opened.
    ///
    /// # Errors
    /// [`DatasetError::Gone`].
    pub fn check_place(&self) -> Result<(), DatasetError> {
        self.place.check()
    }

    /// Writes the parts of a block: all files are staged and synced first, then renamed into place, then the manifests.
    ///
    /// # Errors
    /// The system's or the Parquet library's; what was in place is in place still, and every file that is there is whole.
    pub fn put_block(&mut self, block: &Block) -> Result<(), DatasetError> {
        let Some(first) = block.keys().next() else {
            return Ok(());
        };
        self.check_place()?;
        let per_part = self.manifest.study.rows_per_part;
        let first_row = first / per_part * per_part;
        let failed = block.values().filter(|row| row.failed()).count() as u64;
        let at = PartRows { first_row, failed };
        let TableColumns { runs, blows, timings: times, signals } = self.tables(block)?;
        let formats = &self.formats;
        let runs = self.stage_part(&formats.runs, runs, at, None)?;
        let blows = self.stage_part(&formats.blows, blows, at, None)?;
        let signals = formats.signals.as_ref().map(|format| self.stage_part(format, signals, at, None)).transpose()?;
        let (mut manifest, mut timings) = (self.manifest.clone(), self.timings.clone());
        let files = BlockFiles {
            runs: runs.part.clone(),
            blows: blows.part.clone(),
            signals: signals.as_ref().map(|signals| signals.part.clone()),
        };
        manifest.put_block(block.keys().copied(), files.clone());
        // It describes the others, so that the manifest can be rebuilt from it.
        let description = BlockDescription::new(&manifest, files).to_text()?;
        let times = self.stage_part(&formats.timings, times, at, Some(description))?;
        timings.put(times.part.clone());
        // In this order: a run that a reader sees has its blows and signals.
        [times]
            .into_iter()
            .chain(signals)
            .chain([blows, runs])
            .try_for_each(|staged| self.put_part_in_place(staged))?;
        self.put_manifests_in_place(&manifest, &timings)?;
        (self.manifest, self.timings) = (manifest, timings);
        #[cfg(test)]
        super::trace::note(&self.folder, || super::trace::Event::Durable(block.keys().copied().collect()));
        Ok(())
    }

    /// Writes nulls as the timings of a block whose own are lost.
    ///
    /// # Errors
    /// As [`Store::put_block`].
    pub fn put_null_timings(&mut self, first_row: u64) -> Result<(), DatasetError> {
        let manifest = &self.manifest;
        let Some(files) = manifest.files(first_row) else {
            return Ok(());
        };
        let mut timings = TableColumns::new(&self.columns).timings;
        for row in manifest.rows_of(first_row).into_iter().flat_map(|span| span.first..span.end) {
            let cells = iter::once(Some(Value::Count(row))).chain(iter::repeat(None));
            timings.iter_mut().zip(cells).for_each(|(column, cell)| column.push(cell));
        }
        let rows = PartRows { first_row, failed: files.runs.failed };
        let description = BlockDescription::new(manifest, files).to_text()?;
        let staged = self.stage_part(&self.formats.timings, timings, rows, Some(description))?;
        let part = staged.part.clone();
        self.put_part_in_place(staged)?;
        self.timings.put(part);
        self.put_manifests_in_place(&self.manifest, &self.timings)
    }

    fn tables(&self, block: &Block) -> Result<TableColumns, DatasetError> {
        let mut tables = TableColumns::new(&self.columns);
        for row in block.values() {
            row.append_to(&mut tables).ok_or_else(|| DatasetError::Record {
                row: row.row(),
                what: "cells of the journal".to_owned(),
                found: format!("{} bytes of other columns", row.bytes().len()),
                expected: "the columns of the manifest's study".to_owned(),
            })?;
        }
        Ok(tables)
    }

    fn stage_part(
        &self,
        format: &TableFormat,
        columns: Vec<CellColumn>,
        rows: PartRows,
        description: Option<String>,
    ) -> Result<StagedPart, DatasetError> {
        let PartRows { first_row, failed } = rows;
        let TableFormat { table, file: format } = format;
        let (table, file) = (*table, part_file(*table, first_row));
        let target = self.folder.join(&file);
        let encoded = format
            .batch(columns)
            .map_err(Into::into)
            .and_then(|batch| Ok((format.encode(&batch, description)?, batch.num_rows() as u64)));
        let (bytes, records) = encoded.map_err(|source| DatasetError::Parquet { path: target.clone(), source })?;
        let blake3 = blake3::hash(&bytes).to_hex().to_string();
        let part = TablePart { file, first_row, records, failed, bytes: bytes.len() as u64, blake3 };
        Ok(StagedPart { table, part, file: StagedFile::write(&self.folder.join(STAGING), &target, &bytes)? })
    }

    fn put_part_in_place(&self, staged: StagedPart) -> Result<(), DatasetError> {
        staged.file.put_in_place()?;
        sync_folder(&self.folder.join(staged.table.folder()))
    }

    fn put_manifests_in_place(&self, manifest: &Manifest, timings: &TimingsManifest) -> Result<(), DatasetError> {
        let staging = self.folder.join(STAGING);
        let [manifest_path, timings_path] = [MANIFEST_NAME, TIMINGS_NAME].map(|name| self.folder.join(name));
        let timings = StagedFile::write(&staging, &timings_path, &to_sealed_json(timings, &timings_path)?)?;
        let manifest = StagedFile::write(&staging, &manifest_path, &to_sealed_json(manifest, &manifest_path)?)?;
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
    #[cfg(test)]
    super::trace::note(path, || super::trace::Event::Remove(path.to_owned()));
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(failed_to("remove", path)(error)),
        _ => Ok(()),
    }
}

/// Moves a file or folder into the folder `aside`, under a name that is free there; one that is not there is fine.
///
/// # Errors
/// The system's.
pub fn set_aside(path: &Path, aside: &Path) -> Result<(), DatasetError> {
    if !path.exists() {
        return Ok(());
    }
    make_folder(aside)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut target = aside.join(&*name);
    for number in 2.. {
        if !target.exists() {
            break;
        }
        target = aside.join(format!("{name}.{number}"));
    }
    rename(path, &target)
}
