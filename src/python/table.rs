//! Tables by the Arrow stream protocol: readers of Arrow take them as they are, and none is needed.

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{Array, RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow_schema::{ArrowError, DataType, SchemaRef};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyIterator, PyList};

use super::error::{DatasetError, Error};
use super::value::object;
use super::wait::give_way;
use decore_dataset::{DatasetReader, TableName};
use decore_quantity::Value;
use decore_quantity::words::{did_you_mean, nearest};

/// A table: what implements `__arrow_c_stream__` for pyarrow, polars, pandas, DuckDB and others; units and descriptions are in the
/// fields' metadata.
#[pyclass(module = "decore", frozen)]
pub struct Table {
    name: &'static str,
    content: Content,
}

/// A column of a table.
#[pyclass(module = "decore", frozen, get_all)]
pub struct Column {
    /// Name, with the unit as its suffix.
    name: String,
    /// Unit; `1` for numbers without one, empty for texts.
    unit: String,
    /// What it is.
    description: String,
}

#[pymethods]
impl Column {
    fn __repr__(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" [{}]", self.unit) };
        format!("<decore.Column {}{unit}: {}>", self.name, self.description)
    }
}

enum Content {
    /// In memory.
    Batch(RecordBatch),
    /// In a dataset, read when it is asked for.
    Stored(Arc<DatasetReader>, TableName),
}

impl Table {
    /// A table in memory.
    pub fn new(name: &'static str, batch: RecordBatch) -> Self {
        Self { name, content: Content::Batch(batch) }
    }

    /// A table of a dataset.
    pub fn stored(reader: &Arc<DatasetReader>, table: TableName) -> Self {
        Self { name: table.folder(), content: Content::Stored(Arc::clone(reader), table) }
    }

    fn batches(&self) -> Box<dyn RecordBatchReader + Send> {
        match &self.content {
            Content::Batch(batch) => Box::new(RecordBatchIterator::new([Ok(batch.clone())], batch.schema())),
            Content::Stored(reader, table) => Box::new(reader.batches(*table)),
        }
    }

    fn schema(&self) -> SchemaRef {
        self.batches().schema()
    }

    /// The values of a column in the order of the rows.
    ///
    /// # Errors
    /// `KeyError` for a column that is not there, [`DatasetError`] where a part cannot be read.
    pub fn values<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyList>> {
        let schema = self.schema();
        let place = schema.index_of(column).map_err(|_| {
            let names = schema.fields().iter().map(|field| field.name().as_str());
            let hint = did_you_mean(nearest(column, names));
            PyKeyError::new_err(format!("table `{}` has no column `{column}`{hint}", self.name))
        })?;
        let values = PyList::empty(py);
        let mut batches = self.batches();
        while let Some(batch) = py.detach(|| batches.next()) {
            let batch = batch.map_err(failed)?;
            let array = batch.column(place);
            for row in 0..array.len() {
                values.append(cell(py, array, row)?)?;
                give_way(py, row)?;
            }
        }
        Ok(values)
    }
}

#[pymethods]
impl Table {
    /// Name of the table.
    #[getter]
    fn name(&self) -> &str {
        self.name
    }

    /// The columns: names, units, descriptions.
    #[getter]
    fn columns(&self) -> Vec<Column> {
        let text = |field: &arrow_schema::Field, key: &str| field.metadata().get(key).cloned().unwrap_or_default();
        let column = |field: &Arc<arrow_schema::Field>| Column {
            name: field.name().clone(),
            unit: text(field, "unit"),
            description: text(field, "description"),
        };
        self.schema().fields().iter().map(column).collect()
    }

    fn __len__(&self) -> usize {
        match &self.content {
            Content::Batch(batch) => batch.num_rows(),
            Content::Stored(reader, table) => {
                reader.parts(*table).iter().map(|part| usize::try_from(part.records).unwrap_or(usize::MAX)).sum()
            }
        }
    }

    /// The values of a column as a list; no library is needed.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyList>> {
        self.values(py, column)
    }

    /// Whether there is a column of this name.
    fn __contains__(&self, column: &Bound<'_, PyAny>) -> bool {
        column.extract::<String>().is_ok_and(|column| self.schema().index_of(&column).is_ok())
    }

    /// Names of the columns.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let schema = self.schema();
        PyList::new(py, schema.fields().iter().map(|field| field.name()))?.try_iter()
    }

    fn __repr__(&self) -> String {
        format!("<decore.Table {}: {} rows, {} columns>", self.name, self.__len__(), self.schema().fields().len())
    }

    /// The schema as Arrow's capsule.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.schema().as_ref()).map_err(failed)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    /// The table as Arrow's capsule of a stream; it has its own types, whichever are asked for.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The protocol leaves it to a table whether it casts; readers do it themselves.
        let _ = requested_schema;
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(self.batches()), c"arrow_array_stream")
    }
}

/// A value of an array, of the types that tables have.
fn cell(py: Python<'_>, array: &dyn Array, row: usize) -> PyResult<Py<PyAny>> {
    if array.is_null(row) {
        return Ok(py.None());
    }
    let value = match array.data_type() {
        DataType::Float64 => Value::Real(array.as_primitive::<Float64Type>().value(row)),
        DataType::UInt64 => Value::Count(array.as_primitive::<UInt64Type>().value(row)),
        DataType::Int64 => Value::Integer(array.as_primitive::<Int64Type>().value(row)),
        DataType::Utf8 => Value::Text(array.as_string::<i32>().value(row)),
        DataType::Dictionary(..) => {
            let array = array.as_dictionary::<Int32Type>();
            let key = usize::try_from(array.keys().value(row)).unwrap_or_default();
            Value::Text(array.values().as_string::<i32>().value(key))
        }
        other => return Err(Error::new_err(format!("a column of type {other}, which no table has"))),
    };
    object(py, &value)
}

/// An error while a table is read.
fn failed(error: ArrowError) -> PyErr {
    match error {
        ArrowError::ExternalError(inner) => DatasetError::new_err(inner.to_string()),
        other => DatasetError::new_err(other.to_string()),
    }
}
