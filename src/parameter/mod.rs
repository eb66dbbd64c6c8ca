//! Parameters declared once: name, type, default, unit, range, source and text of each stand together.
//!
//! The macro `parameters!` makes of a declaration the struct with its documentation, its defaults, its reader and writer, its JSON
//! schema with the ranges, and the check. A parameter without a range does not compile.

#[macro_use]
mod words;
mod declare;
mod document;
mod range;

use schemars::Schema;

pub(crate) use declare::{check, declared, kind, parameters};
pub use document::document;
pub(crate) use range::range;
pub use range::{Numbers, Range};

/// A group of parameters, as `parameters!` declares it.
pub trait Parameters {
    /// The declarations, in the order of the fields.
    const ENTRIES: &'static [Parameter];

    /// Holds every value to its range. `at`: path of the group, for the faults.
    fn check(&self, at: &str, faults: &mut Vec<Fault>);
}

/// A type of a few names, all of which are allowed: what has it needs no range.
pub trait Choice {}

impl Choice for bool {}

/// Declaration of one parameter.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name of the field, the key in files.
    pub name: &'static str,
    /// The field's text, line by line as written.
    pub text: &'static [&'static str],
    /// Its default as written in the declaration; empty where it has none.
    pub default: &'static str,
    /// Where its value comes from.
    pub source: &'static str,
    /// What values it may have.
    pub kind: Kind,
}

impl Parameter {
    /// The text as one line.
    pub fn description(&self) -> String {
        let lines: Vec<&str> = self.text.iter().map(|line| line.trim()).collect();
        lines.join(" ")
    }
}

/// What values a parameter may have.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// Numbers, or lists of numbers, each in a range.
    Number(Range),
    /// One of a few names.
    Choice,
    /// A group of its own, with these entries.
    Group(&'static [Parameter]),
}

/// A value outside its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Path of the parameter.
    pub path: String,
    /// What it is and what was expected.
    pub message: String,
}

/// Writes the ranges of a group's numbers into its JSON schema.
pub(crate) fn write_ranges<T: Parameters>(schema: &mut Schema) {
    for entry in T::ENTRIES {
        let Kind::Number(range) = entry.kind else { continue };
        let Some(property) = schema.pointer_mut(&format!("/properties/{}", entry.name)) else { continue };
        let number = if property.get("items").is_some() { property.pointer_mut("/items") } else { Some(property) };
        if let Some(object) = number.and_then(serde_json::Value::as_object_mut) {
            object.extend(range.keywords());
        }
    }
}
