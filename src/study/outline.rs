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
    /// Sand and binder of the cores of each casting that states one, by the casting's name.
    pub sand_binders: BTreeMap<String, String>,
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
    /// Paths of the parameters that have its value times a factor, plus an offset.
    pub links: Vec<Vec<String>>,
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
        let strikes = texts(tree.get("hammer"), "casting");
        let sand_binders = texts(tree.get("casting"), "sand_binder");
        let mut outline = Self::of(entry.unwrap_or_default(), strikes);
        outline.sand_binders = sand_binders;
        Ok(outline)
    }

    /// The factor on which the parameter of this path, by segments, depends, by a link or not.
    pub fn mover(&self, path: &[&str]) -> Option<&FactorOutline> {
        let moves = |factor: &&FactorOutline| factor.drives.iter().chain(&factor.links).any(|driven| driven == path);
        self.factors.iter().find(moves)
    }

    /// The factor that the parameter of this path, by segments, has its value from.
    pub fn driver(&self, path: &[&str]) -> Option<&FactorOutline> {
        self.factors.iter().find(|factor| factor.drives.iter().any(|driven| driven == path))
    }

    fn of(entry: DesignEntry, strikes: BTreeMap<String, String>) -> Self {
        Self {
            strikes,
            sand_binders: BTreeMap::new(),
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
                    links: factor.link.iter().filter_map(|link| path::split(&link.path).ok()).collect(),
                    expression: factor.expression,
                    values: factor.values.unwrap_or_default(),
                    range: factor.range,
                    logarithmic: factor.scale == Some(Scale::Log),
                })
                .collect(),
        }
    }
}

/// The texts that the entries of a table state by a key, by the names of the entries.
fn texts(entries: Option<&toml::Value>, key: &str) -> BTreeMap<String, String> {
    let named = |(name, entry): (&String, &toml::Value)| {
        Some((name.clone(), entry.get(key).and_then(toml::Value::as_str)?.to_owned()))
    };
    entries.and_then(toml::Value::as_table).into_iter().flatten().filter_map(named).collect()
}
