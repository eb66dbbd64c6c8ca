//! A study with its reduced machines, and the metadata of its tables.

use std::sync::Arc;

use arrow_array::RecordBatch;

use decore_dataset::{Columns, DatasetError, DatasetInfo, RowRecord, record_batches, signals_batch};
use decore_model::metrics::{Instant, Signal, signal_list};
use decore_model::run::RowOutcome;
use decore_statistics::design::Level;
use decore_study::engine::{Engine, EngineError, RowRunner};
use decore_study::{CheckedStudy, Study};

/// A study ready to run.
pub struct Ready {
    /// Engine that runs the rows.
    pub engine: Engine,
    /// Description of the study for its tables.
    pub info: DatasetInfo,
    /// Columns of its tables.
    pub columns: Columns,
}

/// Point to simulate.
pub enum Asked {
    /// A row of the design.
    Row(usize),
    /// Levels of the factors.
    Point(Vec<Level>),
}

/// A simulated row as tables.
pub struct Simulated {
    /// Outcome of the row.
    pub outcome: RowOutcome,
    /// Rows of `runs`, `blows` and `timings`.
    pub tables: [RecordBatch; 3],
    /// Signals, if they were requested and the row could be simulated.
    pub signals: Option<RecordBatch>,
}

/// Selection of a row's signals.
pub enum Chosen {
    /// All.
    All,
    /// Signals with these names.
    Named(Vec<String>),
}

/// Signals requested.
pub struct Wanted {
    /// Selection of the signals.
    pub chosen: Chosen,
    /// Time between two of their values in s.
    pub interval_s: f64,
}

impl Ready {
    /// Reduces the machines of a study.
    ///
    /// # Errors
    /// As for [`Engine::new`].
    pub fn new(study: &CheckedStudy, retries: u32) -> Result<Self, EngineError> {
        let engine = Engine::new(study.study().clone())?.with_retries(retries);
        let info = engine.info();
        let columns = Columns::new(&info)?;
        Ok(Self { engine, info, columns })
    }

    /// Converts an outcome for the tables. A point outside the design counts as row 0.
    pub fn record(&self, asked: &Asked, outcome: RowOutcome) -> RowRecord {
        let study = self.engine.checked();
        match asked {
            Asked::Row(row) => RowRecord { row: *row as u64, factors: study.row_values(*row), outcome },
            Asked::Point(levels) => RowRecord { row: 0, factors: study.values_at(levels), outcome },
        }
    }

    /// Simulates a row.
    ///
    /// # Errors
    /// As for [`Engine::outcome_with_signals`]; [`DatasetError::UnknownColumn`] for a signal that the row does not have.
    pub fn simulate(&self, asked: &Asked, wanted: Option<&Wanted>) -> Result<Simulated, EngineError> {
        let engine = &self.engine;
        wanted.map_or(Ok(()), |wanted| wanted.check(engine.study()))?;
        let (outcome, signals) = match (asked, wanted) {
            (Asked::Row(row), None) => (engine.outcome(*row), None),
            (Asked::Point(levels), None) => (engine.outcome_at(levels), None),
            (Asked::Row(row), Some(wanted)) => engine.outcome_with_signals(*row, wanted.interval_s)?,
            (Asked::Point(levels), Some(wanted)) => engine.outcome_with_signals_at(levels, wanted.interval_s)?,
        };
        let signals = match (signals, wanted) {
            (Some(signals), Some(wanted)) => Some(signals_batch(&self.info, &wanted.of(signals))?),
            _ => None,
        };
        let record = self.record(asked, outcome);
        let tables = record_batches(&self.info, &self.columns, std::slice::from_ref(&record))?;
        Ok(Simulated { outcome: record.outcome, tables, signals })
    }
}

impl Wanted {
    /// Holds the names to the signals of a study, before any row is simulated for them.
    fn check(&self, study: &Study) -> Result<(), DatasetError> {
        let Chosen::Named(names) = &self.chosen else { return Ok(()) };
        let known = signal_list(&study.hammer_names(), &study.castings(), &study.outputs().points);
        match names.iter().find(|name| !known.iter().any(|signal| signal.name == **name)) {
            None => Ok(()),
            Some(unknown) => Err(DatasetError::UnknownColumn {
                table: "signals",
                column: unknown.clone(),
                known: known.into_iter().map(|signal| signal.name).collect(),
            }),
        }
    }

    /// The requested signals, the time first.
    fn of(&self, signals: Vec<Signal>) -> Vec<Signal> {
        let Chosen::Named(names) = &self.chosen else { return signals };
        let (times, others): (Vec<Signal>, Vec<Signal>) =
            signals.into_iter().partition(|signal| signal.name == Instant::time_s.name);
        let named = names.iter().filter_map(|name| others.iter().find(|signal| signal.name == *name).cloned());
        times.into_iter().chain(named).collect()
    }
}

/// A study ready to run, shared with the threads that run it.
pub type Shared = Arc<Ready>;
