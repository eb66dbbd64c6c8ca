//! Decisions that were run to compare or to prove them.

use std::ops::Range;

use super::checks::Checks;
use super::error::BestError;
use super::model::Models;
use super::space::{Decision, Space};
use super::task::{Purpose, There};
use decore_dataset::{DatasetReader, RowRecord, TableName};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};

/// A decision that was run.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub decision: Decision,
    /// [`Purpose::Compare`] or [`Purpose::Check`].
    pub purpose: Purpose,
    pub runs: Checks,
}

/// The decisions that were run for a question, in the order of their rows.
pub(super) struct Trials {
    pub all: Vec<Trial>,
    /// Share of the checks that must hold the limits.
    confidence: f64,
    /// Sign by which large values of the goal are better.
    sign: f64,
}

impl Trials {
    /// Reads the rows that were added for a question. Trials with missing rows are left out.
    ///
    /// # Errors
    /// Damaged or missing files of the dataset.
    pub fn read(there: There<'_>, question: &str, (space, models): (&Space<'_>, &Models)) -> Result<Self, BestError> {
        let mut trials = Self { all: Vec::new(), confidence: models.confidence, sign: models.sign() };
        let Some(reader) = there.added else { return Ok(trials) };
        let present: u64 = reader.parts(TableName::Runs).iter().map(|part| part.records).sum();
        let groups = groups(there, question, space).into_iter().filter(|(_, _, rows)| rows.end as u64 <= present);
        trials.all = groups
            .map(|(decision, purpose, rows)| {
                let runs = Checks::unread(&rows, models.wanted.len());
                Trial { decision, purpose, runs }
            })
            .collect();
        trials.read_values(reader, models)?;
        Ok(trials)
    }

    fn read_values(&mut self, reader: &DatasetReader, models: &Models) -> Result<(), BestError> {
        let mut names = vec![RowRecord::row.name, RowOutcome::status.name];
        let places: Vec<Range<usize>> = (models.wanted.iter())
            .map(|wanted| {
                let from = names.len() - 2;
                names.extend(wanted.columns().iter().map(String::as_str));
                from..names.len() - 2
            })
            .collect();
        reader.visit(TableName::Runs, &names, |cells| {
            let [Some(Value::Count(row)), Some(Value::Text(status)), cells @ ..] = cells else { return };
            let own = self.all.iter_mut().find(|trial| (trial.runs.rows[0]..=trial.runs.rows[1]).contains(row));
            let Some(own) = own.filter(|_| *status == RowStatus::Done.name()) else { return };
            let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).unwrap_or(f64::NAN);
            let numbers: Vec<f64> = cells.iter().map(number).collect();
            let values = models.wanted.iter().zip(&places).map(|(wanted, place)| wanted.value(&numbers[place.clone()]));
            own.runs.take(&values.collect::<Vec<f64>>(), models);
        })?;
        self.all.iter_mut().flat_map(|trial| &mut trial.runs.values).for_each(|values| values.sort_by(f64::total_cmp));
        Ok(())
    }

    /// The decisions, each once.
    pub fn decisions(&self) -> Vec<Decision> {
        let mut decisions: Vec<Decision> = Vec::new();
        for trial in &self.all {
            if !decisions.contains(&trial.decision) {
                decisions.push(trial.decision.clone());
            }
        }
        decisions
    }

    /// The runs of a decision: its checks, otherwise the runs that compared it.
    pub fn of(&self, decision: &Decision) -> Option<&Trial> {
        let own = || self.all.iter().filter(|trial| trial.decision == *decision);
        own().find(|trial| trial.purpose == Purpose::Check).or_else(|| own().next_back())
    }

    /// Whether the decision was checked.
    pub fn is_checked(&self, decision: &Decision) -> bool {
        self.of(decision).is_some_and(|trial| trial.purpose == Purpose::Check)
    }

    /// The best of the decisions whose checks hold the limits, and its goal, larger is better.
    pub fn proven(&self) -> Option<(&Trial, f64)> {
        let checked = self.all.iter().filter(|trial| trial.purpose == Purpose::Check);
        let held = checked.filter(|trial| trial.runs.are_held(self.confidence));
        let goals = held.map(|trial| (trial, self.sign * trial.runs.mean(0)));
        goals.reduce(|best, next| if next.1 > best.1 { next } else { best })
    }
}

/// Rows of one decision and purpose that follow each other.
fn groups(there: There<'_>, question: &str, space: &Space<'_>) -> Vec<(Decision, Purpose, Range<usize>)> {
    let mut groups: Vec<(Decision, Purpose, Range<usize>)> = Vec::new();
    for (number, row) in there.rows.iter().enumerate() {
        if row.purpose == Purpose::Learn || row.question != question {
            continue;
        }
        match groups.last_mut() {
            Some((decision, purpose, rows))
                if rows.end == number && *purpose == row.purpose && space.has(&row.cells, decision) =>
            {
                rows.end += 1;
            }
            // The first row has exactly the decision.
            _ => {
                groups.extend(space.decision_of(&row.cells).map(|decision| (decision, row.purpose, number..number + 1)))
            }
        }
    }
    groups
}
