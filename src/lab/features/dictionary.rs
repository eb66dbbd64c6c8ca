//! Data dictionary: descriptions of all columns, as JSON and as a plain table.

use serde::Serialize;

use super::column::{FeatureColumn, Role};
use super::error::FeaturesError;
use decore_quantity::Kind;

/// Descriptions of a table's columns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dictionary<'a> {
    /// Name of the table's file.
    pub table: &'a str,
    /// Number of rows.
    pub rows: usize,
    /// The columns, in order.
    pub columns: Vec<DictionaryEntry<'a>>,
}

/// Description of a column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DictionaryEntry<'a> {
    /// Name of the column.
    pub name: &'a str,
    /// Type of its values.
    #[serde(rename = "type")]
    pub kind: Kind,
    /// Unit; `1` for numbers without one, empty for texts.
    pub unit: &'a str,
    /// Role of the column.
    pub role: Role,
    /// Description in words.
    pub description: &'a str,
    /// Formula from the tables of the dataset.
    pub formula: &'a str,
    /// Least value that can be right; null: no limit.
    pub valid_minimum: Option<f64>,
    /// Largest value that can be right; null: no limit.
    pub valid_maximum: Option<f64>,
    /// Columns of the table that it follows from by arithmetic.
    pub derived_from: &'a [String],
}

impl<'a> Dictionary<'a> {
    /// The dictionary of columns in the file `table`.
    pub fn of(table: &'a str, columns: &'a [FeatureColumn]) -> Self {
        let entry = |column: &'a FeatureColumn| {
            let [valid_minimum, valid_maximum] = column.valid;
            DictionaryEntry {
                name: &column.name,
                kind: column.values.kind(),
                unit: &column.unit,
                role: column.role,
                description: &column.description,
                formula: &column.formula,
                valid_minimum,
                valid_maximum,
                derived_from: &column.derived_from,
            }
        };
        let rows = columns.first().map_or(0, |column| column.values.count);
        Self { table, rows, columns: columns.iter().map(entry).collect() }
    }

    /// As JSON.
    pub fn json(&self) -> String {
        format!("{:#}\n", serde_json::json!(self))
    }

    /// As a table with a row per column; several names are separated by blanks.
    ///
    /// # Errors
    /// [`FeaturesError::Write`], should memory not suffice.
    pub fn csv(&self) -> Result<Vec<u8>, FeaturesError> {
        let kind = |kind: Kind| match kind {
            Kind::Real => "real",
            Kind::Count => "count",
            Kind::Integer => "integer",
            Kind::Text => "text",
            Kind::Category => "category",
        };
        let end = |end: Option<f64>| end.map_or(String::new(), |value| value.to_string());
        let header = [
            "name",
            "type",
            "unit",
            "role",
            "description",
            "formula",
            "valid_minimum",
            "valid_maximum",
            "derived_from",
        ];
        let entries = self.columns.iter().map(|entry| {
            let texts = [entry.name, kind(entry.kind), entry.unit, entry.role.name(), entry.description, entry.formula];
            let further = [end(entry.valid_minimum), end(entry.valid_maximum), entry.derived_from.join(" ")];
            texts.map(str::to_owned).into_iter().chain(further).collect()
        });
        super::file::csv([header.map(str::to_owned).to_vec()].into_iter().chain(entries))
    }
}
