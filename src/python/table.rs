//! Tables with the Arrow stream protocol: readers of Arrow can use them directly.

use std::collections::BTreeMap;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow_schema::{ArrowError, DataType, SchemaRef};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyCapsule, PyDict, PyList};

use super::error::{DatasetError, Error};
use super::value::object;
use super::wait::give_way;
use decore_dataset::{DatasetReader, TableName};
use decore_quantity::Value;
use decore_quantity::words::{did_you_mean, nearest};

/// A table. Libraries that read the Arrow stream protocol take it as it is (polars, pyarrow, DuckDB), pandas as `to_pandas()` or
/// `pandas.DataFrame(table)`; `table["column"]` is a list and needs no library. Units and descriptions are in `columns`.
///
/// >>> dataset.runs["status"][:2]
/// ['done', 'done']
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
    /// Description of the column.
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
    /// In a dataset, read when it is requested.
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

    /// Names of the columns.
    pub fn names(&self) -> Vec<String> {
        self.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    /// The place of a column.
    fn place(&self, column: &str) -> PyResult<usize> {
        let schema = self.schema();
        schema.index_of(column).map_err(|_| {
            let names = schema.fields().iter().map(|field| field.name().as_str());
            let hint = did_you_mean(nearest(column, names));
            PyKeyError::new_err(format!("table `{}` has no column `{column}`{hint}", self.name))
        })
    }

    /// The values of a column in the order of the rows.
    ///
    /// # Errors
    /// `KeyError` for a column that is not there, [`DatasetError`] where a part cannot be read.
    pub fn values<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyList>> {
        self.values_up_to(py, column, usize::MAX)
    }

    fn values_up_to<'py>(&self, py: Python<'py>, column: &str, most: usize) -> PyResult<Bound<'py, PyList>> {
        let place = self.place(column)?;
        let values = PyList::empty(py);
        let mut batches = self.batches();
        while values.len() < most
            && let Some(batch) = py.detach(|| batches.next())
        {
            let batch = batch.map_err(failed)?;
            let array = batch.column(place);
            for row in 0..array.len().min(most - values.len()) {
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

    /// The first values of a column.
    ///
    /// >>> dataset.runs.head("row", 3)
    /// [0, 1, 2]
    #[pyo3(signature = (column, rows=5))]
    fn head<'py>(&self, py: Python<'py>, column: &str, rows: usize) -> PyResult<Bound<'py, PyList>> {
        self.values_up_to(py, column, rows)
    }

    /// Units by the names of the columns: `1` for numbers without one, empty for texts.
    #[getter]
    fn units(&self) -> BTreeMap<String, String> {
        self.columns().into_iter().map(|column| (column.name, column.unit)).collect()
    }

    /// Names of the columns; `dict(table)` uses them with `[]`.
    ///
    /// >>> dataset.timings.keys()
    /// ['row', 'wall_time_s', 'numerical_twin_wall_time_s']
    fn keys(&self) -> Vec<String> {
        self.names()
    }

    /// All columns as arrays of NumPy by their names: numbers that are not there are NaN, texts objects.
    ///
    /// >>> dataset.runs.to_numpy()["delivered_work_j"].dtype
    /// dtype('float64')
    fn to_numpy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let numpy = py.import("numpy")?;
        let batches = py.detach(|| self.batches().collect::<Result<Vec<_>, _>>()).map_err(failed)?;
        let arrays = PyDict::new(py);
        for (place, name) in self.names().into_iter().enumerate() {
            let columns: Vec<_> = batches.iter().map(|batch| batch.column(place)).collect();
            let array = match Numbers::of(&columns) {
                Some(Numbers { bytes, kind }) => {
                    numpy.call_method1("frombuffer", (PyByteArray::new(py, &bytes), kind))?
                }
                None => numpy.call_method1("array", (self.values(py, &name)?, "object"))?,
            };
            arrays.set_item(name, array)?;
        }
        Ok(arrays)
    }

    /// Whether there is a column of this name.
    pub fn __contains__(&self, column: &Bound<'_, PyAny>) -> bool {
        column.extract::<String>().is_ok_and(|column| self.schema().index_of(&column).is_ok())
    }

    fn __repr__(&self) -> String {
        format!("<decore.Table {}: {} rows, {} columns>", self.name, self.__len__(), self.schema().fields().len())
    }

    /// The schema as Arrow's capsule.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.schema().as_ref()).map_err(failed)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    /// The table as Arrow's capsule of a stream; it has its own types, whichever are requested.
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

/// Numbers of a column as NumPy takes them.
struct Numbers {
    bytes: Vec<u8>,
    kind: &'static str,
}

impl Numbers {
    /// Numbers of a column; `None` for texts. Whole numbers with missing values become real numbers.
    fn of(columns: &[&ArrayRef]) -> Option<Self> {
        let first = columns.first()?;
        let whole = columns.iter().all(|column| column.null_count() == 0);
        let reals = |one: fn(&ArrayRef, usize) -> f64| -> Vec<u8> {
            let values = |column: &&ArrayRef| -> Vec<f64> {
                (0..column.len()).map(|row| if column.is_null(row) { f64::NAN } else { one(column, row) }).collect()
            };
            columns.iter().flat_map(values).flat_map(f64::to_ne_bytes).collect()
        };
        Some(match (first.data_type(), whole) {
            (DataType::Float64, _) => {
                Self { bytes: reals(|column, row| column.as_primitive::<Float64Type>().value(row)), kind: "float64" }
            }
            (DataType::UInt64, false) => {
                let bytes = reals(|column, row| column.as_primitive::<UInt64Type>().value(row) as f64);
                Self { bytes, kind: "float64" }
            }
            (DataType::Int64, false) => {
                let bytes = reals(|column, row| column.as_primitive::<Int64Type>().value(row) as f64);
                Self { bytes, kind: "float64" }
            }
            (DataType::UInt64 | DataType::Int64, true) => {
                let kind = if *first.data_type() == DataType::UInt64 { "uint64" } else { "int64" };
                let bytes = |column: &&ArrayRef| match column.as_primitive_opt::<UInt64Type>() {
                    Some(array) => bytemuck::cast_slice(array.values()).to_vec(),
                    None => bytemuck::cast_slice(column.as_primitive::<Int64Type>().values()).to_vec(),
                };
                Self { bytes: columns.iter().flat_map(bytes).collect(), kind }
            }
            _ => return None,
        })
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
