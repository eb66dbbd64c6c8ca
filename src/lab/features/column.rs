//! A column of the table, with its dictionary entry.

use std::collections::HashMap;

use arrow_array::ArrayRef;
use arrow_schema::{ArrowError, Field};
use serde::Serialize;

use decore_dataset::array;
use decore_quantity::{CellColumn, named};

named! {
    /// Role of a column.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    pub enum Role {
        /// Names the row of the table.
        Key = "key",
        /// Status of the run, and residuals of its audits.
        Status = "status",
        /// Group of dependent rows.
        Group = "group",
        /// Part of the splits.
        Split = "split",
        /// A factor of the design: an input of the predictor.
        Factor = "factor",
        /// A result: a value to predict.
        Target = "target",
        /// Uncertainty of a target: its scatter over twins, its standard error.
        Scatter = "scatter",
    }
}

/// A column of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureColumn {
    /// Name; its suffix is the unit.
    pub name: String,
    /// Unit; `1` for numbers without one, empty for texts.
    pub unit: String,
    /// Role of the column.
    pub role: Role,
    /// Description in words.
    pub description: String,
    /// Formula from the tables of the dataset.
    pub formula: String,
    /// Least and largest value that can be right; `None`: no limit on that side.
    pub valid: [Option<f64>; 2],
    /// Columns of this table that it follows from by arithmetic.
    pub derived_from: Vec<String>,
    /// Values; missing ones become null.
    pub values: CellColumn,
}

impl FeatureColumn {
    /// Returns the field with all entries of the dictionary, and the values.
    ///
    /// # Errors
    /// The Arrow library's, such as texts of more than 2 GiB.
    pub fn field(&self) -> Result<(Field, ArrayRef), ArrowError> {
        let array = array(self.values.clone())?;
        let metadata = HashMap::from(
            [
                ("unit", self.unit.clone()),
                ("description", self.description.clone()),
                ("role", self.role.name().to_owned()),
                ("formula", self.formula.clone()),
                ("valid_range", self.valid_text()),
                ("derived_from", self.derived_from.join(" ")),
            ]
            .map(|(key, value)| (key.to_owned(), value)),
        );
        Ok((Field::new(&self.name, array.data_type().clone(), true).with_metadata(metadata), array))
    }

    /// The valid range as `low..high`, an open side left out; empty if there is none.
    pub fn valid_text(&self) -> String {
        let end = |end: Option<f64>| end.map_or(String::new(), |value| value.to_string());
        match self.valid {
            [None, None] => String::new(),
            [low, high] => format!("{}..{}", end(low), end(high)),
        }
    }
}
