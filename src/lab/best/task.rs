//! Task of a search: budgets and existing rows.

use decore_dataset::DatasetReader;
use decore_study::Goal;

/// Budgets of [`super::next`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BestSettings {
    /// Largest number of added rows, including comparisons and checks.
    pub rows: usize,
    /// Rows that prove a proposal. 0: no decision is compared or proven by runs.
    pub checks: usize,
    /// Rows that are chosen at a time.
    pub batch: usize,
}

/// Purpose of an added row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The models.
    Learn,
    /// The comparison of decisions at different places.
    Compare,
    /// The proof of a proposal.
    Check,
}

impl Purpose {
    /// Name in the table of rows.
    pub fn name(self) -> &'static str {
        match self {
            Self::Learn => "learn",
            Self::Compare => "compare",
            Self::Check => "check",
        }
    }

    /// Reads [`Self::name`].
    pub fn read(name: &str) -> Option<Self> {
        [Self::Learn, Self::Compare, Self::Check].into_iter().find(|purpose| purpose.name() == name)
    }
}

/// The rows that there are.
#[derive(Clone, Copy)]
pub struct There<'a> {
    /// Dataset of the study.
    pub base: &'a DatasetReader,
    /// Dataset of the rows that were added; `None`: none yet.
    pub added: Option<&'a DatasetReader>,
    /// The rows that were added, in their order.
    pub rows: &'a [Added],
}

/// A row that was added.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Added {
    /// Purpose of the row.
    pub purpose: Purpose,
    /// The question that it was added for, as [`question`] has it: checks of another one prove nothing.
    pub question: String,
    /// Values of all factors as cells of a table.
    pub cells: Vec<String>,
}

/// Describes a goal in one line: objective, limits, confidence.
pub fn question(goal: &Goal) -> String {
    let wanted = if goal.maximise { "maximise" } else { "minimise" };
    let limits: String = goal.limits.iter().map(|limit| format!("; {}", limit.text)).collect();
    format!("{wanted} {}{limits}; {}", goal.text, goal.confidence)
}
