//! Reads a dataset, also one that is still being written.

use std::fs;
use std::path::{Path, PathBuf};

use super::columns::{ColumnDescription, Columns, TableName};
use super::durable::failed_to;
use super::error::DatasetError;
use super::manifest::{Manifest, Part, TimingsManifest};
use super::parquet_file::visit_rows;
use crate::quantity::Cell;

/// A dataset as its manifests describe it at the time of opening; later parts are not seen.
#[derive(Debug)]
pub struct DatasetReader {
    folder: PathBuf,
    manifest: Manifest,
    timings: TimingsManifest,
    columns: [Vec<ColumnDescription>; 3],
}

impl DatasetReader {
    /// Reads the manifests.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`], [`DatasetError::Version`],
    /// [`DatasetError::DuplicateColumn`] or the system's.
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        // In this order: `timings.json` may be ahead of the manifest, never behind.
        let manifest = Manifest::read(folder)?;
        let timings = TimingsManifest::read(folder)?;
        let columns = Columns::new(&manifest.study)?;
        Ok(Self {
            folder: folder.to_owned(),
            manifest,
            timings,
            columns: TableName::ALL.map(|table| columns.describe(table)),
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
        let [runs, blows, timings] = &self.columns;
        match table {
            TableName::Runs => runs,
            TableName::Blows => blows,
            TableName::Timings => timings,
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
        }
    }

    /// Calls `visit` for every row of a table, in order, with the values of the named columns in the order named.
    ///
    /// Memory is bounded by one batch of rows.
    ///
    /// # Errors
    /// [`DatasetError::UnknownColumn`], [`DatasetError::Damaged`], the Parquet library's or the system's.
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
            visit_rows(&self.folder.join(&part.file), &columns, &mut visit)?;
        }
        Ok(())
    }

    /// Compares every part's length and checksum with the manifests; returns what is damaged, in the manifests' order.
    ///
    /// Each entry is a [`DatasetError::Damaged`] or [`DatasetError::Io`] that names the file.
    pub fn damage(&self) -> Vec<DatasetError> {
        let tables = TableName::ALL.into_iter();
        let parts = tables.flat_map(|table| self.parts(table));
        parts.filter_map(|part| check_part(&self.folder, part).err()).collect()
    }
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
