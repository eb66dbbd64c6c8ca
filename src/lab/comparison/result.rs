//! Result of a comparison: plain data, equal in text and JSON.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use decore_dataset::DatasetReader;
use decore_quantity::Value;

/// The difference of two datasets, A and B.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// The first dataset.
    pub a: Side,
    /// The second dataset.
    pub b: Side,
    /// The factors by whose values rows are matched; none: row by row.
    pub factors: Vec<String>,
    /// Relative difference from which on numbers without a measured scatter differ.
    pub relative: f64,
    /// Rows that are in both.
    pub matched: u64,
    /// Rows of A whose values no row of B has.
    pub only_in_a: Listed<u64>,
    /// Rows of B whose values no row of A has.
    pub only_in_b: Listed<u64>,
    /// Matched rows that ended differently.
    pub statuses: Listed<StatusDifference>,
    /// The outputs that were compared, over the matched rows that are done in both.
    pub outputs: Vec<OutputDifference>,
    /// Outputs that were to be compared and that only A has.
    pub outputs_only_in_a: Vec<String>,
    /// Outputs that were to be compared and that only B has.
    pub outputs_only_in_b: Vec<String>,
    /// Outputs that have another unit, or another type, in B, and were not compared.
    pub outputs_of_other_units: Vec<String>,
    /// Values beyond their scatter, by how far they are beyond it, farthest first.
    pub beyond: Listed<PairDifference>,
}

impl Comparison {
    /// Whether nothing was found to differ.
    pub fn is_same(&self) -> bool {
        let counts = [self.only_in_a.count, self.only_in_b.count, self.statuses.count, self.beyond.count];
        let columns = [&self.outputs_only_in_a, &self.outputs_only_in_b, &self.outputs_of_other_units];
        counts == [0; 4] && columns.iter().all(|names| names.is_empty())
    }
}

/// One of the two datasets.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Side {
    /// Folder of the dataset.
    pub folder: PathBuf,
    /// Name of its study.
    pub study: String,
    /// Hash of its study.
    pub study_hash: String,
    /// Version of the program that wrote it.
    pub program_version: String,
    /// Rows that it holds, whatever their status.
    pub rows: u64,
    /// Twins of each row.
    pub twins: u64,
}

impl Side {
    /// Reads a dataset's description.
    pub(super) fn of(reader: &DatasetReader) -> Self {
        let study = &reader.manifest().study;
        Self {
            folder: reader.folder().to_owned(),
            study: study.study_name.clone(),
            study_hash: study.study_hash.clone(),
            program_version: study.program_version.clone(),
            rows: reader.manifest().rows_done,
            twins: study.twins,
        }
    }
}

/// A list, truncated after its beginning.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Listed<T> {
    /// Number of such rows.
    pub count: u64,
    /// The first of them.
    pub listed: Vec<T>,
}

impl<T> Listed<T> {
    /// Counts all and keeps the first.
    pub(super) fn first(most: usize, all: impl Iterator<Item = T>) -> Self {
        let mut found = Self { count: 0, listed: Vec::new() };
        for entry in all {
            found.count += 1;
            if found.listed.len() < most {
                found.listed.push(entry);
            }
        }
        found
    }
}

/// Two matched rows that ended differently.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct StatusDifference {
    /// Row of A.
    pub row_a: u64,
    /// Row of B.
    pub row_b: u64,
    /// Status of A's row.
    pub status_a: String,
    /// Status of B's row.
    pub status_b: String,
}

/// Difference of an output over the rows.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OutputDifference {
    /// The column.
    pub name: String,
    /// Unit; empty for texts.
    pub unit: String,
    /// Pairs of rows of which at least one has a value.
    pub pairs: u64,
    /// Number of those whose scatter was measured by twins.
    pub measured: u64,
    /// Number of those beyond their scatter.
    pub beyond: u64,
    /// Pairs of which one has a value and the other has none; they count as beyond.
    pub one_sided: u64,
    /// Median of the absolute differences; `null` for texts and where no pair has two numbers.
    pub median: Option<f64>,
    /// Pair with the largest absolute difference among those with two values; for texts the first pair that differs. `null` if all
    /// are equal.
    pub worst: Option<PairDifference>,
}

/// An output of two matched rows.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PairDifference {
    /// The column.
    pub output: String,
    /// Unit; empty for texts.
    pub unit: String,
    /// Row of A.
    pub row_a: u64,
    /// Row of B.
    pub row_b: u64,
    /// Value in A.
    pub value_a: Option<Value>,
    /// Value in B.
    pub value_b: Option<Value>,
    /// Permitted absolute difference of two numbers; `null` for texts and if one value is missing.
    pub allowed: Option<f64>,
    /// Whether that is the scatter that twins measured.
    pub measured: bool,
}

impl PairDifference {
    /// The absolute difference of two numbers; `None` of texts and where one lacks a value.
    pub fn difference(&self) -> Option<f64> {
        let number = |value: &Option<Value>| value.as_ref().and_then(Value::number);
        let [a, b] = [number(&self.value_a)?, number(&self.value_b)?];
        Some(if a == b { 0.0 } else { (a - b).abs() })
    }
}
