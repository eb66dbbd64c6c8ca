//! A value and its kind.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of a value, hence type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// 64-bit floating point.
    Real,
    /// 64-bit unsigned.
    Count,
    /// 64-bit signed.
    Integer,
    /// UTF-8: free text.
    Text,
    /// UTF-8 of which there are few: how something ended, a kind, a name. A column of them has a dictionary.
    Category,
}

impl Kind {
    /// Whether values are texts.
    pub fn is_text(self) -> bool {
        matches!(self, Self::Text | Self::Category)
    }
}

/// A value of a factor or an output; `Value<&str>` borrows its text.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "FactorValue", description = "Value of a factor.")]
pub enum Value<T = String> {
    /// A whole number.
    Integer(i64),
    /// A real number.
    Real(f64),
    /// A text, e.g. the name of an interface point.
    Text(T),
    /// A number of things; a whole number that was typed is an integer.
    #[serde(skip_deserializing)]
    Count(u64),
}

/// A value where there may be none: a cell of a table.
pub type Cell<'a> = Option<Value<&'a str>>;

impl<T> Value<T> {
    /// The value's kind.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Real(_) => Kind::Real,
            Self::Count(_) => Kind::Count,
            Self::Integer(_) => Kind::Integer,
            Self::Text(_) => Kind::Text,
        }
    }

    /// The value as a floating-point number; `None` for a text.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(*value),
            Self::Count(count) => Some(*count as f64),
            Self::Integer(number) => Some(*number as f64),
            Self::Text(_) => None,
        }
    }

    /// The same value with its text made another type of text.
    fn map<'a, U>(&'a self, text: impl FnOnce(&'a T) -> U) -> Value<U> {
        match self {
            Self::Real(value) => Value::Real(*value),
            Self::Count(count) => Value::Count(*count),
            Self::Integer(number) => Value::Integer(*number),
            Self::Text(from) => Value::Text(text(from)),
        }
    }
}

impl Value {
    /// The value with its text borrowed.
    pub fn borrowed(&self) -> Value<&str> {
        self.map(String::as_str)
    }
}

impl Value<&str> {
    /// The value with a text of its own.
    pub fn owned(&self) -> Value {
        self.map(|text| (*text).to_owned())
    }
}

impl<T: fmt::Display> fmt::Display for Value<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real(value) => value.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Integer(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}
