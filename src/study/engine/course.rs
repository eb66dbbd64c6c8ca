//! Runs rows until there are enough: common to all commands that run the rows of a dataset, judge them, and may add more.
//!
//! # States
//!
//! ```text
//!               +------------------ more rows: the decision is written, then ---------------+
//!               v                                                                           |
//! begun --> missing --all rows are there--> failed --they were run again--> whole --> judged --> enough
//!               |                              |
//!               +---- stopped: the same command finds the same state ----+
//! ```
//!
//! - missing: some rows of the current study are in no part. Only these are run.
//! - failed: all rows exist, but some are not done, and the command has larger budgets for them. They are re-run.
//! - whole: no rows are left to run. The command examines the dataset.
//!
//! A sweep ([`sweep`](super::sweep())) is one of the first two states: `decore run` runs missing rows, `decore run --only-failed` failed
//! ones.
//!
//! # Repeated commands
//!
//! The state follows only from the dataset and the options, never from the memory of a process. Each decision is written to a file before
//! its first row runs: the number of rows in the manifest of the grown dataset (which replaces the old one in one step), the rows of a
//! table in the study's file of rows, the budgets and rows of a repair in the manifest's `reruns`. The command examines only complete
//! datasets. So a repeated command decides the same after a kill or stop anywhere, and leaves the same bytes, the manifest's included.

use std::path::Path;

use decore_dataset::{DatasetError, SweepState, settle};

/// Decision after a look at a whole dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There are enough rows.
    Enough,
    /// More rows are needed; the next [`Course::run_missing`] reads which.
    More,
}

/// Actions of a command, one for each state.
pub trait Course {
    /// Error of a step.
    type Error: From<DatasetError>;

    /// Runs the rows that are missing, of the study as decided so far.
    ///
    /// # Errors
    /// Any error of a sweep.
    fn run_missing(&mut self) -> Result<SweepState, Self::Error>;

    /// Runs the rows again that are not done; without budgets for these they stay as they are.
    ///
    /// # Errors
    /// Any error of a sweep.
    fn run_failed(&mut self) -> Result<SweepState, Self::Error> {
        Ok(SweepState::Complete)
    }

    /// Looks at the dataset, which has all its rows.
    ///
    /// # Errors
    /// The dataset cannot be judged, or the decision cannot be written.
    fn judge(&mut self) -> Result<Verdict, Self::Error>;
}

/// Takes a course to its end, from whatever state the dataset in `folder` is in. Returns how the last sweep ended:
/// [`SweepState::Complete`] where there are enough rows.
///
/// # Errors
/// Any error of the course, or [`DatasetError::InUse`].
pub fn pursue<C: Course>(folder: &Path, course: &mut C) -> Result<SweepState, C::Error> {
    // The command first reads the old dataset or the grown one, never a mixture.
    settle(folder)?;
    loop {
        for run in [C::run_missing, C::run_failed] {
            let state = run(course)?;
            if state != SweepState::Complete {
                return Ok(state);
            }
        }
        if course.judge()? == Verdict::Enough {
            return Ok(SweepState::Complete);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three looks, each of which asks for a row; a stop at a given call. Decisions and rows outlive the course.
    struct Counted<'a> {
        disk: &'a mut Vec<&'static str>,
        calls_left: usize,
    }

    impl Counted<'_> {
        fn step(&mut self, done: &'static str) -> SweepState {
            if self.calls_left == 0 {
                return SweepState::Interrupted;
            }
            self.calls_left -= 1;
            if self.disk.last() != Some(&done) {
                self.disk.push(done);
            }
            SweepState::Complete
        }
    }

    impl Course for Counted<'_> {
        type Error = DatasetError;

        fn run_missing(&mut self) -> Result<SweepState, DatasetError> {
            // A decision or nothing is on the disk: rows follow; rows are there: none is missing.
            Ok(if self.disk.last().is_none_or(|last| *last == "more") {
                self.step("run")
            } else {
                SweepState::Complete
            })
        }

        fn run_failed(&mut self) -> Result<SweepState, DatasetError> {
            Ok(if self.disk.last() == Some(&"run") { self.step("again") } else { SweepState::Complete })
        }

        fn judge(&mut self) -> Result<Verdict, DatasetError> {
            let looks = self.disk.iter().filter(|done| **done == "again").count();
            if looks == 3 {
                return Ok(Verdict::Enough);
            }
            self.disk.push("more");
            Ok(Verdict::More)
        }
    }

    #[test]
    fn a_course_that_is_stopped_takes_the_same_steps() {
        let folder = Path::new("no such folder");
        let mut whole = Vec::new();
        let ended = pursue(folder, &mut Counted { disk: &mut whole, calls_left: 100 });
        assert!(matches!(ended, Ok(SweepState::Complete)) && whole.len() == 8, "{whole:?}");
        for calls in 1..4 {
            let mut disk = Vec::new();
            let stopped = |disk: &mut Vec<&'static str>| {
                matches!(pursue(folder, &mut Counted { disk, calls_left: calls }), Ok(SweepState::Interrupted))
            };
            let stops = (0..20).take_while(|_| stopped(&mut disk)).count();
            assert!(stops > 0 && stops < 20 && disk == whole, "{calls} calls at a time: {disk:?}");
        }
    }
}
