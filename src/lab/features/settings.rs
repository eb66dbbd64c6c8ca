//! Settings of a table of features: contents and format.

use serde::Serialize;

use super::groups::GroupBy;
use super::splits::Splits;
use decore_quantity::named;

named! {
    /// Format of the table's file.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
    pub enum Format {
        /// Parquet, with the dictionary in the metadata of its fields.
        #[default]
        Parquet = "parquet",
        /// Text with a comma between cells; nulls are empty.
        Csv = "csv",
    }
}

impl Format {
    /// Name of the table's file.
    pub fn file(self) -> &'static str {
        match self {
            Self::Parquet => "features.parquet",
            Self::Csv => "features.csv",
        }
    }
}

/// Contents of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureSettings {
    /// Energy in J from which a blow counts in the dose. Default 0: every blow that reaches the casting.
    pub dose_threshold_j: f64,
    /// Cumulative work in J; the time to reach it is a column. Default: no such column.
    pub work_j: Option<f64>,
    /// Shares of the rows for training and testing. Default: no such column.
    pub splits: Option<Splits>,
    /// Reasons for which rows are kept together besides trajectories, base points and equal values. Default: none.
    pub group_by: Vec<GroupBy>,
    /// Format of the table's file.
    pub format: Format,
    /// Whether files of an earlier export are written over.
    pub replace: bool,
}

impl Default for FeatureSettings {
    fn default() -> Self {
        Self {
            dose_threshold_j: 0.0,
            work_j: None,
            splits: None,
            group_by: Vec::new(),
            format: Format::default(),
            replace: false,
        }
    }
}
