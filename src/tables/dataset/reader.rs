//! Reads a dataset, also one that is still being written.

use std::fs;
use std::path::{Path, PathBuf};

use super::column::ColumnDescription;
use super::columns::{Columns, TableName};
use super::durable::failed_to;
use super::error::DatasetError;
use super::manifest::{Manifest, Part, TimingsManifest, fingerprint};
use super::parquet_file::{Opened, visit_opened};
use super::rebuild::{strays, timings_of_parts};
use crate::quantity::Cell;

/// A dataset as its manifests describe it at the time of opening; later parts are not seen.
#[derive(Debug)]
pub struct DatasetReader {
    folder: PathBuf,
    manifest: Manifest,
    timings: TimingsManifest,
    columns: [Vec<ColumnDescription>; 4],
}

impl DatasetReader {
    /// Reads the manifests.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`], [`DatasetError::Seal`], [`DatasetError::Version`],
    /// [`DatasetError::DuplicateColumn`] or the system's. Timings that are lost are no error, see [`DatasetReader::damage`].
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        // In this order: `timings.json` may be ahead of the manifest, never behind.
        let manifest = Manifest::read(folder)?;
        let timings = match TimingsManifest::read(folder) {
            Err(error) if error.is_lost_manifest() => timings_of_parts(folder, &manifest)?,
            found => found?,
        };
        let columns = Columns::new(&manifest.study)?;
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
    pub fn parts(&self, table: TableName) -> &[Part] {
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
    /// Memory is bounded by one batch of rows.
    ///
    /// # Errors
    /// [`DatasetError::UnknownColumn`], [`DatasetError::Replaced`], [`DatasetError::Damaged`], the Parquet library's or the system's.
    pub fn visit(
        &self,
        table: TableName,
        names: &[&str],
        mut visit: impl FnMut(&[Cell<'_>]),
    ) -> Result<(), DatasetError> {
        let mut columns = Vec::with_capacity(names.len());
        for name in names {
            columns.push(self.column(table, name)?.clone());
        }
        for part in self.parts(table) {
            let path = self.folder.join(&part.file);
            visit_opened(
                open_part(&self.folder, &path, &self.manifest.study.study_hash)?,
                &path,
                &columns,
                &mut visit,
            )?;
        }
        Ok(())
    }

    /// Compares every part's length and checksum with the manifests; returns what is damaged, in the manifests' order.
    ///
    /// Each entry names the file. A `timings.json` that is lost and files that are no parts come first.
    pub fn damage(&self) -> Vec<DatasetError> {
        let mut found: Vec<DatasetError> = TimingsManifest::read(&self.folder).err().into_iter().collect();
        found.extend(self.strays());
        found.extend(TableName::KNOWN.into_iter().flat_map(|table| self.damage_of(table)));
        found
    }

    /// What can be said without reading the parts: files that are no parts, parts that are gone or of another length.
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

    /// Files in the tables' folders that are no parts of the dataset, but that readers of the whole folder read too.
    pub fn strays(&self) -> Vec<DatasetError> {
        strays(&self.folder, &self.manifest).unwrap_or_else(|error| vec![error])
    }

    /// The same of one table's parts.
    pub fn damage_of(&self, table: TableName) -> impl Iterator<Item = DatasetError> {
        self.parts(table).iter().filter_map(|part| check_part(&self.folder, part).err())
    }
}

/// Opens a part of the dataset in `folder`, which was of the study with this hash when it was opened: the names of parts are those of
/// any study's.
///
/// # Errors
/// [`DatasetError::Replaced`], [`DatasetError::Damaged`], the Parquet library's or the system's.
pub fn open_part(folder: &Path, path: &Path, study_hash: &str) -> Result<Opened, DatasetError> {
    let opened = Opened::new(path);
    if opened.as_ref().is_ok_and(|part| part.is_of(study_hash)) {
        return opened;
    }
    // Only now is it worth reading the manifest again.
    if Manifest::read(folder).is_ok_and(|now| now.study.study_hash != study_hash) {
        return Err(DatasetError::Replaced { path: folder.to_owned() });
    }
    opened.and(Err(DatasetError::Damaged {
        path: path.to_owned(),
        found: "the hash of another study in its metadata".to_owned(),
        expected: format!("{study_hash}, that of the manifest's study"),
    }))
}

/// Compares a part's length and checksum with the manifest's.
///
/// # Errors
/// [`DatasetError::Damaged`] or the system's.
pub fn check_part(folder: &Path, part: &Part) -> Result<(), DatasetError> {
    let path = folder.join(&part.file);
    let (bytes, hash) = fingerprint(&path)?;
    if bytes == part.bytes && hash == part.blake3 {
        return Ok(());
    }
    Err(DatasetError::Damaged {
        path,
        found: format!("{bytes} bytes, BLAKE3 {hash}"),
        expected: format!("{} bytes, BLAKE3 {}", part.bytes, part.blake3),
    })
}
