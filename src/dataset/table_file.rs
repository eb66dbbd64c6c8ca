//! A single table in a Parquet file: time signals of a run, figures of a comparison, a design.

use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, Field, Schema};
use parquet::errors::ParquetError;

use super::column::{ColumnDescription, ColumnGroup};
use super::columns::check_unique;
use super::durable::StagedFile;
use super::error::DatasetError;
use super::info::DatasetInfo;
use super::parquet_file::{self, FileFormat, schema, study_metadata};
use super::target::check_free;
use decore_model::metrics::Signal;
use decore_quantity::words::identifier;
use decore_quantity::{CellColumn, Kind, Quantity};

/// Name of the table of signals.
const SIGNALS: &str = "signals";

/// A column of a table; all columns of a table have the same length.
#[derive(Debug, Clone, PartialEq)]
pub struct TableColumn {
    /// Name, with the unit as its suffix.
    pub name: String,
    /// Unit; `1` for numbers without one, empty for text.
    pub unit: String,
    /// Description of the column.
    pub description: String,
    /// The values, row by row.
    pub values: CellColumn,
}

impl TableColumn {
    /// Column of a quantity, a row per item. Missing values are NaN or an empty text.
    pub fn new<'a, T: 'static>(quantity: &Quantity<T>, items: impl Iterator<Item = Option<&'a T>>) -> Self {
        let cells = items.map(|item| item.and_then(quantity.value));
        let values = match quantity.kind {
            Kind::Text | Kind::Category => {
                CellColumn::texts(cells.map(|cell| cell.map_or(String::new(), |text| text.to_string())))
            }
            _ => CellColumn::reals(cells.map(|cell| cell.and_then(|value| value.number()).unwrap_or(f64::NAN))),
        };
        Self {
            name: quantity.name.to_owned(),
            unit: quantity.unit.to_owned(),
            description: quantity.description(),
            values,
        }
    }
}

/// Writes signals to `path`, one column per signal, one row per instant: see [`write_table`].
///
/// # Errors
/// As [`write_table`].
pub fn write_signals(path: &Path, info: &DatasetInfo, signals: &[Signal]) -> Result<(), DatasetError> {
    write_table(path, info, SIGNALS, &signal_columns(signals))
}

fn signal_columns(signals: &[Signal]) -> Vec<TableColumn> {
    let column = |signal: &Signal| TableColumn {
        name: signal.name.clone(),
        unit: signal.unit.to_owned(),
        description: signal.description.clone(),
        values: CellColumn::reals(signal.values.iter().copied()),
    };
    signals.iter().map(column).collect()
}

/// Writes a table to `path`; units and descriptions are in the fields' metadata, the study in the file's key-values.
///
/// The file appears whole or not at all.
///
/// # Errors
/// [`DatasetError::Target`] where a dataset keeps its own files, [`DatasetError::DuplicateColumn`] if two columns have one name, the
/// Parquet library's or the system's.
pub fn write_table(path: &Path, info: &DatasetInfo, table: &str, columns: &[TableColumn]) -> Result<(), DatasetError> {
    check_free(path, &[])?;
    let descriptions = descriptions(table, columns)?;
    let dictionary = serde_json::json!({ "table": table, "columns": descriptions }).to_string();
    let bytes = batch(info, &descriptions, columns)
        .map_err(Into::into)
        .and_then(|batch| FileFormat::new(batch.schema(), info, dictionary)?.encode(&batch, None))
        .map_err(|source| DatasetError::Parquet { path: path.to_owned(), source })?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    StagedFile::write(folder, path, &bytes)?.put_in_place()
}

/// Parquet file of columns with metadata beyond unit and description; `dictionary`: data dictionary of the file. The study is in its
/// metadata, as in every file.
///
/// # Errors
/// The Parquet library's, such as columns of different lengths.
pub fn table_bytes(
    info: &DatasetInfo,
    dictionary: String,
    columns: Vec<(Field, ArrayRef)>,
) -> Result<Vec<u8>, ParquetError> {
    let (fields, arrays): (Vec<Field>, Vec<ArrayRef>) = columns.into_iter().unzip();
    let schema = Arc::new(Schema::new_with_metadata(fields, study_metadata(info)));
    let format = FileFormat::new(Arc::clone(&schema), info, dictionary)?;
    format.encode(&RecordBatch::try_new(schema, arrays)?, None)
}

/// A table in memory, as [`write_table`] writes it.
///
/// # Errors
/// [`DatasetError::DuplicateColumn`] if two columns have one name, [`DatasetError::Batch`] if they are not of one length.
pub fn table_batch(info: &DatasetInfo, table: &str, columns: &[TableColumn]) -> Result<RecordBatch, DatasetError> {
    Ok(batch(info, &descriptions(table, columns)?, columns)?)
}

/// Signals in memory, as [`write_signals`] writes them.
///
/// # Errors
/// As [`table_batch`].
pub fn signals_batch(info: &DatasetInfo, signals: &[Signal]) -> Result<RecordBatch, DatasetError> {
    table_batch(info, SIGNALS, &signal_columns(signals))
}

fn batch(
    info: &DatasetInfo,
    descriptions: &[ColumnDescription],
    columns: &[TableColumn],
) -> Result<RecordBatch, ArrowError> {
    parquet_file::batch(schema(info, descriptions), columns.iter().map(|column| column.values.clone()).collect())
}

fn descriptions(table: &str, columns: &[TableColumn]) -> Result<Vec<ColumnDescription>, DatasetError> {
    let descriptions: Vec<ColumnDescription> = columns.iter().map(|column| description(table, column)).collect();
    check_unique(&descriptions)?;
    Ok(descriptions)
}

fn description(table: &str, column: &TableColumn) -> ColumnDescription {
    ColumnDescription {
        name: identifier(&column.name, table),
        kind: column.values.kind(),
        unit: column.unit.clone(),
        description: column.description.clone(),
        group: ColumnGroup::Other,
        subject: None,
        quantity: column.name.clone(),
        main: false,
        less: false,
    }
}
