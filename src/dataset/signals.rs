//! Time signals of one run as a Parquet file: one column per signal, one row per instant.

use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};

use super::columns::{ColumnDescription, ColumnGroup, ColumnKind, check_unique, identifier};
use super::durable::StagedFile;
use super::parquet_file::{encode_batch, properties, schema};
use super::{DatasetError, DatasetInfo};
use crate::metrics::Signal;

/// Writes signals to `path`; units and descriptions are in the fields' metadata, the study in the file's key-values.
///
/// The file appears whole or not at all.
///
/// # Errors
/// [`DatasetError::DuplicateColumn`] if two signals have one name, the Parquet library's or the system's.
pub fn write_signals(path: &Path, info: &DatasetInfo, signals: &[Signal]) -> Result<(), DatasetError> {
    let columns: Vec<ColumnDescription> = signals.iter().map(description).collect();
    check_unique(&columns)?;
    let arrays: Vec<ArrayRef> =
        signals.iter().map(|signal| Arc::new(Float64Array::from(signal.values.clone())) as ArrayRef).collect();
    let dictionary = serde_json::json!({ "table": "signals", "columns": columns }).to_string();
    let bytes = RecordBatch::try_new(schema(&columns), arrays)
        .map_err(Into::into)
        .and_then(|batch| encode_batch(&batch, properties(info, dictionary)?))
        .map_err(|source| DatasetError::Parquet { path: path.to_owned(), source })?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    StagedFile::write(folder, path, &bytes)?.put_in_place()
}

fn description(signal: &Signal) -> ColumnDescription {
    ColumnDescription {
        name: identifier(&signal.name, "signal"),
        kind: ColumnKind::Real,
        unit: signal.unit.to_owned(),
        description: signal.description.clone(),
        group: ColumnGroup::Signal,
        subject: None,
        quantity: signal.name.clone(),
    }
}
