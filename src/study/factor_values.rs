//! Values of factors from outside, not from a row of the design.

use super::checked::CheckedStudy;
use super::document::error::{FileLocation, Problem, StudyError};
use super::document::path;
use super::plan::factor::{FactorInfo, FactorSource};
use decore_quantity::Value;
use decore_quantity::words::nearest;
use decore_statistics::design::{Distribution, Level};

impl CheckedStudy {
    /// The factors that need a value in [`CheckedStudy::levels`]: those that the design draws and that have something to drive.
    pub fn free_factors(&self) -> impl Iterator<Item = &FactorInfo> {
        let factors = self.study().factors().iter();
        factors.filter(|factor| factor.distribution().is_some() && !self.is_overridden(factor))
    }

    /// The levels of the factors that the design draws, in its order, from values by the factors' names: for
    /// [`CheckedStudy::scene_at`]. A factor all of whose paths are overridden needs none. Values beyond a factor's range are
    /// taken; of one with `values` it must be one of these.
    ///
    /// # Errors
    /// [`StudyError::Invalid`] with all faults: factors that are unknown, derived, overridden or lack a value, values of
    /// another kind.
    pub fn levels(&self, given: &[(String, Value)]) -> Result<Vec<Level>, StudyError> {
        let mut problems = Vec::new();
        let drawn = |factor: &&FactorInfo| factor.distribution().is_some();
        let names = || self.study().factors().iter().filter(drawn).map(|factor| factor.name.as_str());
        for (name, _) in given.iter().filter(|(name, _)| !names().any(|known| known == name)) {
            let derived = self.study().factors().iter().any(|factor| factor.name == *name);
            let message = if derived { "is derived from others" } else { "is no factor of the design" };
            // It stands nowhere in the file.
            let file = FileLocation::in_file(self.study().name());
            let at = path::join(&["design", "factor", name.as_str()].map(str::to_owned));
            let problem = Problem::new(file, at, message).expected(words(names()));
            problems.push(problem.nearest(nearest(name, names()).filter(|_| !derived)));
        }
        let first = self.design().row(0).unwrap_or_default();
        let mut levels = Vec::with_capacity(first.len());
        for factor in self.study().factors() {
            let FactorSource::Drawn { index, distribution } = &factor.source else { continue };
            let value = given.iter().find(|(name, _)| *name == factor.name).map(|(_, value)| value);
            let level = match (value, self.is_overridden(factor)) {
                (Some(_), true) => Err(self.fault(&factor.name, "is already set by an override of the study")),
                (None, true) => first.get(*index).copied().ok_or_else(|| self.fault(&factor.name, "has no value")),
                (None, false) => Err(self.fault(&factor.name, "has no value").expected("a value for every factor")),
                (Some(value), false) => level(factor, distribution, value).ok_or_else(|| {
                    self.fault(&factor.name, &format!("is {value}")).expected(domain(factor, distribution))
                }),
            };
            match level {
                Ok(level) => levels.push(level),
                Err(problem) => problems.push(problem),
            }
        }
        StudyError::from_problems(problems)?;
        Ok(levels)
    }

    /// Whether nothing is left for a factor to drive.
    fn is_overridden(&self, factor: &FactorInfo) -> bool {
        !factor.drives.is_empty() && factor.drives.iter().all(|driven| self.study().overridden(&driven.path).is_some())
    }

    fn fault(&self, factor: &str, message: &str) -> Problem {
        let at = ["design", "factor", factor].map(str::to_owned);
        Problem::new(self.study().typed.locate(&at), path::join(&at), message)
    }
}

/// The level that stands for a value; `None` if it is none of this factor's kind.
fn level(factor: &FactorInfo, distribution: &Distribution, value: &Value) -> Option<Level> {
    match distribution {
        Distribution::Categories { .. } => {
            let same = |known: &Value| match (known.number(), value.number()) {
                (Some(known), Some(given)) => known == given,
                _ => known == value,
            };
            factor.values.iter().position(same).map(Level::Category)
        }
        Distribution::Integer { .. } | Distribution::LogInteger { .. } => {
            // The largest whole number below which all have a floating-point number.
            let whole =
                value.number().filter(|number| number.fract() == 0.0 && number.abs() <= 9_007_199_254_740_992.0);
            whole.map(|number| Level::Integer(number as i64))
        }
        _ => value.number().filter(|number| number.is_finite()).map(Level::Real),
    }
}

fn domain(factor: &FactorInfo, distribution: &Distribution) -> String {
    match distribution {
        Distribution::Categories { .. } => format!("one of {}", factor.domain()),
        Distribution::Integer { .. } | Distribution::LogInteger { .. } => "a whole number".to_owned(),
        _ => "a finite number".to_owned(),
    }
}

fn words<'a>(names: impl Iterator<Item = &'a str>) -> String {
    match names.collect::<Vec<_>>().as_slice() {
        [] => "none: the design has no factors".to_owned(),
        some => format!("one of {}", some.join(", ")),
    }
}
