//! The design of a study: its factors, its kind, its constraints.

use super::factor::{FactorInfo, FactorSource, Factors, Link, kind_of};
use super::kinds::{DesignChoice, Fault, KindReader, RowFile, spanned};
use super::reader::{FactorReader, Surroundings};
use crate::document::error::Problem;
use crate::document::path;
use crate::document::typed::Typed;
use crate::expression::{self, Expression};
use crate::file::{DesignEntry, FactorEntry};
use decore_quantity::{Kind, Value};
use decore_statistics::design::{self, Design, DesignError, Factor, Level};

/// The design of a study with its factors.
#[derive(Debug, Clone)]
pub(crate) struct DesignPlan {
    pub design: Design,
    pub factors: Vec<FactorInfo>,
    pub constraints: Vec<Constraint>,
    /// The files that the design names, for the study's hash.
    pub files: Vec<RowFile>,
}

/// Condition on every row.
#[derive(Debug, Clone)]
pub(crate) struct Constraint {
    /// As written.
    pub text: String,
    /// As read.
    pub expression: Expression,
}

/// Reads the design section part by part.
struct DesignReader<'a> {
    entry: &'a DesignEntry,
    around: &'a Surroundings<'a>,
    /// The factors so far.
    factors: Vec<FactorInfo>,
    /// Factors that the design draws, in its form.
    drawn: Vec<Factor>,
    problems: Vec<Problem>,
}

impl DesignReader<'_> {
    /// Reads a factor; those before it have been read.
    fn factor(&mut self, name: &str, typed: &FactorEntry) {
        let entry = spanned(self.entry, (name, typed), self.around.typed.row_directory()).unwrap_or_else(
            |Fault { at, message }| {
                self.problems.push(self.around.problem(&at, message));
                typed.clone()
            },
        );
        let mut reader = FactorReader { around: self.around, name, entry: &entry, problems: Vec::new() };
        reader.check_values();
        let drives = reader.drives(&self.factors);
        let source = match &entry.expression {
            Some(text) => FactorSource::Derived { text: text.clone(), expression: reader.derived(text, &self.factors) },
            None => {
                let distribution = reader.distribution();
                let levels = entry.levels.map(|count| usize::try_from(count).unwrap_or(usize::MAX));
                self.drawn.push(Factor { distribution: distribution.clone(), levels });
                FactorSource::Drawn { index: self.drawn.len() - 1, distribution }
            }
        };
        self.problems.extend(reader.problems);
        let values = entry.values.unwrap_or_default();
        let kind = match &source {
            FactorSource::Drawn { distribution, .. } => kind_of(distribution, &values),
            FactorSource::Derived { .. } => Kind::Real,
        };
        let role = entry.role.unwrap_or_default();
        self.factors.push(FactorInfo { name: name.to_owned(), kind, unit: entry.unit, values, role, source, drives });
    }

    fn constraints(&mut self) -> Vec<Constraint> {
        let mut constraints = Vec::new();
        for (index, text) in self.entry.constraints.iter().enumerate() {
            match Expression::parse(text) {
                Ok(expression) => constraints.push(Constraint { text: text.clone(), expression }),
                Err(error) => {
                    let at = ["design", "constraints", &index.to_string()].map(str::to_string);
                    let problem = self.around.problem(&at, error.to_string());
                    self.problems.push(problem.expected("a comparison of factors, e.g. \"a + b <= 3\""));
                }
            }
        }
        constraints
    }

    fn kind_reader(&self) -> KindReader<'_> {
        let drawn = self.factors.iter().filter(|factor| factor.distribution().is_some()).collect();
        KindReader { entry: self.entry, drawn, directory: self.around.typed.row_directory() }
    }

    /// The kind of design; `None` if something is at fault.
    fn kind(&mut self) -> Option<DesignChoice> {
        match self.kind_reader().kind() {
            Ok(chosen) => Some(chosen).filter(|_| self.problems.is_empty()),
            Err(faults) => {
                let place = |Fault { at, message }| self.around.problem(&at, message);
                self.problems.extend(faults.into_iter().map(place));
                None
            }
        }
    }

    fn design(&self, kind: design::Kind) -> Result<Design, DesignError> {
        let (drawn, seed) = (self.drawn.clone(), self.entry.seed.unwrap_or(0));
        let Some(correlation) = &self.entry.correlation else { return Design::new(kind, drawn, seed) };
        let matrix = self.kind_reader().correlations(correlation)?;
        Design::with_correlation(kind, drawn, seed, &matrix)
    }
}

impl DesignPlan {
    /// Reads the design section.
    pub fn read(entry: &DesignEntry, around: &Surroundings<'_>) -> Result<Self, Vec<Problem>> {
        let mut reader = DesignReader { entry, around, factors: Vec::new(), drawn: Vec::new(), problems: Vec::new() };
        for (name, typed) in &entry.factor {
            reader.factor(name, typed);
        }
        let constraints = reader.constraints();
        let Some(DesignChoice { kind, files }) = reader.kind() else { return Err(reader.problems) };
        match reader.design(kind) {
            Ok(design) => Ok(Self { design, factors: reader.factors, constraints, files }),
            Err(error) => Err(vec![design_problem(around.typed, &error, &reader.factors)]),
        }
    }

    /// Fills missing values at the paths of factors with the values of the first row. The error contains the path and the fault.
    pub fn fill_gaps(&self, tree: &mut toml::Table) -> Result<(), (String, String)> {
        for (at, value) in self.driven(&self.row(0)) {
            if path::get(tree, at).is_none() {
                path::set(tree, at, value).map_err(|message| (path::join(at), message))?;
            }
        }
        Ok(())
    }

    /// What is converted from the unit of a factor to that of a parameter, for the study's hash; empty if nothing is.
    pub fn conversions(&self) -> String {
        let all = self.factors.iter().flat_map(|factor| &factor.drives).filter(|driven| driven.converted_to.is_some());
        let words = all.map(|driven| {
            let Link { factor, offset } = driven.link;
            format!("\n{}: {factor:e} {offset:e}", path::join(&driven.path))
        });
        words.collect()
    }

    /// All paths that factors drive.
    pub fn driven_paths(&self) -> impl Iterator<Item = &[String]> {
        self.factors.iter().flat_map(|factor| &factor.drives).map(|driven| driven.path.as_slice())
    }

    /// The factor that drives a path which the function accepts.
    pub fn driver(&self, accepts: impl Fn(&[String]) -> bool) -> Option<&FactorInfo> {
        self.factors.iter().find(|factor| factor.drives.iter().any(|driven| accepts(&driven.path)))
    }

    /// Paths that factors drive, with their values for these values of the factors.
    pub fn driven(&self, values: &[Value]) -> Vec<(&[String], toml::Value)> {
        let mut all = Vec::new();
        for (factor, value) in self.factors.iter().zip(values) {
            all.extend(factor.drives.iter().map(|driven| (driven.path.as_slice(), driven.value(value))));
        }
        all
    }

    /// Values of all factors, in the study's order, for the levels of the drawn ones.
    ///
    /// If the expression of a derived factor has no value, the factor is NaN, and the error contains the reason.
    pub fn values(&self, levels: &[Level]) -> (Vec<Value>, Option<String>) {
        let mut values = Vec::with_capacity(self.factors.len());
        let mut fault = None;
        for factor in &self.factors {
            let value = match &factor.source {
                FactorSource::Drawn { index, .. } => {
                    factor.value(levels.get(*index).copied().unwrap_or(Level::Real(f64::NAN)))
                }
                FactorSource::Derived { expression, .. } => {
                    let scope = Factors { names: &self.factors, values: &values };
                    let number = match expression.evaluate(&scope) {
                        Ok(expression::Outcome::Number(number)) => Ok(number),
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

/// A design's fault with its place in the study.
pub(crate) fn design_problem(typed: &Typed, error: &DesignError, factors: &[FactorInfo]) -> Problem {
    let drawn = |index: usize| factors.iter().filter(|factor| factor.distribution().is_some()).nth(index);
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
    Problem::new(typed.locate(&at), path::join(&at), error.to_string())
}
