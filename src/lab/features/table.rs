//! Builds the table of features from the tables of a dataset: a row per run and casting.

use super::binders::Binders;
use super::column::{FeatureColumn, Role};
use super::error::FeaturesError;
use super::figures::{FIGURES, TIME_TO_WORK};
use super::groups::{Groups, RunKeys};
use super::hammers::Assignment;
use super::leakage::{Derived, find};
use super::plan::{Planned, Reads, View, factor_column};
use super::settings::FeatureSettings;
use super::signals::SignalRows;
use super::struck::{StruckRows, Thresholds};
use decore_dataset::{ColumnGroup, DatasetReader, RowRecord, TableName, ValuesKey};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};
use decore_study::DesignOutline;

/// The table of features.
#[derive(Debug, Clone, PartialEq)]
pub struct Features {
    /// The columns, all of the same length.
    pub columns: Vec<FeatureColumn>,
    /// Rows of the dataset: the table has one for each of their castings.
    pub runs: u64,
    /// Number of runs that are done.
    pub done: u64,
    /// Columns whose numbers follow from targets by arithmetic.
    pub derived: Vec<Derived>,
    /// Interval in s over which the signals are averaged that accelerations and bands come from; `None`: there are none of these.
    pub signal_interval_s: Option<f64>,
}

/// Builds the table of a dataset. If the dataset is still being written, its present rows count.
///
/// # Errors
/// Those of reading, [`FeaturesError::NoRows`], [`FeaturesError::Casting`], [`FeaturesError::Twice`], [`FeaturesError::NoGroups`] and
/// [`FeaturesError::EmptyPart`] of splits.
pub fn features(reader: &DatasetReader, settings: &FeatureSettings) -> Result<Features, FeaturesError> {
    let info = &reader.manifest().study;
    let outline = DesignOutline::read(&info.study_text, &info.overrides, &info.study_name)?;
    let thresholds = Thresholds { dose_j: settings.dose_threshold_j, work_j: settings.work_j };
    let struck = StruckRows::read(reader, thresholds)?;
    let signals = SignalRows::read(reader)?;
    let mut reads = Reads::default();
    let [row, status] = [RowRecord::row.name, RowOutcome::status.name].map(|name| reads.place(name));
    let assignment = Assignment::of(reader, &outline, &mut reads)?;
    let mut keys = KeyReader::new(reader, &outline, &mut reads);
    let binders = Binders::of(reader, &outline, &mut reads);
    let mut planned = plan(reader, (&outline, &binders), settings, &mut reads);
    planned.add_signals(&signals);
    let mut fault = None;
    let (mut runs, mut done) = (0, 0);
    reader.visit(TableName::Runs, reads.names(), |cells| {
        let cell = |place: usize| cells.get(place).copied().flatten();
        let Some(Value::Count(row)) = cell(row) else { return };
        keys.push(row, cells, &binders);
        match assignment.castings(row, cells) {
            Ok(castings) => {
                for (casting, name) in info.castings.iter().enumerate() {
                    let (struck, heave) = (struck.of(row, casting), signals.of(row, casting));
                    let binder = binders.of_casting(casting, cells);
                    let binder = binder.as_deref();
                    planned.push(&View { cells, name, casting, castings: &castings, struck, heave, binder });
                }
            }
            Err(error) => fault = fault.take().or(Some(error)),
        }
        runs += 1;
        done += u64::from(cell(status) == Some(Value::Text(RowStatus::Done.name())));
    })?;
    match fault {
        Some(error) => Err(error),
        None if runs == 0 => Err(FeaturesError::NoRows),
        None => {
            let mut columns = planned.columns();
            // Behind the keys and the status.
            let place = columns.iter().position(|column| matches!(column.role, Role::Factor | Role::Target));
            let place = place.unwrap_or(columns.len());
            columns.splice(place..place, group_columns(reader, &keys.runs, settings)?);
            let mut columns = checked(columns)?;
            let derived = find(&columns);
            for Derived { column, from, .. } in &derived {
                let own = columns.iter_mut().find(|own| own.name == *column && own.derived_from.is_empty());
                own.into_iter().for_each(|own| own.derived_from.clone_from(from));
            }
            Ok(Features { columns, runs, done, derived, signal_interval_s: signals.interval_s })
        }
    }
}

/// The columns of groups and splits.
fn group_columns(
    reader: &DatasetReader,
    runs: &[RunKeys],
    settings: &FeatureSettings,
) -> Result<Vec<FeatureColumn>, FeaturesError> {
    let info = &reader.manifest().study;
    let spans = match (&info.row_groups, &settings.splits) {
        (Some(spans), _) => spans.as_slice(),
        (None, Some(_)) => return Err(FeaturesError::NoGroups),
        (None, None) => return Ok(Vec::new()),
    };
    let groups = Groups::of(runs, spans, &settings.group_by);
    let mut columns = groups.columns(info.castings.len());
    if let Some(splits) = &settings.splits {
        columns.push(splits.column(&groups, info.castings.len())?);
    }
    Ok(columns)
}

/// Reads the data from which the groups of runs follow.
struct KeyReader {
    /// Places of the factors among the cells.
    factors: Vec<usize>,
    /// Place of the factor that chooses the machine.
    machine: Option<usize>,
    runs: Vec<RunKeys>,
}

impl KeyReader {
    fn new<'a>(reader: &'a DatasetReader, outline: &DesignOutline, reads: &mut Reads<'a>) -> Self {
        let factors = reader.columns(TableName::Runs).iter().filter(|column| column.group == ColumnGroup::Factor);
        let driver = outline.driver(&["machine"]).and_then(|factor| factor_column(reader, &factor.name));
        Self {
            factors: factors.map(|column| reads.place(&column.name)).collect(),
            machine: driver.map(|column| reads.place(&column.name)),
            runs: Vec::new(),
        }
    }

    fn push(&mut self, row: u64, cells: &[Cell<'_>], binders: &Binders) {
        let cell = |place: usize| cells.get(place).copied().flatten();
        let values: Vec<Cell<'_>> = self.factors.iter().map(|place| cell(*place)).collect();
        let machine = self.machine.and_then(cell).map_or(String::new(), |name| name.to_string());
        self.runs.push(RunKeys { row, point: ValuesKey::of(&values), machine, binders: binders.of_run(cells) });
    }
}

/// The columns that the table is to have.
fn plan<'a>(
    reader: &'a DatasetReader,
    (outline, binders): (&DesignOutline, &Binders),
    settings: &FeatureSettings,
    reads: &mut Reads<'a>,
) -> Planned<'a> {
    let mut planned = Planned::new(reader, reads, settings);
    planned.add_run(reads, RowRecord::row.name, Role::Key);
    planned.add_casting();
    if binders.any() {
        planned.add_binder();
    }
    for name in [RowOutcome::status.name, RowOutcome::reason.name, RowOutcome::time_reached_s.name] {
        planned.add_run(reads, name, Role::Status);
    }
    planned.add_factors(reads, outline);
    for figure in FIGURES.iter().filter(|figure| figure.name != TIME_TO_WORK || settings.work_j.is_some()) {
        planned.add_figure(reads, figure);
    }
    planned.add_cores(reads);
    planned
}

/// Refuses two columns of one name, whatever their case.
fn checked(columns: Vec<FeatureColumn>) -> Result<Vec<FeatureColumn>, FeaturesError> {
    let mut names: Vec<String> = columns.iter().map(|column| column.name.to_ascii_lowercase()).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some([column, ..]) => Err(FeaturesError::Twice { column: column.clone() }),
        _ => Ok(columns),
    }
}
