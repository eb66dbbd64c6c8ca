//! Knowledge on a page beyond the rows of the dataset: influence of the factors, and models of the outputs.

use serde::Serialize;

use super::model::{ModelData, model_data};
use decore_dataset::DatasetReader;
use decore_lab::sensitivity::{Sensitivity, SensitivitySettings, analyse};
use decore_lab::surrogate::{Surrogate, SurrogateSettings, fit};

/// Rows up to which indices are computed for a page: seconds; of more, `decore analyse` takes its time.
const MOST_ANALYSED: u64 = 20_000;
/// Rows up to which outputs are modelled for a page: the time grows with their third power.
pub(super) const MOST_MODELLED: u64 = 1000;

/// Result, or the reason why there is none.
#[derive(Debug, Serialize)]
pub(super) struct Known<T> {
    found: Option<T>,
    why: Option<String>,
}

impl<T> Known<T> {
    pub(super) fn of<E: ToString>(found: Result<T, E>) -> Self {
        match found {
            Ok(found) => Self { found: Some(found), why: None },
            Err(error) => Self { found: None, why: Some(error.to_string()) },
        }
    }

    pub(super) fn not(why: String) -> Self {
        Self { found: None, why: Some(why) }
    }
}

/// Models and their warnings.
#[derive(Debug, Serialize)]
pub(super) struct Models {
    surrogate: Surrogate,
    warnings: Vec<String>,
    model: ModelData,
}

/// The indices of a dataset with this number of rows, as `decore analyse` finds them by its defaults.
pub(super) fn sensitivity(reader: &DatasetReader, rows: u64) -> Known<Sensitivity> {
    if rows > MOST_ANALYSED {
        return Known::not(format!("{rows} rows take longer than a page should: decore analyse finds their indices."));
    }
    Known::of(analyse(reader, &SensitivitySettings::default()))
}

/// Fits the models of a dataset with this number of rows with the defaults of `decore surrogate`, and appends the predictors to the page's
/// data.
pub(super) fn models(reader: &DatasetReader, rows: u64, data: &mut Vec<u8>) -> Known<Models> {
    if rows > MOST_MODELLED {
        return Known::not(format!(
            "Models of {rows} rows take longer than a page should: decore surrogate fits them."
        ));
    }
    let model = fit(reader, &SurrogateSettings::default());
    Known::of(model.map(|model| Models {
        warnings: model.surrogate.warnings(),
        model: model_data(&model, data),
        surrogate: model.surrogate,
    }))
}
