//! Probability that a row of a dataset succeeds.

use super::error::SurrogateError;
use super::rows::FactorRows;
use super::space::FactorSpace;
use decore_dataset::DatasetReader;
use decore_statistics::regression::{Points, Success};

/// Probability that a row of a study is done, by place.
#[derive(Debug, Clone)]
pub struct SuccessModel {
    /// Name of the study.
    pub study: String,
    /// The factors, in the study's order.
    pub factors: Vec<FactorSpace>,
    /// Places of the rows.
    pub points: Points,
    /// Whether each of them is done.
    pub succeeded: Vec<bool>,
    /// The probability.
    pub success: Success,
}

/// Reads a dataset and models which of its rows are done, whatever outputs they have.
///
/// # Errors
/// Those of reading, [`SurrogateError::NoFactors`]; [`SurrogateError::Regression`].
pub fn fit_success(reader: &DatasetReader) -> Result<SuccessModel, SurrogateError> {
    let FactorRows { table, factors, points, .. } = FactorRows::read(reader, &[], &[])?;
    let succeeded: Vec<bool> = table.faults.iter().map(Option::is_none).collect();
    let named = |source| SurrogateError::Regression { output: "success".to_owned(), source };
    let success = Success::fit(&points, &succeeded).map_err(named)?;
    Ok(SuccessModel { study: reader.manifest().study.study_name.clone(), factors, points, succeeded, success })
}
