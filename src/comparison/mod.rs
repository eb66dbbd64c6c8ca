//! The difference of two datasets: their rows matched by the values of the factors, and outputs that differ by more than
//! they scatter.
//!
//! # What belongs together
//!
//! Two rows match if all factors have equal values: to the last bit, whole numbers and real ones alike. Of rows with the same
//! values in one dataset (repetitions, a study without factors) the first matches the first, the second the second.
//!
//! # When an output differs
//!
//! A row and its twins span a range of each main output, of which `<output>_scatter` is the half, `s`. The rows may be anywhere
//! within theirs. Their outputs `a` and `b` lie beyond their scatter where these ranges cannot meet:
//!
//! ```text
//! |a - b| > 2 (s_a + s_b)
//! ```
//!
//! Where only one dataset has twins, the other is taken to scatter as much. Without any, or for an output without a scatter, two
//! numbers differ where `|a - b| > relative * max(|a|, |b|)`. Texts differ where they are not the same and neither row has a
//! twin with another one. An output that only one of two rows has differs.
//!
//! Outputs are compared of rows that are done in both; rows of different status are listed by themselves.
//!
//! # Memory
//!
//! 56 bytes per row of each dataset for the matching, and a quarter of a gigabyte for the outputs that are looked at together.

mod error;
mod matching;
mod outputs;
mod result;

use crate::dataset::DatasetReader;

pub use error::ComparisonError;
pub use result::{Comparison, Listed, OutputDifference, PairDifference, Side, StatusDifference, comparison_schema};

use matching::Matching;
use outputs::Outputs;

/// How to compare.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonSettings {
    /// Columns of the table of runs to compare; empty (default): all main outputs.
    pub outputs: Vec<String>,
    /// Relative difference from which on numbers without a measured scatter differ. Default 1e-4: between the settings of a solver
    /// that converges, outputs of periodic percussion move by less.
    pub relative: f64,
    /// Rows that are listed at most, of each kind; all are counted. Default 20.
    pub most: usize,
}

impl Default for ComparisonSettings {
    fn default() -> Self {
        Self { outputs: Vec::new(), relative: 1e-4, most: 20 }
    }
}

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
