//! The one table of columns: name, type, unit, description and getter of everything that a dataset holds.
//!
//! The writer, the reader, the data dictionary and the documents derive from what is listed here.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::metrics::{
    Blow, CastingMetrics, HammerMetrics, Quantity, QuantityKind, QuantityValue, RunMetrics, RunTotals, Scatter,
    ScatterOf,
};
use crate::run::RowStatus;

use super::aggregates::AGGREGATES;
use super::info::{FactorKind, FactorValue};
use super::{DatasetError, DatasetInfo, RowRecord};

/// The tables of a dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TableName {
    /// Wide: one row per run.
    Runs,
    /// Long: one row per blow.
    Blows,
    /// Wall times, the only figures that depend on the machine: one row per run.
    Timings,
}

impl TableName {
    /// All tables.
    pub const ALL: [Self; 3] = [Self::Runs, Self::Blows, Self::Timings];

    /// Name of the table, of its folder, and the beginning of its parts' names.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Runs => "runs",
            Self::Blows => "blows",
            Self::Timings => "timings",
        }
    }
}

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ColumnKind {
    /// 64-bit floating point.
    Real,
    /// 64-bit unsigned.
    Count,
    /// 64-bit signed.
    Integer,
    /// UTF-8.
    Text,
}

/// What a column is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ColumnGroup {
    /// The row itself: index, status.
    Row,
    /// A factor of the design.
    Factor,
    /// An output of one hammer.
    Hammer,
    /// An output of one casting.
    Casting,
    /// An output over all hammers or castings.
    Aggregate,
    /// An output of the run as a whole.
    Run,
    /// One blow.
    Blow,
    /// Work and accuracy of the solver.
    Solver,
    /// A figure of a table outside the dataset: a time signal, an error.
    Other,
}

/// A column without its getter: an entry of the data dictionary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ColumnDescription {
    /// Name: letters, digits and underscores; unique in its table even without regard to case.
    pub name: String,
    /// Type.
    #[serde(rename = "type")]
    pub kind: ColumnKind,
    /// Unit; `1` for numbers without one, empty for text.
    pub unit: String,
    /// What it is, in words.
    pub description: String,
    /// What it is about.
    pub group: ColumnGroup,
    /// The factor, hammer or casting, named as in the study.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subject: Option<String>,
    /// Name of the quantity, without hammer or casting.
    pub quantity: String,
}

/// One value of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// Not available.
    Null,
    /// Of a [`ColumnKind::Real`] column.
    Real(f64),
    /// Of a [`ColumnKind::Count`] column.
    Count(u64),
    /// Of a [`ColumnKind::Integer`] column.
    Integer(i64),
    /// Of a [`ColumnKind::Text`] column.
    Text(&'a str),
}

impl Cell<'_> {
    /// The value as a floating-point number; `None` for nulls and text.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(value),
            Self::Count(value) => Some(value as f64),
            Self::Integer(value) => Some(value as f64),
            Self::Null | Self::Text(_) => None,
        }
    }
}

impl<'a> From<Option<QuantityValue<'a>>> for Cell<'a> {
    fn from(value: Option<QuantityValue<'a>>) -> Self {
        match value {
            None => Self::Null,
            Some(QuantityValue::Real(value)) => Self::Real(value),
            Some(QuantityValue::Count(value)) => Self::Count(value),
            Some(QuantityValue::Text(text)) => Self::Text(text),
        }
    }
}

impl From<QuantityKind> for ColumnKind {
    fn from(kind: QuantityKind) -> Self {
        match kind {
            QuantityKind::Real => Self::Real,
            QuantityKind::Count => Self::Count,
            QuantityKind::Text => Self::Text,
        }
    }
}

impl<'a> From<&'a FactorValue> for Cell<'a> {
    fn from(value: &'a FactorValue) -> Self {
        match value {
            FactorValue::Real(value) => Self::Real(*value),
            FactorValue::Integer(value) => Self::Integer(*value),
            FactorValue::Text(value) => Self::Text(value),
        }
    }
}

type Getter<T> = Box<dyn for<'a> Fn(&'a DatasetInfo, &'a T) -> Cell<'a> + Send + Sync>;

/// A column of a table whose rows are made from items of type `T`.
pub struct Column<T> {
    /// Everything but the getter.
    pub description: ColumnDescription,
    get: Getter<T>,
}

impl<T> Column<T> {
    fn new(
        description: ColumnDescription,
        get: impl for<'a> Fn(&'a DatasetInfo, &'a T) -> Cell<'a> + Send + Sync + 'static,
    ) -> Self {
        Self { description, get: Box::new(get) }
    }

    /// The column's value for one item.
    pub fn cell<'a>(&self, info: &'a DatasetInfo, item: &'a T) -> Cell<'a> {
        (self.get)(info, item)
    }
}

/// A blow as the table of blows takes it.
pub struct BlowRecord {
    /// Index of the row in the design.
    pub row: u64,
    /// The blow.
    pub blow: Blow,
}

/// The columns of all tables of one dataset.
pub struct Columns {
    /// Of `runs`.
    pub runs: Vec<Column<RowRecord>>,
    /// Of `blows`.
    pub blows: Vec<Column<BlowRecord>>,
    /// Of `timings`.
    pub timings: Vec<Column<RowRecord>>,
}

impl Columns {
    /// Lists the columns of a dataset.
    ///
    /// # Errors
    /// [`DatasetError::DuplicateColumn`] if two names of the study give the same column.
    pub fn new(info: &DatasetInfo) -> Result<Self, DatasetError> {
        let columns = Self { runs: run_columns(info), blows: blow_columns(), timings: timing_columns() };
        for table in TableName::ALL {
            check_unique(&columns.describe(table))?;
        }
        Ok(columns)
    }

    /// The columns of a table, in order.
    pub fn describe(&self, table: TableName) -> Vec<ColumnDescription> {
        fn descriptions<T>(columns: &[Column<T>]) -> Vec<ColumnDescription> {
            columns.iter().map(|column| column.description.clone()).collect()
        }
        match table {
            TableName::Runs => descriptions(&self.runs),
            TableName::Blows => descriptions(&self.blows),
            TableName::Timings => descriptions(&self.timings),
        }
    }
}

/// Refuses two columns of one name, whatever their case.
///
/// # Errors
/// [`DatasetError::DuplicateColumn`].
pub fn check_unique(columns: &[ColumnDescription]) -> Result<(), DatasetError> {
    let mut seen: BTreeMap<String, &ColumnDescription> = BTreeMap::new();
    let words = |column: &ColumnDescription| match &column.subject {
        Some(subject) => format!("`{}` of `{subject}`", column.quantity),
        None => format!("`{}`", column.quantity),
    };
    for column in columns {
        if let Some(first) = seen.insert(column.name.to_ascii_lowercase(), column) {
            return Err(DatasetError::DuplicateColumn {
                column: column.name.clone(),
                first: words(first),
                second: words(column),
            });
        }
    }
    Ok(())
}

/// A name of the study as the beginning of a column's name: letters, digits and underscores, no digit in front.
pub fn identifier(name: &str, prefix_before_digit: &str) -> String {
    let safe: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if safe.starts_with(|c: char| c.is_ascii_alphabetic()) { safe } else { format!("{prefix_before_digit}_{safe}") }
}

/// A description without subject.
fn describe(group: ColumnGroup, kind: ColumnKind, (name, unit): (&str, &str), description: &str) -> ColumnDescription {
    ColumnDescription {
        name: name.to_owned(),
        kind,
        unit: unit.to_owned(),
        description: description.to_owned(),
        group,
        subject: None,
        quantity: name.to_owned(),
    }
}

fn run_columns(info: &DatasetInfo) -> Vec<Column<RowRecord>> {
    let mut columns = row_columns();
    columns.extend(factor_columns(info));
    columns.extend(AGGREGATES.iter().map(|aggregate| {
        let description =
            describe(ColumnGroup::Aggregate, aggregate.kind, (aggregate.name, aggregate.unit), aggregate.description);
        Column::new(description, move |_, record: &RowRecord| {
            (record.outcome.metrics.as_ref()).map_or(Cell::Null, aggregate.value)
        })
    }));
    let twins = info.twins > 0;
    for (index, hammer) in info.hammers.iter().enumerate() {
        let of = |column| subject_column(column, (ColumnGroup::Hammer, hammer));
        columns.extend(quantity_columns(HammerMetrics::QUANTITIES, &of, move |m| m.hammers.get(index)));
        if twins {
            columns.extend(scatter_columns(HammerMetrics::QUANTITIES, &of, move |s| s.hammers.get(index)));
        }
    }
    for (index, casting) in info.castings.iter().enumerate() {
        let of = |column| subject_column(column, (ColumnGroup::Casting, casting));
        columns.extend(quantity_columns(CastingMetrics::QUANTITIES, &of, move |m| m.castings.get(index)));
        if twins {
            columns.extend(scatter_columns(CastingMetrics::QUANTITIES, &of, move |s| s.castings.get(index)));
        }
    }
    let run = |column: ColumnDescription| ColumnDescription { group: ColumnGroup::Run, ..column };
    columns.extend(quantity_columns(RunTotals::QUANTITIES, &run, |m| Some(&m.totals)));
    if twins {
        columns.extend(scatter_columns(RunTotals::QUANTITIES, &run, |s| Some(&s.totals)));
        columns.push(twins_column());
    }
    columns.extend(solver_columns());
    columns
}

/// Columns of quantities; `of` makes their descriptions those of a hammer, a casting or the run, `part` finds the values.
fn quantity_columns<T: 'static>(
    quantities: &'static [Quantity<T>],
    of: &dyn Fn(ColumnDescription) -> ColumnDescription,
    part: impl Fn(&RunMetrics) -> Option<&T> + Copy + Send + Sync + 'static,
) -> Vec<Column<RowRecord>> {
    let column = |quantity: &'static Quantity<T>| {
        let (kind, named) = (quantity.kind.into(), (quantity.name, quantity.unit));
        let description = of(describe(ColumnGroup::Row, kind, named, &quantity.description()));
        Column::new(description, move |_, record: &RowRecord| {
            let part = record.outcome.metrics.as_ref().and_then(part);
            part.and_then(quantity.value).into()
        })
    };
    quantities.iter().map(column).collect()
}

/// Columns of the scatter of the main quantities, `<quantity>_scatter`.
fn scatter_columns<T: 'static>(
    quantities: &'static [Quantity<T>],
    of: &dyn Fn(ColumnDescription) -> ColumnDescription,
    part: impl Fn(&Scatter) -> Option<&ScatterOf> + Copy + Send + Sync + 'static,
) -> Vec<Column<RowRecord>> {
    let column = |quantity: &'static Quantity<T>| {
        let name = format!("{}_scatter", quantity.name);
        let text = format!("Scatter (half the range over the row and its twins) of {}.", quantity.name);
        let description = of(describe(ColumnGroup::Row, ColumnKind::Real, (&name, quantity.unit), &text));
        Column::new(description, move |_, record: &RowRecord| {
            let scatter = record.outcome.metrics.as_ref().and_then(|metrics| metrics.scatter.as_ref());
            let value = scatter.and_then(part).and_then(|of| of.get(quantity.name).copied().flatten());
            value.map_or(Cell::Null, Cell::Real)
        })
    };
    quantities.iter().filter(|quantity| quantity.main).map(column).collect()
}

fn twins_column() -> Column<RowRecord> {
    let text = "Twins of the row that were simulated to their end; the scatter is over these and the row itself.";
    let description = describe(ColumnGroup::Run, ColumnKind::Count, ("twins_done", "1"), text);
    Column::new(description, |_, record: &RowRecord| {
        let scatter = record.outcome.metrics.as_ref().and_then(|metrics| metrics.scatter.as_ref());
        scatter.map_or(Cell::Null, |scatter| Cell::Count(scatter.twins_done))
    })
}

/// Description of a hammer's or a casting's output: `<subject>_<quantity>`.
fn subject_column(column: ColumnDescription, (group, subject): (ColumnGroup, &str)) -> ColumnDescription {
    let (prefix, word) = match group {
        ColumnGroup::Casting => ("casting", "Casting"),
        _ => ("hammer", "Hammer"),
    };
    ColumnDescription {
        name: format!("{}_{}", identifier(subject, prefix), column.name),
        description: format!("{word} `{subject}`: {}", column.description),
        group,
        subject: Some(subject.to_owned()),
        ..column
    }
}

fn row_columns() -> Vec<Column<RowRecord>> {
    use ColumnGroup::Row;
    vec![
        Column::new(
            describe(Row, ColumnKind::Count, ("row", "1"), "Index of the row in the design, from 0."),
            |_, record: &RowRecord| Cell::Count(record.row),
        ),
        Column::new(
            describe(
                Row,
                ColumnKind::Text,
                ("status", ""),
                &format!("How the row ended: {}.", RowStatus::ALL.map(RowStatus::text).join(", ")),
            ),
            |_, record: &RowRecord| Cell::Text(record.outcome.status.text()),
        ),
        Column::new(
            describe(Row, ColumnKind::Text, ("reason", ""), "Why the row is not done, in words; empty if it is."),
            |_, record: &RowRecord| Cell::Text(&record.outcome.reason),
        ),
        Column::new(
            describe(Row, ColumnKind::Real, ("time_reached_s", "s"), "Simulated time reached."),
            |_, record: &RowRecord| Cell::Real(record.outcome.time_reached_s),
        ),
    ]
}

fn factor_columns(info: &DatasetInfo) -> impl Iterator<Item = Column<RowRecord>> {
    info.factors.iter().enumerate().map(|(index, factor)| {
        let description = ColumnDescription {
            name: format!("factor_{}", identifier(&factor.name, "n")),
            kind: match factor.kind {
                FactorKind::Real => ColumnKind::Real,
                FactorKind::Integer => ColumnKind::Integer,
                FactorKind::Text => ColumnKind::Text,
            },
            unit: factor.unit.clone(),
            description: format!("Factor `{}`: {}", factor.name, factor.description),
            group: ColumnGroup::Factor,
            subject: Some(factor.name.clone()),
            quantity: "factor".to_owned(),
        };
        Column::new(description, move |_, record: &RowRecord| record.factors.get(index).map_or(Cell::Null, Cell::from))
    })
}

fn solver_columns() -> Vec<Column<RowRecord>> {
    type Count = (&'static str, &'static str, fn(&RowRecord) -> u64);
    let counts: [Count; 8] = [
        ("modes", "Modes of the structure that were kept.", |r| r.outcome.modes as u64),
        ("states", "States of the coupled system.", |r| r.outcome.states as u64),
        ("solver_steps", "Accepted steps.", |r| r.outcome.counters.steps),
        ("solver_rejected_steps", "Rejected steps.", |r| r.outcome.counters.rejected_steps),
        ("solver_rhs_evaluations", "Right-hand sides evaluated.", |r| r.outcome.counters.rhs_evaluations),
        ("solver_located_events", "Contact onsets and releases.", |r| r.outcome.counters.located_events),
        ("solver_factorisations", "Factorisations of a matrix (implicit methods).", |r| {
            r.outcome.counters.factorisations
        }),
        (
            "solver_retries",
            "Times the run was repeated with a stricter tolerance; the other counters are of the last time.",
            |r| r.outcome.counters.retries,
        ),
    ];
    let column = |(name, text, value): Count| {
        let description = describe(ColumnGroup::Solver, ColumnKind::Count, (name, "1"), text);
        Column::new(description, move |_, record: &RowRecord| Cell::Count(value(record)))
    };
    counts.into_iter().map(column).collect()
}

fn blow_columns() -> Vec<Column<BlowRecord>> {
    let text = |name, text| describe(ColumnGroup::Blow, ColumnKind::Text, (name, ""), text);
    let mut columns: Vec<Column<BlowRecord>> = vec![
        Column::new(
            describe(ColumnGroup::Row, ColumnKind::Count, ("row", "1"), "Index of the row in the design, from 0."),
            |_, record: &BlowRecord| Cell::Count(record.row),
        ),
        Column::new(text("hammer", "Name of the hammer, as in the study."), |info, record: &BlowRecord| {
            name_cell(info.hammers.get(record.blow.hammer))
        }),
        Column::new(text("casting", "Name of the casting struck, as in the study."), |info, record: &BlowRecord| {
            name_cell(info.castings.get(record.blow.casting))
        }),
        Column::new(
            describe(
                ColumnGroup::Blow,
                ColumnKind::Count,
                ("number", "1"),
                "Number of the blow for this hammer, from 0 (the first impact), blank ones included.",
            ),
            |_, record: &BlowRecord| Cell::Count(record.blow.number as u64),
        ),
        Column::new(
            describe(
                ColumnGroup::Blow,
                ColumnKind::Count,
                ("stroke", "1"),
                "Stroke of the hammer that the blow belongs to, from 0; a stroke begins where the supply is switched on.",
            ),
            |_, record: &BlowRecord| Cell::Count(record.blow.stroke as u64),
        ),
        Column::new(
            text("kind", "Kind of blow: first_impact, stroke_impact, settling, periodic or blank."),
            |_, record: &BlowRecord| Cell::Text(record.blow.kind.text()),
        ),
    ];
    columns.extend(blow_figures());
    columns
}

fn name_cell(name: Option<&String>) -> Cell<'_> {
    name.map_or(Cell::Null, |name| Cell::Text(name))
}

fn blow_figures() -> impl Iterator<Item = Column<BlowRecord>> {
    type Figure = (&'static str, &'static str, &'static str, fn(&Blow) -> f64);
    let figures: [Figure; 7] = [
        ("start_time_s", "s", "Start of the blow, from the start of the simulation.", |b| b.start_time_s),
        ("energy_j", "J", "Kinetic energy of cylinder, spool, piston and chisel at the start.", |b| b.energy_j),
        ("chisel_velocity_m_s", "m/s", "Chisel velocity at the start.", |b| b.chisel_velocity_m_s),
        ("work_j", "J", "Work delivered to the casting within the blow's window.", |b| b.work_j),
        ("impulse_n_s", "N s", "Impulse of the chisel-casting force within the blow's window.", |b| b.impulse_n_s),
        ("peak_force_n", "N", "Largest chisel-casting force within the blow's window.", |b| b.peak_force_n),
        (
            "casting_peak_velocity_m_s",
            "m/s",
            "Largest absolute velocity of the casting at the strike point within the blow's window.",
            |b| b.casting_peak_velocity_m_s,
        ),
    ];
    figures.into_iter().map(|(name, unit, text, value)| {
        let description = describe(ColumnGroup::Blow, ColumnKind::Real, (name, unit), text);
        Column::new(description, move |_, record: &BlowRecord| Cell::Real(value(&record.blow)))
    })
}

fn timing_columns() -> Vec<Column<RowRecord>> {
    vec![
        Column::new(
            describe(ColumnGroup::Row, ColumnKind::Count, ("row", "1"), "Index of the row in the design, from 0."),
            |_, record: &RowRecord| Cell::Count(record.row),
        ),
        Column::new(
            describe(
                ColumnGroup::Solver,
                ColumnKind::Real,
                ("wall_time_s", "s"),
                "Wall time that the row took; depends on the machine and its load.",
            ),
            |_, record: &RowRecord| Cell::Real(record.outcome.wall_time_s),
        ),
    ]
}
