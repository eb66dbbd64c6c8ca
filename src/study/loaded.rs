//! A loaded study with all its files, not yet checked against a machine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::document::error::{FileLocation, Problem, StudyError};
use super::document::keys::Shape;
use super::document::overrides::{Override, SHARED_KEYS};
use super::document::path;
use super::document::read::read_tree;
use super::document::tree::Document;
use super::document::typed::{Typed, check_keys};
use super::file::{DesignEntry, StudyFile};
use super::goal::Goal;
use super::plan::design::DesignPlan;
use super::plan::factor::{FactorInfo, FactorSource, to_toml};
use super::plan::reader::Surroundings;
use super::resolve::issue::Issue;
use super::resolve::library::Library;
use super::resolve::placement::PointTable;
use super::resolve::rows::SceneReader;
use super::resolve::structure::{CastingModel, MachineTable, StructureSettings};
use super::schema::study_schema;
use decore_files::Limit;
use decore_model::metrics::CastingNames;
use decore_model::scene::{NumericalTwin, OutputSettings, Scene, StructureEntry};
use decore_model::workpiece::CastingEntry;
use decore_quantity::Value;
use decore_statistics::design::Kind;

/// A text that some row has at a path.
pub(super) struct Candidate {
    pub value: String,
    /// Place in the study.
    pub place: FileLocation,
    /// Path of its key.
    pub at: Vec<String>,
}

/// A loaded study.
#[derive(Debug, Clone)]
pub struct Study {
    pub(super) typed: Typed,
    pub(super) plan: DesignPlan,
    pub(super) scenes: SceneReader,
    /// Values of the file, overrides and, where the file is silent, row 0's factors applied: a complete study.
    pub(super) file: StudyFile,
    structure: StructureSettings,
    /// The further machines by name.
    structures: Vec<(String, StructureSettings)>,
    /// Models of the elastic castings by the castings' indices.
    elastic_castings: BTreeMap<usize, (String, CastingModel)>,
    goal: Option<Goal>,
    hash: String,
}

fn document(name: &str, text: &str) -> Result<Document, StudyError> {
    Document::parse(name, text).map_err(|problems| StudyError::Invalid { problems })
}

impl Study {
    /// Reads a study file and the hammer files that it names.
    ///
    /// # Errors
    /// [`StudyError::Read`] if the study cannot be read, [`StudyError::Invalid`] with all faults found.
    pub fn load(path: &Path) -> Result<Self, StudyError> {
        let text = decore_files::read_text(path, Limit::TOML)
            .map_err(|source| StudyError::Read { path: path.to_path_buf(), source })?;
        let directory = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let document = document(&path.display().to_string(), &text)?;
        let file = Some(path.to_path_buf());
        let (hammers, overrides) = (BTreeMap::new(), Vec::new());
        Self::build(Typed { document, file, directory, row_directory: None, hammers, overrides })
    }

    /// Reads a study from a text. `directory`: where relative file names start; `name`: the file's name in messages.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] with all faults found.
    pub fn parse(text: &str, directory: &Path, name: &str) -> Result<Self, StudyError> {
        Self::parse_with_hammers(text, directory, name, BTreeMap::new())
    }

    /// As [`Study::parse`], with the texts of hammer files by the name that the study gives them; these files are not opened.
    ///
    /// # Errors
    /// As for [`Study::parse`].
    pub fn parse_with_hammers(
        text: &str,
        directory: &Path,
        name: &str,
        hammers: BTreeMap<String, String>,
    ) -> Result<Self, StudyError> {
        let (document, directory) = (document(name, text)?, directory.to_path_buf());
        Self::build(Typed { document, file: None, directory, row_directory: None, hammers, overrides: Vec::new() })
    }

    /// The study with further values set, each `path=value`, over the file's and the factors' values.
    ///
    /// A value is read as TOML (`4.5`, `[0.0, 0.1]`, `"R3"`); texts need no quotes. Any path of the file can be set, including the
    /// structure and the design.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] for unknown paths and values that do not fit.
    pub fn with_overrides(&self, settings: &[String]) -> Result<Self, StudyError> {
        if settings.is_empty() {
            return Ok(self.clone());
        }
        let shape = Shape::from_schema(&study_schema());
        let (mut typed, mut tree, mut problems) = (self.typed.clone(), self.typed.tree(), Vec::new());
        for setting in settings {
            match Override::read(setting, &shape, &mut tree) {
                Ok(one) => typed.overrides.push(one),
                Err(problem) => problems.push(*problem),
            }
        }
        StudyError::from_problems(problems)?;
        Self::build(typed)
    }

    fn build(typed: Typed) -> Result<Self, StudyError> {
        let shape = Shape::from_schema(&study_schema());
        let mut tree = check_keys(&typed.document, &shape, &typed.overrides)?;
        let fault = |key: String, message: String| {
            let at = path::split(&key).unwrap_or_default();
            StudyError::one(Problem::new(typed.locate(&at), key, message))
        };
        let design = tree.get("design").cloned().map(read_tree::<DesignEntry>);
        let design =
            design.transpose().map_err(|(key, message)| fault(format!("design.{key}"), message))?.unwrap_or_default();
        let around = Surroundings { typed: &typed, shape: &shape, tree: &tree };
        let plan = DesignPlan::read(&design, &around).map_err(StudyError::several)?;
        plan.fill_gaps(&mut tree).map_err(|(key, message)| fault(key, message))?;
        let file: StudyFile =
            read_tree(toml::Value::Table(tree.clone())).map_err(|(key, message)| fault(key, message))?;
        let goal = file.goal.as_ref().map(|entry| Goal::read(entry, &typed)).transpose()?;
        let library = Library::new().map_err(|message| fault(String::new(), message))?;
        let fidelity = file.solver.fidelity.unwrap_or_default();
        let read = |entry: &StructureEntry, at: &[&str]| {
            StructureSettings::read(MachineTable { entry, typed: &typed, at }, fidelity)
        };
        let structure = read(&file.structure, &["structure"]).map_err(StudyError::several)?;
        let further =
            file.structures.iter().map(|(name, entry)| Ok((name.clone(), read(entry, &["structures", name])?)));
        let structures: Vec<(String, StructureSettings)> =
            further.collect::<Result<_, _>>().map_err(StudyError::several)?;
        let mut elastic_castings = BTreeMap::new();
        for (index, (name, casting)) in file.casting.iter().enumerate() {
            let Some(entry) = &casting.structure else { continue };
            let model =
                CastingModel::read(entry, &typed, &["casting", name, "structure"]).map_err(StudyError::several)?;
            elastic_castings.insert(index, (name.clone(), model));
        }
        for key in SHARED_KEYS {
            tree.remove(key);
        }
        let scenes = SceneReader {
            template: tree,
            overrides: typed.overrides.iter().filter(|one| one.reaches_rows()).cloned().collect(),
            rails: structure.rails.clone(),
            machines: structures.iter().map(|(name, _)| name.clone()).collect(),
            library,
        };
        let hash = String::new();
        let mut study = Self { typed, plan, scenes, file, structure, structures, elastic_castings, goal, hash };
        study.read_hammers()?;
        // A tree of finite numbers and texts, which JSON can always hold.
        let values = serde_json::to_string(&study.file.of_rows()).unwrap_or_default() + &study.plan.conversions();
        let overrides = study.typed.overrides.iter().filter(|one| one.reaches_values());
        study.hash = super::hash::hash(&values, overrides, (&study.plan.files, &study.scenes.library));
        Ok(study)
    }

    /// Reads every hammer file that a row can name.
    fn read_hammers(&mut self) -> Result<(), StudyError> {
        let mut problems = Vec::new();
        let names: Vec<String> = self.file.hammer.keys().cloned().collect();
        for name in names {
            let at = ["hammer", name.as_str(), "file"].map(str::to_string);
            for candidate in self.candidates(&at) {
                let key = path::join(&candidate.at);
                let read = self.scenes.library.read(&self.typed, &candidate.value, candidate.place, &key);
                problems.extend(read.err().into_iter().flatten());
            }
        }
        StudyError::from_problems(problems)
    }

    /// Name of the file, as in messages.
    pub fn name(&self) -> &str {
        &self.typed.document.name
    }

    /// All files that the study reads, as paths to open: its own, hammer files, tables of rows, the files of its machines.
    pub fn files(&self) -> Vec<PathBuf> {
        let is_opened = |name: &&str| !self.typed.hammers.contains_key(*name);
        let hammers = self.scenes.library.texts().map(|(name, _)| name).filter(is_opened);
        let hammers = hammers.map(|name| self.typed.directory.join(name));
        let rows = self.plan.files.iter().map(|file| self.typed.row_directory().join(&file.name));
        let machines = [&self.structure].into_iter().chain(self.structures.iter().map(|(_, settings)| settings));
        let castings = self.elastic_castings.values().flat_map(|(_, casting)| casting.listed());
        let machines = machines.flat_map(|settings| settings.source.files()).chain(castings);
        let machines = machines.map(|(_, path)| path.to_path_buf());
        self.typed.file.iter().cloned().chain(hammers).chain(rows).chain(machines).collect()
    }

    /// The file with the rows of a design that is a table, as paths are opened; `None` for any other design.
    pub fn row_file(&self) -> Option<PathBuf> {
        let file = self.plan.files.first().filter(|_| matches!(self.plan.design.kind(), Kind::Table(_)))?;
        Some(self.typed.row_directory().join(&file.name))
    }

    /// Texts of the hammer files, by the name that the study gives them.
    pub fn hammer_files(&self) -> BTreeMap<String, String> {
        self.scenes.library.texts().map(|(name, text)| (name.to_owned(), text.to_owned())).collect()
    }

    /// Names and models of the elastic castings, by the castings' indices.
    pub fn elastic_castings(&self) -> &BTreeMap<usize, (String, CastingModel)> {
        &self.elastic_castings
    }

    /// Whether points of castings are nodes: by tables, factors or overrides.
    pub fn names_nodes(&self) -> bool {
        let struck = self.file.hammer.values().any(|hammer| hammer.strike_nodes.is_some());
        let of_casting = |casting: &CastingEntry| {
            casting.measuring_nodes.is_some()
                || casting.fixture.values().any(|fixture| fixture.at_nodes.is_some())
                || casting.core.values().any(|core| core.at_nodes.is_some())
        };
        struck || self.file.casting.values().any(of_casting)
    }

    /// The text of the study file.
    pub fn text(&self) -> &str {
        &self.typed.document.text
    }

    /// The settings of [`Study::with_overrides`], `path=value`, in order.
    pub fn overrides(&self) -> Vec<String> {
        self.typed.overrides.iter().map(|one| one.text.clone()).collect()
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
        let stem = || Path::new(&self.typed.document.name).file_stem().and_then(|stem| stem.to_str());
        self.file.title.as_deref().or_else(stem).unwrap_or("study")
    }

    /// The factors, in the study's order.
    pub fn factors(&self) -> &[FactorInfo] {
        &self.plan.factors
    }

    /// Value of the last override of exactly this path.
    pub(super) fn overridden(&self, at: &[String]) -> Option<Value> {
        let one = self.typed.overridden(|path| path == at)?;
        one.value.clone().try_into().ok()
    }

    /// Goal of the study; `None` if it has no `[goal]`.
    pub fn goal(&self) -> Option<&Goal> {
        self.goal.as_ref()
    }

    /// Checks the names and units of the goal. `known`: name and unit of each numerical column of the table of runs.
    ///
    /// # Errors
    /// [`StudyError::Invalid`]: each name without a column, with the nearest one; sums and comparisons of different units.
    pub fn check_goal(&self, known: &[(String, String)]) -> Result<(), StudyError> {
        self.goal.as_ref().map_or(Ok(()), |goal| goal.check(known, &self.typed))
    }

    /// Returns this study with the rows of a CSV file as its design: same factors, constraints and seed, and settings over anything
    /// but the design. The text of the study names the file without its folder: it is the same wherever the file lies.
    ///
    /// # Errors
    /// [`StudyError::Invalid`]: the file is no table of rows of the factors.
    pub fn with_rows(&self, file: &Path) -> Result<Self, StudyError> {
        let mut tree = self.typed.document.root.table();
        let design = self.typed.tree().remove("design").and_then(|design| design.try_into::<toml::Table>().ok());
        let mut kept: toml::Table = design.unwrap_or_default();
        kept.retain(|key, _| ["seed", "constraints", "factor"].contains(&key));
        for factor in kept.get_mut("factor").and_then(toml::Value::as_table_mut).into_iter().flatten() {
            factor.1.as_table_mut().map(|factor| factor.remove("levels"));
        }
        kept.insert("kind".to_owned(), "table".into());
        let name = file.file_name().unwrap_or(file.as_os_str());
        kept.insert("file".to_owned(), name.to_string_lossy().into_owned().into());
        tree.insert("design".to_owned(), kept.into());
        let text = toml::to_string(&tree).unwrap_or_default();
        let document = document(&self.typed.document.name, &text)?;
        let beside_design = |one: &&Override| one.path.first().is_none_or(|first| first != "design");
        let overrides = self.typed.overrides.iter().filter(beside_design).cloned().collect();
        let row_directory = Some(file.parent().unwrap_or(Path::new("")).to_path_buf());
        Self::build(Typed { document, overrides, row_directory, ..self.typed.clone() })
    }

    /// Twins of each row.
    pub fn twins(&self) -> usize {
        self.file.outputs.twins
    }

    /// Rows that have a numerical twin: without factors none unless every row is to have one, as a scene alone is no sample.
    pub fn numerical_twin(&self) -> NumericalTwin {
        match self.file.outputs.numerical_twin {
            NumericalTwin::Sample if self.factors().is_empty() => NumericalTwin::None,
            asked => asked,
        }
    }

    /// Windows and thresholds of the outputs, and the signals that are kept.
    pub fn outputs(&self) -> &OutputSettings {
        &self.file.outputs
    }

    /// Names of the castings, in order, with their fixtures and core points.
    pub fn castings(&self) -> Vec<CastingNames<'_>> {
        let castings = self.file.casting.iter();
        castings
            .map(|(name, casting)| CastingNames {
                name,
                fixtures: casting.fixture.keys().map(String::as_str).collect(),
                cores: casting.core.keys().map(String::as_str).collect(),
            })
            .collect()
    }

    /// Names of the elastic castings, in order.
    pub fn elastic_names(&self) -> Vec<&str> {
        self.elastic_castings.values().map(|(name, _)| name.as_str()).collect()
    }

    /// The one-sided fixtures, casting by casting: names of casting and fixture.
    pub fn pads(&self) -> Vec<(&str, &str)> {
        let mut pads = Vec::new();
        for (casting, entry) in &self.file.casting {
            let own = entry.fixture.iter().filter(|(_, fixture)| fixture.one_sided == Some(true));
            pads.extend(own.map(|(name, _)| (casting.as_str(), name.as_str())));
        }
        pads
    }

    /// Names of the fixtures, CASTING.NAME, casting by casting.
    pub fn fixture_names(&self) -> Vec<String> {
        let of = |casting: CastingNames<'_>| {
            casting.fixtures.iter().map(|fixture| format!("{}.{fixture}", casting.name)).collect::<Vec<_>>()
        };
        self.castings().into_iter().flat_map(of).collect()
    }

    /// Names of the core points, CASTING.NAME, casting by casting.
    pub fn core_names(&self) -> Vec<String> {
        let of = |casting: CastingNames<'_>| {
            casting.cores.iter().map(|core| format!("{}.{core}", casting.name)).collect::<Vec<_>>()
        };
        self.castings().into_iter().flat_map(of).collect()
    }

    /// The constraints, as written.
    pub fn constraints(&self) -> Vec<&str> {
        self.plan.constraints.iter().map(|constraint| constraint.text.as_str()).collect()
    }

    /// Names of the hammers, in order.
    pub fn hammer_names(&self) -> Vec<&str> {
        self.file.hammer.keys().map(String::as_str).collect()
    }

    /// Names of the castings, in order.
    pub fn casting_names(&self) -> Vec<&str> {
        self.file.casting.keys().map(String::as_str).collect()
    }

    /// Rails of the machine on which hammers can stand: their names and interface points, in order.
    pub fn rails(&self) -> impl Iterator<Item = (&str, &[String])> {
        self.scenes.rails.iter().map(|rail| (rail.name.as_str(), rail.points.as_slice()))
    }

    /// Settings of the machine.
    pub fn structure(&self) -> &StructureSettings {
        &self.structure
    }

    /// Settings of the further machines, [`Scene::machine`] counts them.
    pub fn structures(&self) -> &[(String, StructureSettings)] {
        &self.structures
    }

    /// The scene of these values of the factors.
    pub(super) fn scene_of(&self, values: &[Value], points: &PointTable) -> Result<Scene, Vec<Issue>> {
        self.scenes.scene(self.plan.driven(values), points)
    }

    /// All texts that some row can have at a path.
    pub(super) fn candidates(&self, at: &[String]) -> Vec<Candidate> {
        let overridden = self.typed.overridden(|path| path == at);
        match (overridden, self.plan.driver(|path| path == at)) {
            (Some(one), _) => {
                let text = one.value.as_str().map(str::to_string);
                text.into_iter().map(|value| Candidate { value, place: one.place(), at: at.to_vec() }).collect()
            }
            (None, Some(factor)) => {
                let candidate = |(index, value)| {
                    let index: usize = index;
                    let entry = index.to_string();
                    let key = ["design", "factor", &factor.name, "values", &entry].map(str::to_string);
                    let value = to_toml(value).as_str()?.to_string();
                    Some(Candidate { value, place: self.typed.locate(&key), at: key.to_vec() })
                };
                factor.values.iter().enumerate().filter_map(candidate).collect()
            }
            (None, None) => {
                let value = path::get(&self.scenes.template, at).and_then(toml::Value::as_str);
                let candidate =
                    |value: &str| Candidate { value: value.to_string(), place: self.typed.locate(at), at: at.to_vec() };
                value.map(candidate).into_iter().collect()
            }
        }
    }

    /// Gives an issue its place: the factor that drives the quantity, the override, the hammer file, or the study.
    pub(super) fn problem(&self, issue: Issue) -> Problem {
        let at = path::split(&issue.path).unwrap_or_default();
        let place = self.place_of(&at);
        Problem::new(place, issue.path, issue.message).nearest(issue.nearest)
    }

    fn place_of(&self, at: &[String]) -> FileLocation {
        if at.is_empty() {
            return self.typed.locate(at);
        }
        if let Some(one) = self.typed.overridden(|path| path.starts_with(at) || at.starts_with(path)) {
            return one.place();
        }
        if let Some(factor) = self.plan.driver(|path| path.starts_with(at) || at.starts_with(path)) {
            let key = match (&factor.source, factor.values.is_empty()) {
                (FactorSource::Derived { .. }, _) => "expression",
                (FactorSource::Drawn { .. }, true) => "range",
                (FactorSource::Drawn { .. }, false) => "values",
            };
            let section = ["design", "factor", factor.name.as_str(), key].map(str::to_string);
            return self.typed.locate(&section);
        }
        if let [hammer, name, parameters, rest @ ..] = at
            && hammer == "hammer"
            && parameters == "parameters"
            && self.typed.document.nearest(at).1 < at.len()
            && let Some(file) = self.file.hammer.get(name).and_then(|entry| entry.file.as_deref())
            && let Some(place) = self.scenes.library.locate(file, rest)
        {
            return place;
        }
        self.typed.locate(at)
    }
}
