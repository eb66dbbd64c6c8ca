//! The dataset of a study: three or four Parquet tables in parts, a manifest, a writer and a reader.
//!
//! # Folder
//!
//! ```text
//! DIR/manifest.json                      study, seed, version, rows done, parts of `runs` and `blows` with checksums
//! DIR/timings.json                       the parts of `timings` with checksums
//! DIR/status.json                        how far the run is or how it ended
//! DIR/runs/runs-000000000000.parquet     wide: one row per run
//! DIR/blows/blows-000000000000.parquet   long: one row per blow
//! DIR/timings/timings-000000000000.parquet   wall time of each row
//! DIR/signals/signals-000000000000.parquet   long: one row per instant of the rows whose signals are kept, if the study asks
//! DIR/.journal/                          rows that are not yet in a part, and the study that they are of
//! DIR/.staging/, DIR/.growing/, DIR/.lock    only while a run writes
//! DIR/.damaged/                          parts that were damaged, as they were found
//! DIR/.replaced/                         datasets that were replaced, until the new one is whole
//! ```
//!
//! A part holds a fixed block of row indices and has the name of its first row, so its bytes depend only on the study. `runs`, `blows`,
//! `signals` and `manifest.json` are byte-identical for any number of threads, interruptions and shards.
//!
//! # Durability
//!
//! A finished row is appended to the journal at once, with a checksum. A killed process loses only running rows; a power failure also
//! loses the rows of the last seconds. When a block is complete, the files of its part and the new manifests are written and synced in
//! `DIR/.staging`. They are then renamed into place in this order: the part's files, folders synced, manifests. Only then the block
//! leaves the journal. Readers can therefore open `DIR/runs/*.parquet` at any time: they see only complete files. A full disk is noticed
//! while staging, when nothing is in place yet. A row that is visible in `runs` has its blows in `blows`. If the machine stops between
//! two renames, a complete file may exist that no manifest lists. The next run writes the same bytes there.
//!
//! Computed rows are removed only if they are stored elsewhere or were to be replaced. Repeated computations are reported.
//! [`Existing::Resume`] checks every part against its checksum, moves damaged parts aside, and lists the rows to run. Manifests end with
//! a checksum. Every part of `timings` describes its block, and the journal its study, so that lost manifests can be rebuilt from the
//! parts, or from the journal before the first part. Lost wall times become nulls.
//!
//! A reader trusts no manifest. [`DatasetReader`] compares the manifests with their checksums and with each other, and every part with
//! its length and checksum before it uses a row. It reads each file once and parses the bytes that it has checked. It refuses damaged, missing and duplicate
//! parts, and foreign files in the folders of the tables. [`DatasetError::Replaced`] marks a part that was replaced since the manifest
//! was read. [`verify`] reads everything. [`grow`] continues with a study that only got more rows, [`DatasetWriter::again`] re-runs
//! chosen rows. A dataset has one writer at a time. Shards are datasets of a range of rows; [`merge`] combines them.
//!
//! # Columns
//!
//! [`Columns`] derives the columns from the declarations of their quantities. Every field's Arrow metadata has its unit and description
//! (`unit`, `description`). The study's text, hash, seed, the program's version and a data dictionary (JSON) are key-values of every file
//! (`decore.study_text`, `decore.study_hash`, `decore.seed`, `decore.version`, `decore.dictionary`); all except the last are also in the
//! Arrow schema. Columns with few different texts (status, kind, names) are Arrow dictionaries.

mod batches;
mod cells;
mod column;
mod columns;
mod consistency;
mod difference;
mod durable;
mod error;
mod growth;
mod info;
mod journal;
mod key;
mod lock;
mod manifest;
mod merge;
mod owned;
mod parquet_file;
#[cfg(test)]
mod power_cut;
mod reader;
mod rebuild;
mod record;
mod recovery;
mod rerun;
mod settled;
mod status;
mod store;
mod table_file;
mod target;
#[cfg(test)]
mod trace;
mod verify;
mod writer;

pub use batches::record_batches;
pub use column::{ColumnDescription, ColumnGroup, Source};
pub use columns::{Columns, TableName};
pub use difference::differences;
pub use error::DatasetError;
pub use growth::{Growth, grow};
pub use info::{DatasetInfo, FactorColumn, PartColumn, RETRIES, RowRecord, SignalColumn, rows_per_part};
pub use key::ValuesKey;
pub use lock::{DatasetDir, Lock, host_name};
pub use manifest::{MANIFEST_NAME, Manifest, Rerun, RowSpan};
pub use merge::merge;
pub use owned::own_files;
pub use parquet_file::array;
pub use reader::DatasetReader;
pub use record::StoredRow;
pub use rerun::RerunSelection;
pub use settled::{is_settled, settle};
pub use status::{RowError, SweepState, SweepStatus};
pub use table_file::{TableColumn, signals_batch, table_batch, table_bytes, write_signals, write_table};
pub use target::{check_ending, check_folder, check_free, is_part_of, place};
pub use verify::{Verification, verify};
pub use writer::{DatasetWriter, Existing, RowRecorder};
