//! Scenes of rows: values set at their paths in the tree of the study's values, which is then read like any file.

use toml::Value;

use super::issue::Issue;
use super::library::Library;
use super::placement::{PointTable, Rail};
use super::scene::{Context, resolve};
use crate::document::overrides::Override;
use crate::document::path;
use crate::document::read::read_tree;
use crate::file::StudyFile;
use decore_model::scene::Scene;

/// All that the scenes of a study's rows share.
#[derive(Debug, Clone)]
pub(crate) struct SceneReader {
    /// Values of the study that concern rows.
    pub template: toml::Table,
    /// Overrides of these values; they replace values of factors.
    pub overrides: Vec<Override>,
    /// Rails of the machine.
    pub rails: Vec<Rail>,
    /// Names of the further machines.
    pub machines: Vec<String>,
    /// Hammer files.
    pub library: Library,
}

impl SceneReader {
    /// The scene with these values at these paths.
    pub fn scene(&self, driven: Vec<(&[String], Value)>, points: &PointTable) -> Result<Scene, Vec<Issue>> {
        let fault = |path: String, message: String| vec![Issue::new(path, message)];
        let mut tree = self.template.clone();
        let set = self.overrides.iter().map(|one| (one.path.as_slice(), one.value.clone()));
        for (at, value) in driven.into_iter().chain(set) {
            path::set(&mut tree, at, value).map_err(|message| fault(path::join(at), message))?;
        }
        let file: StudyFile = read_tree(Value::Table(tree)).map_err(|(key, message)| fault(key, message))?;
        let (rails, machines, library) = (&self.rails, &self.machines, &self.library);
        resolve(&file, &Context { rails, machines, library, points })
    }
}
