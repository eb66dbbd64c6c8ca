//! Goal of a study, and its limits.

use super::document::error::{Problem, StudyError};
use super::document::path;
use super::document::tree::TextSpan;
use super::document::typed::Typed;
use super::file::GoalEntry;
use crate::expression::{Expression, Role};
use decore_quantity::words::nearest;

/// Share of the uncertain factors under which limits must hold by default.
const CONFIDENCE: f64 = 0.95;

/// Goal of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// Whether to maximise the value; otherwise to minimise it.
    pub maximise: bool,
    /// The value, as written.
    pub text: String,
    /// The value: an expression over columns of the table of runs.
    pub value: Expression,
    /// Limits that must hold.
    pub limits: Vec<Limit>,
    /// Share of the uncertain factors' draws in which all limits must hold, above 0 and below 1.
    pub confidence: f64,
}

/// A limit: `left <= right`, or `left >= right`.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// As written.
    pub text: String,
    /// Left side.
    pub left: Expression,
    /// Whether the left side must be at most the right one; at least otherwise.
    pub at_most: bool,
    /// Right side.
    pub right: Expression,
}

impl Goal {
    /// Reads the table `goal`.
    ///
    /// # Errors
    /// All faults with their places.
    pub(super) fn read(entry: &GoalEntry, typed: &Typed) -> Result<Self, StudyError> {
        let mut reader = GoalReader { typed, problems: Vec::new() };
        let value = reader.value(entry);
        let limits: Vec<Limit> = entry.limits.iter().enumerate().filter_map(|limit| reader.limit(limit)).collect();
        let confidence = entry.confidence.unwrap_or(CONFIDENCE);
        if !(confidence > 0.0 && confidence < 1.0) {
            let at = ["goal", "confidence"].map(str::to_owned);
            reader.fault(&at, format!("{confidence} is no share")).expected =
                Some("a number between 0 and 1, e.g. 0.95".into());
        }
        match (value, reader.problems.is_empty()) {
            (Some((maximise, text, value)), true) => Ok(Self { maximise, text, value, limits, confidence }),
            _ => Err(StudyError::several(reader.problems)),
        }
    }

    /// Checks names and units, see [`super::Study::check_goal`].
    pub(super) fn check(&self, known: &[(String, String)], typed: &Typed) -> Result<(), StudyError> {
        let key = if self.maximise { "maximise" } else { "minimise" };
        let mut texts = vec![(vec!["goal".to_owned(), key.to_owned()], &self.text)];
        for (index, limit) in self.limits.iter().enumerate() {
            texts.push((vec!["goal".to_owned(), "limits".to_owned(), index.to_string()], &limit.text));
        }
        let mut problems = Vec::new();
        for (at, text) in texts {
            // It was read before.
            let Ok(expression) = Expression::parse(text) else { continue };
            for word in expression.words().iter().filter(|word| word.role == Role::Value) {
                if known.iter().any(|(name, _)| *name == word.text) {
                    continue;
                }
                let place = typed.locate_part(&at, text, &TextSpan { text: &word.text, column: word.column });
                let message = format!("`{}` is not a numerical column of the table of runs", word.text);
                let near = nearest(&word.text, known.iter().map(|(name, _)| name.as_str()));
                let problem = Problem::new(place, path::join(&at), message).nearest(near);
                problems.push(problem.expected("a column that `decore help outputs` lists"));
            }
            let unit = |name: &str| known.iter().find(|(known, _)| known == name).map(|(_, unit)| unit.clone());
            if let Err(message) = expression.unit(&unit) {
                problems.push(Problem::new(typed.locate(&at), path::join(&at), message).expected("values in one unit"));
            }
        }
        StudyError::from_problems(problems)
    }
}

/// Reads the table `goal` key by key.
struct GoalReader<'a> {
    typed: &'a Typed,
    problems: Vec<Problem>,
}

impl GoalReader<'_> {
    fn fault(&mut self, at: &[String], message: String) -> &mut Problem {
        self.problems.push(Problem::new(self.typed.locate(at), path::join(at), message));
        let last = self.problems.len() - 1;
        &mut self.problems[last]
    }

    /// Objective: direction, text and expression.
    fn value(&mut self, entry: &GoalEntry) -> Option<(bool, String, Expression)> {
        let (maximise, text) = match (&entry.maximise, &entry.minimise) {
            (Some(text), None) => (true, text),
            (None, Some(text)) => (false, text),
            (both, _) => {
                let message = if both.is_some() { "has `maximise` and `minimise`" } else { "wants nothing" };
                let problem = self.fault(&["goal".to_owned()], message.to_owned());
                problem.expected = Some("one of the two keys, e.g. maximise = \"delivered_work_j\"".into());
                return None;
            }
        };
        let at = ["goal", if maximise { "maximise" } else { "minimise" }].map(str::to_owned);
        let value = self.expression(&at, text)?;
        if value.comparison().is_some() {
            self.fault(&at, format!("`{text}` is a comparison")).expected =
                Some("a value, e.g. \"delivered_work_j\"; comparisons belong into `limits`".into());
            return None;
        }
        Some((maximise, text.clone(), value))
    }

    fn limit(&mut self, (index, text): (usize, &String)) -> Option<Limit> {
        let at = ["goal".to_owned(), "limits".to_owned(), index.to_string()];
        let Some((left, symbol, right)) = self.expression(&at, text)?.comparison() else {
            self.fault(&at, format!("`{text}` is not a comparison")).expected =
                Some("`<=` or `>=` between two values, e.g. \"max_casting_point_velocity_m_s <= 4.5\"".into());
            return None;
        };
        Some(Limit { text: text.clone(), left, at_most: symbol.starts_with('<'), right })
    }

    /// An expression that names at least one column and calls no function of geometry.
    fn expression(&mut self, at: &[String], text: &str) -> Option<Expression> {
        let message = match Expression::parse(text) {
            Err(error) => error.to_string(),
            Ok(found) if found.calls_scope() => {
                let called = found.words().iter().find(|word| word.role == Role::Function);
                format!("there is no function `{}` of outputs", called.map_or("", |word| word.text.as_str()))
            }
            Ok(found) if found.names().is_empty() => "names no output".to_owned(),
            Ok(found) => return Some(found),
        };
        self.fault(at, message).expected = Some("an expression over columns of the table of runs".into());
        None
    }
}
