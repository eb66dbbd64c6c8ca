//! Compares two datasets.

use super::error::ComparisonError;
use super::matching::Matching;
use super::outputs::Outputs;
use super::result::{Comparison, Listed, Side};
use super::settings::ComparisonSettings;
use decore_dataset::DatasetReader;

/// Compares two datasets.
///
/// # Errors
/// Datasets whose factors are not the same, unknown outputs, and those of reading.
pub fn compare(
    a: &DatasetReader,
    b: &DatasetReader,
    settings: &ComparisonSettings,
) -> Result<Comparison, ComparisonError> {
    let outputs = Outputs::of(a, b, &settings.outputs)?;
    let matching = Matching::of(a, b)?;
    let most = settings.most;
    let mut found = Comparison {
        a: Side::of(a),
        b: Side::of(b),
        factors: matching.factors.clone(),
        relative: settings.relative,
        matched: matching.pairs().count() as u64,
        only_in_a: Listed::first(most, matching.only_in_a()),
        only_in_b: Listed::first(most, matching.only_in_b()),
        statuses: Listed::first(most, matching.statuses()),
        outputs: Vec::new(),
        outputs_only_in_a: outputs.only_in_a.clone(),
        outputs_only_in_b: outputs.only_in_b.clone(),
        outputs_of_other_units: outputs.of_other_units.clone(),
        beyond: Listed::first(most, std::iter::empty()),
    };
    outputs.compare(&matching, settings, &mut found)?;
    Ok(found)
}
