//! Hammer files, read once when a study is loaded.

use indexmap::IndexMap;

use super::layers::{Conflict, lay};
use crate::document::error::{FileLocation, Problem};
use crate::document::keys::{self, Shape};
use crate::document::path;
use crate::document::read::read_tree;
use crate::document::tree::Document;
use crate::document::typed::Typed;
use crate::schema::hammer_schema;
use decore_files::Limit;
use decore_model::hammer::HammerParameters;

/// The hammers that rows of a study can use.
#[derive(Debug, Clone)]
pub(crate) struct Library {
    defaults: toml::Table,
    files: IndexMap<String, HammerFile>,
}

#[derive(Debug, Clone)]
struct HammerFile {
    document: Document,
    /// All parameters, the file's laid over the defaults.
    values: toml::Table,
    parameters: HammerParameters,
}

impl Library {
    /// A library with the built-in hammer only.
    pub fn new() -> Result<Self, String> {
        let defaults = toml::Table::try_from(HammerParameters::default()).map_err(|error| error.to_string())?;
        Ok(Self { defaults, files: IndexMap::new() })
    }

    /// Reads a hammer file, or its text where the study comes with it; `place` and `key`: where the study names it.
    pub fn read(&mut self, typed: &Typed, file: &str, place: FileLocation, key: &str) -> Result<(), Vec<Problem>> {
        if self.files.contains_key(file) {
            return Ok(());
        }
        let (name, text) = match typed.hammers.get(file) {
            Some(text) => (format!("{file} of {}", typed.document.name), text.clone()),
            None => {
                let full = typed.directory.join(file);
                let text = decore_files::read_text(&full, Limit::TOML).map_err(|error| {
                    let message = format!("cannot read the hammer file {}: {error}", full.display());
                    vec![
                        Problem::new(place, key, message)
                            .expected("a hammer file (TOML), its path relative to the study"),
                    ]
                })?;
                (full.display().to_string(), text)
            }
        };
        let document = Document::parse(&name, &text)?;
        let shape = Shape::from_schema(&hammer_schema());
        let problems = keys::check(&document, &shape, &|_| false);
        if !problems.is_empty() {
            return Err(problems);
        }
        let mut values = self.defaults.clone();
        lay(&mut values, &document.root.table()).map_err(|Conflict { path, message }| {
            vec![Problem::new(document.locate(&path), path::join(&path), message)]
        })?;
        let parameters = read_parameters(values.clone())
            .map_err(|error| vec![Problem::new(FileLocation::in_file(&document.name), "", error)])?;
        self.files.insert(file.to_string(), HammerFile { document, values, parameters });
        Ok(())
    }

    /// Parameters of a file (`None`: the built-in hammer) with overrides laid over them.
    pub fn parameters(&self, file: Option<&str>, overrides: &toml::Table) -> Result<HammerParameters, String> {
        let entry = match file {
            Some(file) => Some(self.files.get(file).ok_or_else(|| format!("the hammer file {file} was not read"))?),
            None => None,
        };
        if overrides.is_empty() {
            return Ok(entry.map_or_else(HammerParameters::default, |entry| entry.parameters));
        }
        let mut values = entry.map_or(&self.defaults, |entry| &entry.values).clone();
        lay(&mut values, overrides)
            .map_err(|Conflict { path, message }| format!("`{}`: {message}", path::join(&path)))?;
        read_parameters(values)
    }

    /// Place of a parameter in a hammer file, if the file gives it.
    pub fn locate(&self, file: &str, parameter: &[String]) -> Option<FileLocation> {
        let document = &self.files.get(file)?.document;
        let (_, depth) = document.nearest(parameter);
        (depth == parameter.len()).then(|| document.locate(parameter))
    }

    /// Names of all files read, as the study has them, and their texts.
    pub fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().map(|(name, file)| (name.as_str(), file.document.text.as_str()))
    }

    /// Names and values of all files read, by name.
    pub fn contents(&self) -> Vec<(&str, toml::Table)> {
        let mut contents: Vec<_> =
            self.files.iter().map(|(name, file)| (name.as_str(), file.document.root.table())).collect();
        contents.sort_by_key(|(name, _)| *name);
        contents
    }
}

/// Parameters of a table of all of them, with the key in the message.
fn read_parameters(values: toml::Table) -> Result<HammerParameters, String> {
    read_tree(toml::Value::Table(values)).map_err(|(key, message)| format!("`{key}`: {message}"))
}
