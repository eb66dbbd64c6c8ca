//! The manifests of a dataset: what it is of, which rows it has, which parts with which checksums.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::TableName;
use super::durable::failed_to;
use super::{DatasetError, DatasetInfo};

/// Version of the folder's layout and of the manifests.
pub const FORMAT_VERSION: u32 = 1;
/// Name of the manifest in the dataset's folder.
pub const MANIFEST_NAME: &str = "manifest.json";
/// Name of the timings' manifest in the dataset's folder.
pub const TIMINGS_NAME: &str = "timings.json";

/// Consecutive rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct RowSpan {
    /// The first row.
    pub first: u64,
    /// One past the last row.
    pub end: u64,
}

/// One file of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Path below the dataset's folder, with forward slashes.
    pub file: String,
    /// First row index of the block that the part is for.
    pub first_row: u64,
    /// Rows of the table in the file (blows, in the table of blows).
    pub records: u64,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// BLAKE3 of the file, in hexadecimal.
    pub blake3: String,
}

/// `manifest.json`: byte-identical for any number of threads.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the layout.
    pub format_version: u32,
    /// Whether all rows of the design are there.
    pub complete: bool,
    /// Number of rows that are there, whatever their status.
    pub rows_done: u64,
    /// Which rows are there: ascending, with gaps between the spans.
    pub done: Vec<RowSpan>,
    /// What the dataset is of.
    pub study: DatasetInfo,
    /// Parts of the table of runs, by first row.
    pub runs: Vec<Part>,
    /// Parts of the table of blows, by first row.
    pub blows: Vec<Part>,
}

impl Manifest {
    /// The manifest of a dataset without rows.
    pub fn new(study: DatasetInfo) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            complete: study.rows == 0,
            rows_done: 0,
            done: Vec::new(),
            study,
            runs: Vec::new(),
            blows: Vec::new(),
        }
    }

    /// Notes a row that is there; rows come in ascending order.
    pub fn add_row(&mut self, row: u64) {
        self.rows_done += 1;
        match self.done.last_mut() {
            Some(span) if span.end == row => span.end += 1,
            _ => self.done.push(RowSpan { first: row, end: row + 1 }),
        }
        self.complete = self.rows_done == self.study.rows;
    }

    /// Reads the manifest of the dataset in `folder`.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`], [`DatasetError::Version`] or the system's.
    pub fn read(folder: &Path) -> Result<Self, DatasetError> {
        /// The version alone: another version may have other keys.
        #[derive(Deserialize)]
        struct VersionOnly {
            format_version: u32,
        }
        let path = folder.join(MANIFEST_NAME);
        let text = read_text(&path, folder)?;
        let version: VersionOnly = parse(&text, &path)?;
        if version.format_version != FORMAT_VERSION {
            return Err(DatasetError::Version { path, found: version.format_version, expected: FORMAT_VERSION });
        }
        parse(&text, &path)
    }
}

/// `timings.json`: kept apart because wall times, and so the checksums, differ from run to run.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimingsManifest {
    /// Parts of the table of wall times, by first row.
    pub timings: Vec<Part>,
}

impl TimingsManifest {
    /// Reads the timings' manifest of the dataset in `folder`.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`] or the system's.
    pub fn read(folder: &Path) -> Result<Self, DatasetError> {
        let path = folder.join(TIMINGS_NAME);
        parse(&read_text(&path, folder)?, &path)
    }
}

/// Path of a part below the dataset's folder.
pub fn part_file(table: TableName, first_row: u64) -> String {
    let table = table.folder();
    format!("{table}/{table}-{first_row:012}.parquet")
}

/// A manifest's bytes.
///
/// # Errors
/// [`DatasetError::Manifest`], should a value not be writable as JSON.
pub fn to_json<T: Serialize>(manifest: &T, path: &Path) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = serde_json::to_vec_pretty(manifest)
        .map_err(|source| DatasetError::Manifest { path: path.to_owned(), source })?;
    bytes.push(b'\n');
    Ok(bytes)
}

fn read_text(path: &Path, folder: &Path) -> Result<String, DatasetError> {
    fs::read_to_string(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => DatasetError::Missing { path: folder.to_owned() },
        _ => failed_to("read", path)(source),
    })
}

fn parse<T: for<'de> Deserialize<'de>>(text: &str, path: &Path) -> Result<T, DatasetError> {
    serde_json::from_str(text).map_err(|source| DatasetError::Manifest { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::{Manifest, RowSpan};
    use crate::dataset::DatasetInfo;

    #[test]
    fn rows_done_are_spans() {
        let mut manifest = Manifest::new(DatasetInfo {
            study_name: String::new(),
            study_text: String::new(),
            study_hash: String::new(),
            seed: 0,
            program_version: String::new(),
            rows: 5,
            rows_per_part: 64,
            factors: Vec::new(),
            hammers: Vec::new(),
            castings: Vec::new(),
        });
        for row in [0, 1, 3] {
            manifest.add_row(row);
        }
        let spans = [RowSpan { first: 0, end: 2 }, RowSpan { first: 3, end: 4 }];
        assert_eq!(manifest.done, spans);
        assert!(!manifest.complete);
        manifest.add_row(4);
        assert_eq!((manifest.rows_done, manifest.complete), (4, false));
    }
}
