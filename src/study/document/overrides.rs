//! Values set from outside the file, `path=value`.

use toml::Value;

use super::error::{FileLocation, Problem};
use super::keys::{Shape, shape_at};
use super::path;
use decore_quantity::words::nearest;

/// Top-level keys that all rows share.
pub(crate) const SHARED_KEYS: [&str; 5] = ["title", "structure", "structures", "design", "goal"];

/// One `path=value`.
#[derive(Debug, Clone)]
pub(crate) struct Override {
    /// As it was given.
    pub text: String,
    pub path: Vec<String>,
    pub value: Value,
}

impl Override {
    /// Reads a setting, holds it to the shape of the study and applies it to `tree`.
    pub fn read(setting: &str, shape: &Shape, tree: &mut toml::Table) -> Result<Self, Box<Problem>> {
        let fault = |key: &str, message: String| Box::new(Problem::new(place(setting), key, message));
        let (left, right) = setting.split_once('=').ok_or_else(|| {
            let problem = fault("", "sets nothing".to_string());
            Box::new(problem.expected("path=value, e.g. hammer.left.supply_bar=4.5"))
        })?;
        let at = path::split(left).map_err(|message| fault("", message))?;
        let key = path::join(&at);
        let allowed = shape_at(shape, tree, &at)
            .map_err(|unknown| Box::new(fault(&key, unknown.message).nearest(unknown.nearest)))?;
        let value = read_value(right.trim(), allowed);
        allowed.accepts(&value).map_err(|message| {
            let comma = matches!(allowed, Shape::Number) && right.trim().replacen(',', ".", 1).parse::<f64>().is_ok();
            let point = if comma { ", with a point as in 5.0" } else { "" };
            let nearest = match (allowed, &value) {
                (Shape::Choice(choices), Value::String(text)) => nearest(text, choices.iter().map(String::as_str)),
                _ => None,
            };
            Box::new(fault(&key, message).expected(format!("{}{point}", allowed.words())).nearest(nearest))
        })?;
        path::set(tree, &at, value.clone()).map_err(|message| fault(&key, message))?;
        Ok(Self { text: setting.to_string(), path: at, value })
    }

    /// Place of the override, for messages.
    pub fn place(&self) -> FileLocation {
        place(&self.text)
    }

    /// Whether it concerns the rows at all: the goal and the roles of factors do not.
    pub fn reaches_values(&self) -> bool {
        let path: Vec<&str> = self.path.iter().map(String::as_str).collect();
        !matches!(path.as_slice(), ["goal", ..] | ["design", "factor", _, "role"])
    }

    /// Whether it changes the rows' scenes, not only shared settings.
    pub fn reaches_rows(&self) -> bool {
        !self.path.first().is_some_and(|first| SHARED_KEYS.contains(&first.as_str()))
    }
}

fn place(setting: &str) -> FileLocation {
    FileLocation::in_file(&format!("--set {setting}"))
}

/// A value as TOML; where it is none, or a text is expected, the text itself.
fn read_value(text: &str, shape: &Shape) -> Value {
    let parsed = toml::from_str::<toml::Table>(&format!("value = {text}")).ok();
    let parsed = parsed.filter(|table| table.len() == 1).and_then(|mut table| table.remove("value"));
    match (parsed, shape) {
        (Some(value @ Value::String(_)), _) => value,
        (_, Shape::Text | Shape::Choice(_)) => Value::String(text.to_string()),
        (Some(value), _) => value,
        (None, _) => Value::String(text.to_string()),
    }
}

/// All paths that the design's factors name, read leniently: for "a factor gives this value", before any check.
pub(crate) fn driven_paths(tree: &toml::Table) -> Vec<Vec<String>> {
    let factors = tree.get("design").and_then(|design| design.get("factor")).and_then(Value::as_table);
    let texts = factors.into_iter().flat_map(|factors| factors.values()).flat_map(|factor| {
        let one = factor.get("path").and_then(Value::as_str);
        let several = factor.get("paths").and_then(Value::as_array);
        let links = factor.get("link").and_then(Value::as_array).into_iter().flatten();
        let linked = links.filter_map(|link| link.get("path").and_then(Value::as_str));
        one.into_iter().chain(several.into_iter().flatten().filter_map(Value::as_str)).chain(linked)
    });
    texts.filter_map(|text| path::split(text).ok()).collect()
}
