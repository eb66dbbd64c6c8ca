//! Contents of a report, gathered in one pass over the dataset.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use super::numbers::number;
use super::numerical::{NumericalTwins, numerical_twins};
use super::precision::{Precision, Precisions, RowTime};
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetReader, RowRecord, TableName};
use decore_model::metrics::{Aggregates, CastingMetrics, CoreTotals, HammerMetrics, RunTotals, Warning};
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};

/// Column by which rows are ranked by default: the energy that strikes give to the castings, which hardly depends on the
/// damping of the fixtures.
pub const DEFAULT_RANKING: &str = RunTotals::strike_energy_j.name;

/// Figures next to the ranking for the best rows.
const BESIDE: [&str; 10] = [
    DEFAULT_RANKING,
    RunTotals::delivered_work_j.name,
    Aggregates::total_fixture_damper_loss_j.name,
    Aggregates::total_first_impact_energy_j.name,
    Aggregates::mean_periodic_energy_j.name,
    Aggregates::mean_hit_frequency_hz.name,
    Aggregates::least_percussion.name,
    CoreTotals::least_core_pseudo_velocity_98hz_10khz_m_s.name,
    Aggregates::max_casting_point_velocity_m_s.name,
    Aggregates::total_air_used_nl.name,
];
/// Outputs of single hammers and castings whose ranges over all hammers or castings are shown, with their titles.
const SUBJECT_RANGES: [(&str, &str); 10] = [
    (HammerMetrics::first_impact_energy_j.name, "first-impact energy of a hammer"),
    (HammerMetrics::first_impact_work_j.name, "work of a first impact on the casting"),
    (HammerMetrics::first_impact_casting_peak_velocity_m_s.name, "casting velocity at a first impact"),
    (HammerMetrics::periodic_energy_mean_j.name, "energy of a periodic blow"),
    (HammerMetrics::periodic_work_mean_j.name, "work of a periodic blow on the casting"),
    (HammerMetrics::hit_frequency_hz.name, "hit frequency of a hammer"),
    (HammerMetrics::periodic_energy_mean_error_j.name, "standard error of a blow's mean energy"),
    (HammerMetrics::arm_rms_steady_m_s.name, "arm velocity, steady hammering (RMS)"),
    (CastingMetrics::peak_velocity_m_s.name, "peak velocity of a casting (heave)"),
    (CastingMetrics::peak_point_velocity_m_s.name, "peak velocity of a casting's points"),
];
/// Outputs of whole rows whose ranges over the rows are shown, with their titles.
const ROW_RANGES: [(&str, &str); 7] = [
    (RunTotals::strike_energy_j.name, "energy given by the strikes of a row"),
    (RunTotals::delivered_work_j.name, "work delivered in a row"),
    (CoreTotals::least_core_pseudo_velocity_98hz_10khz_m_s.name, "shock at the core point that gets least"),
    (Aggregates::total_fixture_damper_loss_j.name, "part of it lost in fixture dampers"),
    (Aggregates::total_periodic_power_w.name, "impact power of a row"),
    (Aggregates::total_air_used_nl.name, "air used in a row"),
    (Aggregates::work_per_air_j_per_nl.name, "work per air in a row"),
];
/// Columns of every report, before the columns of the study.
const ALWAYS: [&str; 6] = [
    RowRecord::row.name,
    RowOutcome::status.name,
    RowOutcome::reason.name,
    RowOutcome::time_reached_s.name,
    Aggregates::least_percussion.name,
    RunTotals::energy_residual.name,
];
/// Largest number of different reasons: they may contain figures of their row.
const MOST_REASONS: usize = 100;

/// Settings of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportSettings {
    /// Column of `runs` by which rows are ranked, the better end first, as each output declares it; with `-` before, the other end first.
    /// Default [`DEFAULT_RANKING`].
    pub rank_by: String,
    /// Number of best rows. Default 5.
    pub best: usize,
    /// Relative standard error for which durations are stated, positive. Default 0.01.
    pub wanted_error: f64,
}

/// Default relative standard error of the stated durations.
pub const WANTED_ERROR: f64 = 0.01;

impl Default for ReportSettings {
    fn default() -> Self {
        Self { rank_by: DEFAULT_RANKING.to_owned(), best: 5, wanted_error: WANTED_ERROR }
    }
}

impl ReportSettings {
    /// Column of the ranking.
    pub fn ranking(&self) -> &str {
        self.rank_by.strip_prefix('-').unwrap_or(&self.rank_by)
    }
}

/// A value as text, with its column's name and unit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NamedValue {
    /// Name of the column; of a factor, its name in the study.
    pub name: String,
    /// Value; `None`: not available.
    pub value: Option<Value>,
    /// Unit.
    pub unit: String,
}

/// One of the best rows.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BestRow {
    /// Index of the row in the design.
    pub row: u64,
    /// Value of the ranking column.
    pub rank: f64,
    /// Other outputs of the row.
    pub outputs: Vec<NamedValue>,
    /// Factors of the row.
    pub factors: Vec<NamedValue>,
}

/// Range of an output over the rows that are done.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Range {
    /// Title of the section.
    pub title: String,
    /// Unit.
    pub unit: String,
    /// Number of values.
    pub count: u64,
    /// Least value.
    pub min: f64,
    /// Mean value.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
}

/// The row whose energies balance worst.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct WorstResidual {
    /// Index of the row in the design.
    pub row: u64,
    /// Energy residual over the largest energy.
    pub energy_residual: f64,
}

/// Least and largest of some values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ValueSpan {
    pub low: f64,
    pub high: f64,
}

impl Default for ValueSpan {
    /// Of no values.
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl ValueSpan {
    fn widen(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }
}

/// Spans over the rows that are done, for charts.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Spans {
    /// Of the ranking.
    pub ranking: ValueSpan,
    /// Of factors that are numbers, by column.
    pub factors: BTreeMap<String, ValueSpan>,
}

/// Summary of a dataset; its `Display` is the text.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// The dataset's folder.
    pub folder: PathBuf,
    /// Name of the study.
    pub study_name: String,
    /// Hash of the study.
    pub study_hash: String,
    /// Seed of the design.
    pub seed: u64,
    /// Version of the program that wrote the dataset.
    pub program_version: String,
    /// Rows of the design.
    pub rows: u64,
    /// Number of rows by status.
    pub statuses: BTreeMap<String, u64>,
    /// Number of rows that are done by the least sound percussion of their hammers.
    pub percussions: BTreeMap<String, u64>,
    /// Number of rows that are done by the reasons to doubt them.
    pub warnings: BTreeMap<&'static str, u64>,
    /// Number of rows by reason, of the rows that are not done.
    pub reasons: BTreeMap<String, u64>,
    /// Number of blows.
    pub blows: u64,
    /// Names of the tables, each a folder.
    pub tables: Vec<&'static str>,
    /// Column of the ranking.
    pub ranking: ColumnDescription,
    /// Whether the least values come first in the ranking; the largest otherwise.
    pub least_first: bool,
    /// Best rows, best first; equal rows by index.
    pub best: Vec<BestRow>,
    /// Ranges of outputs.
    pub ranges: Vec<Range>,
    /// Relative standard error for which durations are stated.
    pub wanted_error: f64,
    /// Outputs of hammers with standard errors: how many rows miss the wanted error, and the duration that they need.
    pub precision: Vec<Precision>,
    /// Row with the largest absolute energy residual.
    pub worst_residual: Option<WorstResidual>,
    /// Numerical errors of the main outputs; null if no row has a numerical twin.
    pub numerical_twins: Option<NumericalTwins>,
    #[serde(skip)]
    pub(super) spans: Spans,
}

/// Reads a dataset and summarises it. Memory is bounded, whatever the number of rows.
///
/// # Errors
/// [`DatasetError::UnknownColumn`] or [`DatasetError::NotANumber`] if rows cannot be ranked by the requested column;
/// those of reading, [`DatasetError::Damaged`] among them.
pub fn summarise(reader: &DatasetReader, settings: &ReportSettings) -> Result<Report, DatasetError> {
    let ranking = reader.column(TableName::Runs, settings.ranking())?.clone();
    if ranking.unit.is_empty() {
        return Err(DatasetError::NotANumber { table: TableName::Runs.folder(), column: ranking.name });
    }
    let study = &reader.manifest().study;
    let report = Report {
        folder: reader.folder().to_owned(),
        study_name: study.study_name.clone(),
        study_hash: study.study_hash.clone(),
        seed: study.seed,
        program_version: study.program_version.clone(),
        rows: study.rows,
        statuses: BTreeMap::new(),
        percussions: BTreeMap::new(),
        warnings: BTreeMap::new(),
        reasons: BTreeMap::new(),
        blows: reader.parts(TableName::Blows).iter().map(|part| part.records).sum(),
        tables: reader.tables().map(TableName::folder).collect(),
        least_first: ranking.less != settings.rank_by.starts_with('-'),
        ranking,
        best: Vec::new(),
        ranges: Vec::new(),
        wanted_error: settings.wanted_error,
        precision: Vec::new(),
        worst_residual: None,
        numerical_twins: numerical_twins(reader)?,
        spans: Spans::default(),
    };
    let mut gatherer = Gatherer::new(reader.columns(TableName::Runs), settings, report);
    reader.visit(TableName::Runs, &gatherer.names(), |cells| gatherer.row(cells))?;
    Ok(gatherer.finish())
}

/// The outputs whose ranges are shown.
pub(super) struct Ranged<'a> {
    /// Title and unit of each.
    pub titles: Vec<(String, String)>,
    /// The columns that go into them, each with its output's place.
    pub columns: Vec<(usize, &'a ColumnDescription)>,
}

/// Outputs of the table whose ranges are printed.
pub(super) fn ranged(columns: &[ColumnDescription]) -> Ranged<'_> {
    let named = |name: &str| columns.iter().find(|column| column.name == name);
    let of_subjects = |quantity: &str| {
        let is_subject = |column: &ColumnDescription| {
            matches!(column.group, ColumnGroup::Hammer | ColumnGroup::Casting) && column.quantity == quantity
        };
        columns.iter().filter(|column| is_subject(column)).collect::<Vec<_>>()
    };
    let subjects = SUBJECT_RANGES.iter().map(|(quantity, title)| (of_subjects(quantity), title));
    let rows = ROW_RANGES.iter().map(|(name, title)| (named(name).into_iter().collect(), title));
    let mut ranged = Ranged { titles: Vec::new(), columns: Vec::new() };
    for (place, (members, title)) in subjects.chain(rows).enumerate() {
        let unit = members.first().map(|column| column.unit.clone()).unwrap_or_default();
        ranged.titles.push(((*title).to_owned(), unit));
        ranged.columns.extend(members.into_iter().map(|column| (place, column)));
    }
    ranged
}

/// Gathers a report row by row.
struct Gatherer<'a> {
    settings: &'a ReportSettings,
    report: Report,
    outputs: Vec<&'a ColumnDescription>,
    factors: Vec<&'a ColumnDescription>,
    /// Columns that go into ranges, each with its range's place.
    ranged: Vec<(usize, &'a ColumnDescription)>,
    /// Column of the warnings; none in datasets of older versions.
    warnings: Option<&'a ColumnDescription>,
    precisions: Precisions<'a>,
    /// One per factor.
    factor_spans: Vec<ValueSpan>,
}

impl<'a> Gatherer<'a> {
    fn new(columns: &'a [ColumnDescription], settings: &'a ReportSettings, mut report: Report) -> Self {
        let named = |name: &str| columns.iter().find(|column| column.name == name);
        let Ranged { titles, columns: ranged } = ranged(columns);
        report.ranges.extend(titles.into_iter().map(|(title, unit)| Range::empty(title, unit)));
        let factors: Vec<_> = columns.iter().filter(|column| column.group == ColumnGroup::Factor).collect();
        Self {
            outputs: BESIDE.iter().filter(|name| **name != settings.ranking()).filter_map(|name| named(name)).collect(),
            precisions: Precisions::of(columns, settings.wanted_error),
            factor_spans: vec![ValueSpan::default(); factors.len()],
            warnings: named(RunTotals::warnings.name),
            factors,
            settings,
            report,
            ranged,
        }
    }

    /// Names of the columns, in the order in which [`Gatherer::row`] takes them.
    fn names(&self) -> Vec<&'a str> {
        let ranged = self.ranged.iter().map(|(_, column)| *column);
        let columns = self.outputs.iter().copied().chain(self.factors.iter().copied()).chain(ranged);
        let columns = columns.chain(self.warnings);
        let fixed = ALWAYS.into_iter().chain([self.settings.ranking()]);
        fixed.chain(columns.map(|column| column.name.as_str())).chain(self.precisions.names()).collect()
    }

    fn row(&mut self, cells: &[Cell<'_>]) {
        let [Some(Value::Count(row)), Some(Value::Text(status)), reason, time_s, rest @ ..] = cells else {
            return;
        };
        let [percussion, residual, rank, others @ ..] = rest else {
            return;
        };
        *self.report.statuses.entry((*status).to_owned()).or_default() += 1;
        if let Some(Value::Text(reason)) = reason.filter(|reason| *reason != Value::Text("")) {
            self.count_reason(reason);
        }
        if let Some(Value::Real(residual)) = residual {
            self.judge_residual(*row, *residual);
        }
        if *status != RowStatus::Done.name() {
            return;
        }
        if let Some(Value::Text(percussion)) = percussion {
            *self.report.percussions.entry((*percussion).to_owned()).or_default() += 1;
        }
        let (beside, ranged) = others.split_at((self.outputs.len() + self.factors.len()).min(others.len()));
        if let Some(rank) = rank.and_then(|rank| rank.number()).filter(|rank| !rank.is_nan()) {
            self.rank(*row, rank, beside);
        }
        self.widen(rank, beside);
        let (ranged, rest) = ranged.split_at(self.ranged.len().min(ranged.len()));
        let (warnings, erring) = rest.split_at(self.warnings.iter().len().min(rest.len()));
        let duration_s = number(time_s).unwrap_or_default();
        self.precisions.row(RowTime { row: *row, duration_s }, erring);
        for ((place, _), cell) in self.ranged.iter().zip(ranged) {
            if let (Some(range), Some(value)) =
                (self.report.ranges.get_mut(*place), cell.and_then(|cell| cell.number()))
            {
                range.add(value);
            }
        }
        if let [Some(Value::Text(text))] = warnings {
            Warning::of(text).for_each(|one| *self.report.warnings.entry(one.name()).or_default() += 1);
        }
    }

    /// Counts a reason. Beyond a number of different reasons, others share an entry.
    fn count_reason(&mut self, reason: &str) {
        let reasons = &mut self.report.reasons;
        let known = reasons.len() < MOST_REASONS || reasons.contains_key(reason);
        let key = if known { reason } else { "other reasons (see column `reason`)" };
        *reasons.entry(key.to_owned()).or_default() += 1;
    }

    fn judge_residual(&mut self, row: u64, residual: f64) {
        // A residual that is not a number counts as the worst.
        let size = |value: f64| if value.is_nan() { f64::INFINITY } else { value.abs() };
        if self.report.worst_residual.is_none_or(|worst| size(residual) > size(worst.energy_residual)) {
            self.report.worst_residual = Some(WorstResidual { row, energy_residual: residual });
        }
    }

    /// Spans of the ranking and the factors; infinite values have no place in a chart.
    fn widen(&mut self, rank: &Cell<'_>, beside: &[Cell<'_>]) {
        number(rank).into_iter().for_each(|rank| self.report.spans.ranking.widen(rank));
        let factors = beside.iter().skip(self.outputs.len());
        for (span, cell) in self.factor_spans.iter_mut().zip(factors) {
            number(cell).into_iter().for_each(|value| span.widen(value));
        }
    }

    fn rank(&mut self, row: u64, rank: f64, beside: &[Cell<'_>]) {
        let best = &mut self.report.best;
        // Rows come in order: behind its equals, a later row stays behind.
        let least_first = self.report.least_first;
        let place = best.partition_point(|other| if least_first { other.rank <= rank } else { other.rank >= rank });
        if place < self.settings.best {
            let (outputs, factors) = beside.split_at(self.outputs.len().min(beside.len()));
            let (outputs, factors) = (figures(&self.outputs, outputs), figures(&self.factors, factors));
            best.insert(place, BestRow { row, rank, outputs, factors });
            best.truncate(self.settings.best);
        }
    }

    /// The report; outputs without any value have no range.
    fn finish(mut self) -> Report {
        self.report.ranges.retain(|range| range.count > 0);
        let names = self.factors.iter().map(|column| column.name.clone());
        self.report.spans.factors = names.zip(self.factor_spans).collect();
        self.report.precision = self.precisions.finish();
        self.report
    }
}

fn figures(columns: &[&ColumnDescription], cells: &[Cell<'_>]) -> Vec<NamedValue> {
    let figure = |(column, cell): (&&ColumnDescription, &Cell<'_>)| NamedValue {
        name: match column.group {
            ColumnGroup::Factor => column.subject.clone().unwrap_or_else(|| column.name.clone()),
            _ => column.name.clone(),
        },
        value: cell.map(|value| value.owned()),
        unit: column.unit.clone(),
    };
    columns.iter().zip(cells).map(figure).collect()
}

impl Range {
    fn empty(title: String, unit: String) -> Self {
        Self { title, unit, count: 0, min: f64::INFINITY, mean: 0.0, max: f64::NEG_INFINITY }
    }

    fn add(&mut self, value: f64) {
        self.count += 1;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        self.mean += (value - self.mean) / self.count as f64;
    }
}
