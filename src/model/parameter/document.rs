//! Writes a group of parameters as a file that shows every key with its default.

use std::fmt::Write;

use serde::Serialize;
use toml::{Table, Value, ser::Error};

use super::entry::{Parameter, ParameterKind, Parameters};

/// Column in which the words behind a value begin, if the value leaves room.
const COLUMN: usize = 39;
/// Columns of a line.
const WIDTH: usize = 126;

/// The TOML file of a group of groups with all defaults: a table per group, a line per parameter, its text and source behind it.
///
/// # Errors
/// A default that TOML cannot hold.
pub fn document<T: Parameters + Serialize + Default>(head: &str) -> Result<String, Error> {
    let values = Table::try_from(T::default())?;
    let mut text = head.to_owned();
    for group in T::ENTRIES {
        if let (ParameterKind::Group(entries), Some(Value::Table(values))) = (group.kind, values.get(group.name)) {
            // Writing into a text cannot fail.
            let _ = writeln!(text, "\n# {}\n[{}]", group.description(), group.name);
            let source = |entry: &Parameter| Some(entry.source.to_owned());
            text.push_str(&lines(entries, values, "", &source));
        }
    }
    Ok(text)
}

/// Writes a line per parameter that has a value: `prefix`, key, value, then the text, and the result of `more` in brackets.
pub fn lines(
    entries: &[Parameter],
    values: &Table,
    prefix: &str,
    more: &dyn Fn(&Parameter) -> Option<String>,
) -> String {
    let mut text = String::new();
    for (entry, value) in entries.iter().filter_map(|entry| Some((entry, values.get(entry.name)?))) {
        let about = entry.description().replace('`', "");
        let about = about.trim_end_matches('.');
        let words = more(entry).map_or_else(|| about.to_owned(), |more| format!("{about} ({more})"));
        let mut line = format!("{:COLUMN$} #", format!("{prefix}{} = {}", entry.name, written(value)));
        for word in words.split(' ') {
            if line.len() + word.len() >= WIDTH {
                let _ = writeln!(text, "{line}");
                line = format!("{:COLUMN$} #", prefix.trim_end());
            }
            let _ = write!(line, " {word}");
        }
        let _ = writeln!(text, "{line}");
    }
    text
}

/// A readable number: powers of ten if they are shorter.
fn written(value: &Value) -> String {
    match value {
        Value::Float(number) => {
            let (plain, power) = (value.to_string(), format!("{number:e}"));
            let far = number.abs() >= 1e4 || number.abs() < 1e-3;
            if far && plain.len() > power.len() { power } else { plain }
        }
        Value::Array(items) => format!("[{}]", items.iter().map(written).collect::<Vec<_>>().join(", ")),
        Value::Table(pairs) => {
            let pairs: Vec<String> = pairs.iter().map(|(key, value)| format!("{key} = {}", written(value))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        _ => value.to_string(),
    }
}
