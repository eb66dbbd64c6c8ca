//! A declaration as data, for use at run time.

use schemars::Schema;

use super::range::{Fault, Range};

/// A group of parameters, as `parameters!` declares it.
pub trait Parameters {
    /// The declarations, in the order of the fields.
    const ENTRIES: &'static [Parameter];

    /// Holds every value to its range. `at`: path of the group, for the faults.
    fn check(&self, at: &str, faults: &mut Vec<Fault>);

    /// Adds a remark for every value that is not between its usual ones: most likely it is stated in another unit.
    fn unusual(&self, at: &str, remarks: &mut Vec<Fault>);
}

/// Path of a key in a group; the group at the top of a file has an empty path.
pub(crate) fn key(group: &str, name: &str) -> String {
    if group.is_empty() { name.to_owned() } else { format!("{group}.{name}") }
}

/// A type of a few values, all of which are permitted. It needs no range.
pub trait Choice {
    /// Nothing to check.
    fn check(&self) {}
}

impl Choice for bool {}

/// Declaration of one parameter.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name of the field, the key in files.
    pub name: &'static str,
    /// The field's text, line by line as written.
    pub text: &'static [&'static str],
    /// Unit, range, default and source in a sentence; empty for groups in a group of groups.
    pub values: &'static str,
    /// Source of the value.
    pub source: &'static str,
    /// Kind of permitted values.
    pub kind: ParameterKind,
}

impl Parameter {
    /// The text as one line.
    pub fn description(&self) -> String {
        let lines: Vec<&str> = self.text.iter().map(|line| line.trim()).collect();
        lines.join(" ")
    }
}

/// Kind of values of a parameter.
#[derive(Debug, Clone, Copy)]
pub enum ParameterKind {
    /// Numbers, or lists of numbers, each in a range.
    Number(Range),
    /// One of a few names.
    Choice,
    /// A group of its own, with these entries.
    Group(&'static [Parameter]),
}

/// Range and default of an entry, the default as in a TOML file instead of the Rust expression.
fn toml_values(values: &str) -> String {
    let marks = [("; default ", " ("), ("; default ", ". "), ("; default ", "."), ("Default `", "` in N/m, N s/m")];
    let found = marks.into_iter().find_map(|(start, end)| {
        let (before, rest) = values.split_once(start)?;
        let (default, after) = rest.split_once(end)?;
        // The keys of a contact have the units in their names.
        let end = if end.starts_with('`') { "`" } else { end };
        Some(format!("{before}{start}{}{end}{after}", toml_default(default)))
    });
    found.unwrap_or_else(|| values.to_owned())
}

/// A default in TOML.
fn toml_default(expression: &str) -> String {
    let inside = |name: &str| expression.strip_prefix(name)?.strip_prefix('(')?.strip_suffix(')');
    if let Some((stiffness, damping)) = inside("kelvin_voigt").and_then(|both| both.split_once(", ")) {
        return format!("{{ stiffness_n_per_m = {stiffness}, damping_n_s_per_m = {damping} }}");
    }
    match (inside("Ratio"), expression) {
        (Some(ratio), _) => ratio.to_owned(),
        (None, "Vec::new()") => "[]".to_owned(),
        (None, number) if number.starts_with(|first: char| first.is_ascii_digit()) => number.replace('_', ""),
        (None, other) => other.to_owned(),
    }
}

/// Writes the declarations of a group into the JSON schema of a table with its keys: descriptions and ranges.
pub fn describe<T: Parameters>(schema: &mut Schema) {
    for entry in T::ENTRIES {
        let Some(property) = schema.pointer_mut(&format!("/properties/{}", entry.name)) else { continue };
        if let Some(object) = property.as_object_mut() {
            let description = format!("{} {}", entry.description(), toml_values(entry.values));
            object.insert("description".to_owned(), description.trim_end().into());
        }
        let ParameterKind::Number(range) = entry.kind else { continue };
        let number = if property.get("items").is_some() { property.pointer_mut("/items") } else { Some(property) };
        if let Some(object) = number.and_then(serde_json::Value::as_object_mut) {
            object.extend(range.keywords());
        }
    }
}
