//! Columns of a foreign Parquet file, as texts.

use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef};
use arrow_schema::DataType;
use bytes::Bytes;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::basic::Compression;
use parquet::file::metadata::ParquetMetaData;

use super::pages;
use decore_files::{Limit, shielded};

/// Most rows of a table: they are kept in memory.
const MOST_ROWS: usize = 10_000_000;
/// Rows that are decoded at a time.
const BATCH_ROWS: usize = 1024;

/// Finds a factor's column among the names of a file's columns, or returns the reason why it is missing.
pub(super) type ColumnPlace<'a> = &'a dyn Fn(&str, &[String]) -> Result<usize, String>;

/// The cells of these factors' columns, row by row, whatever the compression but LZO and Brotli. `sparse`: nulls are empty texts, else
/// faults.
///
/// # Errors
/// What is wrong with the file, in words; a damaged one takes no more memory than its bytes justify.
pub(super) fn read(
    file: &Path,
    factors: &[&str],
    place: ColumnPlace<'_>,
    sparse: bool,
) -> Result<Vec<Vec<String>>, String> {
    let fault = |reason: String| format!("cannot read {}: {reason}", file.display());
    let bytes = decore_files::read(file, Limit::ROWS).map_err(|error| fault(error.to_string()))?;
    let decode = || decode(Bytes::from(bytes), (file, factors), place, sparse);
    shielded(decode).unwrap_or_else(|| Err(fault("it is damaged".to_owned())))
}

fn decode(
    bytes: Bytes,
    (file, factors): (&Path, &[&str]),
    place: ColumnPlace<'_>,
    sparse: bool,
) -> Result<Vec<Vec<String>>, String> {
    let fault = |reason: &dyn std::fmt::Display| format!("cannot read {}: {reason}", file.display());
    // Types of the file; the writer's types in memory (dictionaries, views of texts) do not matter.
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let reader = ParquetRecordBatchReaderBuilder::try_new_with_options(bytes.clone(), options);
    let reader = reader.map_err(|error| fault(&error))?;
    let header: Vec<String> = reader.schema().fields().iter().map(|field| field.name().clone()).collect();
    let places = factors.iter().map(|factor| place(factor, &header)).collect::<Result<Vec<usize>, String>>()?;
    check(&bytes, reader.metadata(), &places).map_err(|reason| fault(&reason))?;
    // Columns of a batch are in the order of the file, each once.
    let mut read = places.clone();
    read.sort_unstable();
    read.dedup();
    let mask = ProjectionMask::roots(reader.parquet_schema(), read.iter().copied());
    let reader = reader.with_projection(mask).with_batch_size(BATCH_ROWS).build().map_err(|error| fault(&error))?;
    let mut rows: Vec<Vec<String>> = Vec::new();
    for batch in reader {
        let batch = batch.map_err(|error| fault(&error))?;
        let column = |place: &usize| Some(Arc::clone(batch.columns().get(read.binary_search(place).ok()?)?));
        let columns: Vec<ArrayRef> = places.iter().filter_map(column).collect();
        for row in 0..batch.num_rows() {
            let cells = columns.iter().zip(factors).map(|(column, factor)| {
                let empty = || (sparse && column.is_null(row)).then(String::new);
                cell(column, row).or_else(empty).ok_or_else(|| {
                    let (row, kind) = (rows.len(), column.data_type());
                    format!("{}, row {row}, column `{factor}`: no number or text ({kind})", file.display())
                })
            });
            let cells = cells.collect::<Result<Vec<String>, String>>()?;
            rows.push(cells);
        }
    }
    Ok(rows)
}

/// Compares the stated sizes of a file with its bytes, for the columns to read.
fn check(bytes: &[u8], metadata: &ParquetMetaData, places: &[usize]) -> Result<(), String> {
    // Packed, a column of a single value takes no bytes for its rows.
    let stated = metadata.file_metadata().num_rows();
    if usize::try_from(stated).map_or(true, |rows| rows > MOST_ROWS) {
        return Err(format!("it states {stated} rows, expected at most {MOST_ROWS}"));
    }
    let schema = metadata.file_metadata().schema_descr();
    for group in metadata.row_groups() {
        let read = group.columns().iter().enumerate().filter(|(leaf, _)| {
            let root = (*leaf < schema.num_columns()).then(|| schema.get_column_root_idx(*leaf));
            root.is_some_and(|root| places.contains(&root))
        });
        for (_, column) in read {
            let name = column.column_path();
            if matches!(column.compression(), Compression::BROTLI(_) | Compression::LZO) {
                return Err(format!(
                    "its column {name} is packed with {}: write it again with snappy, gzip, zstd, lz4 or none",
                    column.compression()
                ));
            }
            pages::check(bytes, column).map_err(|reason| format!("column {name}: {reason}"))?;
        }
    }
    Ok(())
}

/// A cell as text; numbers in the shortest form that reads back the same.
fn cell(column: &ArrayRef, row: usize) -> Option<String> {
    if column.is_null(row) {
        return None;
    }
    match column.data_type() {
        DataType::Float64 => Some(column.as_primitive::<Float64Type>().value(row).to_string()),
        DataType::Float32 => Some(column.as_primitive::<Float32Type>().value(row).to_string()),
        DataType::Int64 => Some(column.as_primitive::<Int64Type>().value(row).to_string()),
        DataType::Int32 => Some(column.as_primitive::<Int32Type>().value(row).to_string()),
        DataType::Int16 => Some(column.as_primitive::<Int16Type>().value(row).to_string()),
        DataType::Int8 => Some(column.as_primitive::<Int8Type>().value(row).to_string()),
        DataType::UInt64 => Some(column.as_primitive::<UInt64Type>().value(row).to_string()),
        DataType::UInt32 => Some(column.as_primitive::<UInt32Type>().value(row).to_string()),
        DataType::UInt16 => Some(column.as_primitive::<UInt16Type>().value(row).to_string()),
        DataType::UInt8 => Some(column.as_primitive::<UInt8Type>().value(row).to_string()),
        DataType::Utf8 => Some(column.as_string::<i32>().value(row).to_string()),
        _ => None,
    }
}
