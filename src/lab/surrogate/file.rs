//! File of a model: its rows as columns of a Parquet file, its figures as JSON in the metadata.

use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use bytes::Bytes;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde::{Deserialize, Serialize};

use super::error::SurrogateError;
use super::model::{Model, OutputModel, RowsProcess};
use super::result::{OutputSurrogate, ProcessFigures, Surrogate};
use decore_dataset::{DatasetInfo, check_ending, check_free};
use decore_files::{Limit, Staged, shielded};
use decore_statistics::regression::{GaussianProcess, Places, Points, RegressionError};

/// Predictor in Python that needs only NumPy, written next to the models.
pub const PREDICTOR: &str = include_str!("../../assets/predict.py");

/// Version of the file's layout.
const LAYOUT: u32 = 1;
/// Key of the figures in the file's key-values.
const FIGURES: &str = "decore.surrogate";
/// Key of the seal.
const SEAL: &str = "decore.seal";
/// Begin of a seal. The hexadecimal BLAKE3 checksum of the file follows, computed with zeros in its own place.
const SEAL_BEGIN: &str = "blake3:";
/// Digits of a seal.
const SEAL_DIGITS: usize = 64;

/// Metadata of a model's file.
#[derive(Serialize, Deserialize)]
struct Figures {
    layout: u32,
    surrogate: Surrogate,
    info: DatasetInfo,
}

/// Writes the bytes of [`to_bytes`] to a file. A failure leaves no partial file.
///
/// # Errors
/// [`SurrogateError::Dataset`] for a name that does not end in `.parquet` or lies where a dataset keeps its own files,
/// [`SurrogateError::Write`].
pub fn write(model: &Model, path: &Path) -> Result<(), SurrogateError> {
    check_ending(path, &["parquet"])?;
    check_free(path, &[])?;
    let fault = |reason: String| SurrogateError::Write { path: path.to_owned(), reason };
    let bytes = to_bytes(model, path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Staged::write(folder, path, &bytes).and_then(Staged::put_in_place).map_err(|error| fault(error.to_string()))
}

/// A model as the bytes of a Parquet file, which depend on the model alone. `path`: the file, for errors.
///
/// Columns: `row`, for each factor `scaled_` and its name (0 to 1 over its range; of names their numbers), for each output at the first
/// row of each place the mean of its runs there, NaN in other rows, `..._weight` (`mean + sum weight k(x, x_row)` is the prediction) and
/// `..._runs` (different runs at the place); `..._success` (1 and -1), `..._success_weight` and `..._success_runs` where rows failed.
///
/// # Errors
/// [`SurrogateError::Write`].
pub fn to_bytes(model: &Model, path: &Path) -> Result<Vec<u8>, SurrogateError> {
    model.check()?;
    let fault = |reason: String| SurrogateError::Write { path: path.to_owned(), reason };
    let figures = Figures { layout: LAYOUT, surrogate: model.surrogate.clone(), info: model.info.clone() };
    let figures = serde_json::to_string(&figures).map_err(|error| fault(error.to_string()))?;
    let mut bytes = encoded(model, figures).map_err(|error| fault(error.to_string()))?;
    let place = seal_place(&bytes).ok_or_else(|| fault("the Parquet library left out its key-values".to_owned()))?;
    let seal = blake3::hash(&bytes).to_hex();
    bytes[place..place + SEAL_DIGITS].copy_from_slice(seal.as_bytes());
    Ok(bytes)
}

fn encoded(model: &Model, figures: String) -> Result<Vec<u8>, ParquetError> {
    let rows: Vec<i64> = model.rows.iter().map(|row| row.cast_signed()).collect();
    let mut columns: Vec<(String, ArrayRef)> = vec![("row".to_owned(), Arc::new(Int64Array::from(rows)))];
    for (place, factor) in model.surrogate.factors.iter().enumerate() {
        let scaled = (0..model.points.rows()).map(|row| model.points.row(row)[place]);
        columns.push((format!("scaled_{}", factor.name), Arc::new(Float64Array::from_iter_values(scaled))));
    }
    for (output, of) in model.surrogate.outputs.iter().zip(&model.outputs) {
        for (suffix, process) in [("", &of.process), ("_success", &of.success)] {
            let Some(process) = process else { continue };
            let spread = |values: &[f64]| {
                let mut all = vec![f64::NAN; model.rows.len()];
                process.rows.iter().zip(values).for_each(|(row, value)| all[*row] = *value);
                Arc::new(Float64Array::from(all)) as ArrayRef
            };
            let name = format!("{}{suffix}", output.output);
            columns.push((format!("{name}_weight"), spread(process.process.row_weights())));
            columns.push((format!("{name}_runs"), spread(process.process.places().runs())));
            columns.push((name, spread(&process.values)));
        }
    }
    let fields: Vec<Field> =
        columns.iter().map(|(name, array)| Field::new(name, array.data_type().clone(), false)).collect();
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(Arc::clone(&schema), columns.into_iter().map(|(_, array)| array).collect())?;
    let seal = format!("{SEAL_BEGIN}{}", "0".repeat(SEAL_DIGITS));
    let entries = [(FIGURES, figures), (SEAL, seal)].map(|(key, value)| KeyValue::new(key.to_owned(), value));
    let properties = WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_created_by(format!("decore version {}", model.info.program_version))
        .set_key_value_metadata(Some(entries.to_vec()));
    let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties.build()))?;
    writer.write(&batch)?;
    writer.into_inner()
}

/// Finds the position of the seal's digits.
fn seal_place(bytes: &[u8]) -> Option<usize> {
    let begin = bytes.windows(SEAL_BEGIN.len()).rposition(|window| window == SEAL_BEGIN.as_bytes())?;
    let place = begin + SEAL_BEGIN.len();
    (place + SEAL_DIGITS <= bytes.len()).then_some(place)
}

/// Reads a model.
///
/// # Errors
/// [`SurrogateError::Model`] for a file that cannot be read, is not a model, or is not as it was written.
pub fn read(path: &Path) -> Result<Model, SurrogateError> {
    let fault = |reason: String| SurrogateError::Model { path: path.to_owned(), reason };
    from_bytes(decore_files::read(path, Limit::ROWS).map_err(|error| fault(error.to_string()))?, path)
}

/// Reads a model from the bytes of its file. `path`: the file, for errors.
///
/// # Errors
/// As for [`read`].
pub fn from_bytes(mut bytes: Vec<u8>, path: &Path) -> Result<Model, SurrogateError> {
    let fault = |reason: String| SurrogateError::Model { path: path.to_owned(), reason };
    if !bytes.starts_with(b"PAR1") {
        return Err(fault("it is not a Parquet file".to_owned()));
    }
    let place =
        seal_place(&bytes).ok_or_else(|| fault("it has no seal: it was truncated, or is another file".to_owned()))?;
    let found = bytes[place..place + SEAL_DIGITS].to_vec();
    bytes[place..place + SEAL_DIGITS].fill(b'0');
    if found != blake3::hash(&bytes).to_hex().as_bytes() {
        return Err(fault("its bytes differ from the written ones: it was truncated or changed".to_owned()));
    }
    let decoded = shielded(|| decoded(Bytes::from(bytes)));
    let model = decoded.unwrap_or_else(|| Err("it is damaged".to_owned())).and_then(|model| match model.check() {
        Ok(()) => Ok(model),
        Err(empty) => Err(empty.to_string()),
    });
    model.map_err(fault)
}

fn decoded(bytes: Bytes) -> Result<Model, String> {
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let reader = ParquetRecordBatchReaderBuilder::try_new_with_options(bytes.clone(), options);
    let reader = reader.map_err(|error| error.to_string())?;
    let file = reader.metadata().file_metadata();
    let stated = usize::try_from(file.num_rows()).unwrap_or(usize::MAX);
    if stated.saturating_mul(8).saturating_mul(reader.schema().fields().len()) > bytes.len() {
        return Err(format!("it states {stated} rows, more than its bytes hold"));
    }
    let entry = file.key_value_metadata().into_iter().flatten().find(|entry| entry.key == FIGURES);
    let figures = entry.and_then(|entry| entry.value.as_deref()).ok_or("it has no figures of a surrogate")?;
    let Figures { layout, surrogate, info } = serde_json::from_str(figures).map_err(|error| error.to_string())?;
    if layout != LAYOUT {
        return Err(format!("its layout is version {layout}, this decore reads version {LAYOUT}"));
    }
    let reader = reader.with_batch_size(stated.max(1)).build().map_err(|error| error.to_string())?;
    let batches = reader.collect::<Result<Vec<RecordBatch>, _>>().map_err(|error| error.to_string())?;
    let columns = FileColumns(&batches);
    let rows = columns.whole_numbers("row")?;
    let mut points = vec![0.0; rows.len() * surrogate.factors.len()];
    for (place, factor) in surrogate.factors.iter().enumerate() {
        let scaled = columns.numbers(&format!("scaled_{}", factor.name), rows.len())?;
        scaled.iter().enumerate().for_each(|(row, value)| points[row * surrogate.factors.len() + place] = *value);
    }
    let nominal = surrogate.factors.iter().map(|factor| !factor.names.is_empty()).collect();
    let points = Points::new(points, nominal).map_err(|error| error.to_string())?;
    let outputs = surrogate.outputs.iter().map(|output| output_model(output, &points, &columns));
    let outputs = outputs.collect::<Result<Vec<OutputModel>, String>>()?;
    Ok(Model { rows, points, outputs, info, surrogate })
}

fn output_model(output: &OutputSurrogate, points: &Points, columns: &FileColumns<'_>) -> Result<OutputModel, String> {
    let process = |figures: Option<&ProcessFigures>, name: &str| -> Result<Option<RowsProcess>, String> {
        let Some(figures) = figures else { return Ok(None) };
        let kernel = figures.hyperparameters().ok_or_else(|| format!("`{}` is no kernel", figures.kernel))?;
        let all = columns.numbers(name, points.rows())?;
        let rows: Vec<usize> = (0..all.len()).filter(|row| !all[*row].is_nan()).collect();
        let values: Vec<f64> = rows.iter().map(|row| all[*row]).collect();
        let fault = |error: RegressionError| format!("`{name}`: {error}");
        // Files of models from before rows were brought together have no such column, and no spread that would need it.
        let runs: Vec<f64> = match (columns.numbers(&format!("{name}_runs"), points.rows()), figures.spread > 0.0) {
            (Ok(runs), _) => rows.iter().map(|row| runs[*row]).collect(),
            (Err(reason), true) => return Err(reason),
            (Err(_), false) => vec![1.0; rows.len()],
        };
        let places = Places::known(&points.select(&rows), (&values, &runs), figures.evidence()).map_err(fault)?;
        let process = GaussianProcess::with(&places, kernel).map_err(fault)?;
        Ok(Some(RowsProcess::new(process, &rows)))
    };
    let success = output.success.as_ref().and_then(|success| success.process.as_ref());
    Ok(OutputModel {
        constant: None,
        process: process(output.process.as_ref(), &output.output)?,
        success: process(success, &format!("{}_success", output.output))?,
    })
}

/// The columns of a file.
struct FileColumns<'a>(&'a [RecordBatch]);

impl FileColumns<'_> {
    fn numbers(&self, name: &str, rows: usize) -> Result<Vec<f64>, String> {
        let mut values = Vec::new();
        for batch in self.0 {
            let column = batch.column_by_name(name).filter(|column| column.data_type() == &DataType::Float64);
            let column = column.ok_or_else(|| format!("it has no column `{name}` of numbers"))?;
            values.extend_from_slice(column.as_primitive::<Float64Type>().values());
        }
        match values.len() == rows {
            true => Ok(values),
            false => Err(format!("its column `{name}` has {} rows, not {rows}", values.len())),
        }
    }

    fn whole_numbers(&self, name: &str) -> Result<Vec<u64>, String> {
        let mut values = Vec::new();
        for batch in self.0 {
            let column = batch.column_by_name(name).filter(|column| column.data_type() == &DataType::Int64);
            let column = column.ok_or_else(|| format!("it has no column `{name}` of whole numbers"))?;
            values.extend(column.as_primitive::<Int64Type>().values().iter().map(|value| value.cast_unsigned()));
        }
        Ok(values)
    }
}
