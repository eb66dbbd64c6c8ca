//! A group of parameters written out as a file that shows every key with its default.

use std::fmt::Write;

use serde::Serialize;

use super::{Kind, Parameter, Parameters};

/// The TOML file of a group of groups with all defaults: a table per group, a line per parameter, its text and source behind it.
///
/// # Errors
/// A default that TOML cannot hold.
pub fn document<T: Parameters + Serialize + Default>(head: &str) -> Result<String, toml::ser::Error> {
    let values = toml::Table::try_from(T::default())?;
    let mut text = head.to_owned();
    for group in T::ENTRIES {
        let (Kind::Group(entries), Some(toml::Value::Table(values))) = (group.kind, values.get(group.name)) else {
            continue;
        };
        // Writing into a text cannot fail.
        let _ = writeln!(text, "\n# {}\n[{}]", group.description(), group.name);
        for entry in entries {
            let _ = writeln!(text, "{}", line(entry, values));
        }
    }
    Ok(text)
}

fn line(entry: &Parameter, values: &toml::Table) -> String {
    let value = match (entry.kind, values.get(entry.name)) {
        (Kind::Group(_), Some(toml::Value::Table(inner))) => {
            let pairs: Vec<String> = inner.iter().map(|(key, value)| format!("{key} = {}", short(value))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        _ => entry.default.to_owned(),
    };
    let about = entry.description().replace('`', "");
    format!("{} = {value} # {} ({})", entry.name, about.trim_end_matches('.'), entry.source)
}

/// Large numbers with a power of ten.
fn short(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) if number.abs() >= 1e4 => format!("{number:e}"),
        _ => value.to_string(),
    }
}
