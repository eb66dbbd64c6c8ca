//! JSON output of commands, and its schemas.

use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::Value;

use super::caller::Caller;
use super::exit::Failure;
use super::text::{fit, print_line, terminal_columns};

/// Prints a result as JSON, its keys in the order of its declaration; numbers that are none are null.
///
/// # Errors
/// As [`print_line`].
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::Argument(error.to_string()))?;
    if let Some(caller) = Caller::current() {
        caller.keep(|result| result.json = text);
        return Ok(());
    }
    print_line(&text)
}

/// Prints a result as JSON or in words, whose lines end where the terminal does. A program that called the command gets both.
///
/// # Errors
/// As [`print_line`].
pub(super) fn print_result(json: bool, value: &impl Serialize, words: impl FnOnce() -> String) -> Result<(), Failure> {
    if json {
        print_json(value)?;
    }
    if wants_words(json) {
        let words = words();
        print_line(&terminal_columns().map_or_else(|| words.clone(), |columns| fit(&words, columns)).trim_end())?;
    }
    Ok(())
}

/// Whether a result is printed in words: not as JSON alone, as only a program that called the command reads both.
pub(super) fn wants_words(json: bool) -> bool {
    !json || Caller::current().is_some()
}

/// The schema of a type, under a title.
pub(super) fn schema<T: JsonSchema>(name: &str) -> Value {
    let mut schema = schema_for!(T).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".to_owned(), format!("decore {name}").into());
    }
    schema
}
