//! Encodes parts as Parquet, and decodes them.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float64Array, Int32Array, Int64Array, RecordBatch, StringArray, UInt64Array,
};
use arrow_buffer::{BooleanBuffer, Buffer, NullBuffer, OffsetBuffer};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use bytes::Bytes;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::arrow::arrow_writer::ArrowWriterOptions;
use parquet::arrow::{ArrowSchemaConverter, ArrowWriter, ProjectionMask, add_encoded_arrow_schema_to_metadata};
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::schema::types::{ColumnPath, SchemaDescriptor};
use serde_json::json;

use super::column::ColumnDescription;
use super::columns::TableName;
use super::error::DatasetError;
use super::info::DatasetInfo;
use decore_quantity::{Cell, CellColumn, ColumnValues, Kind, Value};

/// Level of zstd: about the size of higher levels on such tables at a fraction of their time.
const ZSTD_LEVEL: i32 = 3;
/// Rows per row group; several groups only in large parts of the table of blows.
const ROW_GROUP_ROWS: usize = 65_536;
/// Key of a part's metadata under which it describes its block, see [`Opened::block_text`].
const BLOCK_KEY: &str = "decore.block";

/// The data dictionary of a table, as JSON.
pub fn dictionary_json(table: TableName, columns: &[ColumnDescription]) -> String {
    json!({ "table": table, "columns": columns }).to_string()
}

fn data_type(kind: Kind) -> DataType {
    match kind {
        Kind::Real => DataType::Float64,
        Kind::Count => DataType::UInt64,
        Kind::Integer => DataType::Int64,
        Kind::Text => DataType::Utf8,
        Kind::Category => DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8)),
    }
}

/// Arrow schema with unit and description in every field's metadata, and the study in its own: readers of Arrow show these, and
/// not a file's key-values.
pub fn schema(info: &DatasetInfo, columns: &[ColumnDescription]) -> Arc<Schema> {
    let fields: Vec<Field> = columns
        .iter()
        .map(|column| {
            let metadata = HashMap::from([
                ("unit".to_owned(), column.unit.clone()),
                ("description".to_owned(), column.description.clone()),
            ]);
            // Written in the order of the keys, not of the map.
            Field::new(&column.name, data_type(column.kind), true).with_metadata(metadata)
        })
        .collect();
    Arc::new(Schema::new_with_metadata(fields, study_metadata(info)))
}

/// Returns the study's entries in the schema of each table.
pub fn study_metadata(info: &DatasetInfo) -> HashMap<String, String> {
    HashMap::from(study_entries(info).map(|(key, value)| (key.to_owned(), value)))
}

/// Returns the study's entries in the metadata of each file.
fn study_entries(info: &DatasetInfo) -> [(&'static str, String); 5] {
    [
        ("decore.study_name", info.study_name.clone()),
        ("decore.study_text", info.study_text.clone()),
        ("decore.study_hash", info.study_hash.clone()),
        ("decore.seed", info.seed.to_string()),
        ("decore.version", info.program_version.clone()),
    ]
}

/// The key-values of a file.
fn entries(info: &DatasetInfo, dictionary: String) -> Vec<KeyValue> {
    let all = study_entries(info).into_iter().chain([("decore.dictionary", dictionary)]);
    all.map(|(key, value)| KeyValue::new(key.to_owned(), value)).collect()
}

/// Format shared by all files of a table: the schema and the settings of the writer. No file contains anything of the machine or the clock.
pub struct FileFormat {
    schema: Arc<Schema>,
    parquet_schema: SchemaDescriptor,
    properties: WriterProperties,
}

impl FileFormat {
    /// Format of a study's tables with a schema; `dictionary`: descriptions of the columns.
    ///
    /// # Errors
    /// The Parquet library's.
    pub fn new(schema: Arc<Schema>, info: &DatasetInfo, dictionary: String) -> Result<Self, ParquetError> {
        let mut builder = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::try_new(ZSTD_LEVEL)?))
            .set_created_by(format!("decore version {}", info.program_version))
            .set_max_row_group_row_count(Some(ROW_GROUP_ROWS))
            .set_key_value_metadata(Some(entries(info, dictionary)))
            .set_dictionary_enabled(false);
        // A number seldom stands twice in a column of outputs: a dictionary of them costs more than all else of a row's writing.
        for field in schema.fields().iter().filter(|field| !field.data_type().is_numeric()) {
            builder = builder.set_column_dictionary_enabled(ColumnPath::from(field.name().as_str()), true);
        }
        let mut properties = builder.build();
        add_encoded_arrow_schema_to_metadata(&schema, &mut properties);
        let parquet_schema = ArrowSchemaConverter::new().convert(&schema)?;
        Ok(Self { schema, parquet_schema, properties })
    }

    /// The format of a table of a dataset.
    ///
    /// # Errors
    /// The Parquet library's.
    pub fn of_table(info: &DatasetInfo, table: TableName, columns: &[ColumnDescription]) -> Result<Self, ParquetError> {
        Self::new(schema(info, columns), info, dictionary_json(table, columns))
    }

    /// Columns as a batch of this format.
    ///
    /// # Errors
    /// The Arrow library's, such as columns of other kinds than the format's.
    pub fn batch(&self, columns: Vec<CellColumn>) -> Result<RecordBatch, ArrowError> {
        batch(Arc::clone(&self.schema), columns)
    }

    /// The Parquet file of one batch; `block`: the description of its block.
    ///
    /// # Errors
    /// The Parquet library's, such as a batch of another schema.
    pub fn encode(&self, batch: &RecordBatch, block: Option<String>) -> Result<Vec<u8>, ParquetError> {
        let mut properties = self.properties.clone();
        if let Some(block) = block {
            let mut entries = properties.key_value_metadata().cloned().unwrap_or_default();
            // The schema stays the last, where the Arrow library puts it.
            entries.insert(entries.len().saturating_sub(1), KeyValue::new(BLOCK_KEY.to_owned(), block));
            properties = properties.into_builder().set_key_value_metadata(Some(entries)).build();
        }
        let options = ArrowWriterOptions::new()
            .with_properties(properties)
            .with_parquet_schema(self.parquet_schema.clone())
            .with_skip_arrow_metadata(true);
        let mut bytes = Vec::new();
        let mut writer = ArrowWriter::try_new_with_options(&mut bytes, Arc::clone(&self.schema), options)?;
        writer.write(batch)?;
        writer.close()?;
        Ok(bytes)
    }
}

/// Columns as a batch of Arrow with a schema of [`schema`].
///
/// # Errors
/// The Arrow library's, such as columns of other kinds than the schema's.
pub fn batch(schema: Arc<Schema>, columns: Vec<CellColumn>) -> Result<RecordBatch, ArrowError> {
    let arrays: Result<Vec<ArrayRef>, ArrowError> = columns.into_iter().map(array).collect();
    RecordBatch::try_new(schema, arrays?)
}

/// A column as an array of Arrow; numbers are not copied.
///
/// # Errors
/// The Arrow library's, such as texts of more than 2 GiB.
pub fn array(column: CellColumn) -> Result<ArrayRef, ArrowError> {
    let CellColumn { values, present, count, missing } = column;
    let nulls = (missing > 0).then(|| NullBuffer::new(BooleanBuffer::new(Buffer::from_vec(present), 0, count)));
    Ok(match values {
        ColumnValues::Real(values) => Arc::new(Float64Array::try_new(values.into(), nulls)?),
        ColumnValues::Count(values) => Arc::new(UInt64Array::try_new(values.into(), nulls)?),
        ColumnValues::Integer(values) => Arc::new(Int64Array::try_new(values.into(), nulls)?),
        ColumnValues::Text { text, ends } => Arc::new(texts(text, &ends, nulls)?),
        ColumnValues::Category { keys, entries } => {
            let keys = Int32Array::try_new(keys.into(), nulls)?;
            Arc::new(DictionaryArray::try_new(keys, Arc::new(StringArray::from_iter_values(entries)))?)
        }
    })
}

fn texts(text: String, ends: &[usize], nulls: Option<NullBuffer>) -> Result<StringArray, ArrowError> {
    let offsets: Result<Vec<i32>, _> = [0].iter().chain(ends).map(|end| i32::try_from(*end)).collect();
    let offsets = offsets.map_err(|_| ArrowError::OffsetOverflowError(text.len()))?;
    StringArray::try_new(OffsetBuffer::new(offsets.into()), Buffer::from_vec(text.into_bytes()), nulls)
}

/// A file in memory whose footer is read.
pub struct Opened {
    path: PathBuf,
    builder: ParquetRecordBatchReaderBuilder<Bytes>,
}

impl Opened {
    /// Reads the footer of a file from its bytes; `path`: for errors.
    ///
    /// # Errors
    /// The Parquet library's.
    pub fn new(path: PathBuf, bytes: Vec<u8>) -> Result<Self, DatasetError> {
        match ParquetRecordBatchReaderBuilder::try_new(Bytes::from(bytes)) {
            Ok(builder) => Ok(Self { path, builder }),
            Err(source) => Err(DatasetError::Parquet { path, source }),
        }
    }

    /// Number of rows, as the footer has it.
    pub fn records(&self) -> u64 {
        u64::try_from(self.builder.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// Description of the file's block; `None` if there is none.
    pub fn block_text(&self) -> Option<&str> {
        self.entries().iter().find(|entry| entry.key == BLOCK_KEY)?.value.as_deref()
    }

    fn entries(&self) -> &[KeyValue] {
        self.builder.metadata().file_metadata().key_value_metadata().map_or(&[], Vec::as_slice)
    }

    /// Compares the study and the columns in the file's metadata with a dataset's.
    ///
    /// # Errors
    /// [`DatasetError::Damaged`] with the first key that differs.
    pub fn check_study(
        &self,
        info: &DatasetInfo,
        table: TableName,
        columns: &[ColumnDescription],
    ) -> Result<(), DatasetError> {
        let wanted = entries(info, dictionary_json(table, columns));
        match wanted.iter().find(|entry| !self.entries().contains(entry)) {
            None => Ok(()),
            Some(entry) => Err(DatasetError::Damaged {
                path: self.path.clone(),
                found: format!("another `{}` in its metadata", entry.key),
                expected: "that of the manifest's study".to_owned(),
            }),
        }
    }

    /// Returns the rows in batches of at most `rows`.
    ///
    /// # Errors
    /// The Parquet library's.
    pub fn batches(self, rows: usize) -> Result<ParquetRecordBatchReader, DatasetError> {
        let Self { path, builder } = self;
        builder.with_batch_size(rows).build().map_err(|source| DatasetError::Parquet { path, source })
    }

    /// Calls `visit` with the chosen columns of every row, in the order of `columns`.
    ///
    /// # Errors
    /// [`DatasetError::Damaged`] if a column is missing or of another type, or the Parquet library's.
    pub fn visit(self, columns: &[ColumnDescription], visit: &mut dyn FnMut(&[Cell<'_>])) -> Result<(), DatasetError> {
        let Self { path, builder } = self;
        let parquet_error = |source| DatasetError::Parquet { path: path.clone(), source };
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        let mask = ProjectionMask::columns(builder.parquet_schema(), names);
        let reader = builder.with_projection(mask).build().map_err(parquet_error)?;
        for batch in reader {
            let batch = batch.map_err(|error| parquet_error(error.into()))?;
            visit_batch(&batch, columns, visit).map_err(|column| DatasetError::Damaged {
                path: path.clone(),
                found: format!("no column `{}` of type {}", column.name, data_type(column.kind)),
                expected: "the columns of the manifest's study".to_owned(),
            })?;
        }
        Ok(())
    }
}

/// Fails with the column that the batch does not have.
fn visit_batch<'c>(
    batch: &RecordBatch,
    columns: &'c [ColumnDescription],
    visit: &mut dyn FnMut(&[Cell<'_>]),
) -> Result<(), &'c ColumnDescription> {
    let mut views = Vec::with_capacity(columns.len());
    for column in columns {
        let array = batch.column_by_name(&column.name).ok_or(column)?;
        if *array.data_type() != data_type(column.kind) {
            return Err(column);
        }
        views.push(ColumnView::new(column.kind, array));
    }
    let mut cells = Vec::with_capacity(columns.len());
    for row in 0..batch.num_rows() {
        cells.clear();
        cells.extend(views.iter().map(|view| view.cell(row)));
        visit(&cells);
    }
    Ok(())
}

/// A column of a batch. The type of its array is checked once, not for each cell.
struct ColumnView<'a> {
    nulls: Option<&'a NullBuffer>,
    values: ViewValues<'a>,
}

enum ViewValues<'a> {
    Real(&'a [f64]),
    Count(&'a [u64]),
    Integer(&'a [i64]),
    Text(&'a StringArray),
    Category(&'a [i32], &'a StringArray),
}

impl<'a> ColumnView<'a> {
    /// A view of an array whose type is the one of `kind`.
    fn new(kind: Kind, array: &'a ArrayRef) -> Self {
        let values = match kind {
            Kind::Real => ViewValues::Real(array.as_primitive::<Float64Type>().values()),
            Kind::Count => ViewValues::Count(array.as_primitive::<UInt64Type>().values()),
            Kind::Integer => ViewValues::Integer(array.as_primitive::<Int64Type>().values()),
            Kind::Text => ViewValues::Text(array.as_string()),
            Kind::Category => {
                let array = array.as_dictionary::<Int32Type>();
                ViewValues::Category(array.keys().values(), array.values().as_string())
            }
        };
        Self { nulls: array.nulls(), values }
    }

    fn cell(&self, row: usize) -> Cell<'a> {
        if self.nulls.is_some_and(|nulls| nulls.is_null(row)) {
            return None;
        }
        Some(match &self.values {
            ViewValues::Real(values) => Value::Real(*values.get(row)?),
            ViewValues::Count(values) => Value::Count(*values.get(row)?),
            ViewValues::Integer(values) => Value::Integer(*values.get(row)?),
            ViewValues::Text(texts) => Value::Text(texts.value(row)),
            ViewValues::Category(keys, texts) => Value::Text(texts.value(*keys.get(row)? as usize)),
        })
    }
}
