//! Rows for an analysis: failed ones run again more strictly, further ones until the intervals are narrow enough.

use std::path::Path;

use super::exit::{Exit, Failure};
use super::outputs::{Output, StudyArguments};
use super::run::run_rows;
use super::text::tell;
use crate::dataset::{Chosen, DatasetReader, SweepState};
use crate::engine::{Engine, Rows};
use crate::sensitivity::{Sensitivity, SensitivityError, Widths};

/// Times a failed row is run again, each time with a hundredth of the tolerance before.
const REPAIR_RETRIES: u32 = 3;

/// The study of a dataset, from which its rows can be run.
pub(super) struct Source<'a> {
    /// The study's file.
    pub study: &'a Path,
    /// The dataset's folder.
    pub folder: &'a Path,
    /// Values set for rows that are run again, over those with which the dataset was made.
    pub overrides: &'a [String],
    /// What the command writes besides.
    pub outputs: &'a [Output<'a>],
}

/// What narrow enough is, and how far to go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// Width that no interval exceeds.
    pub width: f64,
    /// Rows at most.
    pub most_rows: u64,
}

impl Source<'_> {
    /// The study as the dataset was made, with these settings over it.
    fn engine(&self, further: &[String]) -> Result<Engine, Failure> {
        let reader = DatasetReader::open(self.folder)?;
        let made = &reader.manifest().study;
        let overrides = [&made.overrides[..], further].concat();
        let study = StudyArguments { file: self.study, overrides: &overrides, outputs: self.outputs };
        Ok(study.engine()?.with_retries(made.retries()))
    }

    /// Holds the outputs to the study's files, also where no row is to be run.
    ///
    /// # Errors
    /// As for [`StudyArguments::study`].
    pub fn check(&self) -> Result<(), Failure> {
        let made = DatasetReader::open(self.folder)?.manifest().study.overrides.clone();
        StudyArguments { file: self.study, overrides: &made, outputs: self.outputs }.study().map(drop)
    }

    /// Runs the rows again that are not done, with up to three retries; rows that are still not done stay as they were.
    ///
    /// # Errors
    /// Those of `decore run --only-failed`.
    pub fn repair(&self) -> Result<Exit, Failure> {
        let engine = self.engine(self.overrides)?.with_retries(REPAIR_RETRIES);
        let status = run_rows(&engine, self.folder, Some(&Chosen::Failed))?;
        let exit = ending(status.state);
        Ok(if exit == Exit::Done && status.rows_failed > 0 { Exit::RowsFailed } else { exit })
    }

    /// Adds rows until no interval is wider than the goal, as many at a time as its width asks for; `analyse` computes the
    /// intervals. Missing the goal ends as rows that are not done do.
    ///
    /// # Errors
    /// A design that cannot grow, an analysis without intervals; those of `decore run`.
    pub fn grow(
        &self,
        goal: Goal,
        analyse: &dyn Fn() -> Result<Sensitivity, SensitivityError>,
    ) -> Result<Exit, Failure> {
        loop {
            let found = analyse()?;
            let widths = found.widths();
            let Some(width) = widths.widest else {
                return Err(Failure::Argument(
                    "--grow-until: no output has intervals that more rows could narrow (see the analysis without it)"
                        .into(),
                ));
            };
            if width <= goal.width {
                return Ok(narrow_enough(goal, &widths));
            }
            let engine = self.engine(&[])?;
            let Some(growth) = engine.checked().design().kind().growth() else {
                return Err(Failure::Argument(
                    "--grow-until: a design of this kind does not grow by itself (decore help designs)".into(),
                ));
            };
            let next = growth.next((width / goal.width).powi(2));
            let rows = found.rows / growth.count as u64 * next as u64;
            if rows > goal.most_rows {
                tell(&format_args!(
                    "the widest interval is {width:.3}, not {}: design.{} = {next} ({rows} rows) would be more than --most-rows {}",
                    goal.width, growth.key, goal.most_rows
                ));
                return Ok(Exit::RowsFailed);
            }
            let setting = format!("design.{}={next}", growth.key);
            tell(&format_args!("the widest interval is {width:.3}, not {}: going on with --set {setting}", goal.width));
            let status = run_rows(&self.engine(&[setting])?, self.folder, None)?;
            if status.state != SweepState::Complete {
                return Ok(ending(status.state));
            }
        }
    }
}

/// How it ends where all intervals are narrow that more rows narrow: what is said of the others.
fn narrow_enough(goal: Goal, widths: &Widths) -> Exit {
    if let Some(settled) = widths.settled.filter(|width| *width > goal.width) {
        tell(&format_args!(
            "intervals of Shapley effects stay up to {settled:.3} wide: they come of no more rows than now, however many there are"
        ));
    }
    if widths.without.is_empty() {
        return Exit::Done;
    }
    let (outputs, width) = (widths.without.join(", "), goal.width);
    tell(&format_args!(
        "not known to be narrower than {width}, as intervals are missing (the analysis says why): {outputs}"
    ));
    Exit::RowsFailed
}

fn ending(state: SweepState) -> Exit {
    if state == SweepState::Complete { Exit::Done } else { Exit::Interrupted }
}
