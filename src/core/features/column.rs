//! A column of the table and what the dictionary says of it.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::types::Int32Type;
use arrow_array::{ArrayRef, DictionaryArray, Float64Array, Int64Array, StringArray, UInt64Array};
use arrow_schema::Field;
use serde::Serialize;

use crate::quantity::{Cell, Kind, Value, named};

named! {
    /// What a column is for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    pub enum Role {
        /// Names the row of the table.
        Key = "key",
        /// How the run ended and how well its books balance.
        Status = "status",
        /// Says which rows belong together.
        Group = "group",
        /// Says which part of the splits the row is for.
        Split = "split",
        /// A factor of the design: what a predictor may know.
        Factor = "factor",
        /// A result: what a predictor is to tell.
        Target = "target",
        /// How far a target is sure: its scatter over twins, its standard error.
        Scatter = "scatter",
    }
}

/// Values of a column, row by row; `None` becomes null.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Real numbers.
    Real(Vec<Option<f64>>),
    /// Numbers of things.
    Count(Vec<Option<u64>>),
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Texts.
    Text(Vec<Option<String>>),
    /// Texts of which there are few.
    Category(Vec<Option<String>>),
}

impl Values {
    /// No values of a kind.
    pub fn none(kind: Kind) -> Self {
        match kind {
            Kind::Real => Self::Real(Vec::new()),
            Kind::Count => Self::Count(Vec::new()),
            Kind::Integer => Self::Integer(Vec::new()),
            Kind::Text => Self::Text(Vec::new()),
            Kind::Category => Self::Category(Vec::new()),
        }
    }

    /// The kind of the values.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Real(_) => Kind::Real,
            Self::Count(_) => Kind::Count,
            Self::Integer(_) => Kind::Integer,
            Self::Text(_) => Kind::Text,
            Self::Category(_) => Kind::Category,
        }
    }

    /// Adds a cell; one of another kind becomes null.
    pub fn push(&mut self, cell: Cell<'_>) {
        match (self, cell) {
            (Self::Real(values), Some(Value::Real(value))) => values.push(Some(value)),
            (Self::Count(values), Some(Value::Count(value))) => values.push(Some(value)),
            (Self::Integer(values), Some(Value::Integer(value))) => values.push(Some(value)),
            (Self::Text(values) | Self::Category(values), Some(Value::Text(text))) => {
                values.push(Some(text.to_owned()))
            }
            (Self::Real(values), _) => values.push(None),
            (Self::Count(values), _) => values.push(None),
            (Self::Integer(values), _) => values.push(None),
            (Self::Text(values) | Self::Category(values), _) => values.push(None),
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Count(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Text(values) | Self::Category(values) => values.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of a row as a number; `None` for nulls and texts.
    pub fn number(&self, row: usize) -> Option<f64> {
        match self {
            Self::Real(values) => *values.get(row)?,
            Self::Count(values) => values.get(row)?.map(|value| value as f64),
            Self::Integer(values) => values.get(row)?.map(|value| value as f64),
            Self::Text(_) | Self::Category(_) => None,
        }
    }

    /// The value of a row as a text that reads back the same; empty for null.
    pub fn text(&self, row: usize) -> String {
        fn shown<T: ToString>(values: &[Option<T>], row: usize) -> String {
            values.get(row).and_then(Option::as_ref).map_or(String::new(), T::to_string)
        }
        match self {
            Self::Real(values) => shown(values, row),
            Self::Count(values) => shown(values, row),
            Self::Integer(values) => shown(values, row),
            Self::Text(values) | Self::Category(values) => shown(values, row),
        }
    }

    fn array(&self) -> ArrayRef {
        match self {
            Self::Real(values) => Arc::new(Float64Array::from(values.clone())),
            Self::Count(values) => Arc::new(UInt64Array::from(values.clone())),
            Self::Integer(values) => Arc::new(Int64Array::from(values.clone())),
            Self::Text(values) => Arc::new(StringArray::from(values.clone())),
            Self::Category(values) => {
                Arc::new(values.iter().map(Option::as_deref).collect::<DictionaryArray<Int32Type>>())
            }
        }
    }
}

/// A column of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name; its suffix is the unit.
    pub name: String,
    /// Unit; `1` for numbers without one, empty for texts.
    pub unit: String,
    /// What it is for.
    pub role: Role,
    /// What it is, in words.
    pub description: String,
    /// How it follows from the tables of the dataset.
    pub formula: String,
    /// Least and largest value that can be right; `None`: no limit on that side.
    pub valid: [Option<f64>; 2],
    /// Columns of this table that it follows from by arithmetic.
    pub derived_from: Vec<String>,
    /// The values.
    pub values: Values,
}

impl Column {
    /// The field with all that the dictionary says of it, and the values.
    pub fn field(&self) -> (Field, ArrayRef) {
        let array = self.values.array();
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
        (Field::new(&self.name, array.data_type().clone(), true).with_metadata(metadata), array)
    }

    /// The valid range as `low..high`, an open side left out; empty where there is none.
    pub fn valid_text(&self) -> String {
        let end = |end: Option<f64>| end.map_or(String::new(), |value| value.to_string());
        match self.valid {
            [None, None] => String::new(),
            [low, high] => format!("{}..{}", end(low), end(high)),
        }
    }
}
