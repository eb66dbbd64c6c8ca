//! Settings of the machine and its reduction, defaults filled in and paths resolved.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::placement::Rail;
use crate::document::error::{Problem, StudyError};
use crate::document::keys::Shape;
use crate::document::read::read_tree;
use crate::document::tree::Document;
use crate::document::typed::{Typed, check_keys};
use crate::file::StructureFile;
use decore_files::Limit;
use decore_model::parameter::{Fault, Parameters};
use decore_model::scene::{Fidelity, Housings, Preset, SourceName, StructureEntry, StructureParameters};
use decore_model::structure::{Damping, ElasticSettings, MatrixFile, MatrixFormat, ModelFiles, read_damping_ratios};
use decore_model::workpiece::{CastingStructure, CastingStructureEntry};

/// The rail of the built-in station.
const STATION_RAIL: (&str, [&str; 9]) = ("rail", ["R1", "R2", "R3", "R4", "R5", "R6", "R7", "R8", "R9"]);

/// Source of the machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StructureSource {
    /// The built-in station.
    Station,
    /// Finite element matrices.
    Matrices(Box<MatrixSource>),
    /// Modal table.
    ModalTable {
        /// Frequencies, damping and rows per interface point.
        table: PathBuf,
        /// Table of interface points.
        points: PathBuf,
    },
}

/// Finite element matrices and how to read them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MatrixSource {
    /// Files, format and units.
    pub files: ModelFiles,
    /// Whether reductions are kept and used again.
    pub cache: bool,
}

impl StructureSource {
    /// Every file that it reads, with its key in the study.
    pub fn files(&self) -> Vec<(&'static str, &Path)> {
        match self {
            Self::Station => Vec::new(),
            Self::ModalTable { table, points } => vec![("modal_file", table), ("points_file", points)],
            Self::Matrices(source) => files_of(&source.files),
        }
    }
}

/// Every file of a finite element model, with its key in the study.
fn files_of(files: &ModelFiles) -> Vec<(&'static str, &Path)> {
    let all = [
        ("stiffness_file", Some(files.stiffness.path.as_path())),
        ("mass_file", Some(&files.mass.path)),
        ("points_file", Some(files.points.as_path()).filter(|path| !path.as_os_str().is_empty())),
        ("damping_file", files.damping.as_ref().map(|matrix| matrix.path.as_path())),
        ("dof_file", files.dofs.as_deref()),
        ("nodes_file", files.nodes.as_deref()),
    ];
    all.into_iter().filter_map(|(key, path)| Some((key, path?))).collect()
}

/// Finite element model of an elastic casting: its files and settings.
#[derive(Debug, Clone, PartialEq)]
pub struct CastingModel {
    /// Files of the matrices, without interface points.
    pub files: ModelFiles,
    /// Cut-off, damping, size of points.
    pub settings: ElasticSettings,
}

impl CastingModel {
    /// Fills in defaults and resolves paths against the study's directory. `at`: place of the table in the study.
    pub(crate) fn read(entry: &CastingStructureEntry, typed: &Typed, at: &[&str]) -> Result<Self, Vec<Problem>> {
        let CastingStructureEntry { stiffness_file, mass_file, dof_file, nodes_file, format, units, .. } =
            entry.clone();
        let matrices = StructureEntry {
            source: Some(SourceName::Matrices),
            stiffness_file: Some(stiffness_file),
            mass_file: Some(mass_file),
            dof_file,
            nodes_file,
            format,
            units,
            dofs_per_node: entry.dofs_per_node,
            stiffness_name: entry.stiffness_name.clone(),
            mass_name: entry.mass_name.clone(),
            ..StructureEntry::default()
        };
        let table = MachineTable { entry: &matrices, typed, at };
        let mut reader = Reader { table, problems: Vec::new() };
        reader.require_files();
        let files = ModelFiles { points: PathBuf::new(), ..reader.matrices().files };
        let numbers = entry.over(CastingStructure::default());
        reader.check_numbers(&numbers, &numbers.damping_ratio);
        let CastingStructure { cutoff_hz, damping_ratio: damping, point_radius_m, .. } = numbers;
        let settings = ElasticSettings { cutoff_hz, damping, point_radius_m };
        if reader.problems.is_empty() { Ok(Self { files, settings }) } else { Err(reader.problems) }
    }

    /// Every file that it reads, with its key in the study.
    pub fn listed(&self) -> Vec<(&'static str, &Path)> {
        files_of(&self.files)
    }
}

/// The machine and its reduction.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureSettings {
    /// Source of the machine.
    pub source: StructureSource,
    /// Modes of the coupled machine are kept up to this frequency in Hz.
    pub cutoff_hz: f64,
    /// Selects modes for this error of a scene's receptances, instead of all modes up to the cut-off.
    pub mode_tolerance: Option<f64>,
    /// Edge of the band for which that error holds, in Hz.
    pub mode_band_hz: f64,
    /// Fixed-interface modes of the Craig-Bampton basis are kept up to this frequency in Hz.
    pub fixed_interface_cutoff_hz: f64,
    /// Modal damping.
    pub damping_ratio: Damping,
    /// Whether housings are added.
    pub housings: Housings,
    /// Rails on which hammers can stand.
    pub rails: Vec<Rail>,
}

/// Reads a file that has only the table `[structure]`; `None` for a study, recognised by its hammers or castings.
///
/// # Errors
/// [`StudyError::Read`] if the file cannot be read, [`StudyError::Invalid`] with all faults found.
pub fn load_structure(path: &Path) -> Result<Option<StructureSettings>, StudyError> {
    let text = decore_files::read_text(path, Limit::TOML)
        .map_err(|source| StudyError::Read { path: path.to_path_buf(), source })?;
    let name = path.display().to_string();
    let document = Document::parse(&name, &text).map_err(|problems| StudyError::Invalid { problems })?;
    let root = document.root.table();
    if !root.contains_key("structure") || root.contains_key("hammer") || root.contains_key("casting") {
        return Ok(None);
    }
    let shape = Shape::from_schema(&schemars::schema_for!(StructureFile).to_value());
    let tree = check_keys(&document, &shape, &[])?;
    let file: StructureFile = read_tree(toml::Value::Table(tree)).map_err(|(key, message)| {
        let at = crate::document::path::split(&key).unwrap_or_default();
        StudyError::one(Problem::new(document.locate(&at), key, message))
    })?;
    let directory = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let (machine, file) = (file.structure, Some(path.to_path_buf()));
    let (hammers, overrides) = (BTreeMap::new(), Vec::new());
    let typed = Typed { document, file, directory, row_directory: None, hammers, overrides };
    let table = MachineTable { entry: &machine, typed: &typed, at: &["structure"] };
    StructureSettings::read(table, Fidelity::default()).map(Some).map_err(StudyError::several)
}

impl StructureSettings {
    /// Fills in defaults and resolves paths against the study's directory.
    ///
    /// `fidelity`: the preset that selects modes where the table is silent.
    pub(crate) fn read(table: MachineTable<'_>, fidelity: Fidelity) -> Result<Self, Vec<Problem>> {
        let entry = table.entry;
        let mut reader = Reader { table, problems: Vec::new() };
        let source = reader.source();
        let preset = Preset::of(fidelity);
        let mut base = StructureParameters { mode_tolerance: preset.mode_tolerance, ..StructureParameters::default() };
        if reader.selects_modes() && source == StructureSource::Station {
            base.fixed_interface_cutoff_hz = preset.station_basis_hz;
        }
        let mut numbers = entry.over(base);
        if let Some(listed) = reader.listed_damping() {
            numbers.damping_ratio = listed;
        }
        reader.check_numbers(&numbers, &numbers.damping_ratio);
        let settings = Self {
            source,
            cutoff_hz: numbers.cutoff_hz,
            mode_tolerance: reader.selects_modes().then_some(numbers.mode_tolerance),
            mode_band_hz: numbers.mode_band_hz,
            fixed_interface_cutoff_hz: numbers.fixed_interface_cutoff_hz,
            damping_ratio: numbers.damping_ratio,
            housings: entry.housings.unwrap_or_default(),
            rails: reader.rails(),
        };
        if reader.problems.is_empty() { Ok(settings) } else { Err(reader.problems) }
    }
}

/// The table of a machine as typed.
#[derive(Clone, Copy)]
pub(crate) struct MachineTable<'a> {
    pub entry: &'a StructureEntry,
    pub typed: &'a Typed,
    /// Table of the machine in the study.
    pub at: &'a [&'a str],
}

struct Reader<'a> {
    table: MachineTable<'a>,
    problems: Vec<Problem>,
}

impl Reader<'_> {
    fn problem(&mut self, keys: &[&str], message: impl Into<String>) {
        let at: Vec<String> = self.table.at.iter().chain(keys).copied().map(str::to_string).collect();
        let problem = Problem::new(self.table.typed.locate(&at), crate::document::path::join(&at), message);
        self.problems.push(problem);
    }

    /// Whether a tolerance selects the modes: a given one, or the preset's, unless the study selects them with a cut-off or a list of
    /// damping ratios, one per mode.
    fn selects_modes(&self) -> bool {
        let entry = self.table.entry;
        let listed = entry.damping_ratio_file.is_some() || matches!(entry.damping_ratio, Some(Damping::PerMode(_)));
        self.table.entry.mode_tolerance.is_some() || (self.table.entry.cutoff_hz.is_none() && !listed)
    }

    /// Damping ratios of the file that lists them.
    fn listed_damping(&mut self) -> Option<Damping> {
        let entry = self.table.entry;
        let path = entry.damping_ratio_file.as_ref().map(|file| self.table.typed.directory.join(file))?;
        if entry.damping_ratio.is_some() {
            self.problem(&["damping_ratio_file"], "cannot be combined with `damping_ratio`: give one of the two");
            return None;
        }
        match read_damping_ratios(&path) {
            Ok(ratios) => Some(Damping::PerMode(ratios)),
            Err(error) => {
                self.problem(&["damping_ratio_file"], error.to_string());
                None
            }
        }
    }

    fn check_numbers(&mut self, numbers: &impl Parameters, damping: &Damping) {
        let mut faults = Vec::new();
        numbers.check("", &mut faults);
        for Fault { path, message } in faults {
            self.problem(&[path.as_str()], message);
        }
        if let Some(fault) = damping.fault() {
            self.problem(&["damping_ratio"], fault);
        }
    }

    /// Reports files that are named and do not exist.
    fn require_files(&mut self) {
        for (key, file) in files(self.table.entry) {
            if let Some(path) = file.map(|file| self.table.typed.directory.join(file)).filter(|path| !path.is_file()) {
                self.problem(&[key], format!("there is no file {}", path.display()));
            }
        }
    }

    fn source(&mut self) -> StructureSource {
        let name = self.table.entry.source.unwrap_or_default();
        let (wanted, words): (&[&str], _) = match name {
            SourceName::Station => (&[], "station"),
            SourceName::Matrices => (&["stiffness_file", "mass_file", "points_file"], "matrices"),
            SourceName::ModalTable => (&["modal_file", "points_file"], "modal_table"),
        };
        let optional: &[&str] =
            if name == SourceName::Matrices { &["damping_file", "dof_file", "nodes_file"] } else { &[] };
        for (key, file) in files(self.table.entry).map(|(key, file)| (key, file.is_some())) {
            match (wanted.contains(&key), file) {
                (true, false) => self.problem(&[key], format!("missing key: `source = \"{words}\"` needs this file")),
                (false, true) if !optional.contains(&key) => {
                    self.problem(&[key], format!("does not belong to `source = \"{words}\"`"));
                }
                _ => {}
            }
        }
        self.require_files();
        if name != SourceName::Matrices {
            self.refuse_matrix_keys(words);
        }
        match name {
            SourceName::Station => StructureSource::Station,
            SourceName::Matrices => StructureSource::Matrices(Box::new(self.matrices())),
            SourceName::ModalTable => StructureSource::ModalTable {
                table: self.full(&self.table.entry.modal_file),
                points: self.full(&self.table.entry.points_file),
            },
        }
    }

    fn full(&self, file: &Option<String>) -> PathBuf {
        self.table.typed.directory.join(file.as_deref().unwrap_or_default())
    }

    fn refuse_matrix_keys(&mut self, words: &str) {
        let entry = self.table.entry;
        let given = [
            ("format", entry.format.is_some()),
            ("units", entry.units.is_some()),
            ("dofs_per_node", entry.dofs_per_node.is_some()),
            ("stiffness_name", entry.stiffness_name.is_some()),
            ("mass_name", entry.mass_name.is_some()),
            ("damping_name", entry.damping_name.is_some()),
            ("cache", entry.cache.is_some()),
        ];
        for (key, _) in given.into_iter().filter(|(_, given)| *given) {
            self.problem(&[key], format!("does not belong to `source = \"{words}\"`"));
        }
    }

    fn matrices(&mut self) -> MatrixSource {
        let entry = self.table.entry;
        let stiffness = entry.stiffness_file.as_deref().unwrap_or_default();
        let shown =
            || MatrixFormat::of_file(stiffness).or_else(|| MatrixFormat::of_content(&self.full(&entry.stiffness_file)));
        let format = entry.format.or_else(shown).unwrap_or_else(|| {
            if !stiffness.is_empty() {
                let way_out = MatrixFormat::way_out(stiffness).map_or(String::new(), |way| format!("; {way}"));
                let message = format!(
                    "missing key: neither the end nor the first lines of `{stiffness}` tell the format of the matrices: expected {}{way_out}",
                    MatrixFormat::names()
                );
                self.problem(&["format"], message);
            }
            MatrixFormat::MatrixMarket
        });
        if entry.dofs_per_node.is_some_and(|dofs| dofs != 3 && dofs != 6) {
            self.problem(&["dofs_per_node"], "expected 3 (displacements) or 6 (and rotations)");
        }
        let matrix = |file: &Option<String>, name: &Option<String>, default: &str| MatrixFile {
            path: self.full(file),
            name: name.clone().unwrap_or_else(|| default.to_owned()),
        };
        let files = ModelFiles {
            format,
            units: entry.units.unwrap_or_default(),
            stiffness: matrix(&entry.stiffness_file, &entry.stiffness_name, "KAAX"),
            mass: matrix(&entry.mass_file, &entry.mass_name, "MAAX"),
            damping: (entry.damping_file.is_some()).then(|| matrix(&entry.damping_file, &entry.damping_name, "BAAX")),
            dofs: entry.dof_file.is_some().then(|| self.full(&entry.dof_file)),
            nodes: entry.nodes_file.is_some().then(|| self.full(&entry.nodes_file)),
            dofs_per_node: entry.dofs_per_node.map(|dofs| dofs as usize),
            points: self.full(&entry.points_file),
        };
        MatrixSource { files, cache: entry.cache.unwrap_or(true) }
    }

    fn rails(&mut self) -> Vec<Rail> {
        if self.table.at.first() != Some(&"structure") {
            if !self.table.entry.rails.is_empty() {
                self.problem(&["rails"], "rails belong to the table [structure]: all machines of a study share them");
            }
            return Vec::new();
        }
        let mut rails: Vec<Rail> = self
            .table
            .entry
            .rails
            .iter()
            .map(|(name, points)| Rail { name: name.clone(), points: points.clone() })
            .collect();
        let short: Vec<String> =
            rails.iter().filter(|rail| rail.points.len() < 2).map(|rail| rail.name.clone()).collect();
        for name in short {
            self.problem(&["rails", &name], "a rail needs at least two interface points");
        }
        let (name, points) = STATION_RAIL;
        let station = self.table.entry.source.unwrap_or_default() == SourceName::Station;
        if station && rails.iter().all(|rail| rail.name != name) {
            rails.insert(0, Rail { name: name.to_string(), points: points.map(str::to_string).to_vec() });
        }
        rails
    }
}

/// The files that a table names, by key.
fn files(entry: &StructureEntry) -> [(&'static str, Option<&String>); 7] {
    [
        ("stiffness_file", entry.stiffness_file.as_ref()),
        ("mass_file", entry.mass_file.as_ref()),
        ("damping_file", entry.damping_file.as_ref()),
        ("dof_file", entry.dof_file.as_ref()),
        ("nodes_file", entry.nodes_file.as_ref()),
        ("modal_file", entry.modal_file.as_ref()),
        ("points_file", entry.points_file.as_ref()),
    ]
}
