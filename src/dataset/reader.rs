//! Reads a dataset, also one that is still being written.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::column::ColumnDescription;
use super::columns::{Columns, TableName};
use super::consistency::check_manifests;
use super::durable::failed_to;
use super::error::DatasetError;
use super::lock::Lock;
use super::manifest::{MANIFEST_NAME, Manifest, TablePart, TimingsManifest, find, fingerprint, part_file, read_bytes};
use super::parquet_file::Opened;
use super::rebuild::{strays, timings_of_parts};
use decore_quantity::Cell;

/// A dataset as its manifests describe it at the time of opening; later parts are not seen.
#[derive(Debug)]
pub struct DatasetReader {
    folder: PathBuf,
    manifest: Manifest,
    timings: TimingsManifest,
    columns: [Vec<ColumnDescription>; 4],
}

impl DatasetReader {
    /// Reads the manifests and compares them with their own checksums.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`], [`DatasetError::Seal`], [`DatasetError::Version`],
    /// [`DatasetError::Columns`], [`DatasetError::Damaged`] for parts that are listed twice, leave a gap or do not add up,
    /// [`DatasetError::DuplicateColumn`], or a system error. Lost timings are an error only where they are read.
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        // In this order: `timings.json` may be ahead of the manifest, never behind.
        let manifest = Manifest::read(folder)?;
        let mut timings = match TimingsManifest::read(folder) {
            Err(error) if error.is_lost_manifest() => timings_of_parts(folder, &manifest)?,
            found => found?,
        };
        timings.timings.retain(|part| find(&manifest.runs, part.first_row).is_some());
        check_manifests(folder, &manifest, &timings)?;
        let columns = Columns::new(&manifest.study)?;
        let written = &manifest.study.columns_hash;
        if !written.is_empty() && *written != columns.hash() {
            let (path, written_by) = (folder.join(MANIFEST_NAME), manifest.study.program_version.clone());
            return Err(DatasetError::Columns { path, written_by });
        }
        Ok(Self {
            folder: folder.to_owned(),
            manifest,
            timings,
            columns: TableName::KNOWN.map(|table| columns.describe(table)),
        })
    }

    /// The dataset's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The columns of a table, in order.
    pub fn columns(&self, table: TableName) -> &[ColumnDescription] {
        let [runs, blows, timings, signals] = &self.columns;
        match table {
            TableName::Runs => runs,
            TableName::Blows => blows,
            TableName::Timings => timings,
            TableName::Signals => signals,
        }
    }

    /// The column of a table with this name.
    ///
    /// # Errors
    /// [`DatasetError::UnknownColumn`].
    pub fn column(&self, table: TableName, name: &str) -> Result<&ColumnDescription, DatasetError> {
        let columns = self.columns(table);
        let found = columns.iter().find(|column| column.name == name);
        found.ok_or_else(|| DatasetError::UnknownColumn {
            table: table.folder(),
            column: name.to_owned(),
            known: columns.iter().map(|column| column.name.clone()).collect(),
        })
    }

    /// The parts of a table, by first row.
    pub fn parts(&self, table: TableName) -> &[TablePart] {
        match table {
            TableName::Runs => &self.manifest.runs,
            TableName::Blows => &self.manifest.blows,
            TableName::Timings => &self.timings.timings,
            TableName::Signals => &self.manifest.signals,
        }
    }

    /// The tables that the dataset has.
    pub fn tables(&self) -> impl Iterator<Item = TableName> {
        TableName::KNOWN.into_iter().filter(|table| !self.columns(*table).is_empty())
    }

    /// Calls `visit` for every row of a table, in order, with the values of the named columns in the order named.
    ///
    /// Every part is compared with its length and checksum before a row of it is visited. Memory is bounded by one part.
    ///
    /// # Errors
    /// [`DatasetError::UnknownColumn`], [`DatasetError::Replaced`], [`DatasetError::Damaged`], [`DatasetError::Stray`], the
    /// Parquet library's or the system's.
    pub fn visit(
        &self,
        table: TableName,
        names: &[&str],
        mut visit: impl FnMut(&[Cell<'_>]),
    ) -> Result<(), DatasetError> {
        self.visit_parts((table, self.whole(table)?), names, &mut visit)
    }

    /// As [`DatasetReader::visit`], but reads only the part that a row of the design is in.
    ///
    /// # Errors
    /// As for [`DatasetReader::visit`].
    pub fn visit_block_of(
        &self,
        row: u64,
        (table, names): (TableName, &[&str]),
        mut visit: impl FnMut(&[Cell<'_>]),
    ) -> Result<(), DatasetError> {
        let parts = self.whole(table)?;
        let first = parts.partition_point(|part| part.first_row <= row).saturating_sub(1);
        self.visit_parts((table, parts.get(first..).and_then(|parts| parts.get(..1)).unwrap_or(&[])), names, &mut visit)
    }

    fn visit_parts(
        &self,
        (table, parts): (TableName, &[TablePart]),
        names: &[&str],
        visit: &mut dyn FnMut(&[Cell<'_>]),
    ) -> Result<(), DatasetError> {
        let mut columns = Vec::with_capacity(names.len());
        for name in names {
            columns.push(self.column(table, name)?.clone());
        }
        let opening = self.opening();
        parts.iter().try_for_each(|part| opening.open(part)?.visit(&columns, visit))
    }

    /// Returns the parts of a table for reading.
    ///
    /// # Errors
    /// [`DatasetError::Stray`] for a file in the tables' folders that is no part: whoever reads the whole folder takes its rows for
    /// the dataset's. [`DatasetError::Damaged`] for wall times without a part. [`DatasetError::Replaced`].
    pub(super) fn whole(&self, table: TableName) -> Result<&[TablePart], DatasetError> {
        let lost = || {
            let has_times = |runs: &&TablePart| {
                find(&self.timings.timings, runs.first_row).is_some_and(|times| times.records == runs.records)
            };
            self.manifest.runs.iter().find(|runs| !has_times(runs)).map(|runs| DatasetError::Damaged {
                path: self.folder.join(part_file(TableName::Timings, runs.first_row)),
                found: "no entry in timings.json".to_owned(),
                expected: format!("the wall times of {} rows from row {}", runs.records, runs.first_row),
            })
        };
        let fault = self.strays().into_iter().next().or_else(|| lost().filter(|_| table == TableName::Timings));
        fault.map_or(Ok(self.parts(table)), |fault| Err(self.opening().explain(fault, None)))
    }

    /// Opens the parts of the dataset as it was when it was opened itself.
    pub(super) fn opening(&self) -> Opening {
        Opening { folder: self.folder.clone(), study_hash: self.manifest.study.study_hash.clone() }
    }

    /// Faults that are visible without reading the parts: foreign files, missing parts and parts of another length.
    pub fn damage_at_a_glance(&self) -> Vec<DatasetError> {
        let parts = TableName::KNOWN.into_iter().flat_map(|table| self.parts(table));
        let odd = parts.filter_map(|part| {
            let path = self.folder.join(&part.file);
            let length = fs::metadata(&path).map(|data| data.len()).map_err(failed_to("look at", &path));
            match length {
                Ok(length) if length == part.bytes => None,
                Ok(length) => Some(DatasetError::Damaged {
                    path,
                    found: format!("{length} bytes"),
                    expected: format!("{} bytes", part.bytes),
                }),
                Err(error) => Some(error),
            }
        });
        self.strays().into_iter().chain(odd).collect()
    }

    /// Foreign files in the tables' folders, which readers of the whole folder would read too.
    pub fn strays(&self) -> Vec<DatasetError> {
        strays(&self.folder, &self.manifest).unwrap_or_else(|error| vec![error])
    }

    /// The parts of a table whose length or checksum is not the manifest's, in the manifest's order.
    pub fn damage_of(&self, table: TableName) -> impl Iterator<Item = DatasetError> {
        self.parts(table).iter().filter_map(|part| check_part(&self.folder, part).err())
    }
}

/// Opens parts of a dataset that may have changed since its manifests were read.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    folder: PathBuf,
    study_hash: String,
}

impl Opening {
    /// Opens a part as [`open_part`].
    ///
    /// # Errors
    /// [`DatasetError::Replaced`] if the dataset has changed or a sweep is writing it; else as for [`open_part`].
    pub fn open(&self, part: &TablePart) -> Result<Opened, DatasetError> {
        open_part(&self.folder, part).map_err(|error| self.explain(error, Some(part)))
    }

    /// The reason for a fault: the dataset is another one by now, or a part is being replaced. `part`: the one at fault.
    fn explain(&self, fault: DatasetError, part: Option<&TablePart>) -> DatasetError {
        let is_other = Manifest::read(&self.folder).is_ok_and(|now| {
            let is_listed = |part: &TablePart| match part.file.starts_with(TableName::Timings.folder()) {
                true => TimingsManifest::read(&self.folder).map_or(true, |now| now.timings.contains(part)),
                false => [&now.runs, &now.blows, &now.signals].iter().any(|parts| parts.contains(part)),
            };
            now.study.study_hash != self.study_hash || part.is_some_and(|part| !is_listed(part))
        });
        // A part comes into place before the manifest that lists it; a stray is one whoever writes.
        let may_change = !matches!(fault, DatasetError::Stray { .. });
        if is_other || (may_change && Lock::is_taken(&self.folder)) {
            return DatasetError::Replaced { path: self.folder.clone() };
        }
        fault
    }
}

/// Opens a part of the dataset in `folder`, and parses exactly the bytes whose length and checksum were compared.
///
/// # Errors
/// [`DatasetError::Damaged`], the Parquet library's or the system's.
pub fn open_part(folder: &Path, part: &TablePart) -> Result<Opened, DatasetError> {
    let path = folder.join(&part.file);
    let opened = Opened::new(path.clone(), checked_bytes(folder, part)?)?;
    match opened.records() {
        records if records == part.records => Ok(opened),
        records => Err(DatasetError::Damaged {
            path,
            found: format!("{records} records"),
            expected: format!("the {} records of the manifest", part.records),
        }),
    }
}

/// Compares a part's length and checksum with the manifest's.
///
/// # Errors
/// [`DatasetError::Damaged`] or the system's.
pub fn check_part(folder: &Path, part: &TablePart) -> Result<(), DatasetError> {
    checked_bytes(folder, part).map(drop)
}

/// The bytes of a part, if they have the length and the checksum of the manifest.
fn checked_bytes(folder: &Path, part: &TablePart) -> Result<Vec<u8>, DatasetError> {
    let path = folder.join(&part.file);
    let expected = || format!("{} bytes, BLAKE3 {}", part.bytes, part.blake3);
    let bytes = match read_bytes(&path) {
        Err(DatasetError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
            return Err(DatasetError::Damaged {
                path,
                found: "there is no such file".to_owned(),
                expected: expected(),
            });
        }
        bytes => bytes?,
    };
    let (length, hash) = fingerprint(&bytes);
    if length == part.bytes && hash == part.blake3 {
        return Ok(bytes);
    }
    Err(DatasetError::Damaged { path, found: format!("{length} bytes, BLAKE3 {hash}"), expected: expected() })
}
