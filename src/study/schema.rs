//! JSON schemas of the study file and the hammer file, and the hammer file with all defaults, generated from the types that
//! read them.

use serde_json::Value;

use super::file::StudyFile;
use decore_model::hammer::HammerParameters;
use decore_model::parameter::document;

/// JSON schema (draft 2020-12) of a study file.
pub fn study_schema() -> Value {
    published::<StudyFile>("decore study")
}

/// JSON schema (draft 2020-12) of a hammer file.
pub fn hammer_schema() -> Value {
    published::<HammerParameters>("decore hammer")
}

/// The built-in hammer as a hammer file, a comment behind each parameter.
///
/// # Errors
/// A default that TOML cannot hold.
pub fn hammer_file() -> Result<String, toml::ser::Error> {
    let head = "# The built-in hammer, written out: the published hammer, and assumed or calibrated values where the publication is \
                silent.\n# Source of the published values: Mariadass et al., Appl. Mech. 2023, 4, 1206-1226, Table 2.\n\
                # A hammer file may give any part of this; what it leaves out keeps these values. SI units, named in each key.\n";
    document::<HammerParameters>(head)
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
