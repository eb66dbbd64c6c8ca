//! Settings of the machine and its reduction, defaults filled in and paths resolved.

use std::path::{Path, PathBuf};

use super::document::Document;
use super::error::Problem;
use super::file::{DampingRatio, Housings, SourceName, StructureEntry};
use super::placement::Rail;

/// Modes of the coupled machine are kept up to this frequency in Hz.
const CUTOFF_HZ: f64 = 1000.0;
/// Fixed-interface modes are kept up to this frequency in Hz.
const FIXED_INTERFACE_CUTOFF_HZ: f64 = 3000.0;
/// Modal damping ratio.
const DAMPING_RATIO: f64 = 0.02;
/// The rail of the built-in station.
const STATION_RAIL: (&str, [&str; 9]) = ("rail", ["R1", "R2", "R3", "R4", "R5", "R6", "R7", "R8", "R9"]);

/// Where the machine comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StructureSource {
    /// The built-in station.
    Station,
    /// Finite element matrices.
    Matrices {
        /// Stiffness matrix, Matrix Market.
        stiffness: PathBuf,
        /// Mass matrix without housings, Matrix Market.
        mass: PathBuf,
        /// Table of interface points.
        points: PathBuf,
    },
    /// Modal table.
    ModalTable {
        /// Frequencies, damping and rows per interface point.
        table: PathBuf,
        /// Table of interface points.
        points: PathBuf,
    },
}

/// The machine and its reduction.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureSettings {
    /// Where it comes from.
    pub source: StructureSource,
    /// Modes of the coupled machine are kept up to this frequency in Hz.
    pub cutoff_hz: f64,
    /// Fixed-interface modes of the Craig-Bampton basis are kept up to this frequency in Hz.
    pub fixed_interface_cutoff_hz: f64,
    /// Modal damping.
    pub damping_ratio: DampingRatio,
    /// Whether housings are added.
    pub housings: Housings,
    /// Rails on which hammers can stand.
    pub rails: Vec<Rail>,
}

impl StructureSettings {
    /// Fills in defaults and resolves paths against the study's directory.
    pub(super) fn read(entry: &StructureEntry, document: &Document, directory: &Path) -> Result<Self, Vec<Problem>> {
        let mut reader = Reader { entry, document, directory, problems: Vec::new() };
        let source = reader.source();
        let settings = Self {
            source,
            cutoff_hz: reader.frequency("cutoff_hz", entry.cutoff_hz, CUTOFF_HZ),
            fixed_interface_cutoff_hz: reader.frequency(
                "fixed_interface_cutoff_hz",
                entry.fixed_interface_cutoff_hz,
                FIXED_INTERFACE_CUTOFF_HZ,
            ),
            damping_ratio: reader.damping(),
            housings: entry.housings.unwrap_or_default(),
            rails: reader.rails(),
        };
        if reader.problems.is_empty() { Ok(settings) } else { Err(reader.problems) }
    }
}

struct Reader<'a> {
    entry: &'a StructureEntry,
    document: &'a Document,
    directory: &'a Path,
    problems: Vec<Problem>,
}

impl Reader<'_> {
    fn problem(&mut self, keys: &[&str], message: impl Into<String>) {
        let at: Vec<String> = std::iter::once("structure").chain(keys.iter().copied()).map(str::to_string).collect();
        let problem = Problem::new(self.document.locate(&at), super::path::join(&at), message);
        self.problems.push(problem);
    }

    fn source(&mut self) -> StructureSource {
        let name = self.entry.source.unwrap_or_default();
        let (wanted, words): (&[&str], _) = match name {
            SourceName::Station => (&[], "station"),
            SourceName::Matrices => (&["stiffness_file", "mass_file", "points_file"], "matrices"),
            SourceName::ModalTable => (&["modal_file", "points_file"], "modal_table"),
        };
        let given = [
            ("stiffness_file", &self.entry.stiffness_file),
            ("mass_file", &self.entry.mass_file),
            ("modal_file", &self.entry.modal_file),
            ("points_file", &self.entry.points_file),
        ];
        for (key, file) in given {
            match (wanted.contains(&key), file) {
                (true, None) => self.problem(&[key], format!("missing key: `source = \"{words}\"` needs this file")),
                (false, Some(_)) => self.problem(&[key], format!("does not belong to `source = \"{words}\"`")),
                (true, Some(file)) if !self.directory.join(file).is_file() => {
                    self.problem(&[key], format!("there is no file {}", self.directory.join(file).display()));
                }
                _ => {}
            }
        }
        let full = |file: &Option<String>| self.directory.join(file.as_deref().unwrap_or_default());
        match name {
            SourceName::Station => StructureSource::Station,
            SourceName::Matrices => StructureSource::Matrices {
                stiffness: full(&self.entry.stiffness_file),
                mass: full(&self.entry.mass_file),
                points: full(&self.entry.points_file),
            },
            SourceName::ModalTable => StructureSource::ModalTable {
                table: full(&self.entry.modal_file),
                points: full(&self.entry.points_file),
            },
        }
    }

    fn frequency(&mut self, key: &str, given: Option<f64>, default: f64) -> f64 {
        let value = given.unwrap_or(default);
        if value <= 0.0 {
            self.problem(&[key], format!("is {value}, expected a positive number"));
        }
        value
    }

    fn damping(&mut self) -> DampingRatio {
        let ratio = self.entry.damping_ratio.clone().unwrap_or(DampingRatio::Uniform(DAMPING_RATIO));
        let sound = |ratio: &f64| (0.0..1.0).contains(ratio);
        let bad = match &ratio {
            DampingRatio::Uniform(one) => (!sound(one)).then_some(*one),
            DampingRatio::PerMode(list) => list.iter().copied().find(|one| !sound(one)),
        };
        if let Some(bad) = bad {
            self.problem(&["damping_ratio"], format!("is {bad}, expected 0 or more and below 1"));
        }
        if matches!(&ratio, DampingRatio::PerMode(list) if list.is_empty()) {
            self.problem(&["damping_ratio"], "is an empty list, expected one ratio per mode");
        }
        ratio
    }

    fn rails(&mut self) -> Vec<Rail> {
        let mut rails: Vec<Rail> =
            self.entry.rails.iter().map(|(name, points)| Rail { name: name.clone(), points: points.clone() }).collect();
        let short: Vec<String> =
            rails.iter().filter(|rail| rail.points.len() < 2).map(|rail| rail.name.clone()).collect();
        for name in short {
            self.problem(&["rails", &name], "a rail needs at least two interface points");
        }
        let (name, points) = STATION_RAIL;
        let station = self.entry.source.unwrap_or_default() == SourceName::Station;
        if station && rails.iter().all(|rail| rail.name != name) {
            rails.insert(0, Rail { name: name.to_string(), points: points.map(str::to_string).to_vec() });
        }
        rails
    }
}
