//! JSON schemas of the study file and the hammer file, generated from the types that read them.

use serde_json::Value;

use super::file::StudyFile;
use crate::hammer::HammerParameters;

/// JSON schema (draft 2020-12) of a study file.
pub fn study_schema() -> Value {
    published::<StudyFile>("decore study")
}

/// JSON schema (draft 2020-12) of a hammer file.
pub fn hammer_schema() -> Value {
    published::<HammerParameters>("decore hammer")
}

fn published<T: schemars::JsonSchema>(title: &str) -> Value {
    let mut schema = schemars::schema_for!(T).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".to_string(), Value::from(title));
    }
    // A hammer file and its overrides may give one half of a contact: the other keeps its value.
    if let Some(contact) = schema.pointer_mut("/$defs/ContactParameters").and_then(Value::as_object_mut) {
        contact.remove("required");
    }
    schema
}
