//! A TOML document with the position of every key and value, so that later errors can show the text.

use std::ops::Range;

use indexmap::IndexMap;
use toml::de::{DeTable, DeValue};

use super::error::{FileLocation, MOST_FAULTS, Problem};

/// Parts of a key that the parser takes at most.
const MOST_PARTS: usize = 80;

/// Text of a TOML file and its tree.
#[derive(Debug, Clone)]
pub(crate) struct Document {
    /// Name for messages, usually the path.
    pub name: String,
    /// The text as read.
    pub text: String,
    /// Begin of each line.
    begins: Vec<usize>,
    /// The top-level table.
    pub root: Node,
}

/// A value with its place in the text (byte ranges).
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub content: Content,
    pub key: Range<usize>,
    pub span: Range<usize>,
}

#[derive(Debug, Clone)]
pub(crate) enum Content {
    Table(IndexMap<String, Node>),
    Array(Vec<Node>),
    Leaf(toml::Value),
}

/// A part of a text.
pub(crate) struct TextSpan<'a> {
    /// The part.
    pub text: &'a str,
    /// The character of the whole at which it begins, counted from 1.
    pub column: usize,
}

impl Document {
    /// Parses `text`; syntax errors become problems, as many as the parser can separate.
    pub fn parse(name: &str, text: &str) -> Result<Self, Vec<Problem>> {
        // A byte order mark is legal at the start of a file and would shift the columns.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let begins: Vec<usize> = [0].into_iter().chain(text.match_indices('\n').map(|(end, _)| end + 1)).collect();
        let (table, errors) = DeTable::parse_recoverable(text);
        let fault = |error: &toml::de::Error| syntax_problem(name, (text, &begins), error);
        let mut problems: Vec<Problem> = errors.iter().take(MOST_FAULTS).map(fault).collect();
        // After its first fault, the rest of a line is not useful.
        problems.dedup_by_key(|problem| problem.place.line);
        let span = table.span();
        let mut document = Self {
            name: name.to_string(),
            text: text.to_string(),
            begins,
            root: Node { content: Content::Table(IndexMap::new()), key: span.clone(), span },
        };
        if problems.is_empty() {
            let content = document.table(table.get_ref(), &mut problems);
            document.root.content = content;
        }
        problems.truncate(MOST_FAULTS);
        if problems.is_empty() { Ok(document) } else { Err(problems) }
    }

    fn table(&self, table: &DeTable<'_>, problems: &mut Vec<Problem>) -> Content {
        let entries = table.iter().map(|(key, value)| {
            let node = Node {
                content: self.content(value.get_ref(), &value.span(), problems),
                key: key.span(),
                span: value.span(),
            };
            (key.get_ref().to_string(), node)
        });
        Content::Table(entries.collect())
    }

    fn content(&self, value: &DeValue<'_>, span: &Range<usize>, problems: &mut Vec<Problem>) -> Content {
        let fault = |message: String| Problem::new(self.place(span.clone()), "", message);
        Content::Leaf(match value {
            DeValue::Table(table) => return self.table(table, problems),
            DeValue::Array(array) => {
                let entries = array.iter().map(|entry| Node {
                    content: self.content(entry.get_ref(), &entry.span(), problems),
                    key: entry.span(),
                    span: entry.span(),
                });
                return Content::Array(entries.collect());
            }
            DeValue::String(text) => toml::Value::String(text.to_string()),
            DeValue::Boolean(flag) => toml::Value::Boolean(*flag),
            DeValue::Datetime(date) => toml::Value::Datetime(*date),
            DeValue::Integer(digits) => {
                let parsed = i64::from_str_radix(digits.as_str(), digits.radix()).map_err(|error| {
                    problems.push(fault(format!("{} is no 64-bit integer: {error}", digits.as_str())));
                });
                toml::Value::Integer(parsed.unwrap_or(0))
            }
            DeValue::Float(digits) => {
                let parsed = digits.as_str().parse::<f64>().map_err(|error| {
                    problems.push(fault(format!("{} is no number: {error}", digits.as_str())));
                });
                toml::Value::Float(parsed.unwrap_or(0.0))
            }
        })
    }

    /// Place of a byte range.
    pub fn place(&self, span: Range<usize>) -> FileLocation {
        FileLocation::in_text(&self.name, (&self.text, &self.begins), span)
    }

    /// Node at a path, or the deepest one above it, and how many segments were found.
    pub fn nearest(&self, path: &[String]) -> (&Node, usize) {
        let mut node = &self.root;
        for (depth, segment) in path.iter().enumerate() {
            match node.child(segment) {
                Some(child) => node = child,
                None => return (node, depth),
            }
        }
        (node, path.len())
    }

    /// Place of a part of the text at a path; of the whole value where the file spells the text in another way.
    pub fn locate_part(&self, path: &[String], text: &str, part: &TextSpan<'_>) -> FileLocation {
        let (node, depth) = self.nearest(path);
        let written = self.text.get(node.span.clone()).filter(|_| depth == path.len());
        let start = written.and_then(|written| written.find(text)).map(|begin| node.span.start + begin);
        let before = text.char_indices().nth(part.column.saturating_sub(1)).map(|(before, _)| before);
        match (start, before) {
            (Some(start), Some(before)) => self.place(start + before..start + before + part.text.len()),
            _ => self.locate(path),
        }
    }

    /// Place of the value at a path; where it is absent, of the key of the deepest table above it.
    pub fn locate(&self, path: &[String]) -> FileLocation {
        let (node, depth) = self.nearest(path);
        if depth == 0 {
            return FileLocation::in_file(&self.name);
        }
        if depth == path.len() && !matches!(node.content, Content::Table(_)) {
            return self.place(node.span.clone());
        }
        self.place(node.key.clone())
    }
}

/// A syntax error with its place, and what to write instead where that is known.
fn syntax_problem(name: &str, (text, begins): (&str, &[usize]), error: &toml::de::Error) -> Problem {
    let place = |span: Range<usize>| FileLocation::in_text(name, (text, begins), span);
    let Some(span) = error.span() else {
        // The parser names no place for keys that are nested too deep.
        let place = deep_key(text).map_or_else(|| FileLocation::in_file(name), place);
        return Problem::new(place, "", error.message())
            .expected(format!("keys of at most {MOST_PARTS} parts with dots between them"));
    };
    if error.message().starts_with("duplicate key") {
        let first = first_definition(text, begins, span.start);
        let message = first.map_or_else(
            || "is defined twice".to_owned(),
            |line| format!("is defined twice; the first definition is in line {line}"),
        );
        return Problem::new(place(span), "", message)
            .expected("each key and each table once: delete or rename one of them");
    }
    match slip(text, span.start) {
        Some(Slip { span, message, expected }) => Problem::new(place(span), "", message).expected(expected),
        None => Problem::new(place(span), "", error.message()),
    }
}

/// A common mistake of syntax.
struct Slip {
    span: Range<usize>,
    message: &'static str,
    expected: String,
}

/// The mistake in the line of `at`, if it is a common one.
fn slip(text: &str, at: usize) -> Option<Slip> {
    let start = text.get(..at)?.rfind('\n').map_or(0, |end| end + 1);
    let line = text.get(start..)?.lines().next()?;
    let slip = |part: &str, message, expected: String| {
        let begin = part.as_ptr() as usize - text.as_ptr() as usize;
        Some(Slip { span: begin..begin + part.len(), message, expected })
    };
    if is_decimal_comma(text, at) {
        let expected = "a point in a number, as in 5.0: a comma separates the entries of a list";
        return slip(text.get(at..=at)?, "a comma in a number", expected.to_owned());
    }
    let code = line.split('#').next().unwrap_or_default().trim();
    if code.starts_with('[') {
        let closing = if code.starts_with("[[") { "]]" } else { "]" };
        let name = code.trim_start_matches('[').trim_end_matches(']').trim();
        let plain = !name.is_empty() && !name.contains(['[', ']', '=', '"']);
        let expected = format!("`{}{name}{closing}`", &"[["[..closing.len()]);
        return if plain && !code.ends_with(closing) {
            slip(code, "the name of a table without its closing bracket", expected)
        } else {
            None
        };
    }
    let Some((key, value)) = code.split_once('=') else {
        return match code.split_once(':') {
            Some((key, value)) if !value.trim().is_empty() => {
                let expected = format!("`{} = {}`", key.trim().trim_matches('"'), value.trim());
                slip(code, "a colon between key and value", expected)
            }
            _ => slip(
                code,
                "neither `key = value` nor `[table]`",
                "for example `duration_s = 1.5`; a comment begins with #".to_owned(),
            )
            .filter(|_| !code.is_empty() && code.chars().all(|c| c.is_alphanumeric() || " _-".contains(c))),
        };
    };
    let (key, value) = (key.trim(), value.trim());
    if value.is_empty() {
        return slip(code, "a key without a value", format!("`{key} = VALUE`"));
    }
    if ["True", "False", "TRUE", "FALSE"].contains(&value) {
        return slip(
            value,
            "true and false are written in small letters",
            format!("`{key} = {}`", value.to_lowercase()),
        );
    }
    if let Some(text) = value.strip_prefix(['\u{201c}', '\u{201d}', '\u{201e}', '\u{2018}', '\u{2019}']) {
        let text = text.trim_end_matches(['\u{201c}', '\u{201d}', '\u{2018}', '\u{2019}']);
        return slip(
            value,
            "curly quotes, as text programs write them",
            format!("straight quotes: `{key} = \"{text}\"`"),
        );
    }
    let is_word = value.starts_with(|c: char| c.is_alphabetic() || "./_".contains(c))
        && !value.contains(['"', '\'', ',', '{', '[']);
    if is_word {
        return slip(value, "a text without quotes", format!("quotes around a text: `{key} = \"{value}\"`"));
    }
    let number =
        value.split(|c: char| c == ' ' || c.is_alphabetic()).next().filter(|number| number.parse::<f64>().is_ok());
    number.filter(|number| number.len() < value.len()).and_then(|number| {
        slip(
            value,
            "a number with text behind it",
            format!("the number alone: `{key} = {number}`; its unit is in the key's name"),
        )
    })
}

/// Line of the earlier definition of the key or table that is defined again at `at`.
fn first_definition(text: &str, begins: &[usize], at: usize) -> Option<usize> {
    let number = begins.partition_point(|begin| *begin <= at);
    let lines: Vec<&str> =
        text.lines().take(number).map(|line| line.split('#').next().unwrap_or_default().trim()).collect();
    let (again, before) = lines.split_last()?;
    let key = |line: &str| line.split('=').next().unwrap_or_default().replace([' ', '"'], "");
    if again.starts_with('[') {
        return before.iter().position(|line| key(line) == key(again)).map(|index| index + 1);
    }
    let table = before.iter().rposition(|line| line.starts_with('[')).map_or(0, |index| index + 1);
    before.get(table..)?.iter().position(|line| key(line) == key(again)).map(|index| table + index + 1)
}

/// Byte range of the first key with more than [`MOST_PARTS`] parts.
fn deep_key(text: &str) -> Option<Range<usize>> {
    let ends = |c: char| "[]{},=#\n".contains(c);
    let is_deep =
        |key: &&str| key.matches('.').count() >= MOST_PARTS && key.split('.').all(|part| !part.trim().is_empty());
    let key = text.split(ends).map(str::trim).find(is_deep)?;
    let start = key.as_ptr() as usize - text.as_ptr() as usize;
    Some(start..start + key.len())
}

/// Whether a comma stands between two digits.
fn is_decimal_comma(text: &str, at: usize) -> bool {
    let digit = |at: Option<usize>| at.and_then(|at| text.as_bytes().get(at)).is_some_and(u8::is_ascii_digit);
    text.as_bytes().get(at) == Some(&b',') && digit(at.checked_sub(1)) && digit(at.checked_add(1))
}

impl Node {
    /// Child of this name (table) or index (array).
    pub fn child(&self, segment: &str) -> Option<&Node> {
        match &self.content {
            Content::Table(entries) => entries.get(segment),
            Content::Array(entries) => entries.get(segment.parse::<usize>().ok()?),
            Content::Leaf(_) => None,
        }
    }

    /// The value without places.
    pub fn value(&self) -> toml::Value {
        match &self.content {
            Content::Table(entries) => {
                toml::Value::Table(entries.iter().map(|(key, node)| (key.clone(), node.value())).collect())
            }
            Content::Array(entries) => toml::Value::Array(entries.iter().map(Node::value).collect()),
            Content::Leaf(value) => value.clone(),
        }
    }

    /// The value as a table; empty for anything else.
    pub fn table(&self) -> toml::Table {
        match self.value() {
            toml::Value::Table(table) => table,
            _ => toml::Table::new(),
        }
    }
}
