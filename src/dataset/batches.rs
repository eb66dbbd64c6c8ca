//! Tables as Arrow batches: from rows in memory, and from a dataset that is read.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::{RecordBatch, RecordBatchReader};
use arrow_schema::{ArrowError, SchemaRef};
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;

use super::column::{Column, Source};
use super::columns::{Columns, TableName};
use super::error::DatasetError;
use super::info::{DatasetInfo, RowRecord};
use super::manifest::TablePart;
use super::parquet_file::{batch, schema};
use super::reader::{DatasetReader, Opening};
use super::record::{TableColumns, check_record};
use decore_quantity::CellColumn;

/// Rows of a batch that is read.
const BATCH_ROWS: usize = 65_536;

/// The tables of some rows, as the parts of a dataset hold them: in the order of [`TableName::ALL`].
///
/// # Errors
/// [`DatasetError::Record`] if a row has not the shape of the study, [`DatasetError::Batch`].
pub fn record_batches(
    info: &DatasetInfo,
    columns: &Columns,
    records: &[RowRecord],
) -> Result<[RecordBatch; 3], DatasetError> {
    records.iter().try_for_each(|record| check_record(info, record))?;
    let mut tables = TableColumns::new(columns);
    for record in records {
        let mut source = Source::new(info, record);
        push(&mut tables.runs, &columns.runs, &source);
        push(&mut tables.timings, &columns.timings, &source);
        for blow in record.outcome.metrics.iter().flat_map(|metrics| &metrics.blows) {
            source.blow = Some(blow);
            push(&mut tables.blows, &columns.blows, &source);
        }
    }
    let batch = |table, cells| batch(schema(info, &columns.describe(table)), cells);
    let TableColumns { runs, blows, timings, .. } = tables;
    Ok([batch(TableName::Runs, runs)?, batch(TableName::Blows, blows)?, batch(TableName::Timings, timings)?])
}

fn push(table: &mut [CellColumn], columns: &[Column], source: &Source<'_>) {
    table.iter_mut().zip(columns).for_each(|(cells, column)| cells.push(column.cell(source)));
}

/// Batches of a table of a dataset, part by part; memory is bounded by one part.
pub struct Batches {
    schema: SchemaRef,
    folder: PathBuf,
    opening: Opening,
    /// The reason why the table is not read at all.
    fault: Option<DatasetError>,
    /// Parts that have not been begun.
    left: VecDeque<TablePart>,
    /// The part that is being read, and its path.
    part: Option<(PathBuf, ParquetRecordBatchReader)>,
}

impl DatasetReader {
    /// The rows of a table as batches of Arrow, in the order of the parts; every field has its unit and description, the schema the
    /// study.
    ///
    /// Batches fail as [`DatasetReader::visit`] does, with the error of this library inside the Arrow library's.
    pub fn batches(&self, table: TableName) -> Batches {
        let schema = schema(&self.manifest().study, self.columns(table));
        let (left, fault) = match self.whole(table) {
            Ok(parts) => (parts.iter().cloned().collect(), None),
            Err(fault) => (VecDeque::new(), Some(fault)),
        };
        Batches { schema, folder: self.folder().to_owned(), opening: self.opening(), fault, left, part: None }
    }
}

impl Batches {
    fn read(&mut self) -> Result<Option<RecordBatch>, DatasetError> {
        if let Some(fault) = self.fault.take() {
            return Err(fault);
        }
        loop {
            if self.part.is_none() {
                let Some(part) = self.left.pop_front() else { return Ok(None) };
                self.part = Some((self.folder.join(&part.file), self.opening.open(&part)?.batches(BATCH_ROWS)?));
            }
            let Some((path, reader)) = &mut self.part else { return Ok(None) };
            let Some(batch) = reader.next() else {
                self.part = None;
                continue;
            };
            let batch = batch.map_err(|error| DatasetError::Parquet { path: path.clone(), source: error.into() })?;
            // Compare only columns and types: parts have further metadata.
            let columns = batch.columns().to_vec();
            return match RecordBatch::try_new(Arc::clone(&self.schema), columns) {
                Ok(batch) => Ok(Some(batch)),
                Err(error) => Err(DatasetError::Damaged {
                    path: path.clone(),
                    found: error.to_string(),
                    expected: "the columns of the manifest's study".to_owned(),
                }),
            };
        }
    }
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        let read = self.read();
        if read.is_err() {
            (self.left, self.part) = (VecDeque::new(), None);
        }
        read.map_err(|error| ArrowError::ExternalError(Box::new(error))).transpose()
    }
}

impl RecordBatchReader for Batches {
    fn schema(&self) -> SchemaRef {
        Arc::clone(&self.schema)
    }
}
