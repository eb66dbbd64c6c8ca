//! Manifests of a dataset: its study, rows and parts, with checksums.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::TableName;
use super::durable::failed_to;
use super::error::DatasetError;
use super::info::DatasetInfo;
use decore_files::{Limit, read};

/// Version of the folder's layout, of the manifests and of the columns' meanings. 3: outputs defined again (struck and blank
/// blows, strokes, whole-run work, scatter). 4: manifests end with their checksum. 5: categories have dictionaries. 6: contacts
/// counted apart in time, standard errors and scatter defined again, the ledger of the castings.
pub const FORMAT_VERSION: u32 = 6;
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

/// Rows that were to be run with other budgets than the study's: an entry for each set of changes, whatever number of runs it took.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rerun {
    /// Changed settings, a sentence each.
    pub changed: Vec<String>,
    /// The rows: ascending, with gaps between the spans.
    pub rows: Vec<RowSpan>,
}

/// One file of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TablePart {
    /// Path below the dataset's folder, with forward slashes.
    pub file: String,
    /// First row index of the block that the part is for.
    pub first_row: u64,
    /// Rows of the table in the file (blows, in the table of blows).
    pub records: u64,
    /// Rows of the design in the block that are not done (audit failed, invalid, diverged, budget exhausted).
    pub failed: u64,
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
    /// Whether all rows of [`Manifest::range`] exist.
    pub complete: bool,
    /// Rows of the complete dataset: all rows of the design, or of a shard.
    pub range: RowSpan,
    /// Number of existing rows with any status.
    pub rows_done: u64,
    /// Existing rows: ascending spans with gaps between them.
    pub done: Vec<RowSpan>,
    /// The dataset's study.
    pub study: DatasetInfo,
    /// Rows that were to be run with other budgets than the study's, in the order in which the changes were first asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reruns: Vec<Rerun>,
    /// Parts of the table of runs, by first row.
    pub runs: Vec<TablePart>,
    /// Parts of the table of blows, by first row.
    pub blows: Vec<TablePart>,
    /// Parts of the table of signals, by first row; none if the study keeps no signals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<TablePart>,
}

/// The parts of one block that depend on the study alone.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlockFiles {
    /// Of the table of runs.
    pub runs: TablePart,
    /// Of the table of blows.
    pub blows: TablePart,
    /// Of the table of signals, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signals: Option<TablePart>,
}

impl RowSpan {
    /// Number of rows.
    pub fn len(self) -> u64 {
        self.end.saturating_sub(self.first)
    }

    /// Whether there are none.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Rows that are in both.
    pub fn intersection(self, other: Self) -> Self {
        Self { first: self.first.max(other.first), end: self.end.min(other.end) }
    }
}

/// The rows that are in any of `spans`: ascending, with gaps between the spans.
pub fn union(spans: impl IntoIterator<Item = RowSpan>) -> Vec<RowSpan> {
    let mut spans: Vec<RowSpan> = spans.into_iter().filter(|span| !span.is_empty()).collect();
    spans.sort_unstable_by_key(|span| span.first);
    let mut merged: Vec<RowSpan> = Vec::new();
    for span in spans {
        match merged.last_mut() {
            Some(last) if last.end >= span.first => last.end = last.end.max(span.end),
            _ => merged.push(span),
        }
    }
    merged
}

/// The rows of `whole` that are in none of `spans`, which ascend.
pub fn gaps(whole: RowSpan, spans: &[RowSpan]) -> Vec<RowSpan> {
    let mut found = Vec::new();
    let mut next = whole.first;
    for span in spans {
        found.push(RowSpan { first: next, end: span.first.min(whole.end) });
        next = next.max(span.end);
    }
    found.push(RowSpan { first: next, end: whole.end });
    found.retain(|span| !span.is_empty());
    found
}

impl Manifest {
    /// Manifest of an empty dataset for the rows of `range`.
    pub fn new(study: DatasetInfo, range: RowSpan) -> Self {
        let mut manifest = Self {
            format_version: FORMAT_VERSION,
            complete: false,
            range,
            rows_done: 0,
            done: Vec::new(),
            study,
            reruns: Vec::new(),
            runs: Vec::new(),
            blows: Vec::new(),
            signals: Vec::new(),
        };
        manifest.count();
        manifest
    }

    /// Number of existing rows that are not done (audit failed, invalid, diverged, budget exhausted).
    pub fn rows_failed(&self) -> u64 {
        self.runs.iter().map(|part| part.failed).sum()
    }

    /// Whether a row exists.
    pub fn has(&self, row: u64) -> bool {
        let before = self.done.partition_point(|span| span.first <= row);
        before.checked_sub(1).and_then(|index| self.done.get(index)).is_some_and(|span| row < span.end)
    }

    /// The block of rows that begins at `first_row`.
    pub fn block(&self, first_row: u64) -> RowSpan {
        RowSpan { first: first_row, end: first_row.saturating_add(self.study.rows_per_part) }
    }

    /// Existing rows of the block that begins at `first_row`.
    pub fn rows_of(&self, first_row: u64) -> Vec<RowSpan> {
        let block = self.block(first_row);
        self.done.iter().map(|span| span.intersection(block)).filter(|span| !span.is_empty()).collect()
    }

    /// The parts of the block that begins at `first_row`; `None` unless all are there that the dataset's tables ask for.
    pub fn files(&self, first_row: u64) -> Option<BlockFiles> {
        let part = |parts| find(parts, first_row).cloned();
        let files = BlockFiles { runs: part(&self.runs)?, blows: part(&self.blows)?, signals: part(&self.signals) };
        (files.signals.is_some() || self.study.signals.is_empty()).then_some(files)
    }

    /// Records rows to run with other budgets. Recording them again changes nothing: a repeated run leaves the manifest unchanged.
    pub fn note_rerun(&mut self, rerun: Rerun) {
        match self.reruns.iter_mut().find(|known| known.changed == rerun.changed) {
            Some(known) => known.rows = union(known.rows.drain(..).chain(rerun.rows)),
            None => self.reruns.push(Rerun { rows: union(rerun.rows), ..rerun }),
        }
    }

    /// Forgets the rows and parts of a block.
    pub fn remove_block(&mut self, first_row: u64) {
        let block = self.block(first_row);
        let split = |span: &RowSpan| gaps(*span, &[block]);
        self.done = self.done.iter().flat_map(split).collect();
        self.runs.retain(|part| part.first_row != first_row);
        self.blows.retain(|part| part.first_row != first_row);
        self.signals.retain(|part| part.first_row != first_row);
        self.count();
    }

    /// Records the ascending `rows` of a block and its parts, and replaces the block's earlier entry.
    pub fn put_block(&mut self, rows: impl Iterator<Item = u64>, files: BlockFiles) {
        let BlockFiles { runs, blows, signals } = files;
        self.remove_block(runs.first_row);
        self.done = union(self.done.drain(..).chain(rows.map(|row| RowSpan { first: row, end: row + 1 })));
        insert(&mut self.runs, runs);
        insert(&mut self.blows, blows);
        signals.into_iter().for_each(|part| insert(&mut self.signals, part));
        self.count();
    }

    fn count(&mut self) {
        self.rows_done = self.done.iter().map(|span| span.len()).sum();
        self.complete = self.rows_done == self.range.len();
    }

    /// Reads the manifest of the dataset in `folder`.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`], [`DatasetError::Seal`], [`DatasetError::Version`] or the
    /// system's.
    pub fn read(folder: &Path) -> Result<Self, DatasetError> {
        Self::read_file(&folder.join(MANIFEST_NAME), folder)
    }

    /// Reads a manifest of the dataset in `folder` from another file than its own.
    ///
    /// # Errors
    /// As [`Manifest::read`].
    pub(super) fn read_file(path: &Path, folder: &Path) -> Result<Self, DatasetError> {
        /// The version alone: another version may have other keys.
        #[derive(Deserialize)]
        struct VersionOnly {
            format_version: u32,
        }
        let text = read_text(path, folder)?;
        let version: VersionOnly = parse(&text, path)?;
        // Older versions have no seal. With a broken seal not even the version is certain.
        if version.format_version != FORMAT_VERSION && (is_sealed(&text) || !text.contains(SEAL)) {
            let path = path.to_owned();
            return Err(DatasetError::Version { path, found: version.format_version, expected: FORMAT_VERSION });
        }
        parse_sealed(&text, path)
    }
}

/// `timings.json`: kept apart because wall times, and so the checksums, differ from run to run.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimingsManifest {
    /// Parts of the table of wall times, by first row.
    pub timings: Vec<TablePart>,
}

impl TimingsManifest {
    /// Notes a part in place of the one of its block.
    pub fn put(&mut self, part: TablePart) {
        self.timings.retain(|known| known.first_row != part.first_row);
        insert(&mut self.timings, part);
    }

    /// Reads the timings' manifest of the dataset in `folder`.
    ///
    /// # Errors
    /// [`DatasetError::Missing`], [`DatasetError::Manifest`], [`DatasetError::Seal`] or the system's.
    pub fn read(folder: &Path) -> Result<Self, DatasetError> {
        let path = folder.join(TIMINGS_NAME);
        parse_sealed(&read_text(&path, folder)?, &path)
    }
}

/// Inserts a part by its first row.
fn insert(parts: &mut Vec<TablePart>, part: TablePart) {
    let at = parts.partition_point(|known| known.first_row < part.first_row);
    parts.insert(at, part);
}

/// The part of a block.
pub fn find(parts: &[TablePart], first_row: u64) -> Option<&TablePart> {
    parts.iter().find(|part| part.first_row == first_row)
}

/// Path of a part below the dataset's folder.
pub fn part_file(table: TableName, first_row: u64) -> String {
    let table = table.folder();
    format!("{table}/{table}-{first_row:012}.parquet")
}

/// The first row of the block whose part of `table` has this file name.
pub fn part_first_row(table: TableName, name: &str) -> Option<u64> {
    let digits = name.strip_prefix(table.folder())?.strip_prefix('-')?.strip_suffix(".parquet")?;
    let first_row = digits.parse().ok()?;
    // The one way to write it: a copy by another name is no part.
    (part_file(table, first_row).rsplit('/').next() == Some(name)).then_some(first_row)
}

/// Text between a manifest's contents and their BLAKE3 checksum.
const SEAL: &str = ",\n  \"checksum\": \"";

/// A manifest's bytes: JSON whose last key is the BLAKE3 of all bytes before that key.
///
/// # Errors
/// As [`to_json`].
pub fn to_sealed_json<T: Serialize>(manifest: &T, path: &Path) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = to_json(manifest, path)?;
    bytes.truncate(bytes.trim_ascii_end().len() - "\n}".len());
    let end = format!("{SEAL}{}\"\n}}\n", blake3::hash(&bytes).to_hex());
    bytes.extend(end.as_bytes());
    Ok(bytes)
}

/// Whether [`to_sealed_json`] wrote a text.
fn is_sealed(text: &str) -> bool {
    let contents = text.rsplit_once(SEAL);
    contents.is_some_and(|(body, end)| end == format!("{}\"\n}}\n", blake3::hash(body.as_bytes()).to_hex()))
}

fn parse_sealed<T: for<'de> Deserialize<'de>>(text: &str, path: &Path) -> Result<T, DatasetError> {
    let parsed = parse(text, path)?;
    if is_sealed(text) { Ok(parsed) } else { Err(DatasetError::Seal { path: path.to_owned() }) }
}

/// Reads a value from a text of [`to_sealed_json`], or from a text without a checksum of an earlier program.
///
/// # Errors
/// [`DatasetError::Manifest`] or [`DatasetError::Seal`].
pub fn from_sealed_json<T: for<'de> Deserialize<'de>>(bytes: &[u8], path: &Path) -> Result<T, DatasetError> {
    let seal = || DatasetError::Seal { path: path.to_owned() };
    let text = std::str::from_utf8(bytes).map_err(|_| seal())?;
    if text.contains(SEAL) { parse_sealed(text, path) } else { parse(text, path) }
}

/// A value as JSON in lines.
///
/// # Errors
/// [`DatasetError::Manifest`], should a value not be writable as JSON.
pub fn to_json<T: Serialize>(manifest: &T, path: &Path) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = serde_json::to_vec_pretty(manifest)
        .map_err(|source| DatasetError::Manifest { path: path.to_owned(), source })?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// The bytes of a part's file.
///
/// # Errors
/// The system's.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, DatasetError> {
    read(path, Limit::PART).map_err(failed_to("read", path))
}

/// Length and checksum of a part's bytes.
pub fn fingerprint(bytes: &[u8]) -> (u64, String) {
    (bytes.len() as u64, blake3::hash(bytes).to_hex().to_string())
}

fn read_text(path: &Path, folder: &Path) -> Result<String, DatasetError> {
    let bytes = read(path, Limit::DATASET).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => DatasetError::Missing { path: folder.to_owned() },
        _ => failed_to("read", path)(source),
    })?;
    String::from_utf8(bytes).map_err(|_| DatasetError::Seal { path: path.to_owned() })
}

fn parse<T: for<'de> Deserialize<'de>>(text: &str, path: &Path) -> Result<T, DatasetError> {
    serde_json::from_str(text).map_err(|source| DatasetError::Manifest { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(first_row: u64, failed: u64) -> TablePart {
        TablePart { file: String::new(), first_row, records: 0, failed, bytes: 0, blake3: String::new() }
    }

    fn span(first: u64, end: u64) -> RowSpan {
        RowSpan { first, end }
    }

    fn files(part: TablePart) -> BlockFiles {
        BlockFiles { runs: part.clone(), blows: part, signals: None }
    }

    #[test]
    fn rows_done_are_spans_whatever_the_order_of_the_blocks() {
        let mut manifest =
            Manifest::new(DatasetInfo { rows: 10, rows_per_part: 4, ..DatasetInfo::empty() }, span(0, 10));
        manifest.put_block(4..8, files(part(4, 1)));
        manifest.put_block([0, 1, 3].into_iter(), files(part(0, 2)));
        assert_eq!(manifest.done, [span(0, 2), span(3, 8)]);
        assert_eq!((manifest.rows_done, manifest.rows_failed(), manifest.complete), (7, 3, false));
        assert_eq!(gaps(manifest.range, &manifest.done), [span(2, 3), span(8, 10)]);
        manifest.put_block(0..4, files(part(0, 0)));
        manifest.put_block(8..10, files(part(8, 0)));
        assert_eq!((manifest.done.as_slice(), manifest.complete), ([span(0, 10)].as_slice(), true));
        assert_eq!(manifest.runs.iter().map(|part| part.first_row).collect::<Vec<_>>(), [0, 4, 8]);
        manifest.remove_block(4);
        assert_eq!((manifest.done.as_slice(), manifest.complete), ([span(0, 4), span(8, 10)].as_slice(), false));
        assert_eq!(manifest.runs.len(), 2);
    }

    #[test]
    fn rows_run_again_are_noted_once() {
        let mut manifest = Manifest::new(DatasetInfo::empty(), span(0, 10));
        let rerun = |budget: &str, rows: &[RowSpan]| Rerun { changed: vec![budget.to_owned()], rows: rows.to_vec() };
        for rows in [&[span(7, 8), span(2, 3), span(3, 4)][..], &[span(3, 4)], &[span(8, 9)]] {
            manifest.note_rerun(rerun("steps", rows));
        }
        manifest.note_rerun(rerun("retries", &[span(2, 3)]));
        manifest.note_rerun(rerun("steps", &[span(2, 3)]));
        assert_eq!(manifest.reruns, [rerun("steps", &[span(2, 4), span(7, 9)]), rerun("retries", &[span(2, 3)])]);
    }
}
