//! Design and hammers of a study from its text alone, for readers of its rows who do not have the files of its machine.

use std::collections::BTreeMap;

use super::document::error::{Problem, StudyError};
use super::document::keys::Shape;
use super::document::overrides::Override;
use super::document::path;
use super::document::read::read_tree;
use super::document::tree::Document;
use super::file::{DesignEntry, Scale};
use super::schema::study_schema;
use decore_quantity::Value;
use decore_statistics::design::Kind;

/// The design of a study as its text describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignOutline {
    /// Kind of design; `None` if it uses rows of a file or parts.
    pub design: Option<Kind>,
    /// The factors, in the study's order.
    pub factors: Vec<FactorOutline>,
    /// The constraints, as written.
    pub constraints: Vec<String>,
    /// Factors with rank correlations; empty if there are none.
    pub correlated: Vec<String>,
    /// The casting that each hammer strikes, by the hammer's name; without those that strike the only one.
    pub strikes: BTreeMap<String, String>,
}

/// A factor as the text describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorOutline {
    /// Name as in the study.
    pub name: String,
    /// Whether its value is an expression of other factors.
    pub derived: bool,
    /// The expression, as written.
    pub expression: Option<String>,
    /// Paths of the parameters that have its value, by segments.
    pub drives: Vec<Vec<String>>,
    /// The values that it chooses from; empty for a range.
    pub values: Vec<Value>,
    /// The ends that the study gives it; `None` if it gives none.
    pub range: Option<[f64; 2]>,
    /// Whether it is spaced by its logarithm.
    pub logarithmic: bool,
}

impl DesignOutline {
    /// Reads the design of a study from its text and the settings `path=value` over it. `name`: the file's name in messages.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] for a text that is not a study.
    pub fn read(text: &str, overrides: &[String], name: &str) -> Result<Self, StudyError> {
        let document = Document::parse(name, text).map_err(|problems| StudyError::Invalid { problems })?;
        let shape = Shape::from_schema(&study_schema());
        let mut tree = document.root.table();
        for setting in overrides {
            Override::read(setting, &shape, &mut tree).map_err(|problem| StudyError::one(*problem))?;
        }
        let entry = tree.remove("design").map(read_tree::<DesignEntry>).transpose();
        let entry = entry.map_err(|(key, message)| {
            let at = ["design".to_owned()];
            StudyError::one(Problem::new(document.locate(&at), format!("design.{key}"), message))
        })?;
        let strikes = strikes(tree.get("hammer"));
        Ok(Self::of(entry.unwrap_or_default(), strikes))
    }

    /// The factor that the parameter of this path, by segments, has its value from.
    pub fn driver(&self, path: &[&str]) -> Option<&FactorOutline> {
        self.factors.iter().find(|factor| factor.drives.iter().any(|driven| driven == path))
    }

    fn of(entry: DesignEntry, strikes: BTreeMap<String, String>) -> Self {
        Self {
            strikes,
            design: entry.kind.unwrap_or_default().of(&entry.as_part().options()).ok(),
            constraints: entry.constraints,
            correlated: entry.correlation.map(|correlation| correlation.factors).unwrap_or_default(),
            factors: entry
                .factor
                .into_iter()
                .map(|(name, factor)| FactorOutline {
                    name,
                    derived: factor.expression.is_some(),
                    drives: (factor.path.iter().chain(factor.paths.iter().flatten()))
                        .filter_map(|path| path::split(path).ok())
                        .collect(),
                    expression: factor.expression,
                    values: factor.values.unwrap_or_default(),
                    range: factor.range,
                    logarithmic: factor.scale == Some(Scale::Log),
                })
                .collect(),
        }
    }
}

/// The castings that the table of hammers names.
fn strikes(hammers: Option<&toml::Value>) -> BTreeMap<String, String> {
    let named = |(name, hammer): (&String, &toml::Value)| {
        Some((name.clone(), hammer.get("casting").and_then(toml::Value::as_str)?.to_owned()))
    };
    hammers.and_then(toml::Value::as_table).into_iter().flatten().filter_map(named).collect()
}
