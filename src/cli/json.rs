//! What commands print as JSON: one way to print it, one form of its schemas.

use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::Value;

use super::exit::Failure;
use super::text::print_line;

/// Prints a result as JSON, its keys in the order of its declaration; numbers that are none are null.
///
/// # Errors
/// As [`say`].
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::Argument(error.to_string()))?;
    print_line(&text)
}

/// The schema of a type, under a title.
pub(super) fn schema<T: JsonSchema>(name: &str) -> Value {
    let mut schema = schema_for!(T).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".to_owned(), format!("decore {name}").into());
    }
    schema
}
