//! The keys of a study, section by section, from its JSON schema: what `decore help study` lists.

use serde_json::{Map, Value};

use decore_quantity::units::{NO_UNIT, unit_of_key};
use decore_study::study_schema;

/// Sections that are explained on a page of their own.
const ELSEWHERE: [(&str, &str); 1] = [("HammerParameters", "see `decore help theory`")];

/// The sections with their keys as Markdown, in the order of a study file.
pub(super) fn study_keys() -> String {
    let schema = study_schema();
    let mut text = String::new();
    Sections { root: &schema, text: &mut text, written: Vec::new() }.section("", &schema, &[]);
    text
}

/// Writes sections one below the other.
struct Sections<'a> {
    root: &'a Value,
    text: &'a mut String,
    /// Definitions that have a section, with its heading.
    written: Vec<(String, String)>,
}

/// A table of the study that is described after the section that contains it.
struct Inner<'a> {
    path: String,
    schema: &'a Value,
    name: String,
}

impl<'a> Sections<'a> {
    /// Writes the keys of a table, then the keys of its inner tables. `above`: definitions that contain this section.
    fn section(&mut self, path: &str, schema: &'a Value, above: &[String]) {
        let heading = if path.is_empty() { "At the top of the file".to_owned() } else { format!("`{path}`") };
        self.text.push_str(&format!("\n## {heading}\n\n"));
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let mut inner = Vec::new();
        for (key, entry) in schema["properties"].as_object().into_iter().flatten() {
            match self.table(path, key, entry) {
                Some(table) => inner.push(table),
                None => self.key(key, entry, required.contains(&key.as_str())),
            }
        }
        for Inner { path, schema, name } in inner {
            if let Some((_, place)) = ELSEWHERE.iter().find(|(known, _)| *known == name) {
                self.text.push_str(&format!("\n## `{path}`\n\nSingle values of the hammer file, {place}.\n"));
            } else if let Some((_, first)) = self.written.iter().find(|(known, _)| *known == name) {
                let line = format!("\n## `{path}`\n\nThe same keys as in `{first}`.\n");
                self.text.push_str(&line);
            } else if !above.contains(&name) {
                self.written.push((name.clone(), path.clone()));
                let above: Vec<String> = above.iter().cloned().chain([name]).collect();
                self.section(&path, schema, &above);
            }
        }
    }

    /// The table that a key holds: one, one by name, or one of a list.
    fn table(&self, path: &str, key: &str, entry: &'a Value) -> Option<Inner<'a>> {
        let join = |name: &str| {
            if path.is_empty() { name.to_owned() } else { format!("{}.{name}", path.trim_matches(['[', ']'])) }
        };
        let (of, shown) = match (entry.get("additionalProperties"), entry.get("items")) {
            (Some(of @ Value::Object(_)), _) => (of, format!("[{}.NAME]", join(key))),
            (_, Some(of)) => (of, format!("[[{}]]", join(key))),
            _ => (entry, format!("[{}]", join(key))),
        };
        let options = of["anyOf"].as_array().into_iter().flatten();
        let reference = std::iter::once(of).chain(options).find_map(|option| option["$ref"].as_str())?;
        let schema = self.root.pointer(reference.trim_start_matches('#'))?;
        schema["properties"].is_object().then(|| Inner {
            path: shown,
            schema,
            name: reference.rsplit('/').next().unwrap_or_default().to_owned(),
        })
    }

    /// Writes a key: unit, default, description.
    fn key(&mut self, key: &str, entry: &Value, required: bool) {
        let description =
            entry["description"].as_str().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
        let (about, default) = split(&description);
        let unit = if is_number(self.root, entry) { unit_of_key(key) } else { NO_UNIT };
        let unit = (unit != NO_UNIT).then(|| unit.to_owned());
        let default = match default {
            _ if required => Some("required".to_owned()),
            Some(default) => Some(format!("default {default}")),
            None => None,
        };
        let notes: Vec<String> = unit.into_iter().chain(default).collect();
        let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join(", ")) };
        let choices = choices(self.root, entry);
        let choices = if choices.is_empty() { String::new() } else { format!(" One of {}.", choices.join(", ")) };
        self.text.push_str(&format!("- `{key}`{notes}: {about}{choices}\n"));
    }
}

/// Description and default of a key: schemas state the default in a sentence of its own or behind the range.
fn split(description: &str) -> (String, Option<String>) {
    let (about, values) = match description.split_once(" Takes ") {
        Some((about, values)) => (about, Some(values.split(" Usually ").next().unwrap_or(values))),
        None => (description, None),
    };
    if let Some(values) = values {
        let default =
            values.split_once("; default").map(|(_, rest)| rest.trim_start_matches(':').trim().trim_end_matches('.'));
        return (about.to_owned(), default.map(str::to_owned));
    }
    match about.split_once(" Default") {
        Some((before, rest)) => {
            let rest = rest.trim_start_matches(':').trim();
            let end = rest.find(". ").map_or(rest.len(), |end| end + 1);
            let (default, after) = rest.split_at(end);
            (
                format!("{before}{}{}", if after.is_empty() { "" } else { " " }, after.trim()),
                Some(default.trim_end_matches('.').to_owned()),
            )
        }
        None => (about.to_owned(), None),
    }
}

/// Whether an entry holds numbers.
fn is_number(root: &Value, entry: &Value) -> bool {
    let named = |kind: &str| ["number", "integer"].contains(&kind);
    let own = match &entry["type"] {
        Value::String(kind) => named(kind),
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).any(named),
        _ => false,
    };
    let target = entry["$ref"].as_str().and_then(|path| root.pointer(path.trim_start_matches('#')));
    let options = entry["anyOf"].as_array().into_iter().flatten();
    own || entry.get("items").is_some_and(|item| is_number(root, item))
        || target.into_iter().chain(options).any(|option| is_number(root, option))
}

/// Names that an entry can have.
fn choices(root: &Value, entry: &Value) -> Vec<String> {
    let options = entry["anyOf"].as_array().into_iter().flatten();
    let reference = std::iter::once(entry).chain(options).find_map(|option| option["$ref"].as_str());
    let target = reference.and_then(|path| root.pointer(path.trim_start_matches('#')));
    let names = |schema: &Map<String, Value>| -> Vec<String> {
        let listed = schema.get("enum").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str);
        let described = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
        let described = described.flat_map(|one| {
            let several = one["enum"].as_array().into_iter().flatten().filter_map(Value::as_str);
            one["const"].as_str().into_iter().chain(several).collect::<Vec<_>>()
        });
        listed.chain(described).map(|name| format!("`{name}`")).collect()
    };
    target.and_then(Value::as_object).map(names).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_schema_is_listed() {
        let (text, schema) = (study_keys(), study_schema());
        let hammers = ["Chisel", "Guide", "Housing", "Piston", "Telescope", "Valve", "Contact"]
            .map(|one| format!("{one}Parameters"));
        let definitions = schema["$defs"].as_object().expect("definitions");
        for (name, definition) in definitions.iter().filter(|(name, _)| !hammers.contains(name)) {
            for key in definition["properties"].as_object().into_iter().flatten().map(|(key, _)| key) {
                let listed = text.contains(&format!("- `{key}`"))
                    || text.contains(&format!("{key}.NAME]"))
                    || text.contains(&format!("{key}]"))
                    || name == "HammerParameters";
                assert!(listed, "{name}.{key} in\n{text}");
            }
        }
    }

    #[test]
    fn keys_have_unit_and_default() {
        let text = study_keys();
        for line in [
            "- `supply_bar` (bar, default 5.0 (the paper's rig)): Supply pressure above ambient (gauge).",
            "- `seed` (default 0): Seed of the design's random numbers.",
            "- `max_steps` (default 20000000 (far beyond a sound row)): ",
            "- `supply_switch_times_s` (s, default [] (on for good)): ",
            "- `damping_ratio` (default 0.02 (assumed)): ",
        ] {
            assert!(text.contains(line), "{line} in\n{text}");
        }
        // No Rust expression, in the keys of studies or of hammers.
        let schemas = [text.clone(), study_schema().to_string()];
        for rust in ["Ratio(", "Vec::", "kelvin_voigt(", "::new", "0_000"] {
            assert!(schemas.iter().all(|schema| !schema.contains(rust)), "{rust}");
        }
        assert!(schemas[1].contains("Default `{ stiffness_n_per_m = 2.95e8, damping_n_s_per_m = 500.0 }` (Table 2)."));
        assert!(text.contains("- `mass_kg` (kg, required): "), "{text}");
        assert!(text.contains("\n## `[design.factor.NAME]`\n"), "{text}");
    }
}
