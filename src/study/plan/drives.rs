//! Targets of a factor, as typed: parameters of the study that vary between rows.

use super::factor::{Driven, FactorInfo, Link, to_toml};
use super::reader::FactorReader;
use crate::document::keys::{Shape, shape_at};
use crate::document::path;
use crate::file::LinkEntry;
use decore_quantity::Value;
use decore_quantity::units::{accepted, conversion, unit_of_key};
use decore_quantity::words::nearest;

/// Top-level tables and keys that rows may change; the rest is shared by all rows.
const DRIVABLE: [&str; 7] = ["machine", "hammer", "casting", "solver", "outputs", "environment", "duration_s"];

/// The keys of `outputs` that all rows share: they decide which tables and columns there are.
const SHARED_OUTPUTS: [&str; 8] = [
    "twins",
    "numerical_twin",
    "points",
    "signals",
    "signal_rows",
    "signal_interval_s",
    "core_spectra",
    "fixture_energy",
];

/// A parameter as the factor names it.
struct Named<'a> {
    /// Path of the key that names it.
    at: Vec<String>,
    text: &'a str,
    link: Link,
}

impl<'a> FactorReader<'a> {
    /// The parameters that the factor drives; `before` are the factors before it, which drive others.
    pub fn drives(&mut self, before: &[FactorInfo]) -> Vec<Driven> {
        let texts_only = self.values().iter().any(|value| matches!(value, Value::Text(_)));
        let mut drives: Vec<Driven> = Vec::new();
        for Named { at, text, link } in self.named() {
            if texts_only && link != Link::SAME {
                self.problem_at(&at, "a text has no factor or offset");
            }
            let Some(path) = self.drivable(&at, text) else { continue };
            let mut others = before.iter().flat_map(|factor| &factor.drives);
            if drives.iter().any(|own| own.path == path) || others.any(|other| overlap(&other.path, &path)) {
                self.problem_at(&at, format!("`{text}` is driven twice"));
            }
            self.fits(&path);
            let (link, converted_to) = self.converted(&path, link);
            drives.push(Driven { path, link, converted_to });
        }
        drives
    }

    /// The link with the conversion of the factor's unit to the parameter's, and the parameter's unit if it is another one.
    ///
    /// A link with a factor or an offset of its own takes the value in the unit of the factor's first path: its parameter may be any
    /// quantity.
    fn converted(&mut self, path: &[String], link: Link) -> (Link, Option<&'static str>) {
        let Some(unit) = self.entry.unit.as_deref() else { return (link, None) };
        let first = self.entry.path.iter().chain(self.entry.paths.iter().flatten()).next();
        let target = match (link == Link::SAME, first.and_then(|first| path::split(first).ok())) {
            (true, _) => path.to_vec(),
            (false, Some(first)) => first,
            (false, None) => return (link, None),
        };
        let is_number = shape_at(self.around.shape, self.around.tree, &target).is_ok_and(Shape::is_number);
        let key = target.iter().rev().find(|part| part.parse::<usize>().is_err());
        let Some(key) = key.filter(|_| is_number) else { return (link, None) };
        let own = unit_of_key(key);
        match conversion(unit, own) {
            Some(conversion) => {
                let converted = link.after(conversion);
                (converted, (converted != link).then_some(own).filter(|_| link == Link::SAME))
            }
            None => {
                let message =
                    format!("is \"{unit}\", but the factor drives `{}`, which is in {own}", path::join(&target));
                let units = accepted(own).map(|unit| format!("\"{unit}\"")).collect::<Vec<_>>().join(", ");
                let known = nearest(unit, accepted(own));
                let problem = self.problem(&["unit"], message);
                problem.expected = Some(format!(
                    "one of {units} (see `decore help units`); values in another unit than {own} are converted"
                ));
                problem.nearest = known;
                (link, None)
            }
        }
    }

    /// The parameters that `path`, `paths` and the links name.
    fn named(&mut self) -> Vec<Named<'a>> {
        let entry = self.entry;
        let mut named = match (&entry.path, &entry.paths) {
            (Some(path), None) => vec![Named { at: self.at(&["path"]), text: path, link: Link::SAME }],
            (None, Some(paths)) if !paths.is_empty() => {
                let named = |(index, path): (usize, &'a String)| Named {
                    at: self.at(&["paths", &index.to_string()]),
                    text: path,
                    link: Link::SAME,
                };
                paths.iter().enumerate().map(named).collect()
            }
            // A derived factor, or one that others or the constraints use, may drive nothing.
            (None, None) if !entry.link.is_empty() || entry.expression.is_some() => Vec::new(),
            _ => {
                let expected = "either `path` or `paths`, the parameters that the factor drives";
                let both = entry.path.is_some() && entry.paths.is_some();
                let message = if both { "has both `path` and `paths`" } else { "drives no parameter" };
                self.problem(&[], message).expected = Some(expected.into());
                return Vec::new();
            }
        };
        let linked = |(index, link): (usize, &'a LinkEntry)| Named {
            at: self.at(&["link", &index.to_string(), "path"]),
            text: &link.path,
            link: Link { factor: link.factor.unwrap_or(1.0), offset: link.offset.unwrap_or(0.0) },
        };
        named.extend(entry.link.iter().enumerate().map(linked));
        named
    }

    /// The path as segments, if rows may change it.
    fn drivable(&mut self, at: &[String], text: &str) -> Option<Vec<String>> {
        let segments = match path::split(text) {
            Ok(segments) => segments,
            Err(message) => {
                self.problem_at(at, message);
                return None;
            }
        };
        let shape = match shape_at(self.around.shape, self.around.tree, &segments) {
            Ok(shape) => shape,
            Err(unknown) => {
                let problem = self.problem_at(at, unknown.message);
                problem.expected = Some("the path of a parameter, e.g. hammer.left.supply_bar".into());
                problem.nearest = unknown.nearest;
                return None;
            }
        };
        if matches!(shape, Shape::Table { .. } | Shape::Map(_) | Shape::Array { .. }) {
            let problem = self.problem_at(at, format!("`{text}` is {}, no single value", shape.words()));
            problem.expected = Some("the path of a single number or text (an entry of a list: `.0`, `.1`)".into());
            return None;
        }
        let names: Vec<&str> = segments.iter().map(String::as_str).collect();
        let shared = matches!(names.as_slice(), ["outputs", key, ..] if SHARED_OUTPUTS.contains(key))
            || matches!(names.as_slice(), ["casting", _, "structure", ..] | ["casting", _, "fixture", _, "one_sided"]);
        if shared || !segments.first().is_some_and(|first| DRIVABLE.contains(&first.as_str())) {
            let problem = self.problem_at(at, format!("`{text}` is shared by all rows, so no factor can drive it"));
            problem.expected = Some(format!("a path that starts with one of {}", DRIVABLE.join(", ")));
            return None;
        }
        Some(segments)
    }

    /// Holds the factor's values to the type of a parameter that it drives.
    fn fits(&mut self, driven: &[String]) {
        let Ok(shape) = shape_at(self.around.shape, self.around.tree, driven) else { return };
        let name = path::join(driven);
        for (index, value) in self.values().iter().enumerate() {
            if let Err(message) = shape.accepts(&to_toml(value)) {
                let problem = self.problem(&["values", &index.to_string()], format!("{message}, but drives `{name}`"));
                problem.expected = Some(shape.words());
                if let (Shape::Choice(choices), Value::Text(text)) = (shape, value) {
                    problem.nearest = nearest(text, choices.iter().map(String::as_str));
                }
            }
        }
        let Some([low, _]) = self.entry.range.filter(|[low, _]| low.is_finite()) else { return };
        let integer = self.entry.integer == Some(true);
        let probe = if integer { toml::Value::Integer(low as i64) } else { toml::Value::Float(low) };
        if let Err(message) = shape.accepts(&probe) {
            let problem = self.problem(&["range"], format!("a value of this range {message}, but drives `{name}`"));
            problem.expected = Some(shape.words());
        }
    }
}

/// Whether one path is the other or leads to it.
fn overlap(a: &[String], b: &[String]) -> bool {
    a.iter().zip(b).all(|(a, b)| a == b)
}
