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
//! DIR/signals/signals-000000000000.parquet   long: one row per instant of the rows whose signals are kept, where the study asks
//! DIR/.journal/                          rows that are not yet in a part, and the study that they are of
//! DIR/.staging/, DIR/.growing/, DIR/.lock    only while a run writes
//! DIR/.damaged/                          parts that were damaged, as they were found
//! DIR/.replaced/                         datasets that were replaced, until the new one is whole
//! ```
//!
//! A part holds a fixed block of row indices and is named by the block's first row, so its bytes depend on the study
//! only. `runs`, `blows`, `signals` and `manifest.json` are byte-identical for any number of threads, of interruptions and of shards.
//!
//! # Durability
//!
//! A row that ends is appended to the journal at once, with a checksum: a process that is killed loses the rows that were
//! running, a power failure those of the last seconds before. When all rows of a block are there, its part's files and the
//! new manifests are first written and synced in `DIR/.staging`, then renamed into place: the part's files, folders synced,
//! then the manifests; only then the block leaves the journal. Readers can therefore open `DIR/runs/*.parquet` at any
//! time: they see whole files only. A full disk is met while staging, when nothing is in place yet. A row that is
//! visible in `runs` has its blows in `blows`. If the machine stops between two renames, a file may be there that no
//! manifest lists; it is whole, and its bytes are the ones that the next run puts there.
//!
//! Nothing that was computed is removed unless it is in place elsewhere or was to be replaced, and what is computed again is
//! said. [`Existing::Resume`] checks every part against its checksum, moves damaged ones aside, and names the rows that are to
//! be run. Manifests end with a checksum of their own; every part of `timings` describes its block, and the journal its study, so that lost
//! manifests are made anew from the parts, or from the journal where there is no part yet. Wall times are expendable: lost ones
//! become nulls.
//!
//! A reader takes the manifest's word for nothing: [`DatasetReader`] compares the manifests with their own checksums and with
//! themselves, and every part with its length and checksum before a row of it is used; the bytes that are parsed are those that were
//! compared. It refuses damaged or missing parts, parts twice, and files in the tables' folders that are no parts. A part that was
//! replaced since the manifest was read is told from a damaged one ([`DatasetError::Replaced`]). [`verify`] reads everything.
//! [`grow`] goes on with a study that only got more rows, [`DatasetWriter::again`] runs chosen rows again. A dataset has one writer at
//! a time. Shards are datasets of a range of rows; [`merge`] makes one of them.
//!
//! # Columns
//!
//! [`Columns`] puts the columns together from the declarations of their quantities. Units and descriptions are in every field's Arrow metadata (`unit`,
//! `description`); the study's text, hash, seed, the program's version and a data dictionary (JSON) are key-values of
//! every file (`decore.study_text`, `decore.study_hash`, `decore.seed`, `decore.version`, `decore.dictionary`), all but the last
//! entries of the Arrow schema too. Texts of which there are few (status, kind, names) are dictionaries of Arrow.

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
