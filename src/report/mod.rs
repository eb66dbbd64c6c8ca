//! Summary of a dataset as plain text: how the rows ended, the best rows, ranges of the outputs, where the tables are.

mod text;

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::dataset::{Cell, ColumnDescription, ColumnGroup, DatasetError, DatasetReader, TableName};

/// Column by which rows are ranked unless another is asked for: the work delivered to the castings over the whole run.
pub const DEFAULT_RANKING: &str = "delivered_work_j";

/// Figures shown beside the ranking for the best rows.
const BESIDE: [&str; 8] = [
    DEFAULT_RANKING,
    "total_first_impact_work_j",
    "total_first_impact_energy_j",
    "mean_periodic_energy_j",
    "mean_hit_frequency_hz",
    "least_percussion",
    "max_casting_point_velocity_m_s",
    "total_air_used_nl",
];
/// Outputs of single hammers and castings whose ranges over all hammers or castings are shown, with their titles.
const SUBJECT_RANGES: [(&str, &str); 10] = [
    ("first_impact_energy_j", "first-impact energy of a hammer"),
    ("first_impact_work_j", "work of a first impact on the casting"),
    ("first_impact_casting_peak_velocity_m_s", "casting velocity at a first impact"),
    ("periodic_energy_mean_j", "energy of a periodic blow"),
    ("periodic_work_mean_j", "work of a periodic blow on the casting"),
    ("hit_frequency_hz", "hit frequency of a hammer"),
    ("periodic_energy_mean_error_j", "standard error of that energy"),
    ("arm_rms_steady_m_s", "arm velocity, steady hammering (RMS)"),
    ("peak_velocity_m_s", "peak velocity of a casting (heave)"),
    ("peak_point_velocity_m_s", "peak velocity of a casting's points"),
];
/// Aggregates whose ranges over the rows are shown, with their titles.
const AGGREGATE_RANGES: [(&str, &str); 4] = [
    ("delivered_work_j", "work delivered in a row"),
    ("total_periodic_power_w", "impact power of a row"),
    ("total_air_used_nl", "air used in a row"),
    ("work_per_air_j_per_nl", "work per air in a row"),
];

/// What to report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReportSettings {
    /// Column of `runs` by which rows are ranked, largest first. Default [`DEFAULT_RANKING`].
    pub rank_by: String,
    /// Number of best rows. Default 5.
    pub best: usize,
}

impl Default for ReportSettings {
    fn default() -> Self {
        Self { rank_by: DEFAULT_RANKING.to_owned(), best: 5 }
    }
}

/// A value as text, with its column's name and unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of the column; of a factor, its name in the study.
    pub name: String,
    /// Value.
    pub value: Value,
    /// Unit.
    pub unit: String,
}

/// A value of a figure.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Not available.
    None,
    /// A floating-point number.
    Number(f64),
    /// A whole number.
    Whole(i128),
    /// A name.
    Text(String),
}

/// One of the best rows.
#[derive(Debug, Clone, PartialEq)]
pub struct BestRow {
    /// Index of the row in the design.
    pub row: u64,
    /// Value of the ranking column.
    pub rank: f64,
    /// Other outputs of the row.
    pub outputs: Vec<Figure>,
    /// Factors of the row.
    pub factors: Vec<Figure>,
}

/// Range of an output over the rows that are done.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// What it is.
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

/// Summary of a dataset; its `Display` is the text.
#[derive(Debug, Clone, PartialEq)]
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
    /// Number of rows by reason, of the rows that are not done.
    pub reasons: BTreeMap<String, u64>,
    /// Number of blows.
    pub blows: u64,
    /// Column of the ranking.
    pub ranking: ColumnDescription,
    /// Best rows, best first; equal rows by index.
    pub best: Vec<BestRow>,
    /// Ranges of outputs.
    pub ranges: Vec<Range>,
    /// Row with the largest absolute energy residual, and that residual.
    pub worst_residual: Option<(u64, f64)>,
    /// Damaged files, in words.
    pub damage: Vec<String>,
}

/// Reads a dataset and summarises it. Memory is bounded, whatever the number of rows.
///
/// # Errors
/// [`DatasetError::UnknownColumn`] or [`DatasetError::NotANumber`] if rows cannot be ranked by the column asked for;
/// those of reading. Damaged files that can still be read are no error: they are named in the report.
pub fn summarise(reader: &DatasetReader, settings: &ReportSettings) -> Result<Report, DatasetError> {
    let ranking = reader.column(TableName::Runs, &settings.rank_by)?.clone();
    if ranking.unit.is_empty() {
        return Err(DatasetError::NotANumber { table: TableName::Runs.folder(), column: ranking.name });
    }
    let study = &reader.manifest().study;
    let mut report = Report {
        folder: reader.folder().to_owned(),
        study_name: study.study_name.clone(),
        study_hash: study.study_hash.clone(),
        seed: study.seed,
        program_version: study.program_version.clone(),
        rows: study.rows,
        statuses: BTreeMap::new(),
        percussions: BTreeMap::new(),
        reasons: BTreeMap::new(),
        blows: reader.parts(TableName::Blows).iter().map(|part| part.records).sum(),
        ranking,
        best: Vec::new(),
        ranges: Vec::new(),
        worst_residual: None,
        damage: reader.damage().iter().map(ToString::to_string).collect(),
    };
    count_statuses(reader, &mut report)?;
    report.best = best_rows(reader, settings)?;
    report.ranges = ranges(reader)?;
    judge_residuals(reader, &mut report)?;
    Ok(report)
}

fn count_statuses(reader: &DatasetReader, report: &mut Report) -> Result<(), DatasetError> {
    reader.visit(TableName::Runs, &["status", "reason", "least_percussion"], |cells| {
        if let [Cell::Text(status), Cell::Text(reason), percussion] = cells {
            *report.statuses.entry((*status).to_owned()).or_default() += 1;
            if let ("done", Cell::Text(percussion)) = (*status, percussion) {
                *report.percussions.entry((*percussion).to_owned()).or_default() += 1;
            }
            if !reason.is_empty() {
                count_reason(&mut report.reasons, reason);
            }
        }
    })
}

/// Reasons may carry figures of their row: only so many different ones are told apart, the others share an entry.
fn count_reason(reasons: &mut BTreeMap<String, u64>, reason: &str) {
    const MOST: usize = 100;
    let key = if reasons.len() < MOST || reasons.contains_key(reason) {
        reason
    } else {
        "other reasons (see column `reason`)"
    };
    *reasons.entry(key.to_owned()).or_default() += 1;
}

fn best_rows(reader: &DatasetReader, settings: &ReportSettings) -> Result<Vec<BestRow>, DatasetError> {
    let columns = reader.columns(TableName::Runs);
    let beside = BESIDE.iter().filter(|name| **name != settings.rank_by);
    let outputs: Vec<&ColumnDescription> =
        beside.filter_map(|name| columns.iter().find(|column| column.name == **name)).collect();
    let factors: Vec<&ColumnDescription> =
        columns.iter().filter(|column| column.group == ColumnGroup::Factor).collect();
    let mut names = vec!["row", "status", settings.rank_by.as_str()];
    names.extend(outputs.iter().chain(&factors).map(|column| column.name.as_str()));

    let mut best: Vec<BestRow> = Vec::new();
    reader.visit(TableName::Runs, &names, |cells| {
        let [Cell::Count(row), Cell::Text("done"), rank, others @ ..] = cells else {
            return;
        };
        let Some(rank) = rank.number().filter(|rank| !rank.is_nan()) else {
            return;
        };
        // Rows come in order: behind its equals, a later row stays behind.
        let place = best.partition_point(|other| other.rank >= rank);
        if place >= settings.best {
            return;
        }
        let (output_cells, factor_cells) = others.split_at(outputs.len().min(others.len()));
        best.insert(
            place,
            BestRow {
                row: *row,
                rank,
                outputs: figures(&outputs, output_cells),
                factors: figures(&factors, factor_cells),
            },
        );
        best.truncate(settings.best);
    })?;
    Ok(best)
}

fn figures(columns: &[&ColumnDescription], cells: &[Cell<'_>]) -> Vec<Figure> {
    let figure = |(column, cell): (&&ColumnDescription, &Cell<'_>)| Figure {
        name: match column.group {
            ColumnGroup::Factor => column.subject.clone().unwrap_or_else(|| column.name.clone()),
            _ => column.name.clone(),
        },
        value: match cell {
            Cell::Null => Value::None,
            Cell::Real(value) => Value::Number(*value),
            Cell::Count(value) => Value::Whole((*value).into()),
            Cell::Integer(value) => Value::Whole((*value).into()),
            Cell::Text(text) => Value::Text((*text).to_owned()),
        },
        unit: column.unit.clone(),
    };
    columns.iter().zip(cells).map(figure).collect()
}

/// Ranges over the rows that are done; outputs without any value are left out.
fn ranges(reader: &DatasetReader) -> Result<Vec<Range>, DatasetError> {
    let columns = reader.columns(TableName::Runs);
    let is_subject = |column: &&ColumnDescription| matches!(column.group, ColumnGroup::Hammer | ColumnGroup::Casting);
    let of_subjects = SUBJECT_RANGES.iter().map(|(quantity, title)| {
        let of_quantity = columns.iter().filter(is_subject).filter(|c| c.quantity == *quantity);
        (*title, of_quantity.collect::<Vec<_>>())
    });
    let of_aggregates = AGGREGATE_RANGES
        .iter()
        .map(|(name, title)| (*title, columns.iter().filter(|column| column.name == *name).collect()));
    let mut ranges = Vec::new();
    let mut names = vec!["status"];
    // For each column read, the range that it belongs to.
    let mut owners = Vec::new();
    for (title, members) in of_subjects.chain(of_aggregates) {
        owners.extend(members.iter().map(|_| ranges.len()));
        names.extend(members.iter().map(|column| column.name.as_str()));
        ranges.push(Range {
            title: title.to_owned(),
            unit: members.first().map(|column| column.unit.clone()).unwrap_or_default(),
            count: 0,
            min: f64::INFINITY,
            mean: 0.0,
            max: f64::NEG_INFINITY,
        });
    }
    reader.visit(TableName::Runs, &names, |cells| {
        let [Cell::Text("done"), values @ ..] = cells else {
            return;
        };
        for (owner, cell) in owners.iter().zip(values) {
            if let (Some(range), Some(value)) = (ranges.get_mut(*owner), cell.number()) {
                range.add(value);
            }
        }
    })?;
    ranges.retain(|range| range.count > 0);
    Ok(ranges)
}

impl Range {
    fn add(&mut self, value: f64) {
        self.count += 1;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        self.mean += (value - self.mean) / self.count as f64;
    }
}

fn judge_residuals(reader: &DatasetReader, report: &mut Report) -> Result<(), DatasetError> {
    reader.visit(TableName::Runs, &["row", "energy_residual"], |cells| {
        let [Cell::Count(row), Cell::Real(residual)] = cells else {
            return;
        };
        // A residual that is no number counts as the worst.
        let size = |value: f64| {
            if value.is_nan() { f64::INFINITY } else { value.abs() }
        };
        if report.worst_residual.is_none_or(|(_, worst)| size(*residual) > size(worst)) {
            report.worst_residual = Some((*row, *residual));
        }
    })
}
