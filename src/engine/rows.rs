//! Where a sweep's rows come from: the study's machines, or the built-in test scene.

use std::collections::BTreeMap;

use super::error::EngineError;
use super::info::{dataset_info, record};
use super::machine::SourceModel;
use super::prepared::Engine;
use crate::dataset::{DatasetInfo, RowRecord};
use crate::run::{RowOutcome, StubRows};
use crate::study::Study;

/// The rows of a sweep.
#[derive(Debug)]
pub enum Rows {
    /// Simulated on the study's machines.
    Simulated(Box<Engine>),
    /// Of the study's design, but with made-up outcomes.
    Stub {
        /// The study, its constraints applied.
        study: Box<Study>,
        /// What makes up the outcomes.
        rows: StubRows,
    },
}

impl Rows {
    /// The study.
    pub fn study(&self) -> &Study {
        match self {
            Self::Simulated(engine) => engine.study(),
            Self::Stub { study, .. } => study,
        }
    }

    /// What the tables must know of the study.
    pub fn info(&self) -> DatasetInfo {
        match self {
            Self::Simulated(engine) => engine.info(),
            Self::Stub { study, .. } => {
                // Made-up rows never mix with simulated ones.
                let settings = BTreeMap::from([("stub-row-ms".to_owned(), "made-up outcomes".to_owned())]);
                dataset_info(study, BTreeMap::new(), settings)
            }
        }
    }

    /// Runs a row. Pure: depends on the study and the row alone.
    pub fn run(&self, row: u64) -> RowOutcome {
        match self {
            Self::Simulated(engine) => engine.run(row as usize),
            Self::Stub { rows, .. } => rows.run(row),
        }
    }

    /// A row as the tables take it.
    pub fn record(&self, row: u64, outcome: RowOutcome) -> RowRecord {
        record(self.study(), row, outcome)
    }
}

/// The study with its constraints applied: they may ask for the machine's geometry.
///
/// # Errors
/// What is wrong with the study or the files of its machine.
pub fn constrained(study: &Study) -> Result<Study, EngineError> {
    let points = SourceModel::read(study.structure())?.points();
    study.check(&points)?;
    Ok(study.constrained(&points)?)
}
