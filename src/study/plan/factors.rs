//! The design section: factors bound to paths, values drawn by the design.

use std::path::Path;

use super::kinds;
use crate::design::{Design, DesignError, Distribution, Factor, Level};
use crate::expression::{self, Expression, Scope};
use crate::quantity::{Kind, Value};
use crate::study::document::error::Problem;
use crate::study::document::keys::{Shape, shape_at};
use crate::study::document::path;
use crate::study::document::tree::Document;
use crate::study::file::{DesignEntry, DistributionName, FactorEntry, LinkEntry, Scale};
use crate::words::nearest;

/// Top-level tables and keys that rows may change; the rest is shared by all rows.
const DRIVABLE: [&str; 7] = ["machine", "hammer", "casting", "solver", "outputs", "environment", "duration_s"];

/// The key among them that all rows share: it decides which columns there are.
const TWINS_PATH: [&str; 2] = ["outputs", "twins"];

/// One factor of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorInfo {
    /// Name as in the study.
    pub name: String,
    /// Type of its values, hence of its column.
    pub kind: Kind,
    /// Paths that it drives.
    pub paths: Vec<String>,
    /// Its unit, if the study names one.
    pub unit: Option<String>,
    /// What it varies over; categories stand for `values`. `None` for a derived factor.
    pub distribution: Option<Distribution>,
    /// The values that it chooses from; empty for a range.
    pub values: Vec<Value>,
    /// The expression that gives a derived factor its value.
    pub expression: Option<String>,
}

impl FactorInfo {
    /// What it varies over, in words: a range, a distribution, its values or its expression.
    pub fn domain(&self) -> String {
        match &self.distribution {
            None => format!("= {}", self.expression.as_deref().unwrap_or_default()),
            Some(Distribution::Uniform { low, high }) => format!("{low} to {high}"),
            Some(Distribution::LogUniform { low, high }) => format!("{low} to {high} (logarithmic)"),
            Some(Distribution::Normal { mean, std_dev }) => format!("normal, {mean} +- {std_dev}"),
            Some(Distribution::TruncatedNormal { mean, std_dev, low, high }) => {
                format!("{low} to {high} (normal, {mean} +- {std_dev}, cut)")
            }
            Some(Distribution::Triangular { low, mode, high }) => format!("{low} to {high} (triangular about {mode})"),
            Some(Distribution::Beta { alpha, beta, low, high }) => format!("{low} to {high} (beta {alpha}, {beta})"),
            Some(Distribution::Empirical { sorted }) => {
                let end = |end: Option<&f64>| end.copied().unwrap_or_default();
                format!("{} to {} ({} observations)", end(sorted.first()), end(sorted.last()), sorted.len())
            }
            Some(Distribution::Integer { low, high }) => format!("{low} to {high} (whole numbers)"),
            Some(Distribution::LogInteger { low, high }) => format!("{low} to {high} (whole numbers, logarithmic)"),
            Some(Distribution::Categories { .. }) => {
                self.values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" | ")
            }
        }
    }

    /// The value of a level.
    pub(in crate::study) fn value(&self, level: Level) -> Value {
        match level {
            Level::Real(value) => Value::Real(value),
            Level::Integer(value) => Value::Integer(value),
            Level::Category(index) => match (self.values.get(index), self.kind) {
                (Some(Value::Integer(value)), Kind::Real) => Value::Real(*value as f64),
                (Some(value), _) => value.clone(),
                (None, _) => Value::Text(String::new()),
            },
        }
    }

    /// The levels at the ends of its range, or all its categories: what has to be sound for every row to be.
    pub(in crate::study) fn extremes(&self) -> Vec<Level> {
        match &self.distribution {
            None => Vec::new(),
            Some(Distribution::Integer { low, high } | Distribution::LogInteger { low, high }) => {
                vec![Level::Integer(*low), Level::Integer(*high)]
            }
            Some(Distribution::Categories { count }) => (0..*count).map(Level::Category).collect(),
            Some(real) => real.range().map_or(Vec::new(), |(low, high)| vec![Level::Real(low), Level::Real(high)]),
        }
    }
}

/// A factor's value as TOML.
pub(in crate::study) fn to_toml(value: &Value) -> toml::Value {
    match value {
        Value::Integer(number) => toml::Value::Integer(*number),
        Value::Real(number) => toml::Value::Float(*number),
        Value::Count(number) => toml::Value::Integer(number.cast_signed()),
        Value::Text(text) => toml::Value::String(text.clone()),
    }
}

/// The value of a parameter linked to a factor, as TOML.
fn linked(value: &Value, link: Link) -> toml::Value {
    match value.number() {
        Some(number) if link != Link::SAME => toml::Value::Float(link.factor * number + link.offset),
        _ => to_toml(value),
    }
}

/// How a parameter follows its factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::study) struct Link {
    pub factor: f64,
    pub offset: f64,
}

impl Link {
    /// The same value.
    pub const SAME: Self = Self { factor: 1.0, offset: 0.0 };
}

/// Where a factor's value comes from.
#[derive(Debug, Clone)]
pub(in crate::study) enum Source {
    /// The design's factor of this index.
    Drawn(usize),
    /// An expression of factors before it.
    Derived(Expression),
}

/// The design of a study with its factors.
#[derive(Debug, Clone)]
pub(in crate::study) struct Plan {
    pub design: Design,
    pub factors: Vec<FactorInfo>,
    pub sources: Vec<Source>,
    /// Paths that each factor drives, split.
    pub paths: Vec<Vec<Vec<String>>>,
    /// How each of these parameters follows.
    pub links: Vec<Vec<Link>>,
    /// Constraints with their texts.
    pub constraints: Vec<(String, Expression)>,
    /// Contents of the files that the design names, for the study's hash.
    pub files: Vec<(String, String)>,
}

/// Values of the factors so far, as names of an expression.
pub(in crate::study) struct Factors<'a> {
    pub names: &'a [FactorInfo],
    pub values: &'a [Value],
}

impl Factors<'_> {
    pub fn get(&self, name: &str) -> Option<expression::Value> {
        let pair = self.names.iter().zip(self.values).find(|(info, _)| info.name == name);
        let text = |value: &Value| expression::Value::Text(value.to_string());
        pair.map(|(_, value)| value.number().map_or_else(|| text(value), expression::Value::Number))
    }
}

impl Scope for Factors<'_> {
    fn value(&self, name: &str) -> Result<expression::Value, String> {
        self.get(name).ok_or_else(|| format!("there is no factor `{name}`"))
    }

    fn call(&self, function: &str, _: &[&str]) -> Result<f64, String> {
        Err(format!("there is no function `{function}`"))
    }
}

impl Plan {
    /// Where the tree has no value at a path that a factor drives, puts the first row's there.
    pub fn fill_gaps(&self, tree: &mut toml::Table) -> Result<(), (String, String)> {
        for (at, value) in self.driven(&self.row(0)) {
            if path::get(tree, at).is_none() {
                path::set(tree, at, value).map_err(|message| (path::join(at), message))?;
            }
        }
        Ok(())
    }

    /// All paths that factors drive.
    pub fn driven_paths(&self) -> impl Iterator<Item = &[String]> {
        self.paths.iter().flatten().map(Vec::as_slice)
    }

    /// The paths that factors drive, with what they have for these values of the factors.
    pub fn driven(&self, values: &[Value]) -> Vec<(&[String], toml::Value)> {
        let mut driven = Vec::new();
        for ((paths, links), value) in self.paths.iter().zip(&self.links).zip(values) {
            driven.extend(paths.iter().zip(links).map(|(at, link)| (at.as_slice(), linked(value, *link))));
        }
        driven
    }

    /// Reads the design section. `tree` is the study's tree of values, for the names in it; files lie in `directory`.
    pub fn read(
        entry: &DesignEntry,
        (document, directory): (&Document, &Path),
        shape: &Shape,
        tree: &toml::Table,
    ) -> Result<Self, Vec<Problem>> {
        let mut reader = Reader { document, shape, tree, problems: Vec::new() };
        let (mut factors, mut sources): (Vec<FactorInfo>, Vec<Source>) = (Vec::new(), Vec::new());
        let (mut paths, mut links): (Vec<Vec<Vec<String>>>, Vec<Vec<Link>>) = (Vec::new(), Vec::new());
        let mut drawn = Vec::new();
        for (name, typed) in &entry.factor {
            let factor = &reader.spanned(entry, (name, typed), directory);
            let values = reader.values(name, factor);
            let (driven, followed) = reader.paths(name, factor, &values, &paths);
            let source = match &factor.expression {
                Some(text) => Source::Derived(reader.derived(name, factor, (text, &factors))),
                None => {
                    let distribution = reader.distribution(name, factor, &values);
                    drawn.push(Factor { distribution, levels: factor.levels.map(clamp_count) });
                    Source::Drawn(drawn.len() - 1)
                }
            };
            let distribution = match &source {
                Source::Drawn(index) => drawn.get(*index).map(|factor| factor.distribution.clone()),
                Source::Derived(_) => None,
            };
            factors.push(FactorInfo {
                name: name.clone(),
                kind: distribution.as_ref().map_or(Kind::Real, |distribution| kind_of(distribution, &values)),
                paths: driven.iter().map(|driven| path::join(driven)).collect(),
                unit: factor.unit.clone(),
                distribution,
                values,
                expression: factor.expression.clone(),
            });
            sources.push(source);
            paths.push(driven);
            links.push(followed);
        }
        let constraints = reader.constraints(entry);
        let chosen = kinds::Drawn::new(&factors).kind(entry, directory);
        let mut problems = reader.problems;
        let (kind, files) = match chosen {
            Ok(chosen) if problems.is_empty() => chosen,
            Ok(_) => return Err(problems),
            Err(faults) => {
                let place =
                    |(at, message): (Vec<String>, String)| Problem::new(document.locate(&at), path::join(&at), message);
                problems.extend(faults.into_iter().map(place));
                return Err(problems);
            }
        };
        let seed = entry.seed.unwrap_or(0);
        let design = match &entry.correlation {
            None => Design::new(kind, drawn, seed),
            Some(correlation) => kinds::Drawn::new(&factors)
                .correlations(correlation)
                .and_then(|matrix| Design::with_correlation(kind, drawn, seed, &matrix)),
        };
        match design {
            Ok(design) => Ok(Self { design, factors, sources, paths, links, constraints, files }),
            Err(error) => Err(vec![design_problem(document, &error, &factors)]),
        }
    }

    /// Values of all factors, in the study's order, for the levels of the drawn ones.
    ///
    /// A derived factor whose expression has no value is not a number; the error says why.
    pub fn values(&self, levels: &[Level]) -> (Vec<Value>, Option<String>) {
        let mut values = Vec::with_capacity(self.factors.len());
        let mut fault = None;
        for (factor, source) in self.factors.iter().zip(&self.sources) {
            let value = match source {
                Source::Drawn(index) => factor.value(levels.get(*index).copied().unwrap_or(Level::Real(f64::NAN))),
                Source::Derived(expression) => {
                    let scope = Factors { names: &self.factors, values: &values };
                    let number = match expression.evaluate(&scope) {
                        Ok(expression::Value::Number(number)) => Ok(number),
                        Ok(other) => Err(format!("expected a number, found {other}")),
                        Err(message) => Err(message),
                    };
                    Value::Real(number.unwrap_or_else(|message| {
                        fault = Some(format!("factor `{}`: {message}", factor.name));
                        f64::NAN
                    }))
                }
            };
            values.push(value);
        }
        (values, fault)
    }

    /// Values of all factors in a row; empty past the last row.
    pub fn row(&self, row: usize) -> Vec<Value> {
        self.design.row(row).map_or(Vec::new(), |levels| self.values(&levels).0)
    }
}

fn clamp_count(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

fn kind_of(distribution: &Distribution, values: &[Value]) -> Kind {
    match distribution {
        Distribution::Integer { .. } | Distribution::LogInteger { .. } => Kind::Integer,
        Distribution::Categories { .. } => {
            if values.iter().any(|value| matches!(value, Value::Text(_))) {
                Kind::Text
            } else if values.iter().all(|value| matches!(value, Value::Integer(_))) {
                Kind::Integer
            } else {
                Kind::Real
            }
        }
        _ => Kind::Real,
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

    /// The factor with what a table's file tells of it.
    fn spanned(&mut self, entry: &DesignEntry, (name, typed): (&str, &FactorEntry), directory: &Path) -> FactorEntry {
        kinds::spanned(entry, (name, typed), directory).unwrap_or_else(|(at, message)| {
            self.problem(&at, message);
            typed.clone()
        })
    }

    fn constraints(&mut self, entry: &DesignEntry) -> Vec<(String, Expression)> {
        let mut constraints = Vec::new();
        for (index, text) in entry.constraints.iter().enumerate() {
            match Expression::parse(text) {
                Ok(expression) => constraints.push((text.clone(), expression)),
                Err(error) => {
                    let at = ["design", "constraints", &index.to_string()].map(str::to_string);
                    self.problem(&at, error.to_string()).expected =
                        Some("a comparison of factors, e.g. \"a + b <= 3\"".into());
                }
            }
        }
        constraints
    }

    /// Reads a derived factor's expression; `before` are the factors that it may use.
    fn derived(&mut self, name: &str, factor: &FactorEntry, (text, before): (&str, &[FactorInfo])) -> Expression {
        let at = self.at(name, &["expression"]);
        if factor.range.is_some() || factor.values.is_some() || factor.distribution.is_some() {
            self.problem(&at, "gives the factor's value, so it has no range, values or distribution");
        }
        match Expression::parse(text) {
            Ok(expression) => {
                let unknown = |used: &&str| before.iter().all(|info| info.name != *used);
                if let Some(used) = expression.names().into_iter().find(unknown) {
                    let problem = self.problem(&at, format!("there is no factor `{used}` before this one"));
                    problem.nearest = nearest(used, before.iter().map(|info| info.name.as_str()));
                } else if expression.calls_scope() {
                    self.problem(&at, "calls a function that is not known here");
                }
                expression
            }
            Err(error) => {
                self.problem(&at, error.to_string());
                Expression::constant(0.0)
            }
        }
    }

    fn values(&mut self, name: &str, factor: &FactorEntry) -> Vec<Value> {
        let values = factor.values.clone().unwrap_or_default();
        for (index, value) in values.iter().enumerate() {
            if values.iter().take(index).any(|other| same(other, value)) {
                let at = self.at(name, &["values", &index.to_string()]);
                self.problem(&at, format!("the value {value} is given twice"));
            }
        }
        let texts = values.iter().filter(|value| matches!(value, Value::Text(_))).count();
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
        values: &[Value],
        taken: &[Vec<Vec<String>>],
    ) -> (Vec<Vec<String>>, Vec<Link>) {
        let linked = factor
            .link
            .iter()
            .enumerate()
            .map(|(index, link)| (self.at(name, &["link", &index.to_string(), "path"]), &link.path, link_of(link)));
        let linked: Vec<(Vec<String>, &String, Link)> = linked.collect();
        let mut texts: Vec<(Vec<String>, &String, Link)> = match (&factor.path, &factor.paths) {
            (Some(path), None) => vec![(self.at(name, &["path"]), path, Link::SAME)],
            (None, Some(paths)) if !paths.is_empty() => {
                let at = |index: usize| self.at(name, &["paths", &index.to_string()]);
                paths.iter().enumerate().map(|(index, path)| (at(index), path, Link::SAME)).collect()
            }
            // A derived factor, or one that others or the constraints use, may drive nothing.
            (None, None) if !linked.is_empty() || factor.expression.is_some() => Vec::new(),
            _ => {
                let at = self.at(name, &[]);
                let expected = "either `path` or `paths`, the parameters that the factor drives";
                self.problem(&at, "says not (or twice) what it drives").expected = Some(expected.into());
                return Default::default();
            }
        };
        texts.extend(linked);
        let texts_only = values.iter().any(|value| matches!(value, Value::Text(_)));
        let (mut driven, mut links): (Vec<Vec<String>>, Vec<Link>) = Default::default();
        for (at, text, link) in texts {
            if texts_only && link != Link::SAME {
                self.problem(&at, "a text has no factor or offset");
            }
            let Some(segments) = self.drivable(&at, text) else {
                continue;
            };
            if driven.contains(&segments) || taken.iter().flatten().any(|other| overlap(other, &segments)) {
                self.problem(&at, format!("`{text}` is driven twice"));
            }
            self.fits(name, factor, values, &segments);
            driven.push(segments);
            links.push(link);
        }
        (driven, links)
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
        let shared = segments.iter().map(String::as_str).eq(TWINS_PATH);
        if shared || !segments.first().is_some_and(|first| DRIVABLE.contains(&first.as_str())) {
            let problem = self.problem(at, format!("`{text}` is shared by all rows, so no factor can drive it"));
            problem.expected = Some(format!("a path that starts with one of {}", DRIVABLE.join(", ")));
            return None;
        }
        Some(segments)
    }

    /// Holds the factor's values to the type of a parameter that it drives.
    fn fits(&mut self, name: &str, factor: &FactorEntry, values: &[Value], segments: &[String]) {
        let Ok(shape) = shape_at(self.shape, self.tree, segments) else {
            return;
        };
        let driven = path::join(segments);
        for (index, value) in values.iter().enumerate() {
            if let Err(message) = shape.accepts(&to_toml(value)) {
                let at = self.at(name, &["values", &index.to_string()]);
                let nearest = match (shape, value) {
                    (Shape::Choice(choices), Value::Text(text)) => nearest(text, choices.iter().map(String::as_str)),
                    _ => None,
                };
                let problem = self.problem(&at, format!("{message}, but drives `{driven}`"));
                problem.expected = Some(shape.words());
                problem.nearest = nearest;
            }
        }
        let Some([low, _]) = factor.range else { return };
        let probe =
            if factor.integer == Some(true) { toml::Value::Integer(low as i64) } else { toml::Value::Float(low) };
        if low.is_finite()
            && let Err(message) = shape.accepts(&probe)
        {
            let at = self.at(name, &["range"]);
            let problem = self.problem(&at, format!("a value of this range {message}, but drives `{driven}`"));
            problem.expected = Some(shape.words());
        }
    }

    fn distribution(&mut self, name: &str, factor: &FactorEntry, values: &[Value]) -> Distribution {
        let fallback = Distribution::Categories { count: values.len().max(1) };
        if let Some(distribution) = self.shaped(name, factor) {
            return distribution;
        }
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
            (true, scale) => {
                // Beyond 2^53 a float no longer tells neighbouring integers apart.
                let whole = |end: f64| end.fract() == 0.0 && end.abs() <= 9_007_199_254_740_992.0;
                if !(whole(low) && whole(high)) {
                    let at = self.at(name, &["range"]);
                    self.problem(&at, "the ends of a range of integers must be whole numbers");
                    return fallback;
                }
                let (low, high) = (low as i64, high as i64);
                match scale {
                    Scale::Linear => Distribution::Integer { low, high },
                    Scale::Log => Distribution::LogInteger { low, high },
                }
            }
        }
    }

    /// A distribution other than uniform; `None` for uniform ones and where it is at fault.
    fn shaped(&mut self, name: &str, factor: &FactorEntry) -> Option<Distribution> {
        let kind = factor.distribution.unwrap_or_default();
        let given = [
            ("mean", factor.mean, &[DistributionName::Normal]),
            ("std_dev", factor.std_dev, &[DistributionName::Normal]),
            ("mode", factor.mode, &[DistributionName::Triangular]),
            ("alpha", factor.alpha, &[DistributionName::Beta]),
            ("beta", factor.beta, &[DistributionName::Beta]),
        ];
        let mut sound = true;
        for (key, value, [owner]) in given {
            if (*owner == kind) != value.is_some() {
                let at = self.at(name, &[key]);
                let message = if *owner == kind { "missing key" } else { "does not belong to this distribution" };
                self.problem(&at, message).expected = (*owner == kind).then(|| "a number".into());
                sound = false;
            }
        }
        if (kind == DistributionName::Empirical) != factor.data.is_some() {
            let at = self.at(name, &["data"]);
            self.problem(&at, "belongs to `distribution = \"empirical\"`, which needs it").expected =
                Some("a list of observations".into());
            sound = false;
        }
        let plain = kind == DistributionName::Uniform;
        if !plain && (factor.scale.is_some() || factor.integer == Some(true) || factor.values.is_some()) {
            let at = self.at(name, &["distribution"]);
            self.problem(&at, "is for real numbers: it takes no `scale`, `integer` or `values`");
            sound = false;
        }
        if plain || !sound {
            return None;
        }
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let (mean, std_dev) = (number(factor.mean), number(factor.std_dev));
        match (kind, factor.range) {
            (DistributionName::Normal, None) => Some(Distribution::Normal { mean, std_dev }),
            (DistributionName::Normal, Some([low, high])) => {
                Some(Distribution::TruncatedNormal { mean, std_dev, low, high })
            }
            (DistributionName::Empirical, None) => {
                Some(Distribution::empirical(factor.data.clone().unwrap_or_default()))
            }
            (DistributionName::Triangular, Some([low, high])) => {
                Some(Distribution::Triangular { low, mode: number(factor.mode), high })
            }
            (DistributionName::Beta, Some([low, high])) => {
                Some(Distribution::Beta { alpha: number(factor.alpha), beta: number(factor.beta), low, high })
            }
            (DistributionName::Empirical, Some(_)) => {
                let at = self.at(name, &["range"]);
                self.problem(&at, "the data tell the range");
                None
            }
            _ => None,
        }
    }
}

fn link_of(link: &LinkEntry) -> Link {
    Link { factor: link.factor.unwrap_or(1.0), offset: link.offset.unwrap_or(0.0) }
}

/// A design's fault with its place in the study.
pub(in crate::study) fn design_problem(document: &Document, error: &DesignError, factors: &[FactorInfo]) -> Problem {
    let drawn = |index: usize| factors.iter().filter(|factor| factor.distribution.is_some()).nth(index);
    let name = error.factor().and_then(drawn).map(|factor| factor.name.as_str());
    let key = match error {
        DesignError::NoCategories { .. } | DesignError::FactorKind { .. } => "values",
        DesignError::Levels { .. } | DesignError::LevelsNeeded { .. } => "levels",
        DesignError::NoRows => "rows",
        DesignError::Setting { key, .. } | DesignError::Parameter { parameter: key, .. } => key,
        DesignError::Factors(_) | DesignError::TooManyRows => "kind",
        DesignError::Correlation(_) => "correlation",
        DesignError::Unsatisfiable(_) | DesignError::Constraint(_) => "constraints",
        DesignError::NotFinite { .. } | DesignError::EmptyRange { .. } | DesignError::NotPositive { .. } => "range",
    };
    let at: Vec<String> = match name {
        Some(name) => ["design", "factor", name, key].map(str::to_string).to_vec(),
        None => ["design", key].map(str::to_string).to_vec(),
    };
    Problem::new(document.locate(&at), path::join(&at), error.to_string())
}

fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Integer(a), Value::Real(b)) | (Value::Real(b), Value::Integer(a)) => *a as f64 == *b,
        _ => a == b,
    }
}

/// Whether one path is the other or leads to it.
fn overlap(a: &[String], b: &[String]) -> bool {
    a.iter().zip(b).all(|(a, b)| a == b)
}
