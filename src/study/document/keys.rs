//! Permitted keys of a file, read from its JSON schema: one table for parser, schema and paths.

use serde_json::Value as Json;
use toml::Value;

use super::error::{MOST_FAULTS, Problem};
use super::path;
use super::tree::{Content, Document, Node};
use decore_quantity::words::nearest;

/// Longest text that a message repeats, in characters.
const SHOWN_TEXT: usize = 40;

/// Permitted content at one place of a file.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// Table with fixed keys, in the order of the schema.
    Table { keys: Vec<(String, Shape)>, required: Vec<String> },
    /// Table with names of the user's choice.
    Map(Box<Shape>),
    /// List; `length` if it is fixed.
    Array { item: Box<Shape>, length: Option<u64> },
    /// Number.
    Number,
    /// Whole number, not below the minimum.
    Integer { minimum: i64 },
    /// true or false.
    Boolean,
    /// Any text.
    Text,
    /// One of these texts.
    Choice(Vec<String>),
    /// Any of these.
    Either(Vec<Shape>),
}

impl Shape {
    /// Reads a schema of schemars. Unknown parts count as free text.
    pub fn from_schema(schema: &Json) -> Self {
        Self::read(schema, schema)
    }

    fn read(schema: &Json, root: &Json) -> Self {
        if let Some(reference) = schema.get("$ref").and_then(Json::as_str) {
            let target = reference.strip_prefix('#').and_then(|pointer| root.pointer(pointer));
            return target.map_or(Self::Text, |target| Self::read(target, root));
        }
        for key in ["anyOf", "oneOf"] {
            if let Some(options) = schema.get(key).and_then(Json::as_array) {
                return Self::union(options, root);
            }
        }
        if let Some(choices) = schema.get("enum").and_then(Json::as_array) {
            return Self::Choice(choices.iter().filter_map(Json::as_str).map(str::to_string).collect());
        }
        if let Some(choice) = schema.get("const").and_then(Json::as_str) {
            return Self::Choice(vec![choice.to_string()]);
        }
        let kind = match schema.get("type") {
            Some(Json::Array(kinds)) => kinds.iter().filter_map(Json::as_str).find(|kind| *kind != "null"),
            Some(kind) => kind.as_str(),
            None => None,
        };
        match kind {
            Some("object") => Self::read_table(schema, root),
            Some("array") => Self::Array {
                item: Box::new(schema.get("items").map_or(Self::Text, |item| Self::read(item, root))),
                length: schema.get("maxItems").and_then(Json::as_u64),
            },
            Some("number") => Self::Number,
            Some("integer") => {
                let minimum = schema.get("minimum").and_then(Json::as_i64).unwrap_or(i64::MIN);
                Self::Integer { minimum }
            }
            Some("boolean") => Self::Boolean,
            _ => Self::Text,
        }
    }

    fn read_table(schema: &Json, root: &Json) -> Self {
        if let Some(item @ Json::Object(_)) = schema.get("additionalProperties") {
            return Self::Map(Box::new(Self::read(item, root)));
        }
        let properties = schema.get("properties").and_then(Json::as_object);
        let keys = properties.into_iter().flatten();
        let required = schema.get("required").and_then(Json::as_array).into_iter().flatten();
        Self::Table {
            keys: keys.map(|(key, value)| (key.clone(), Self::read(value, root))).collect(),
            required: required.filter_map(Json::as_str).map(str::to_string).collect(),
        }
    }

    fn union(options: &[Json], root: &Json) -> Self {
        let is_null = |option: &&Json| option.get("type").and_then(Json::as_str) == Some("null");
        let mut choices = Vec::new();
        let mut shapes = Vec::new();
        for option in options.iter().filter(|option| !is_null(option)) {
            match Self::read(option, root) {
                Self::Choice(more) => choices.extend(more),
                shape => shapes.push(shape),
            }
        }
        if !choices.is_empty() {
            shapes.push(Self::Choice(choices));
        }
        match shapes.pop() {
            Some(only) if shapes.is_empty() => only,
            Some(last) => {
                shapes.push(last);
                Self::Either(shapes)
            }
            None => Self::Text,
        }
    }

    /// Whether numbers fit.
    pub fn is_number(&self) -> bool {
        match self {
            Self::Number | Self::Integer { .. } => true,
            Self::Either(shapes) => shapes.iter().any(Self::is_number),
            _ => false,
        }
    }

    /// The shape in words.
    pub fn words(&self) -> String {
        match self {
            Self::Table { .. } => "a table".to_string(),
            Self::Map(_) => "a table of named entries".to_string(),
            Self::Array { item, length: Some(length) } => format!("a list of {length} entries, each {}", item.words()),
            Self::Array { item, length: None } => format!("a list, each entry {}", item.words()),
            Self::Number => "a number".to_string(),
            Self::Integer { minimum: i64::MIN } => "a whole number without a decimal point".to_string(),
            Self::Integer { minimum } => format!("a whole number of at least {minimum}, without a decimal point"),
            Self::Boolean => "true or false".to_string(),
            Self::Text => "a text in quotes".to_string(),
            Self::Choice(choices) => {
                let quoted: Vec<String> = choices.iter().map(|choice| format!("\"{choice}\"")).collect();
                format!("one of {}", quoted.join(", "))
            }
            Self::Either(shapes) => shapes.iter().map(Self::words).collect::<Vec<_>>().join(", or "),
        }
    }

    /// Whether a plain value fits; the error describes the value.
    pub fn accepts(&self, value: &Value) -> Result<(), String> {
        let fits = match (self, value) {
            (Self::Number, Value::Float(number)) if !number.is_finite() => {
                return Err(format!("is {number}, which is no finite number"));
            }
            (Self::Integer { minimum }, Value::Integer(number)) if number < minimum => {
                return Err(format!("is {number}"));
            }
            (Self::Text, Value::String(text)) if text.contains(char::is_control) => {
                let found = text.chars().find(|c| c.is_control()).unwrap_or_default();
                return Err(format!(
                    "is a text with the control character {found:?} (a line break, a tab or the like)"
                ));
            }
            (Self::Choice(choices), Value::String(text)) if !choices.contains(text) => {
                return Err(format!("is \"{text}\""));
            }
            (Self::Array { length: Some(length), .. }, Value::Array(entries)) if entries.len() as u64 != *length => {
                let entries = entries.len();
                return Err(format!("is a list of {entries} {}", if entries == 1 { "entry" } else { "entries" }));
            }
            (Self::Array { item, .. }, Value::Array(entries)) => {
                return entries.iter().try_for_each(|entry| item.accepts(entry));
            }
            (Self::Either(shapes), _) => return either(shapes, value),
            (Self::Number, Value::Float(_) | Value::Integer(_)) => true,
            (Self::Integer { .. }, Value::Integer(_)) | (Self::Boolean, Value::Boolean(_)) => true,
            (Self::Text | Self::Choice(_), Value::String(_)) => true,
            (Self::Table { .. } | Self::Map(_), Value::Table(_)) => true,
            _ => false,
        };
        if fits { Ok(()) } else { Err(format!("is {}", type_words(value))) }
    }
}

/// The first shape of the value's own kind gives the message.
fn either(shapes: &[Shape], value: &Value) -> Result<(), String> {
    let (mut first, mut own) = (None, None);
    for shape in shapes {
        match shape.accepts(value) {
            Ok(()) => return Ok(()),
            Err(error) if !error.starts_with("is a") => own = own.or(Some(error)),
            Err(error) => first = first.or(Some(error)),
        }
    }
    Err(own.or(first).unwrap_or_else(|| format!("is {}", type_words(value))))
}

/// The kind of a value, and the value itself if it is short.
fn type_words(value: &Value) -> String {
    match value {
        Value::String(text) if text.chars().count() <= SHOWN_TEXT => format!("the text {text:?}"),
        Value::String(_) => "a text".to_string(),
        Value::Integer(number) => format!("the whole number {number}"),
        Value::Float(number) => format!("the number {number:?}"),
        Value::Boolean(flag) => flag.to_string(),
        Value::Datetime(_) => "a date".to_string(),
        Value::Array(_) => "a list".to_string(),
        Value::Table(_) => "a table".to_string(),
    }
}

/// Checks a document against its shape: unknown keys, wrong types, numbers that are not finite, missing keys.
///
/// `provided` returns whether something outside the document gives a value for a path.
pub(crate) fn check(document: &Document, shape: &Shape, provided: &dyn Fn(&[String]) -> bool) -> Vec<Problem> {
    let mut walk = Walk { document, provided, problems: Vec::new() };
    walk.node(&document.root, shape, &mut Vec::new());
    walk.problems.truncate(MOST_FAULTS);
    walk.problems
}

struct Walk<'a> {
    document: &'a Document,
    provided: &'a dyn Fn(&[String]) -> bool,
    problems: Vec<Problem>,
}

impl Walk<'_> {
    fn node(&mut self, node: &Node, shape: &Shape, at: &mut Vec<String>) {
        if self.problems.len() >= MOST_FAULTS {
            return;
        }
        match (shape, &node.content) {
            (Shape::Table { keys, required }, Content::Table(entries)) => {
                for (key, child) in entries {
                    at.push(key.clone());
                    match keys.iter().find(|(name, _)| name == key) {
                        Some((_, inner)) => self.node(child, inner, at),
                        None => self.unknown(child, keys, at),
                    }
                    at.pop();
                }
                for key in required.iter().filter(|key| !entries.contains_key(*key)) {
                    let inner = keys.iter().find(|(name, _)| name == key).map(|(_, inner)| inner);
                    self.missing(key, inner, at);
                }
            }
            (Shape::Map(inner), Content::Table(entries)) => {
                for (name, child) in entries {
                    at.push(name.clone());
                    self.name(child, name, at);
                    self.node(child, inner, at);
                    at.pop();
                }
            }
            (Shape::Array { item, length }, Content::Array(entries))
                if length.is_none_or(|length| length == entries.len() as u64) =>
            {
                for (index, child) in entries.iter().enumerate() {
                    at.push(index.to_string());
                    self.node(child, item, at);
                    at.pop();
                }
            }
            _ => {
                if let Err(message) = shape.accepts(&node.value()) {
                    let nearest = match (shape, &node.content) {
                        (Shape::Choice(choices), Content::Leaf(Value::String(text))) => {
                            nearest(text, choices.iter().map(String::as_str)).or_else(|| abbreviated(text, choices))
                        }
                        _ => None,
                    };
                    // A table's position is its header; the key is more precise.
                    let is_table = matches!(node.content, Content::Table(_));
                    let span = if is_table { &node.key } else { &node.span };
                    let place = self.document.place(span.clone());
                    let problem = Problem::new(place, path::join(at), message);
                    let written = self.document.text.get(node.span.clone()).unwrap_or_default();
                    let expected = format!("{}{}", shape.words(), advice(shape, &node.content, written));
                    self.problems.push(problem.expected(expected).nearest(nearest));
                }
            }
        }
    }

    /// Names become parts of paths and of column names.
    fn name(&mut self, node: &Node, name: &str, at: &[String]) {
        let sound = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(sound) {
            let place = self.document.place(node.key.clone());
            let problem = Problem::new(place, path::join(at), format!("\"{name}\" cannot be a name"));
            self.problems.push(problem.expected("letters a to z, digits, _ and - only"));
        }
    }

    fn unknown(&mut self, node: &Node, keys: &[(String, Shape)], at: &[String]) {
        let names = || keys.iter().map(|(name, _)| name.as_str());
        if self.problems.len() >= MOST_FAULTS {
            return;
        }
        let meant = at.last().and_then(|key| synonym(key, |name| names().any(|known| known == name)));
        let nearest =
            meant.map_or_else(|| at.last().and_then(|key| nearest(key, names())), |(_, shown)| Some(shown.to_owned()));
        let place = self.document.place(node.key.clone());
        let problem = Problem::new(place, path::join(at), "unknown key");
        let known = format!("one of {}", names().collect::<Vec<_>>().join(", "));
        self.problems.push(problem.expected(known).nearest(nearest));
    }

    fn missing(&mut self, key: &str, shape: Option<&Shape>, at: &mut Vec<String>) {
        at.push(key.to_string());
        if !(self.provided)(at) {
            let place = self.document.locate(at);
            let problem = Problem::new(place, path::join(at), "missing key");
            let table = path::join(at.get(..at.len() - 1).unwrap_or_default());
            let written = match shape {
                Some(Shape::Table { .. }) => format!(": add `[{}]`", path::join(at)),
                Some(Shape::Map(_)) => format!(": add `[{}.NAME]`", path::join(at)),
                _ if table.is_empty() => format!(": add `{key} = ...` at the top of the file"),
                _ => format!(": add `{key} = ...` to `[{table}]`"),
            };
            self.problems.push(problem.expected(shape.map_or_else(String::new, Shape::words) + &written));
        }
        at.pop();
    }
}

/// What to write instead of a value that does not fit, where that is clear.
fn advice(shape: &Shape, content: &Content, written: &str) -> String {
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    match (shape, content) {
        (Shape::Number | Shape::Integer { .. }, Content::Leaf(Value::String(text))) if is_number(text) => {
            format!(": write {text}, without quotes")
        }
        (Shape::Boolean, Content::Leaf(Value::String(text))) if ["true", "false"].contains(&text.as_str()) => {
            format!(": write {text}, without quotes")
        }
        (Shape::Integer { .. }, Content::Leaf(Value::Float(number))) if number.fract() == 0.0 => {
            format!(": write {number}")
        }
        (Shape::Text | Shape::Choice(_), Content::Leaf(Value::Integer(_) | Value::Float(_) | Value::Boolean(_))) => {
            format!(": write \"{written}\"")
        }
        (Shape::Array { item, length: Some(length) }, Content::Array(entries))
            if matches!(**item, Shape::Number) && entries.len() as u64 == 2 * length =>
        {
            ", with a point in a number, as in 4.5: a comma separates the entries".to_owned()
        }
        (Shape::Array { length: None, .. }, Content::Leaf(Value::String(_) | Value::Integer(_) | Value::Float(_))) => {
            format!(": write [{written}]")
        }
        _ => String::new(),
    }
}

/// Keys that other programs and languages use, the study's key for the same, and how to write it.
const SYNONYMS: [(&[&str], &str, &str); 13] = [
    (
        &[
            "min", "max", "minimum", "maximum", "low", "high", "lower", "upper", "from", "to", "bounds", "limits",
            "interval", "start", "stop",
        ],
        "range",
        "range = [LOW, HIGH]",
    ),
    (&["choices", "options", "categories", "list", "grid"], "values", "values = [...]"),
    (&["parameter", "target", "key", "variable", "drives"], "path", "path = \"hammer.NAME.KEY\""),
    (&["steps", "count", "n"], "levels", "levels"),
    (&["n", "samples", "runs", "size", "count", "n_samples", "points"], "rows", "rows"),
    (&["type", "method", "sampler", "design"], "kind", "kind"),
    (&["mu", "average"], "mean", "mean"),
    (&["sigma", "std", "sd", "stdev"], "std_dev", "std_dev"),
    (&["pressure", "pressure_bar", "supply_pressure", "supply_pressure_bar", "p"], "supply_bar", "supply_bar"),
    (&["weight", "m"], "mass_kg", "mass_kg"),
    (&["time", "t_end", "end_time", "simulation_time", "t"], "duration_s", "duration_s"),
    (&["position", "x"], "rail_position_m", "rail_position_m"),
    (&["objective", "maximize"], "maximise", "maximise"),
];

/// The known key that another word stands for, and how to write it.
fn synonym(key: &str, is_known: impl Fn(&str) -> bool) -> Option<(&'static str, &'static str)> {
    let found = SYNONYMS.iter().find(|(words, name, _)| words.contains(&key) && is_known(name));
    found.map(|(_, name, shown)| (*name, *shown))
}

/// The choice whose words begin with the letters that a short text begins with: `lhs` is a Latin hypercube (sampling).
fn abbreviated(text: &str, choices: &[String]) -> Option<String> {
    let initials = |choice: &str| choice.split('_').filter_map(|word| word.chars().next()).collect::<String>();
    let stands = |choice: &&String| choice.contains('_') && text.to_lowercase().starts_with(&initials(choice));
    choices.iter().filter(|_| text.len() <= 4).find(stands).cloned()
}

/// Reason why a path does not exist.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UnknownPath {
    pub message: String,
    pub nearest: Option<String>,
}

/// Shape at a path. Names in maps must be in `tree`; entries of a list only where `tree` has the list.
pub(crate) fn shape_at<'a>(root: &'a Shape, tree: &toml::Table, at: &[String]) -> Result<&'a Shape, UnknownPath> {
    let mut shape = root;
    for (depth, segment) in at.iter().enumerate() {
        let here = at.get(..depth).unwrap_or(&[]);
        let value = path::get(tree, at.get(..=depth).unwrap_or(&[]));
        let next = match shape {
            Shape::Table { keys, .. } => keys.iter().find(|(name, _)| name == segment).map(|(_, inner)| inner),
            Shape::Map(inner) => value.map(|_| inner.as_ref()),
            Shape::Array { item, .. } if value.is_some() => Some(item.as_ref()),
            Shape::Array { .. } => {
                let message =
                    format!("`{}` has no entry {segment} in the study: write the list there first", path::join(here));
                return Err(UnknownPath { message, nearest: None });
            }
            _ => None,
        };
        shape = next.ok_or_else(|| UnknownPath {
            message: format!("this study has no parameter `{}`", path::join(at)),
            nearest: nearest_path(root, tree, at),
        })?;
    }
    Ok(shape)
}

/// The known path that is most alike.
fn nearest_path(root: &Shape, tree: &toml::Table, wanted: &[String]) -> Option<String> {
    let mut known = Vec::new();
    collect(root, Some(tree), &mut Vec::new(), &mut known);
    let wanted = path::join(wanted);
    let last = format!(".{}", wanted.rsplit('.').next().unwrap_or(&wanted));
    let found = nearest(&wanted, known.iter().map(String::as_str));
    found.or_else(|| known.iter().find(|name| name.ends_with(&last)).cloned())
}

fn collect(shape: &Shape, tree: Option<&toml::Table>, at: &mut Vec<String>, known: &mut Vec<String>) {
    let inner_tree = |key: &str| tree.and_then(|tree| tree.get(key)).and_then(Value::as_table);
    match shape {
        Shape::Table { keys, .. } => {
            for (key, inner) in keys {
                at.push(key.clone());
                collect(inner, inner_tree(key), at, known);
                at.pop();
            }
        }
        Shape::Map(inner) => {
            for key in tree.into_iter().flat_map(|tree| tree.keys()) {
                at.push(key.clone());
                collect(inner, inner_tree(key), at, known);
                at.pop();
            }
        }
        _ => known.push(path::join(at)),
    }
}
