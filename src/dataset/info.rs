//! A dataset's information about its study, and the data that it takes for each row: plain data, no types of studies.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use decore_model::metrics::Signal;
use decore_model::run::{DEFAULT_RETRIES, RowOutcome};
use decore_quantity::words::identifier;
use decore_quantity::{Kind, Value, quantities};
use decore_statistics::design::GroupSpan;

/// One factor of the design.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FactorColumn {
    /// Name as in the study.
    pub name: String,
    /// Type of its values.
    pub kind: Kind,
    /// Unit of its values; `1` for numbers without one, empty for names.
    pub unit: String,
    /// Description in words: the paths of the study that the factor drives.
    pub description: String,
}

/// A core point or a fixture with columns of its own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartColumn {
    /// Name of its casting as in the study.
    pub casting: String,
    /// Name as in the study.
    pub name: String,
}

/// One column of the table of signals.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SignalColumn {
    /// Name, with the unit as its suffix.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Description of the signal and of its averaging.
    pub description: String,
}

impl SignalColumn {
    /// Column of a signal whose means over `interval_s` are stored.
    pub fn of(signal: &Signal, interval_s: f64) -> Self {
        let what = signal.description.trim_end_matches('.');
        Self {
            name: identifier(&signal.name, "signals"),
            unit: signal.unit.to_owned(),
            description: format!(
                "{what}; mean over {interval_s} s around the instant (zero phase, gain |sinc(f {interval_s} s)|)."
            ),
        }
    }
}

/// A dataset's information about its study. Fixed for the whole dataset, stored in its manifest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DatasetInfo {
    /// Name of the study.
    pub study_name: String,
    /// The study file's text, as typed.
    pub study_text: String,
    /// Hash of the values of the study and its hammer files, in hexadecimal.
    pub study_hash: String,
    /// The same over all except the number of rows: a study that only got more rows has the same one. Empty: not known.
    #[serde(default)]
    pub frame_hash: String,
    /// The same as [`DatasetInfo::study_hash`] over all except the budgets of a row: rows that met none are the same under any.
    /// Empty: not known.
    #[serde(default)]
    pub budget_free_hash: String,
    /// Hash of the factors' values in the rows, by which a study that got more rows is known to start with the old ones.
    #[serde(default)]
    pub rows_hash: String,
    /// Values set over the study's, `path=value`.
    pub overrides: Vec<String>,
    /// BLAKE3 of the files that the rows depend on besides, by the key and name of the file.
    pub inputs: BTreeMap<String, String>,
    /// Text of each hammer file that the study names, by the name that the study gives it: rows can be run again without the files.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub hammer_files: BTreeMap<String, String>,
    /// Settings outside the study that the rows' results depend on, by name.
    pub settings: BTreeMap<String, String>,
    /// Seed of the design.
    pub seed: u64,
    /// Version of the program.
    pub program_version: String,
    /// Hash of the tables' columns, by which a program of the same version that has others is known. Empty: not known.
    #[serde(default)]
    pub columns_hash: String,
    /// Rows of the design.
    pub rows: u64,
    /// Rows per part file; `rows_per_part(rows)` unless there is a reason for another number.
    pub rows_per_part: u64,
    /// Factors of the design, in the study's order.
    pub factors: Vec<FactorColumn>,
    /// Measures of the design's points (smallest distance, discrepancies, correlation, points tried and accepted under
    /// constraints); null for a design without factors.
    #[serde(default)]
    pub design_quality: serde_json::Value,
    /// Groups of dependent rows of the design. `None`: unknown, because an older program wrote the dataset.
    #[serde(default)]
    pub row_groups: Option<Vec<GroupSpan>>,
    /// Twins of each row.
    #[serde(default)]
    pub twins: u64,
    /// Whether some rows have numerical twins.
    #[serde(default)]
    pub numerical_twins: bool,
    /// Names of the hammers, in the scene's order.
    pub hammers: Vec<String>,
    /// Names of the castings, in the scene's order.
    pub castings: Vec<String>,
    /// Names of the elastic castings, in the scene's order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elastic_castings: Vec<String>,
    /// Core points of the castings, casting by casting.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cores: Vec<PartColumn>,
    /// One-sided fixtures, casting by casting.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pads: Vec<PartColumn>,
    /// Fixtures whose energies are kept, casting by casting.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixture_energies: Vec<PartColumn>,
    /// Whether spectra of the core points are kept.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub core_spectra: bool,
    /// Columns of the table of signals behind row and time; empty: there is no such table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<SignalColumn>,
}

/// Name among [`DatasetInfo::settings`] of how many times a row that diverges is run again.
pub const RETRIES: &str = "retries";

impl DatasetInfo {
    /// Number of retries of a row that diverges.
    pub fn retries(&self) -> u32 {
        self.settings.get(RETRIES).and_then(|times| times.parse().ok()).unwrap_or(DEFAULT_RETRIES)
    }
}

impl DatasetInfo {
    /// An empty study: it has only the columns that every study has.
    pub fn empty() -> Self {
        Self {
            study_name: String::new(),
            study_text: String::new(),
            study_hash: String::new(),
            frame_hash: String::new(),
            budget_free_hash: String::new(),
            rows_hash: String::new(),
            overrides: Vec::new(),
            inputs: BTreeMap::new(),
            hammer_files: BTreeMap::new(),
            settings: BTreeMap::new(),
            seed: 0,
            program_version: String::new(),
            columns_hash: String::new(),
            rows: 0,
            rows_per_part: 64,
            factors: Vec::new(),
            design_quality: serde_json::Value::Null,
            row_groups: None,
            twins: 0,
            numerical_twins: false,
            hammers: Vec::new(),
            castings: Vec::new(),
            elastic_castings: Vec::new(),
            cores: Vec::new(),
            pads: Vec::new(),
            fixture_energies: Vec::new(),
            core_spectra: false,
            signals: Vec::new(),
        }
    }
}

/// Rows per part for a design of `rows` rows: about 64 parts, each a power of two from 64 to 4096 rows.
///
/// Small parts let readers see results early; large ones keep the files of a long sweep few and their writing cheap, as a file takes
/// as long for each of its columns as some hundred rows. A row is safe in the journal before its part is written. The number depends
/// on the design only, never on timing.
pub fn rows_per_part(rows: u64) -> u64 {
    // Clamped before rounding up: `next_power_of_two` overflows near the end of u64.
    (rows / 64).clamp(64, 4096).next_power_of_two()
}

quantities! {
    /// One row as the dataset takes it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct RowRecord {
        /// Index of the row in the design, from 0.
        pub row: u64 => "1",
        /// Values of the factors, in the order of [`DatasetInfo::factors`].
        pub factors: Vec<Value>,
        /// Outcome of the row.
        pub outcome: RowOutcome,
    }
}
