//! The dataset of a study: three Parquet tables in parts, a manifest, a writer and a reader.
//!
//! # Folder
//!
//! ```text
//! DIR/manifest.json                      study, seed, version, rows done, parts of `runs` and `blows` with checksums
//! DIR/timings.json                       the parts of `timings` with checksums
//! DIR/runs/runs-000000000000.parquet     wide: one row per run
//! DIR/blows/blows-000000000000.parquet   long: one row per blow
//! DIR/timings/timings-000000000000.parquet   wall time of each row
//! DIR/.staging/                          only while a run writes
//! ```
//!
//! A part holds a fixed block of row indices and is named by the block's first row, so its bytes depend on the study
//! only. Everything except `timings` and `timings.json` is byte-identical for any number of threads.
//!
//! # Durability
//!
//! A part's files and the new manifests are first written and synced in `DIR/.staging`; then they are renamed into
//! place: the part's files, folders synced, then the manifests. Readers can therefore open `DIR/runs/*.parquet` at any
//! time: they see whole files only. A full disk is met while staging, when nothing is in place yet. A row that is
//! visible in `runs` has its blows in `blows`. If the machine stops between two renames, a file may be there that no
//! manifest lists; it is whole, and the same bytes replace it when its rows are run again.
//!
//! # Columns
//!
//! [`Columns`] is the only list of columns. Units and descriptions are in every field's Arrow metadata (`unit`,
//! `description`); the study's text, hash, seed, the program's version and a data dictionary (JSON) are key-values of
//! every file (`decore.study_text`, `decore.study_hash`, `decore.seed`, `decore.version`, `decore.dictionary`).

mod aggregates;
mod columns;
mod durable;
mod error;
mod info;
mod manifest;
mod parquet_file;
mod reader;
mod signals;
mod writer;

pub use columns::{
    BlowRecord, Cell, Column, ColumnDescription, ColumnGroup, ColumnKind, Columns, TableName, status_text,
};
pub use error::DatasetError;
pub use info::{DatasetInfo, Factor, FactorKind, FactorValue, RowRecord, rows_per_part};
pub use manifest::{Manifest, Part, RowSpan, TimingsManifest};
pub use reader::DatasetReader;
pub use signals::write_signals;
pub use writer::{DatasetWriter, Existing};
