//! From the tables of a dataset to the table of features: a row per run and casting.

use super::column::{Column, Role};
use super::error::FeaturesError;
use super::figures::{FIGURES, TIME_TO_WORK};
use super::hammers::Assignment;
use super::plan::{Planned, Reads, View};
use super::settings::FeatureSettings;
use super::struck::{StruckRows, Thresholds};
use crate::dataset::{DatasetReader, RowRecord, TableName};
use crate::quantity::Value;
use crate::run::{RowOutcome, RowStatus};
use crate::study::DesignOutline;

/// The table of features.
#[derive(Debug, Clone, PartialEq)]
pub struct Features {
    /// The columns, all of the same length.
    pub columns: Vec<Column>,
    /// Rows of the dataset: the table has one for each of their castings.
    pub runs: u64,
    /// Those of them that are done.
    pub done: u64,
}

/// Builds the table of a dataset. The dataset may still be written: what is there counts.
///
/// # Errors
/// Those of reading, [`FeaturesError::NoRows`], [`FeaturesError::Casting`], [`FeaturesError::Twice`].
pub fn features(reader: &DatasetReader, settings: &FeatureSettings) -> Result<Features, FeaturesError> {
    let info = &reader.manifest().study;
    let outline = DesignOutline::read(&info.study_text, &info.overrides, &info.study_name)?;
    let thresholds = Thresholds { dose_j: settings.dose_threshold_j, work_j: settings.work_j };
    let struck = StruckRows::read(reader, thresholds)?;
    let mut reads = Reads::default();
    let [row, status] = [RowRecord::row.name, RowOutcome::status.name].map(|name| reads.place(name));
    let assignment = Assignment::of(reader, &outline, &mut reads)?;
    let mut planned = plan(reader, &outline, settings, &mut reads);
    let mut fault = None;
    let (mut runs, mut done) = (0, 0);
    reader.visit(TableName::Runs, reads.names(), |cells| {
        let cell = |place: usize| cells.get(place).copied().flatten();
        let Some(Value::Count(row)) = cell(row) else { return };
        match assignment.castings(row, cells) {
            Ok(castings) => {
                for (casting, name) in info.castings.iter().enumerate() {
                    let struck = struck.of(row, casting);
                    planned.push(&View { cells, name, casting, castings: &castings, struck });
                }
            }
            Err(error) => fault = fault.take().or(Some(error)),
        }
        runs += 1;
        done += u64::from(cell(status) == Some(Value::Text(RowStatus::Done.text())));
    })?;
    match fault {
        Some(error) => Err(error),
        None if runs == 0 => Err(FeaturesError::NoRows),
        None => Ok(Features { columns: checked(planned.columns())?, runs, done }),
    }
}

/// The columns that the table is to have.
fn plan<'a>(
    reader: &'a DatasetReader,
    outline: &DesignOutline,
    settings: &FeatureSettings,
    reads: &mut Reads<'a>,
) -> Planned<'a> {
    let mut planned = Planned::new(reader, reads);
    planned.add_run(reads, RowRecord::row.name, Role::Key);
    planned.add_casting();
    for name in [RowOutcome::status.name, RowOutcome::reason.name, RowOutcome::time_reached_s.name] {
        planned.add_run(reads, name, Role::Status);
    }
    planned.add_factors(reads, outline);
    for figure in FIGURES.iter().filter(|figure| figure.name != TIME_TO_WORK || settings.work_j.is_some()) {
        planned.add_figure(reads, figure);
    }
    planned.derive(settings);
    planned
}

/// Refuses two columns of one name, whatever their case.
fn checked(columns: Vec<Column>) -> Result<Vec<Column>, FeaturesError> {
    let mut names: Vec<String> = columns.iter().map(|column| column.name.to_ascii_lowercase()).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some([column, ..]) => Err(FeaturesError::Twice { column: column.clone() }),
        _ => Ok(columns),
    }
}
