//! Writes a dataset part by part; what is in place is whole.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::columns::{BlowRecord, Column, Columns, TableName};
use super::durable::{StagedFile, failed_to, sync_folder};
use super::manifest::{MANIFEST_NAME, Manifest, Part, TIMINGS_NAME, TimingsManifest, part_file, to_json};
use super::parquet_file::encode;
use super::{DatasetError, DatasetInfo, RowRecord};

/// Folder for files that are not yet in place, on the same file system as the tables.
const STAGING: &str = ".staging";

/// What to do if the folder already holds a dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Refuse with [`DatasetError::Exists`].
    Refuse,
    /// Remove the dataset's tables and manifests (nothing else), then start anew.
    Replace,
}

/// Writes the rows of a study in ascending order.
///
/// Memory is bounded: at most [`DatasetInfo::rows_per_part`] records are held. If the writer is dropped without
/// [`DatasetWriter::finish`], the parts in place and the manifest stay valid, the rows of the unfinished part are lost.
pub struct DatasetWriter {
    folder: PathBuf,
    columns: Columns,
    manifest: Manifest,
    timings: TimingsManifest,
    pending: Vec<RowRecord>,
    next_row: u64,
}

impl DatasetWriter {
    /// Creates the dataset's folder, its table folders and manifests.
    ///
    /// # Errors
    /// [`DatasetError::Exists`] if there is a dataset and `existing` is [`Existing::Refuse`];
    /// [`DatasetError::Occupied`] if the folder holds something else; [`DatasetError::DuplicateColumn`];
    /// [`DatasetError::Setting`] if there are no rows per part; the system's. Names and settings are checked before
    /// anything is written or removed.
    pub fn create(folder: &Path, info: &DatasetInfo, existing: Existing) -> Result<Self, DatasetError> {
        let columns = Columns::new(info)?;
        if info.rows_per_part == 0 {
            return Err(DatasetError::Setting { key: "rows_per_part", found: 0, expected: "at least 1" });
        }
        make_way(folder, existing)?;
        for name in TableName::ALL.map(TableName::folder).into_iter().chain([STAGING]) {
            let path = folder.join(name);
            fs::create_dir_all(&path).map_err(failed_to("create", &path))?;
        }
        let writer = Self {
            folder: folder.to_owned(),
            columns,
            manifest: Manifest::new(info.clone()),
            timings: TimingsManifest::default(),
            pending: Vec::new(),
            next_row: 0,
        };
        let files = writer.stage_manifests(&writer.manifest, &writer.timings)?;
        writer.put_in_place(files)?;
        Ok(writer)
    }

    /// Takes one row; writes a part when its block of rows is over.
    ///
    /// Rows may be left out, but must ascend.
    ///
    /// # Errors
    /// [`DatasetError::RowOrder`], [`DatasetError::Record`] (the row is not taken then), the system's or the Parquet
    /// library's (what is in place stays valid, the rows of the part are still held).
    pub fn write(&mut self, record: RowRecord) -> Result<(), DatasetError> {
        let info = &self.manifest.study;
        if record.row < self.next_row || record.row >= info.rows {
            return Err(DatasetError::RowOrder {
                row: record.row,
                expected_from: self.next_row,
                expected_end: info.rows,
            });
        }
        check_record(info, &record)?;
        let block = |row: u64| row / info.rows_per_part;
        let opens_block = (self.pending.first()).is_some_and(|first| block(first.row) != block(record.row));
        let ends_block = record.row + 1 == info.rows || block(record.row) != block(record.row + 1);
        if opens_block {
            self.flush()?;
        }
        self.next_row = record.row + 1;
        self.pending.push(record);
        if ends_block {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes the last part, removes the staging folder and returns the manifest.
    ///
    /// The manifest says whether the dataset has all rows of its design.
    ///
    /// # Errors
    /// The system's or the Parquet library's.
    pub fn finish(mut self) -> Result<Manifest, DatasetError> {
        self.flush()?;
        let staging = self.folder.join(STAGING);
        fs::remove_dir_all(&staging).map_err(failed_to("remove", &staging))?;
        Ok(self.manifest.clone())
    }

    /// Stages all files of a part and the manifests, then puts them in place.
    fn flush(&mut self) -> Result<(), DatasetError> {
        let Some(first) = self.pending.first() else {
            return Ok(());
        };
        let per_part = self.manifest.study.rows_per_part;
        let first_row = first.row / per_part * per_part;
        let blows = blow_records(&self.pending);
        let (timings_part, timings_file) =
            self.stage_part(TableName::Timings, &self.columns.timings, (first_row, &self.pending))?;
        let (blows_part, blows_file) = self.stage_part(TableName::Blows, &self.columns.blows, (first_row, &blows))?;
        let (runs_part, runs_file) =
            self.stage_part(TableName::Runs, &self.columns.runs, (first_row, &self.pending))?;

        let (mut manifest, mut timings) = (self.manifest.clone(), self.timings.clone());
        self.pending.iter().for_each(|record| manifest.add_row(record.row));
        timings.timings.push(timings_part);
        manifest.blows.push(blows_part);
        manifest.runs.push(runs_part);
        // Runs last: a run that a reader sees has its blows.
        let mut files = vec![
            (TableName::Timings.folder(), timings_file),
            (TableName::Blows.folder(), blows_file),
            (TableName::Runs.folder(), runs_file),
        ];
        files.extend(self.stage_manifests(&manifest, &timings)?);
        self.put_in_place(files)?;
        (self.manifest, self.timings) = (manifest, timings);
        self.pending.clear();
        Ok(())
    }

    /// Stages one table's file of a part, given the part's first row and the items.
    fn stage_part<T>(
        &self,
        table: TableName,
        columns: &[Column<T>],
        (first_row, items): (u64, &[T]),
    ) -> Result<(Part, StagedFile), DatasetError> {
        let file = part_file(table, first_row);
        let target = self.folder.join(&file);
        let bytes = encode(table, &self.manifest.study, columns, items)
            .map_err(|source| DatasetError::Parquet { path: target.clone(), source })?;
        let part = Part {
            file,
            first_row,
            records: items.len() as u64,
            bytes: bytes.len() as u64,
            blake3: blake3::hash(&bytes).to_hex().to_string(),
        };
        Ok((part, StagedFile::write(&self.folder.join(STAGING), &target, &bytes)?))
    }

    fn stage_manifests(
        &self,
        manifest: &Manifest,
        timings: &TimingsManifest,
    ) -> Result<Vec<(&'static str, StagedFile)>, DatasetError> {
        let staging = self.folder.join(STAGING);
        let manifest_path = self.folder.join(MANIFEST_NAME);
        let timings_path = self.folder.join(TIMINGS_NAME);
        let timings_file = StagedFile::write(&staging, &timings_path, &to_json(timings, &timings_path)?)?;
        let manifest_file = StagedFile::write(&staging, &manifest_path, &to_json(manifest, &manifest_path)?)?;
        Ok(vec![("", timings_file), ("", manifest_file)])
    }

    /// Renames files into place in their order, each with the folder (below the dataset's) to sync after it.
    fn put_in_place(&self, files: Vec<(&'static str, StagedFile)>) -> Result<(), DatasetError> {
        for (folder, file) in files {
            file.put_in_place()?;
            sync_folder(&self.folder.join(folder))?;
        }
        Ok(())
    }
}

impl Drop for DatasetWriter {
    fn drop(&mut self) {
        // Only unfinished files are in there. Failing to remove them harms no reader, and drop cannot report.
        let _ = fs::remove_dir_all(self.folder.join(STAGING));
    }
}

/// Makes sure that the dataset can be created: an absent or empty folder, or one whose dataset may be replaced.
fn make_way(folder: &Path, existing: Existing) -> Result<(), DatasetError> {
    if is_vacant(folder)? {
        return Ok(());
    }
    let manifest = match (Manifest::read(folder), existing) {
        (Ok(manifest), _) => Some(manifest),
        // Whoever asks for replacement of a damaged dataset, or one of another version, gets it.
        (Err(DatasetError::Version { .. }), Existing::Replace) => None,
        (Err(error @ DatasetError::Version { .. }), Existing::Refuse) => return Err(error),
        (Err(_), _) => {
            return Err(DatasetError::Occupied { path: folder.to_owned() });
        }
    };
    match (manifest, existing) {
        (Some(manifest), Existing::Refuse) => Err(DatasetError::Exists {
            path: folder.to_owned(),
            study: manifest.study.study_name,
            rows_done: manifest.rows_done,
            rows: manifest.study.rows,
        }),
        _ => remove_dataset(folder),
    }
}

/// Whether a folder is absent, empty, or holds only the empty folders of a dataset whose creation was interrupted.
fn is_vacant(folder: &Path) -> Result<bool, DatasetError> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(failed_to("open the folder", folder)(error)),
    };
    for entry in entries {
        let entry = entry.map_err(failed_to("read the folder", folder))?;
        let name = entry.file_name();
        let is_table = TableName::ALL.iter().any(|table| name == table.folder());
        let is_empty = |path: &Path| fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none());
        if name != STAGING && !(is_table && is_empty(&entry.path())) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Removes what a dataset consists of; the manifest goes last, so that an interrupted removal can be repeated.
fn remove_dataset(folder: &Path) -> Result<(), DatasetError> {
    let absent_is_fine = |result: io::Result<()>, path: &Path| match result {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(failed_to("remove", path)(error)),
        _ => Ok(()),
    };
    for name in TableName::ALL.map(TableName::folder).into_iter().chain([STAGING]) {
        let path = folder.join(name);
        absent_is_fine(fs::remove_dir_all(&path), &path)?;
    }
    for name in [TIMINGS_NAME, MANIFEST_NAME] {
        let path = folder.join(name);
        absent_is_fine(fs::remove_file(&path), &path)?;
    }
    Ok(())
}

fn blow_records(records: &[RowRecord]) -> Vec<BlowRecord> {
    let mut blows = Vec::new();
    for record in records {
        let of_row = record.outcome.metrics.iter().flat_map(|metrics| &metrics.blows);
        blows.extend(of_row.map(|blow| BlowRecord { row: record.row, blow: blow.clone() }));
    }
    blows
}

/// Holds a record to the shape that the columns were made for: a value without column would be lost silently.
fn check_record(info: &DatasetInfo, record: &RowRecord) -> Result<(), DatasetError> {
    let misfit = |what: &str, found: String, expected: String| {
        Err(DatasetError::Record { row: record.row, what: what.to_owned(), found, expected })
    };
    let count = |what: &str, found: usize, expected: usize| match found == expected {
        true => Ok(()),
        false => misfit(what, found.to_string(), expected.to_string()),
    };
    count("number of factors", record.factors.len(), info.factors.len())?;
    for (value, factor) in record.factors.iter().zip(&info.factors) {
        if value.kind() != factor.kind {
            let what = format!("type of factor `{}`", factor.name);
            return misfit(&what, format!("{:?}", value.kind()), format!("{:?}", factor.kind));
        }
    }
    let Some(metrics) = &record.outcome.metrics else {
        return Ok(());
    };
    count("number of hammers", metrics.hammers.len(), info.hammers.len())?;
    count("number of castings", metrics.castings.len(), info.castings.len())?;
    if let Some(blow) = metrics.blows.iter().find(|blow| blow.hammer >= info.hammers.len()) {
        return misfit("index of a blow's hammer", blow.hammer.to_string(), format!("below {}", info.hammers.len()));
    }
    if let Some(blow) = metrics.blows.iter().find(|blow| blow.casting >= info.castings.len()) {
        return misfit("index of a blow's casting", blow.casting.to_string(), format!("below {}", info.castings.len()));
    }
    Ok(())
}
