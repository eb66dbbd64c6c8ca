//! What the text of a study alone says of its design: for those who have its rows, but not the files of its machine.

use super::document::error::{Problem, StudyError};
use super::document::keys::Shape;
use super::document::overrides::Override;
use super::document::tree::Document;
use super::document::typed::read_tree;
use super::file::{DesignEntry, Scale};
use super::schema::study_schema;
use crate::design::Kind;
use crate::quantity::Value;

/// The design of a study as its text describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignOutline {
    /// How the rows are chosen; `None` where rows of a file or parts belong to it.
    pub design: Option<Kind>,
    /// The factors, in the study's order.
    pub factors: Vec<FactorOutline>,
    /// The constraints, as written.
    pub constraints: Vec<String>,
    /// Factors with rank correlations; empty where there are none.
    pub correlated: Vec<String>,
}

/// A factor as the text describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorOutline {
    /// Name as in the study.
    pub name: String,
    /// Whether its value is an expression of other factors.
    pub derived: bool,
    /// The values that it chooses from; empty for a range.
    pub values: Vec<Value>,
    /// The ends that the study gives it; `None` where it gives none.
    pub range: Option<[f64; 2]>,
    /// Whether it is spaced by its logarithm.
    pub logarithmic: bool,
}

impl DesignOutline {
    /// Reads the design of a study from its text and the settings `path=value` over it. `name`: the file's name in messages.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] for a text that is no study.
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
        Ok(Self::of(entry.unwrap_or_default()))
    }

    fn of(entry: DesignEntry) -> Self {
        Self {
            design: entry.kind.unwrap_or_default().of(&entry.as_part().options()).ok(),
            constraints: entry.constraints,
            correlated: entry.correlation.map(|correlation| correlation.factors).unwrap_or_default(),
            factors: entry
                .factor
                .into_iter()
                .map(|(name, factor)| FactorOutline {
                    name,
                    derived: factor.expression.is_some(),
                    values: factor.values.unwrap_or_default(),
                    range: factor.range,
                    logarithmic: factor.scale == Some(Scale::Log),
                })
                .collect(),
        }
    }
}
