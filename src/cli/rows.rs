//! Where a sweep's rows come from: the study's machine, or the built-in test scene.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use super::exit::Failure;
use super::prepare::{Prepared, dataset_info, load, prepare, record};
use crate::dataset::{DatasetInfo, RowRecord};
use crate::run::{RowOutcome, SourceModel, StubRows};
use crate::study::Study;

/// The rows of a sweep.
pub(super) enum Rows {
    /// Simulated on the study's machine.
    Simulated(Box<Prepared>),
    /// Of the study's design, but with made-up outcomes.
    Stub { study: Box<Study>, rows: StubRows },
}

impl Rows {
    /// Rows that are simulated; one that diverges is run again at most `retries` times.
    pub fn simulated(study: &Path, overrides: &[String], retries: u32) -> Result<Self, Failure> {
        let mut prepared = prepare(study, overrides)?;
        prepared.retries = retries;
        Ok(Self::Simulated(Box::new(prepared)))
    }

    /// Rows of the built-in test scene that take `milliseconds` each, computing or sleeping.
    pub fn stub(study: &Path, overrides: &[String], (milliseconds, busy): (f64, bool)) -> Result<Self, Failure> {
        let duration = Duration::try_from_secs_f64(milliseconds * 1e-3);
        let duration = duration.map_err(|error| Failure::Argument(format!("--stub-row-ms: {error}")))?;
        let study = load(study, overrides)?;
        let study = if study.constraints().is_empty() { study } else { constrained(&study)? };
        let (hammers, castings) = (study.hammer_names().len(), study.casting_names().len());
        let rows = StubRows { duration, busy, hammers, castings };
        Ok(Self::Stub { study: Box::new(study), rows })
    }

    /// Hash of the factors' values in the first rows, see [`Study::rows_hash`].
    pub fn rows_hash(&self, rows: u64) -> String {
        self.study().rows_hash(rows as usize)
    }

    fn study(&self) -> &Study {
        match self {
            Self::Simulated(prepared) => &prepared.study,
            Self::Stub { study, .. } => study,
        }
    }

    /// What the tables must know of the study.
    pub fn info(&self) -> DatasetInfo {
        match self {
            Self::Simulated(prepared) => prepared.info(),
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
            Self::Simulated(prepared) => prepared.run(row as usize),
            Self::Stub { rows, .. } => rows.run(row),
        }
    }

    /// A row as the tables take it.
    pub fn record(&self, row: u64, outcome: RowOutcome) -> RowRecord {
        record(self.study(), row, outcome)
    }
}

/// The study with its constraints applied: they may ask for the machine's geometry.
pub(super) fn constrained(study: &Study) -> Result<Study, Failure> {
    let points = SourceModel::read(study.structure())?.points();
    study.check(&points)?;
    Ok(study.constrained(&points)?)
}
