//! Page of a dataset, drawn by `src/assets/pages/report.js`.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::answer::{Answered, answered};
use super::blocks::{Scripts, page};
use super::error::PageError;
use super::knowledge::{self, Known, Models};
use super::rows::{KeptRows, columns, is_number};
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetError, DatasetInfo, DatasetReader, TableName};
use decore_lab::report::{ReportSettings, summarise};
use decore_lab::sensitivity::Sensitivity;
use decore_model::metrics::{Aggregates, CoreTotals, RunTotals};
use decore_model::run::RowOutcome;
use decore_quantity::{Cell, Kind, Value};
use decore_study::{CheckedStudy, DesignOutline};

/// Rows that a page carries; of more some are chosen.
pub const MOST_ROWS: u64 = 100_000;
/// Numbers up to which a page carries all digits; beyond, single precision.
const MOST_EXACT: u64 = 250_000;
/// Largest number of different texts of a column.
const MOST_NAMES: usize = 200;
/// Text for all texts beyond [`MOST_NAMES`].
const OTHERS: &str = "others";
/// Outputs that are shown first, in this order, and whether small values are the good ones.
const MAIN: [(&str, bool); 10] = [
    (RunTotals::strike_energy_j.name, false),
    (RunTotals::delivered_work_j.name, false),
    (Aggregates::total_first_impact_energy_j.name, false),
    (Aggregates::mean_periodic_energy_j.name, false),
    (Aggregates::mean_hit_frequency_hz.name, false),
    (CoreTotals::least_core_pseudo_velocity_98hz_10khz_m_s.name, false),
    (Aggregates::max_casting_point_velocity_m_s.name, true),
    (Aggregates::max_arm_rms_steady_m_s.name, true),
    (Aggregates::total_air_used_nl.name, true),
    (Aggregates::work_per_air_j_per_nl.name, false),
];

/// Metadata of a page.
#[derive(Serialize)]
struct Meta<'a> {
    title: &'a str,
    study_hash: &'a str,
    seed: u64,
    version: &'a str,
    rows: u64,
    rows_there: u64,
    rows_shown: usize,
    blows: u64,
    worst_residual: Option<f64>,
    statuses: &'a BTreeMap<String, u64>,
    reasons: Vec<(String, u64)>,
    notes: Vec<String>,
    overrides: &'a [String],
    inputs: Vec<(&'a String, &'a String)>,
    study_text: &'a str,
    columns: Vec<Stored<'a>>,
    sensitivity: Known<Sensitivity>,
    models: Known<Models>,
    answer: Option<Known<Answered>>,
}

/// A column of the data block: where it is, and how its bytes are read.
#[derive(Serialize)]
struct Stored<'a> {
    name: &'a str,
    subject: Option<&'a str>,
    group: ColumnGroup,
    unit: &'a str,
    text: &'a str,
    /// Place among the outputs shown first; -1: none.
    rank: i64,
    smaller: bool,
    whole: bool,
    /// Whether its values are spaced by their logarithms.
    logarithmic: bool,
    form: &'static str,
    offset: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    names: Option<Vec<String>>,
}

/// Contents of a page.
#[derive(Clone, Copy)]
pub struct PageOf<'a> {
    /// The dataset.
    pub reader: &'a DatasetReader,
    /// Study with the goal that the page answers, or the reason why it cannot be read; empty if no answer is wanted.
    pub study: Result<&'a CheckedStudy, &'a str>,
}

/// A dataset as a page, whole in one file. Where its study has a goal, the page begins with the answer.
///
/// A table of more than `most_rows` rows is thinned to about as many: rows whose index has a small hash, and the rows with the
/// extremes of every column of numbers. Default [`MOST_ROWS`].
///
/// # Errors
/// [`PageError::Dataset`] if the dataset cannot be read.
pub fn dataset_page(of: PageOf<'_>, settings: &ReportSettings, most_rows: u64) -> Result<String, PageError> {
    let PageOf { reader, study: asked } = of;
    let report = summarise(reader, settings)?;
    let study = &reader.manifest().study;
    let rows_there: u64 = report.statuses.values().sum();
    let all = reader.columns(TableName::Runs);
    let main = MAIN.map(|(name, _)| name);
    let chosen = columns(all, rows_there.min(most_rows), &main);
    let numbers: Vec<&ColumnDescription> = chosen.iter().copied().filter(|column| is_number(column)).collect();
    let kept = KeptRows::of(reader, &numbers, most_rows)?;
    let values = gather(reader, &chosen, kept.as_ref())?;
    let rows_shown = values.first().map_or(0, Values::len);
    let is_exact = (rows_shown * numbers.len()) as u64 <= MOST_EXACT;
    let mut data = Vec::new();
    let logarithmic = logarithmic(study);
    let mut stored: Vec<Stored<'_>> =
        chosen.iter().zip(values).map(|(column, values)| store(column, values, is_exact, &mut data)).collect();
    for column in &mut stored {
        column.logarithmic = column.subject.is_some_and(|name| logarithmic.contains(name));
    }
    let models = knowledge::models(reader, rows_there, &mut data);
    let answer = answered(reader, asked, rows_there, &mut data);
    let meta = Meta {
        title: &report.study_name,
        study_hash: &report.study_hash,
        seed: report.seed,
        version: &report.program_version,
        rows: report.rows,
        rows_there,
        rows_shown,
        blows: report.blows,
        worst_residual: report.worst_residual.map(|worst| worst.energy_residual.abs()),
        statuses: &report.statuses,
        reasons: reasons(&report.reasons),
        notes: notes(rows_there, rows_shown, is_exact, all.len() - chosen.len()),
        overrides: &study.overrides,
        inputs: study.inputs.iter().collect(),
        study_text: &study.study_text,
        columns: stored,
        sensitivity: knowledge::sensitivity(reader, rows_there),
        models,
        answer,
    };
    Ok(page(&report.study_name, Scripts::Dataset, &meta, &data)?)
}

/// Names of the factors that the study spaces by their logarithms.
fn logarithmic(study: &DatasetInfo) -> BTreeSet<String> {
    let outline = DesignOutline::read(&study.study_text, &study.overrides, &study.study_name);
    let factors = outline.map_or_else(|_| Vec::new(), |outline| outline.factors);
    factors.into_iter().filter(|factor| factor.logarithmic).map(|factor| factor.name).collect()
}

/// Returns notes on the page's data.
fn notes(rows: u64, shown: usize, is_exact: bool, left_out: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if rows > shown as u64 {
        notes.push(format!(
            "The page shows {shown} of {rows} rows: a random sample, and the rows with the 20 smallest and 20 largest \
             values of each column. The figures above include all rows."
        ));
    }
    if !is_exact {
        notes.push("Numbers have seven digits here (single precision); the tables of the dataset have all.".to_owned());
    }
    if left_out > 0 {
        notes.push(format!("{left_out} columns of the table found no room here: see the tables of the dataset."));
    }
    notes
}

/// The values of a column in the rows that are kept.
enum Values {
    /// NaN: none.
    Numbers(Vec<f64>),
    /// Codes into names, in the order in which they came.
    Texts { codes: Vec<u8>, names: Vec<String>, places: BTreeMap<String, u8> },
}

impl Values {
    fn of(column: &ColumnDescription) -> Self {
        match column.kind {
            Kind::Text | Kind::Category => {
                Self::Texts { codes: Vec::new(), names: Vec::new(), places: BTreeMap::new() }
            }
            Kind::Real | Kind::Count | Kind::Integer => Self::Numbers(Vec::new()),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Texts { codes, .. } => codes.len(),
        }
    }

    fn push(&mut self, cell: Cell<'_>, is_reason: bool) {
        match self {
            Self::Numbers(values) => values.push(cell.and_then(|value| value.number()).unwrap_or(f64::NAN)),
            Self::Texts { codes, names, places } => {
                let Some(Value::Text(text)) = cell.filter(|cell| *cell != Value::Text("")) else {
                    return codes.push(u8::MAX);
                };
                let text = if is_reason { without_figures(text) } else { text.to_owned() };
                let text =
                    if names.len() < MOST_NAMES || places.contains_key(&text) { text } else { OTHERS.to_owned() };
                let code = *places.entry(text).or_insert_with_key(|text| {
                    names.push(text.clone());
                    (names.len() - 1) as u8
                });
                codes.push(code);
            }
        }
    }
}

fn gather(
    reader: &DatasetReader,
    columns: &[&ColumnDescription],
    kept: Option<&KeptRows>,
) -> Result<Vec<Values>, DatasetError> {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    let is_reason: Vec<bool> = names.iter().map(|name| *name == RowOutcome::reason.name).collect();
    let mut values: Vec<Values> = columns.iter().map(|column| Values::of(column)).collect();
    reader.visit(TableName::Runs, &names, |cells| {
        // The index of the row is the first column of every table.
        let Some(Some(Value::Count(row))) = cells.first() else { return };
        if kept.is_some_and(|kept| !kept.has(*row)) {
            return;
        }
        for ((values, cell), is_reason) in values.iter_mut().zip(cells).zip(&is_reason) {
            values.push(*cell, *is_reason);
        }
    })?;
    Ok(values)
}

/// Appends a column to the data block, at a multiple of eight bytes.
fn store<'a>(column: &'a ColumnDescription, values: Values, is_exact: bool, data: &mut Vec<u8>) -> Stored<'a> {
    data.resize(data.len().next_multiple_of(8), 0);
    let offset = data.len();
    let (form, names) = match values {
        Values::Texts { codes, names, .. } => {
            data.extend(codes);
            ("u8", Some(names))
        }
        // Indices of rows have more digits than single precision.
        Values::Numbers(values) if is_exact || column.group == ColumnGroup::Row => {
            data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            ("f64", None)
        }
        Values::Numbers(values) => {
            data.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
            ("f32", None)
        }
    };
    let main = MAIN.iter().position(|(name, _)| *name == column.name);
    Stored {
        name: &column.name,
        subject: column.subject.as_deref(),
        group: column.group,
        unit: &column.unit,
        text: &column.description,
        rank: main.map_or(-1, |place| place as i64),
        smaller: main.is_some_and(|place| MAIN[place].1),
        logarithmic: false,
        whole: matches!(column.kind, Kind::Count | Kind::Integer),
        form,
        offset,
        names,
    }
}

/// Reasons without the figures of single rows, most frequent first.
fn reasons(counts: &BTreeMap<String, u64>) -> Vec<(String, u64)> {
    let mut merged: BTreeMap<String, u64> = BTreeMap::new();
    for (reason, count) in counts {
        *merged.entry(without_figures(reason)).or_default() += count;
    }
    let mut reasons: Vec<(String, u64)> = merged.into_iter().collect();
    reasons.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    reasons
}

/// A text whose numbers stand as an ellipsis: rows that fail alike have one reason.
fn without_figures(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut in_number = false;
    for c in text.chars() {
        let goes_on = in_number && matches!(c, '.' | 'e' | '-' | '+');
        if c.is_ascii_digit() || goes_on {
            if !in_number {
                plain.push('…');
            }
            in_number = true;
        } else {
            in_number = false;
            plain.push(c);
        }
    }
    plain
}
