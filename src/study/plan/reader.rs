//! Reads a factor, and collects its errors.

use crate::document::error::Problem;
use crate::document::keys::Shape;
use crate::document::path;
use crate::document::typed::Typed;
use crate::file::FactorEntry;
use decore_quantity::Value;

/// Context of the design section of a study.
pub(crate) struct Surroundings<'a> {
    pub typed: &'a Typed,
    pub shape: &'a Shape,
    /// The study's tree of values, for the names in it.
    pub tree: &'a toml::Table,
}

impl Surroundings<'_> {
    /// A fault of a key.
    pub fn problem(&self, at: &[String], message: impl Into<String>) -> Problem {
        Problem::new(self.typed.locate(at), path::join(at), message)
    }
}

/// Reads one factor, part by part.
pub(super) struct FactorReader<'a> {
    pub around: &'a Surroundings<'a>,
    pub name: &'a str,
    pub entry: &'a FactorEntry,
    /// Problems found.
    pub problems: Vec<Problem>,
}

impl<'a> FactorReader<'a> {
    /// The values that it chooses from; empty for a range.
    pub fn values(&self) -> &'a [Value] {
        self.entry.values.as_deref().unwrap_or_default()
    }

    /// Path of a key of the factor.
    pub fn at(&self, keys: &[&str]) -> Vec<String> {
        ["design", "factor", self.name].iter().chain(keys).map(|key| (*key).to_owned()).collect()
    }

    /// Notes a fault of a key of the factor.
    pub fn problem(&mut self, keys: &[&str], message: impl Into<String>) -> &mut Problem {
        let at = self.at(keys);
        self.problem_at(&at, message)
    }

    /// Notes a fault of a key by its path.
    pub fn problem_at(&mut self, at: &[String], message: impl Into<String>) -> &mut Problem {
        self.problems.push(self.around.problem(at, message));
        let last = self.problems.len() - 1;
        &mut self.problems[last]
    }
}
