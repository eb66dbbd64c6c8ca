//! Rows for an analysis: failed ones run again more strictly, further ones until the intervals are narrow enough.

use std::path::Path;

use super::exit::{Exit, Failure};
use super::outputs::{Output, StudyArguments};
use super::run::run_rows;
use super::text::eprint_line;
use decore_dataset::{DatasetReader, RerunSelection, SweepState, is_settled};
use decore_lab::sensitivity::{Sensitivity, SensitivityError, Widths};
use decore_study::engine::{Course, Engine, RowRunner, Verdict, pursue};

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
    /// Further outputs of the command.
    pub outputs: &'a [Output<'a>],
}

/// Wanted width of the intervals, and the largest number of rows.
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

    /// Runs the rows that are missing, those again that are not done, and further ones until intervals are narrow, as far as that is
    /// `wanted`. Missing the goal ends as rows that are not done do.
    ///
    /// # Errors
    /// A design that cannot grow, an analysis without intervals, or an error of `decore run`.
    pub fn run(&self, wanted: Wanted<'_>) -> Result<Exit, Failure> {
        let mut course = Analysed { source: self, wanted, setting: None, missed: false };
        Ok(match pursue(self.folder, &mut course)? {
            SweepState::Complete if course.missed || (wanted.repair && self.rows_failed()? > 0) => Exit::RowsFailed,
            SweepState::Complete => Exit::Done,
            _ => Exit::Interrupted,
        })
    }

    fn rows_failed(&self) -> Result<u64, Failure> {
        Ok(DatasetReader::open(self.folder)?.manifest().rows_failed())
    }
}

/// Rows to run before a dataset is analysed.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// Whether rows that are not done are run again.
    pub repair: bool,
    /// Intervals that are narrow enough; `None`: no rows are added.
    pub goal: Option<Goal>,
    /// Computes the intervals.
    pub analyse: &'a dyn Fn() -> Result<Sensitivity, SensitivityError>,
}

/// The course of rows for an analysis. A look is taken at all rows of the design as the manifest has it; the number of rows that it
/// decides on is in the manifest before one of them is run.
struct Analysed<'a> {
    source: &'a Source<'a>,
    wanted: Wanted<'a>,
    /// Setting that the last look decided on.
    setting: Option<String>,
    /// Whether the goal was not reached.
    missed: bool,
}

impl Course for Analysed<'_> {
    type Error = Failure;

    fn run_missing(&mut self) -> Result<SweepState, Failure> {
        let setting = self.setting.take();
        if setting.is_none() && is_settled(self.source.folder)? {
            return Ok(SweepState::Complete);
        }
        let engine = self.source.engine(setting.as_slice())?;
        Ok(run_rows(&engine, self.source.folder, None)?.state)
    }

    fn run_failed(&mut self) -> Result<SweepState, Failure> {
        if !self.wanted.repair || self.source.rows_failed()? == 0 {
            return Ok(SweepState::Complete);
        }
        let engine = self.source.engine(self.source.overrides)?.with_retries(REPAIR_RETRIES);
        Ok(run_rows(&engine, self.source.folder, Some(&RerunSelection::Failed))?.state)
    }

    fn judge(&mut self) -> Result<Verdict, Failure> {
        let Some(goal) = self.wanted.goal else { return Ok(Verdict::Enough) };
        let found = (self.wanted.analyse)()?;
        let widths = found.widths();
        let Some(width) = widths.widest else {
            return Err(Failure::Argument(
                "--grow-until: no output has intervals that more rows could narrow (see the analysis without it)"
                    .into(),
            ));
        };
        if width <= goal.width {
            self.missed = !is_narrow_enough(goal, &widths);
            return Ok(Verdict::Enough);
        }
        let engine = self.source.engine(&[])?;
        let Some(growth) = engine.checked().design().kind().growth() else {
            return Err(Failure::Argument(
                "--grow-until: a design of this kind does not grow by itself (decore help designs)".into(),
            ));
        };
        let next = growth.next((width / goal.width).powi(2));
        let rows = found.rows / growth.count as u64 * next as u64;
        if rows > goal.most_rows {
            eprint_line(&format_args!(
                "the widest interval is {width:.3}, not {}: design.{} = {next} ({rows} rows) would be more than --most-rows {}",
                goal.width, growth.key, goal.most_rows
            ));
            self.missed = true;
            return Ok(Verdict::Enough);
        }
        let setting = format!("design.{}={next}", growth.key);
        eprint_line(&format_args!(
            "the widest interval is {width:.3}, not {}: going on with --set {setting}",
            goal.width
        ));
        self.setting = Some(setting);
        Ok(Verdict::More)
    }
}

/// Whether all intervals that more rows can narrow are narrow enough. Prints the others.
fn is_narrow_enough(goal: Goal, widths: &Widths) -> bool {
    if let Some(settled) = widths.settled.filter(|width| *width > goal.width) {
        eprint_line(&format_args!(
            "intervals of Shapley effects stay up to {settled:.3} wide: they come of no more rows than now, however many there are"
        ));
    }
    if widths.without.is_empty() {
        return true;
    }
    let (outputs, width) = (widths.without.join(", "), goal.width);
    eprint_line(&format_args!(
        "not known to be narrower than {width}, as intervals are missing (the analysis says why): {outputs}"
    ));
    false
}
