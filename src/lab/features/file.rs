//! The table as bytes of a file.

use std::path::PathBuf;

use super::column::FeatureColumn;
use super::error::FeaturesError;

/// Texts as lines of a CSV file.
///
/// # Errors
/// [`FeaturesError::Write`], should memory not suffice.
pub(super) fn csv(lines: impl Iterator<Item = Vec<String>>) -> Result<Vec<u8>, FeaturesError> {
    let fault = |source: std::io::Error| FeaturesError::Write { path: PathBuf::from("a CSV file"), source };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for line in lines {
        writer.write_record(line).map_err(|error| fault(error.into()))?;
    }
    writer.into_inner().map_err(|error| fault(error.into_error()))
}

/// The columns as CSV, numbers in the shortest form that reads back the same, nulls empty.
///
/// # Errors
/// As [`csv`].
pub(super) fn columns_csv(columns: &[FeatureColumn]) -> Result<Vec<u8>, FeaturesError> {
    let rows = columns.first().map_or(0, |column| column.values.count);
    let header = columns.iter().map(|column| column.name.clone()).collect();
    let line = |row: usize| columns.iter().map(|column| column.values.text(row)).collect();
    csv([header].into_iter().chain((0..rows).map(line)))
}
