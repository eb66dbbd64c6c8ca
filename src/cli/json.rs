//! What commands print as JSON: one way to print it, one list of its schemas.

use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::Value;

use super::accuracy::AccuracyResult;
use super::check_result::Check;
use super::exit::Failure;
use super::scene_result::scene_schema;
use super::status::DatasetStatus;
use super::structure::StructureResult;
use super::text::say;
use super::verify::Verified;
use crate::comparison::Comparison;
use crate::refinement::Progress;
use crate::report::Report;
use crate::sensitivity::Sensitivity;
use crate::surrogate::Surrogate;

/// Prints a result as JSON, its keys in the order of its declaration; numbers that are none are null.
///
/// # Errors
/// As [`say`].
pub(super) fn say_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::Argument(error.to_string()))?;
    say(&text)
}

/// The schema (JSON Schema 2020-12) of what each command prints with `--json`, by the name that its file in `schemas/` has.
pub fn output_schemas() -> Vec<(&'static str, Value)> {
    vec![
        ("accuracy", schema::<AccuracyResult>("accuracy")),
        ("check", schema::<Check>("check")),
        ("comparison", schema::<Comparison>("comparison")),
        ("refinement", schema::<Progress>("refinement")),
        ("report", schema::<Report>("report")),
        ("scene", scene_schema()),
        ("sensitivity", schema::<Sensitivity>("sensitivity")),
        ("status", schema::<Vec<DatasetStatus>>("status")),
        ("structure", schema::<StructureResult>("structure")),
        ("surrogate", schema::<Surrogate>("surrogate")),
        ("verification", schema::<Vec<Verified>>("verification")),
    ]
}

/// The schema of a type, under a title.
pub(super) fn schema<T: JsonSchema>(name: &str) -> Value {
    let mut schema = schema_for!(T).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".to_owned(), format!("decore {name}").into());
    }
    schema
}
