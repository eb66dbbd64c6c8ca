//! Part of a hammer file within a study.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use crate::hammer::HammerParameters;

/// Part of a hammer file: a tree of values laid over it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ParameterOverrides(pub toml::Table);

impl ParameterOverrides {
    /// Whether nothing is overridden.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl JsonSchema for ParameterOverrides {
    fn schema_name() -> Cow<'static, str> {
        HammerParameters::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        HammerParameters::json_schema(generator)
    }
}
