//! The design section: factors bound to paths, values drawn by the design.

use toml::Value;

use super::document::Document;
use super::error::{Problem, nearest_name};
use super::file::{DesignEntry, DesignKind, FactorEntry, FactorValue, Scale};
use super::keys::{Shape, shape_at};
use super::path;
use crate::design::{Design, DesignError, Distribution, Factor, Kind, Level, Placement};

/// Top-level tables and keys that rows may change; the rest is shared by all rows.
const DRIVABLE: [&str; 6] = ["hammer", "casting", "solver", "outputs", "environment", "duration_s"];

/// Type of a factor's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FactorKind {
    /// Real numbers.
    Real,
    /// Whole numbers.
    Integer,
    /// Texts.
    Text,
}

/// One factor of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorInfo {
    /// Name as in the study.
    pub name: String,
    /// Type of its values, hence of its column.
    pub kind: FactorKind,
    /// Paths that it drives.
    pub paths: Vec<String>,
    /// Its unit, if the study names one.
    pub unit: Option<String>,
    /// What it varies over; categories stand for `values`.
    pub distribution: Distribution,
    /// The values that it chooses from; empty for a range.
    pub values: Vec<FactorValue>,
}

impl FactorInfo {
    /// What it varies over, in words: a range or its values.
    pub fn domain(&self) -> String {
        match &self.distribution {
            Distribution::Uniform { low, high } => format!("{low} to {high}"),
            Distribution::LogUniform { low, high } => format!("{low} to {high} (logarithmic)"),
            Distribution::Integer { low, high } => format!("{low} to {high} (whole numbers)"),
            Distribution::Categories { .. } => {
                self.values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" | ")
            }
        }
    }

    /// The value of a level.
    pub(super) fn value(&self, level: Level) -> FactorValue {
        match level {
            Level::Real(value) => FactorValue::Real(value),
            Level::Integer(value) => FactorValue::Integer(value),
            Level::Category(index) => match (self.values.get(index), self.kind) {
                (Some(FactorValue::Integer(value)), FactorKind::Real) => FactorValue::Real(*value as f64),
                (Some(value), _) => value.clone(),
                (None, _) => FactorValue::Text(String::new()),
            },
        }
    }

    /// The values at the ends of its range, or all its categories: what has to be sound for every row to be.
    pub(super) fn extremes(&self) -> Vec<FactorValue> {
        match self.distribution {
            Distribution::Uniform { low, high } | Distribution::LogUniform { low, high } => {
                vec![FactorValue::Real(low), FactorValue::Real(high)]
            }
            Distribution::Integer { low, high } => {
                vec![FactorValue::Integer(low), FactorValue::Integer(high)]
            }
            Distribution::Categories { count } => (0..count).map(|index| self.value(Level::Category(index))).collect(),
        }
    }
}

/// A factor's value as TOML.
pub(super) fn to_toml(value: &FactorValue) -> Value {
    match value {
        FactorValue::Integer(number) => Value::Integer(*number),
        FactorValue::Real(number) => Value::Float(*number),
        FactorValue::Text(text) => Value::String(text.clone()),
    }
}

/// The design of a study with its factors.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub design: Design,
    pub factors: Vec<FactorInfo>,
    /// Paths that each factor drives, split.
    pub paths: Vec<Vec<Vec<String>>>,
}

impl Plan {
    /// Where the tree has no value at a path that a factor drives, puts the first row's there.
    pub fn fill_gaps(&self, tree: &mut toml::Table) -> Result<(), (String, String)> {
        let first = self.design.row(0).unwrap_or_default();
        for ((factor, level), paths) in self.factors.iter().zip(first).zip(&self.paths) {
            for at in paths {
                if path::get(tree, at).is_none() {
                    let value = to_toml(&factor.value(level));
                    path::set(tree, at, value).map_err(|message| (path::join(at), message))?;
                }
            }
        }
        Ok(())
    }

    /// Reads the design section. `tree` is the study's tree of values, for the names in it.
    pub fn read(
        entry: &DesignEntry,
        document: &Document,
        shape: &Shape,
        tree: &toml::Table,
    ) -> Result<Self, Vec<Problem>> {
        let mut reader = Reader { document, shape, tree, problems: Vec::new() };
        let mut factors = Vec::new();
        let mut paths: Vec<Vec<Vec<String>>> = Vec::new();
        let mut design_factors = Vec::new();
        for (name, factor) in &entry.factor {
            let values = reader.values(name, factor);
            let driven = reader.paths(name, factor, &values, &paths);
            let distribution = reader.distribution(name, factor, &values);
            design_factors.push(Factor { distribution, levels: factor.levels.map(clamp_count) });
            factors.push(FactorInfo {
                name: name.clone(),
                kind: kind_of(distribution, &values),
                paths: driven.iter().map(|driven| path::join(driven)).collect(),
                unit: factor.unit.clone(),
                distribution,
                values,
            });
            paths.push(driven);
        }
        let kind = reader.kind(entry);
        if !reader.problems.is_empty() {
            return Err(reader.problems);
        }
        match Design::new(kind, design_factors, entry.seed.unwrap_or(0)) {
            Ok(design) => Ok(Self { design, factors, paths }),
            Err(error) => Err(vec![reader.design_problem(&error, &factors)]),
        }
    }
}

fn clamp_count(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

fn kind_of(distribution: Distribution, values: &[FactorValue]) -> FactorKind {
    match distribution {
        Distribution::Integer { .. } => FactorKind::Integer,
        Distribution::Uniform { .. } | Distribution::LogUniform { .. } => FactorKind::Real,
        Distribution::Categories { .. } => {
            if values.iter().any(|value| matches!(value, FactorValue::Text(_))) {
                FactorKind::Text
            } else if values.iter().all(|value| matches!(value, FactorValue::Integer(_))) {
                FactorKind::Integer
            } else {
                FactorKind::Real
            }
        }
    }
}

struct Reader<'a> {
    document: &'a Document,
    shape: &'a Shape,
    tree: &'a toml::Table,
    problems: Vec<Problem>,
}

impl Reader<'_> {
    fn at(&self, name: &str, keys: &[&str]) -> Vec<String> {
        ["design", "factor", name].into_iter().chain(keys.iter().copied()).map(str::to_string).collect()
    }

    fn problem(&mut self, at: &[String], message: impl Into<String>) -> &mut Problem {
        let problem = Problem::new(self.document.locate(at), path::join(at), message);
        let index = self.problems.len();
        self.problems.push(problem);
        // The entry that was just pushed.
        &mut self.problems[index]
    }

    fn kind(&mut self, entry: &DesignEntry) -> Kind {
        let at = |key: &str| ["design".to_string(), key.to_string()];
        let placement = if entry.centred == Some(true) { Placement::Centred } else { Placement::Random };
        let kind = entry.kind.unwrap_or_default();
        if kind != DesignKind::LatinHypercube {
            for (key, given) in [("rows", entry.rows.is_some()), ("centred", entry.centred.is_some())] {
                if given {
                    self.problem(&at(key), "belongs to `kind = \"latin_hypercube\"` only");
                }
            }
        }
        match (kind, entry.rows) {
            (DesignKind::None, _) => Kind::Single,
            (DesignKind::FullFactorial, _) => Kind::FullFactorial,
            (DesignKind::LatinHypercube, Some(rows)) => Kind::LatinHypercube { rows: clamp_count(rows), placement },
            (DesignKind::LatinHypercube, None) => {
                self.problem(&at("rows"), "missing key").expected =
                    Some("the number of rows of the Latin hypercube".into());
                Kind::LatinHypercube { rows: 1, placement }
            }
        }
    }

    fn values(&mut self, name: &str, factor: &FactorEntry) -> Vec<FactorValue> {
        let values = factor.values.clone().unwrap_or_default();
        for (index, value) in values.iter().enumerate() {
            if values.iter().take(index).any(|other| same(other, value)) {
                let at = self.at(name, &["values", &index.to_string()]);
                self.problem(&at, format!("the value {value} is given twice"));
            }
        }
        let texts = values.iter().filter(|value| matches!(value, FactorValue::Text(_))).count();
        if texts > 0 && texts < values.len() {
            let at = self.at(name, &["values"]);
            self.problem(&at, "mixes texts and numbers");
        }
        values
    }

    fn paths(
        &mut self,
        name: &str,
        factor: &FactorEntry,
        values: &[FactorValue],
        taken: &[Vec<Vec<String>>],
    ) -> Vec<Vec<String>> {
        let texts: Vec<(Vec<String>, &String)> = match (&factor.path, &factor.paths) {
            (Some(path), None) => vec![(self.at(name, &["path"]), path)],
            (None, Some(paths)) if !paths.is_empty() => {
                let at = |index: usize| self.at(name, &["paths", &index.to_string()]);
                paths.iter().enumerate().map(|(index, path)| (at(index), path)).collect()
            }
            _ => {
                let at = self.at(name, &[]);
                let expected = "either `path` or `paths`, the parameters that the factor drives";
                self.problem(&at, "says not (or twice) what it drives").expected = Some(expected.into());
                return Vec::new();
            }
        };
        let mut driven: Vec<Vec<String>> = Vec::new();
        for (at, text) in texts {
            let Some(segments) = self.drivable(&at, text) else {
                continue;
            };
            if driven.contains(&segments) || taken.iter().flatten().any(|other| overlap(other, &segments)) {
                self.problem(&at, format!("`{text}` is driven twice"));
            }
            self.fits(name, factor, values, &segments);
            driven.push(segments);
        }
        driven
    }

    /// The path as segments, if rows may change it.
    fn drivable(&mut self, at: &[String], text: &str) -> Option<Vec<String>> {
        let segments = match path::split(text) {
            Ok(segments) => segments,
            Err(message) => {
                self.problem(at, message);
                return None;
            }
        };
        let shape = match shape_at(self.shape, self.tree, &segments) {
            Ok(shape) => shape,
            Err(unknown) => {
                let problem = self.problem(at, unknown.message);
                problem.expected = Some("the path of a parameter, e.g. hammer.left.supply_bar".into());
                problem.nearest = unknown.nearest;
                return None;
            }
        };
        if matches!(shape, Shape::Table { .. } | Shape::Map(_) | Shape::Array { .. }) {
            let problem = self.problem(at, format!("`{text}` is {}, no single value", shape.words()));
            problem.expected = Some("the path of a single number or text (an entry of a list: `.0`, `.1`)".into());
            return None;
        }
        if !segments.first().is_some_and(|first| DRIVABLE.contains(&first.as_str())) {
            let problem = self.problem(at, format!("`{text}` is shared by all rows, so no factor can drive it"));
            problem.expected = Some(format!("a path that starts with one of {}", DRIVABLE.join(", ")));
            return None;
        }
        Some(segments)
    }

    /// Holds the factor's values to the type of a parameter that it drives.
    fn fits(&mut self, name: &str, factor: &FactorEntry, values: &[FactorValue], segments: &[String]) {
        let Ok(shape) = shape_at(self.shape, self.tree, segments) else {
            return;
        };
        let driven = path::join(segments);
        for (index, value) in values.iter().enumerate() {
            if let Err(message) = shape.accepts(&to_toml(value)) {
                let at = self.at(name, &["values", &index.to_string()]);
                let nearest = match (shape, value) {
                    (Shape::Choice(choices), FactorValue::Text(text)) => {
                        nearest_name(text, choices.iter().map(String::as_str))
                    }
                    _ => None,
                };
                let problem = self.problem(&at, format!("{message}, but drives `{driven}`"));
                problem.expected = Some(shape.words());
                problem.nearest = nearest;
            }
        }
        let Some([low, _]) = factor.range else { return };
        let probe = if factor.integer == Some(true) { Value::Integer(low as i64) } else { Value::Float(low) };
        if low.is_finite()
            && let Err(message) = shape.accepts(&probe)
        {
            let at = self.at(name, &["range"]);
            let problem = self.problem(&at, format!("a value of this range {message}, but drives `{driven}`"));
            problem.expected = Some(shape.words());
        }
    }

    fn distribution(&mut self, name: &str, factor: &FactorEntry, values: &[FactorValue]) -> Distribution {
        let fallback = Distribution::Categories { count: values.len().max(1) };
        let (Some([low, high]), None) = (factor.range, &factor.values) else {
            if factor.values.is_none() || factor.range.is_some() {
                let at = self.at(name, &[]);
                let expected = "either `range = [low, high]` or `values = [...]`";
                self.problem(&at, "says not (or twice) what it varies over").expected = Some(expected.into());
                return fallback;
            }
            for (key, given) in [
                ("scale", factor.scale.is_some()),
                ("integer", factor.integer.is_some()),
                ("levels", factor.levels.is_some()),
            ] {
                if given {
                    let at = self.at(name, &[key]);
                    self.problem(&at, "belongs to a `range`, not to `values`");
                }
            }
            return Distribution::Categories { count: values.len() };
        };
        match (factor.integer == Some(true), factor.scale.unwrap_or_default()) {
            (false, Scale::Linear) => Distribution::Uniform { low, high },
            (false, Scale::Log) => Distribution::LogUniform { low, high },
            (true, Scale::Log) => {
                let at = self.at(name, &["scale"]);
                self.problem(&at, "a range of integers has no logarithmic scale").expected =
                    Some("`values = [...]` for integers that are not evenly spaced".into());
                fallback
            }
            (true, Scale::Linear) => {
                // Beyond 2^53 a float no longer tells neighbouring integers apart.
                let whole = |end: f64| end.fract() == 0.0 && end.abs() <= 9_007_199_254_740_992.0;
                if !(whole(low) && whole(high)) {
                    let at = self.at(name, &["range"]);
                    self.problem(&at, "the ends of a range of integers must be whole numbers");
                    return fallback;
                }
                Distribution::Integer { low: low as i64, high: high as i64 }
            }
        }
    }

    fn design_problem(&self, error: &DesignError, factors: &[FactorInfo]) -> Problem {
        let name = error.factor().and_then(|index| factors.get(index)).map(|factor| factor.name.as_str());
        let key = match error {
            DesignError::NoCategories { .. } => "values",
            DesignError::Levels { .. } | DesignError::LevelsNeeded { .. } => "levels",
            DesignError::NoRows => "rows",
            DesignError::Factors(_) | DesignError::TooManyRows => "kind",
            DesignError::NotFinite { .. } | DesignError::EmptyRange { .. } | DesignError::NotPositive { .. } => "range",
        };
        let at = match name {
            Some(name) => self.at(name, &[key]),
            None => vec!["design".to_string(), key.to_string()],
        };
        Problem::new(self.document.locate(&at), path::join(&at), error.to_string())
    }
}

fn same(a: &FactorValue, b: &FactorValue) -> bool {
    match (a, b) {
        (FactorValue::Integer(a), FactorValue::Real(b)) | (FactorValue::Real(b), FactorValue::Integer(a)) => {
            *a as f64 == *b
        }
        _ => a == b,
    }
}

/// Whether one path is the other or leads to it.
fn overlap(a: &[String], b: &[String]) -> bool {
    a.iter().zip(b).all(|(a, b)| a == b)
}
