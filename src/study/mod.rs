//! Studies: the TOML file as typed, and what it means: a machine, a scene per row, and the design of the rows.
//!
//! [`Study::load`] reads the file and everything it names (hammer files) once; [`Study::check`] holds it to the interface
//! points of the machine; after that [`Study::scene`] is a pure function of the row that touches no file.
//!
//! A row's values are put at their paths into the tree of the file's values, which is then read like any file: whatever
//! the file can say, a factor or a `--set` can vary.

mod constraints;
mod demand;
mod document;
mod error;
mod factors;
mod file;
mod geometry;
mod growth;
mod keys;
mod kinds;
mod layers;
mod library;
mod overrides;
mod path;
mod placement;
mod preset;
mod resolve;
mod schema;
mod structure;
mod table;

use std::path::{Path, PathBuf};

use document::Document;
use factors::{Plan, Source, linked};
use keys::Shape;
use library::Library;
use overrides::Override;
use resolve::{Context, Issue, resolve};

pub use demand::InterfaceDemand;
pub use error::{InvalidRow, Place, Problem, StudyError};
pub use factors::FactorInfo;
pub use file::{
    CastingEntry, CorrelationEntry, DesignEntry, DesignKind, DistributionName, FactorEntry, Fidelity, FixtureEntry,
    HammerEntry, Housings, LinkEntry, OptimiseName, ParameterOverrides, PartEntry, Scale, SolverEntry, SourceName,
    StructureEntry, StudyFile,
};
pub use placement::{PointTable, Rail};
pub use schema::{hammer_file, hammer_schema, study_schema};
pub use structure::{MatrixSource, StructureSettings, StructureSource, load_structure};

use crate::design::Level;
use crate::quantity::Value;
use crate::scene::Scene;

/// A commented study that shows every key: what `init` writes.
pub const TEMPLATE: &str = include_str!("template.toml");

/// Top-level keys that all rows share.
const SHARED_KEYS: [&str; 4] = ["title", "structure", "structures", "design"];

/// A loaded study.
#[derive(Debug, Clone)]
pub struct Study {
    document: Document,
    directory: PathBuf,
    overrides: Vec<Override>,
    plan: Plan,
    library: Library,
    structure: StructureSettings,
    /// The further machines by name.
    structures: Vec<(String, StructureSettings)>,
    /// Whether the design's constraints have chosen its rows.
    constrained: bool,
    /// Paths at which only factors give a value.
    filled: Vec<Vec<String>>,
    /// Values of the file, overrides and, where the file is silent, row 0's factors applied: a complete study.
    base: StudyFile,
    /// The same as a tree, without what all rows share.
    template: toml::Table,
    hash: String,
}

impl Study {
    /// Reads a study file and the hammer files that it names.
    ///
    /// # Errors
    /// [`StudyError::Read`] if the study cannot be read, [`StudyError::Invalid`] with all faults found.
    pub fn load(path: &Path) -> Result<Self, StudyError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| StudyError::Read { path: path.to_path_buf(), source })?;
        let directory = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, directory, &path.display().to_string())
    }

    /// Reads a study from a text. `directory`: where relative file names start; `name`: the file's name in messages.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] with all faults found.
    pub fn parse(text: &str, directory: &Path, name: &str) -> Result<Self, StudyError> {
        let document = Document::parse(name, text).map_err(|problems| StudyError::Invalid { problems })?;
        Self::build(document, directory.to_path_buf(), Vec::new())
    }

    /// The study with further values set, each `path=value`, over the file's and the factors' values.
    ///
    /// A value is read as TOML (`4.5`, `[0.0, 0.1]`, `"R3"`); where a text is expected it needs no quotes. Any path of the
    /// file can be set, those of the structure and the design included.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] for unknown paths and values that do not fit.
    pub fn with_overrides(&self, settings: &[String]) -> Result<Self, StudyError> {
        if settings.is_empty() {
            return Ok(self.clone());
        }
        let shape = Shape::from_schema(&study_schema());
        let mut tree = self.document.root.table();
        let mut overrides = self.overrides.clone();
        let mut problems = Vec::new();
        for one in &overrides {
            // Accepted before: cannot fail.
            let _ = path::set(&mut tree, &one.path, one.value.clone());
        }
        for setting in settings {
            match Override::read(setting, &shape, &mut tree) {
                Ok(one) => overrides.push(one),
                Err(problem) => problems.push(*problem),
            }
        }
        StudyError::from_problems(problems)?;
        Self::build(self.document.clone(), self.directory.clone(), overrides)
    }

    fn build(document: Document, directory: PathBuf, overrides: Vec<Override>) -> Result<Self, StudyError> {
        let shape = Shape::from_schema(&study_schema());
        let mut tree = check_keys(&document, &shape, &overrides)?;
        let fault = |key: String, message: String| {
            let at = path::split(&key).unwrap_or_default();
            StudyError::one(Problem::new(document.locate(&at), key, message))
        };
        let design = tree.get("design").cloned().map(read_tree::<DesignEntry>);
        let design =
            design.transpose().map_err(|(key, message)| fault(format!("design.{key}"), message))?.unwrap_or_default();
        let plan = Plan::read(&design, (&document, &directory), &shape, &tree);
        let plan = plan.map_err(StudyError::several)?;
        let filled = plan.fill_gaps(&mut tree).map_err(|(key, message)| fault(key, message))?;
        let base: StudyFile =
            read_tree(toml::Value::Table(tree.clone())).map_err(|(key, message)| fault(key, message))?;
        let library = Library::new().map_err(|message| fault(String::new(), message))?;
        let fidelity = base.solver.fidelity.unwrap_or_default();
        let read = |entry, at: &[&str]| StructureSettings::read(entry, (&document, &directory), (at, fidelity));
        let structure = read(&base.structure, &["structure"]).map_err(StudyError::several)?;
        let further =
            base.structures.iter().map(|(name, entry)| Ok((name.clone(), read(entry, &["structures", name])?)));
        let structures = further.collect::<Result<_, _>>().map_err(StudyError::several)?;
        for key in SHARED_KEYS {
            tree.remove(key);
        }
        let mut study = Self {
            document,
            directory,
            overrides,
            plan,
            library,
            structure,
            structures,
            constrained: false,
            filled,
            base,
            template: tree,
            hash: String::new(),
        };
        study.read_hammers()?;
        study.hash = study.compute_hash();
        Ok(study)
    }

    /// Reads every hammer file that a row can name.
    fn read_hammers(&mut self) -> Result<(), StudyError> {
        let mut problems = Vec::new();
        let names: Vec<String> = self.base.hammer.keys().cloned().collect();
        for name in names {
            let at = ["hammer", name.as_str(), "file"].map(str::to_string);
            for candidate in self.candidates(&at) {
                let key = path::join(&candidate.at);
                let read = self.library.read(&self.directory, &candidate.value, candidate.place, &key);
                problems.extend(read.err().into_iter().flatten());
            }
        }
        StudyError::from_problems(problems)
    }

    /// BLAKE3 over all that determines the rows' scenes; see [`Study::hash`].
    fn compute_hash(&self) -> String {
        let typed = StudyFile { title: None, ..self.base.clone() };
        // A tree of finite numbers and texts, which JSON can always hold.
        let text = serde_json::to_string(&typed).unwrap_or_default();
        self.hash_of(&text, self.overrides.iter(), &self.plan.files)
    }

    /// BLAKE3 over a study's values, overrides, the contents of the design's files, and the hammer files.
    fn hash_of<'a>(
        &self,
        values: &str,
        overrides: impl Iterator<Item = &'a Override>,
        files: &[(String, String)],
    ) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut add = |label: &str, content: String| {
            for part in [label.as_bytes(), content.as_bytes()] {
                hasher.update(&(part.len() as u64).to_le_bytes());
                hasher.update(part);
            }
        };
        add("study", values.to_string());
        for one in overrides {
            add(&path::join(&one.path), one.value.to_string());
        }
        for (name, content) in files {
            add(name, content.clone());
        }
        for (name, table) in self.library.contents() {
            add(name, serde_json::to_string(&table).unwrap_or_default());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Name of the file, as in messages.
    pub fn name(&self) -> &str {
        &self.document.name
    }

    /// The text of the study file.
    pub fn text(&self) -> &str {
        &self.document.text
    }

    /// The settings of [`Study::with_overrides`], `path=value`, in order.
    pub fn overrides(&self) -> Vec<String> {
        self.overrides.iter().map(|one| one.text.clone()).collect()
    }

    /// BLAKE3 hash (hex) over all that determines the rows' scenes: the study's values (comments, layout, the title and the
    /// spelling of numbers do not count; the order of hammers, castings and factors does), the overrides, and the values of
    /// the hammer files named. The contents of the structure's files are not part of it: they are large and belong to
    /// their reader.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Seed of the design.
    pub fn seed(&self) -> u64 {
        self.plan.design.seed()
    }

    /// Title; without one, the file's name without its extension.
    pub fn title(&self) -> &str {
        let stem = || Path::new(&self.document.name).file_stem().and_then(|stem| stem.to_str());
        self.base.title.as_deref().or_else(stem).unwrap_or("study")
    }

    /// The factors, in the study's order.
    pub fn factors(&self) -> &[FactorInfo] {
        &self.plan.factors
    }

    /// The design.
    pub fn design(&self) -> &crate::design::Design {
        &self.plan.design
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.plan.design.row_count()
    }

    /// Values of the factors in a row, in the order of [`Study::factors`]; empty past the last row.
    ///
    /// A factor all of whose paths are overridden has the override's value.
    pub fn row_values(&self, row: usize) -> Vec<Value> {
        let drawn = self.plan.row(row).into_iter().zip(&self.plan.paths);
        drawn
            .map(|(value, paths)| {
                let overridden: Option<Vec<Value>> = paths.iter().map(|at| self.overridden(at)).collect();
                let first = overridden.and_then(|values| values.into_iter().next());
                match (first, &value) {
                    (Some(Value::Integer(whole)), Value::Real(_)) => Value::Real(whole as f64),
                    (Some(value), _) => value,
                    (None, _) => value,
                }
            })
            .collect()
    }

    /// Value of the last override of exactly this path.
    fn overridden(&self, at: &[String]) -> Option<Value> {
        let one = self.overrides.iter().rev().find(|one| one.path == at)?;
        one.value.clone().try_into().ok()
    }

    /// Twins of each row.
    pub fn twins(&self) -> usize {
        self.base.outputs.twins
    }

    /// Names of the hammers, in order.
    pub fn hammer_names(&self) -> Vec<&str> {
        self.base.hammer.keys().map(String::as_str).collect()
    }

    /// Names of the castings, in order.
    pub fn casting_names(&self) -> Vec<&str> {
        self.base.casting.keys().map(String::as_str).collect()
    }

    /// Settings of the machine.
    pub fn structure(&self) -> &StructureSettings {
        &self.structure
    }

    /// Settings of the further machines, [`Scene::machine`] counts them.
    pub fn structures(&self) -> &[(String, StructureSettings)] {
        &self.structures
    }

    /// The scene of a row; `points`: the machine's interface points.
    ///
    /// Pure: touches no file, depends on no other row.
    ///
    /// # Errors
    /// [`InvalidRow`] if the row's values describe no scene that can be simulated, e.g. a hammer beside its casting, and
    /// for rows past the last one.
    pub fn scene(&self, row: usize, points: &PointTable) -> Result<Scene, InvalidRow> {
        let levels = self.plan.design.row(row).ok_or_else(|| InvalidRow {
            reason: format!("row {row} does not exist: the study has the rows 0 to {}", self.row_count() - 1),
        })?;
        if !self.plan.constraints.is_empty() && !self.constrained {
            let reason = "the constraints of the design are not applied: call `Study::constrained` first".to_string();
            return Err(InvalidRow { reason });
        }
        let (values, fault) = self.plan.values(&levels);
        if let Some(reason) = fault {
            return Err(InvalidRow { reason });
        }
        self.resolve_with(&values, points).map_err(|issues| {
            let words = issues.iter().map(|issue| match &issue.nearest {
                Some(nearest) => format!("`{}`: {} (did you mean `{nearest}`?)", issue.path, issue.message),
                None => format!("`{}`: {}", issue.path, issue.message),
            });
            InvalidRow { reason: words.collect::<Vec<_>>().join("; ") }
        })
    }

    /// Applies the factors' values, then the overrides, and resolves.
    fn resolve_with(&self, values: &[Value], points: &PointTable) -> Result<Scene, Vec<Issue>> {
        let fault = |path: String, message: String| vec![Issue { path, message, nearest: None, row_only: false }];
        let mut tree = self.template.clone();
        for ((paths, links), value) in self.plan.paths.iter().zip(&self.plan.links).zip(values) {
            for (at, link) in paths.iter().zip(links) {
                path::set(&mut tree, at, linked(value, *link)).map_err(|message| fault(path::join(at), message))?;
            }
        }
        for one in self.overrides.iter().filter(|one| one.reaches_rows()) {
            path::set(&mut tree, &one.path, one.value.clone())
                .map_err(|message| fault(path::join(&one.path), message))?;
        }
        let file: StudyFile = read_tree(toml::Value::Table(tree)).map_err(|(key, message)| fault(key, message))?;
        let machines: Vec<&str> = self.structures.iter().map(|(name, _)| name.as_str()).collect();
        let context = Context { rails: &self.structure.rails, machines: &machines, library: &self.library, points };
        resolve(&file, &context)
    }

    /// Checks the study against the machine's interface points, before any row is run: every name that a row can use, the
    /// values of the first row, and each factor at its ends (or each of its values) with the others as in the first row.
    ///
    /// Hammers that miss their casting are no fault here: such rows end as invalid.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] with all faults found.
    pub fn check(&self, points: &PointTable) -> Result<(), StudyError> {
        let mut problems = self.check_names(points);
        let first = self.plan.design.row(0).unwrap_or_default();
        self.collect_issues(&first, points, &mut problems);
        for (source, factor) in self.plan.sources.iter().zip(&self.plan.factors) {
            let Source::Drawn(index) = *source else { continue };
            for extreme in factor.extremes() {
                let mut levels = first.clone();
                if let Some(level) = levels.get_mut(index) {
                    *level = extreme;
                }
                self.collect_issues(&levels, points, &mut problems);
            }
        }
        // Rows share their faults: one report per place and key.
        let mut seen = std::collections::BTreeSet::new();
        problems.retain(|problem| {
            let place = &problem.place;
            seen.insert((place.file.clone(), place.line, place.column, problem.key.clone()))
        });
        StudyError::from_problems(problems)
    }

    fn collect_issues(&self, levels: &[Level], points: &PointTable, problems: &mut Vec<Problem>) {
        let (values, fault) = self.plan.values(levels);
        if let Some(message) = fault {
            let at = "design.factor".to_string();
            problems.push(self.problem(Issue { path: at, message, nearest: None, row_only: false }));
            return;
        }
        let values = values.as_slice();
        let issues = self.resolve_with(values, points).err().unwrap_or_default();
        let studies = issues.into_iter().filter(|issue| !issue.row_only);
        problems.extend(studies.map(|issue| self.problem(issue)));
    }

    /// Gives an issue its place: the factor that drives the quantity, the override, the hammer file, or the study.
    fn problem(&self, issue: Issue) -> Problem {
        let at = path::split(&issue.path).unwrap_or_default();
        let place = self.place_of(&at);
        Problem::new(place, issue.path, issue.message).nearest(issue.nearest)
    }

    fn place_of(&self, at: &[String]) -> Place {
        if at.is_empty() {
            return self.document.locate(at);
        }
        if let Some(one) = self.overrides.iter().rev().find(|one| one.path.starts_with(at) || at.starts_with(&one.path))
        {
            return one.place();
        }
        let drives = |paths: &Vec<Vec<String>>| paths.iter().any(|path| path.starts_with(at) || at.starts_with(path));
        if let Some(index) = self.plan.paths.iter().position(drives)
            && let Some(factor) = self.plan.factors.get(index)
        {
            let key = match (&factor.expression, factor.values.is_empty()) {
                (Some(_), _) => "expression",
                (None, true) => "range",
                (None, false) => "values",
            };
            let section = ["design", "factor", factor.name.as_str(), key].map(str::to_string);
            return self.document.locate(&section);
        }
        if let [hammer, name, parameters, rest @ ..] = at
            && hammer == "hammer"
            && parameters == "parameters"
            && self.document.nearest(at).1 < at.len()
            && let Some(file) = self.base.hammer.get(name).and_then(|entry| entry.file.as_deref())
            && let Some(place) = self.library.locate(file, rest)
        {
            return place;
        }
        self.document.locate(at)
    }
}

/// Holds the document to its shape and returns its values, overrides applied.
fn check_keys(document: &Document, shape: &Shape, overrides: &[Override]) -> Result<toml::Table, StudyError> {
    let mut tree = document.root.table();
    let driven = overrides::driven_paths(&tree);
    let provided = |at: &[String]| {
        // A value inside a missing table provides the table too.
        let set = overrides.iter().map(|one| &one.path);
        driven.iter().chain(set).any(|path| path.starts_with(at))
    };
    StudyError::from_problems(keys::check(document, shape, &provided))?;
    for one in overrides {
        path::set(&mut tree, &one.path, one.value.clone())
            .map_err(|message| StudyError::one(Problem::new(one.place(), path::join(&one.path), message)))?;
    }
    Ok(tree)
}

/// Reads a tree of values; the error is the key's path and the message.
fn read_tree<T: serde::de::DeserializeOwned>(value: toml::Value) -> Result<T, (String, String)> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let key = error.path().to_string();
        (key, error.into_inner().message().to_string())
    })
}
