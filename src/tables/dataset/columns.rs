//! The columns of all tables: name, type, unit, description and getter follow from the declarations of the quantities.
//!
//! The writer, the reader and the data dictionary derive from what is put together here.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::error::DatasetError;
use super::info::{DatasetInfo, RowRecord};
use crate::integrate::Counters;
use crate::metrics::{
    Aggregates, Blow, CastingMetrics, HammerMetrics, Instant, RunMetrics, RunTotals, Scatter, ScatterOf,
};
use crate::quantity::{Cell, Kind, Quantity, Value};
use crate::run::RowOutcome;
use crate::words::identifier;

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
    /// Means of signals: one row per instant of a run whose signals are kept. Only where the study asks for it.
    Signals,
}

impl TableName {
    /// The tables of every dataset.
    pub const ALL: [Self; 3] = [Self::Runs, Self::Blows, Self::Timings];
    /// Those, and the one of a study that asks for it.
    pub const KNOWN: [Self; 4] = [Self::Runs, Self::Blows, Self::Timings, Self::Signals];

    /// Name of the table, of its folder, and the beginning of its parts' names.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Runs => "runs",
            Self::Blows => "blows",
            Self::Timings => "timings",
            Self::Signals => "signals",
        }
    }
}

/// What a column is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
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
    /// A signal at one instant.
    Signal,
    /// Work and accuracy of the solver.
    Solver,
    /// A figure of a table outside the dataset: a time signal, an error.
    Other,
}

/// A column without its getter: an entry of the data dictionary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ColumnDescription {
    /// Name: letters, digits and underscores; unique in its table even without regard to case.
    pub name: String,
    /// Type.
    #[serde(rename = "type")]
    pub kind: Kind,
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
    /// Whether it is a main output, whose scatter twins measure. No entry of the dictionary.
    #[serde(skip)]
    pub main: bool,
}

impl ColumnDescription {
    /// Name of the column that holds the scatter of this one, where its row has twins.
    pub fn scatter_name(&self) -> String {
        scatter_name(&self.name)
    }
}

fn scatter_name(name: &str) -> String {
    format!("{name}_scatter")
}

/// What a row of a table is made from.
pub struct Source<'a> {
    info: &'a DatasetInfo,
    record: &'a RowRecord,
    aggregates: Option<Aggregates>,
    /// The blow, for the table of blows.
    pub blow: Option<&'a Blow>,
    /// The instant, for the table of signals: time and means.
    pub instant: Option<&'a [f64]>,
}

impl<'a> Source<'a> {
    /// A row of `runs` or `timings`.
    pub fn new(info: &'a DatasetInfo, record: &'a RowRecord) -> Self {
        Self {
            info,
            record,
            aggregates: record.outcome.metrics.as_ref().map(Aggregates::of),
            blow: None,
            instant: None,
        }
    }

    fn outcome(&self) -> &RowOutcome {
        &self.record.outcome
    }

    fn metrics(&self) -> Option<&RunMetrics> {
        self.outcome().metrics.as_ref()
    }

    fn scatter(&self) -> Option<&Scatter> {
        self.metrics()?.scatter.as_ref()
    }
}

/// A column of a table.
pub struct Column {
    /// Everything but the getter.
    pub description: ColumnDescription,
    get: Box<dyn for<'s> Fn(&'s Source<'_>) -> Cell<'s> + Send + Sync>,
}

impl Column {
    /// The column's value for one row of its table.
    pub fn cell<'s>(&self, source: &'s Source<'_>) -> Cell<'s> {
        (self.get)(source)
    }
}

/// The columns of all tables of one dataset.
pub struct Columns {
    /// Of `runs`.
    pub runs: Vec<Column>,
    /// Of `blows`.
    pub blows: Vec<Column>,
    /// Of `timings`.
    pub timings: Vec<Column>,
    /// Of `signals`; empty where the dataset has no such table.
    pub signals: Vec<Column>,
}

impl Columns {
    /// Lists the columns of a dataset.
    ///
    /// # Errors
    /// [`DatasetError::DuplicateColumn`] if two names of the study give the same column.
    pub fn new(info: &DatasetInfo) -> Result<Self, DatasetError> {
        let columns = Self {
            runs: run_columns(info),
            blows: blow_columns(),
            timings: timing_columns(),
            signals: signal_columns(info),
        };
        for table in TableName::KNOWN {
            check_unique(&columns.describe(table))?;
        }
        Ok(columns)
    }

    /// The columns of a table, in order.
    pub fn of(&self, table: TableName) -> &[Column] {
        match table {
            TableName::Runs => &self.runs,
            TableName::Blows => &self.blows,
            TableName::Timings => &self.timings,
            TableName::Signals => &self.signals,
        }
    }

    /// The tables that the dataset has.
    pub fn tables(&self) -> impl Iterator<Item = TableName> {
        TableName::KNOWN.into_iter().filter(|table| !self.of(*table).is_empty())
    }

    /// The columns of a table without their getters, in order.
    pub fn describe(&self, table: TableName) -> Vec<ColumnDescription> {
        self.of(table).iter().map(|column| column.description.clone()).collect()
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

/// What columns are about.
struct About<'a> {
    group: ColumnGroup,
    /// The hammer or casting: what it is and its name.
    subject: Option<(&'static str, &'a str)>,
    /// What comes before the quantity in a column's name.
    prefix: String,
}

impl<'a> About<'a> {
    /// Columns that are about no single hammer or casting.
    fn all(group: ColumnGroup) -> Self {
        Self { group, subject: None, prefix: String::new() }
    }

    /// Columns `<subject>_<quantity>` of a hammer or a casting.
    fn one(group: ColumnGroup, what: &'static str, name: &'a str) -> Self {
        Self {
            group,
            subject: Some((what, name)),
            prefix: format!("{}_", identifier(name, &what.to_ascii_lowercase())),
        }
    }

    fn describe(&self, quantity: &str, kind: Kind, unit: &str, text: &str) -> ColumnDescription {
        let name = format!("{}{quantity}", self.prefix);
        let described = self.subject.map(|(what, name)| format!("{what} `{name}`: {text}"));
        ColumnDescription {
            kind,
            unit: unit.to_owned(),
            group: self.group,
            subject: self.subject.map(|(_, name)| name.to_owned()),
            quantity: if self.subject.is_some() { quantity.to_owned() } else { name.clone() },
            description: described.unwrap_or_else(|| text.to_owned()),
            main: false,
            name,
        }
    }

    /// Columns of quantities; `part` finds what has the values.
    fn columns<T: 'static>(
        &self,
        quantities: &[Quantity<T>],
        part: impl for<'s> Fn(&'s Source<'_>) -> Option<&'s T> + Copy + Send + Sync + 'static,
    ) -> impl Iterator<Item = Column> {
        quantities.iter().map(move |quantity| {
            let get = quantity.value;
            let described = self.describe(quantity.name, quantity.kind, quantity.unit, &quantity.description());
            Column {
                description: ColumnDescription { main: quantity.main, ..described },
                get: Box::new(move |source| part(source).and_then(get)),
            }
        })
    }

    /// Columns of the scatter of the main quantities, `<quantity>_scatter`.
    fn scatter<T: 'static>(
        &self,
        quantities: &[Quantity<T>],
        part: impl Fn(&Scatter) -> Option<&ScatterOf> + Copy + Send + Sync + 'static,
    ) -> impl Iterator<Item = Column> {
        quantities.iter().filter(|quantity| quantity.main).map(move |quantity| {
            let (name, column) = (quantity.name, scatter_name(quantity.name));
            let (of, unit) = match quantity.kind {
                Kind::Text | Kind::Category => ("share of the row and its twins with another value", "1"),
                Kind::Real | Kind::Count | Kind::Integer => {
                    ("half the range over the row and its twins", quantity.unit)
                }
            };
            let text = format!("Scatter ({of}) of {name}.");
            Column {
                description: self.describe(&column, Kind::Real, unit, &text),
                get: Box::new(move |source| part(source.scatter()?)?.get(name).copied()?.map(Value::Real)),
            }
        })
    }
}

fn run_columns(info: &DatasetInfo) -> Vec<Column> {
    let twins = info.twins > 0;
    let [row, aggregate, run, solver] =
        [ColumnGroup::Row, ColumnGroup::Aggregate, ColumnGroup::Run, ColumnGroup::Solver].map(About::all);
    let mut columns = row_column();
    let ending = [RowOutcome::status, RowOutcome::reason, RowOutcome::time_reached_s];
    columns.extend(row.columns(&ending, |source| Some(source.outcome())));
    columns.extend(factor_columns(info));
    columns.extend(aggregate.columns(Aggregates::QUANTITIES, |source| source.aggregates.as_ref()));
    for (index, name) in info.hammers.iter().enumerate() {
        let hammer = About::one(ColumnGroup::Hammer, "Hammer", name);
        columns.extend(hammer.columns(HammerMetrics::QUANTITIES, move |source| source.metrics()?.hammers.get(index)));
        if twins {
            columns.extend(hammer.scatter(HammerMetrics::QUANTITIES, move |scatter| scatter.hammers.get(index)));
        }
    }
    for (index, name) in info.castings.iter().enumerate() {
        let casting = About::one(ColumnGroup::Casting, "Casting", name);
        columns
            .extend(casting.columns(CastingMetrics::QUANTITIES, move |source| source.metrics()?.castings.get(index)));
        if twins {
            columns.extend(casting.scatter(CastingMetrics::QUANTITIES, move |scatter| scatter.castings.get(index)));
        }
    }
    columns.extend(run.columns(RunTotals::QUANTITIES, |source| Some(&source.metrics()?.totals)));
    if twins {
        columns.extend(run.scatter(RunTotals::QUANTITIES, |scatter| Some(&scatter.totals)));
        columns.extend(run.columns(Scatter::QUANTITIES, |source| source.scatter()));
    }
    columns.extend(solver.columns(&[RowOutcome::modes, RowOutcome::states], |source| Some(source.outcome())));
    let counted = About { prefix: "solver_".to_owned(), ..solver };
    columns.extend(counted.columns(Counters::QUANTITIES, |source| Some(&source.outcome().counters)));
    columns
}

/// The index of the row, by which rows of all tables belong together.
fn row_column() -> Vec<Column> {
    About::all(ColumnGroup::Row).columns(RowRecord::QUANTITIES, |source| Some(source.record)).collect()
}

fn factor_columns(info: &DatasetInfo) -> impl Iterator<Item = Column> {
    info.factors.iter().enumerate().map(|(index, factor)| Column {
        description: ColumnDescription {
            name: format!("factor_{}", identifier(&factor.name, "n")),
            // Names among which a design chooses.
            kind: if factor.kind == Kind::Text { Kind::Category } else { factor.kind },
            unit: factor.unit.clone(),
            description: format!("Factor `{}`: {}", factor.name, factor.description),
            group: ColumnGroup::Factor,
            subject: Some(factor.name.clone()),
            quantity: "factor".to_owned(),
            main: false,
        },
        get: Box::new(move |source| source.record.factors.get(index).map(Value::borrowed)),
    })
}

fn blow_columns() -> Vec<Column> {
    type Names = fn(&DatasetInfo) -> &[String];
    let about = About::all(ColumnGroup::Blow);
    let named = |column: &str, text: &str, names: Names, index: fn(&Blow) -> usize| Column {
        description: about.describe(column, Kind::Category, "", text),
        get: Box::new(move |source| names(source.info).get(index(source.blow?)).map(|name| Value::Text(name.as_str()))),
    };
    let mut columns = row_column();
    columns.push(named("hammer", "Name of the hammer, as in the study.", |info| &info.hammers, |blow| blow.hammer));
    columns.push(named(
        "casting",
        "Name of the casting struck, as in the study.",
        |info| &info.castings,
        |blow| blow.casting,
    ));
    columns.extend(about.columns(Blow::QUANTITIES, |source| source.blow));
    columns
}

fn timing_columns() -> Vec<Column> {
    let mut columns = row_column();
    let about = About::all(ColumnGroup::Solver);
    columns.extend(about.columns(&[RowOutcome::wall_time_s], |source| Some(source.outcome())));
    columns
}

/// Row, time, and the signals that the study keeps.
fn signal_columns(info: &DatasetInfo) -> Vec<Column> {
    if info.signals.is_empty() {
        return Vec::new();
    }
    let about = About::all(ColumnGroup::Signal);
    let column = |(place, description): (usize, ColumnDescription)| Column {
        description,
        get: Box::new(move |source| source.instant?.get(place).copied().map(Value::Real)),
    };
    let time = about.describe(Instant::time_s.name, Kind::Real, Instant::time_s.unit, "Instant.");
    let signals =
        info.signals.iter().map(|signal| about.describe(&signal.name, Kind::Real, &signal.unit, &signal.description));
    row_column().into_iter().chain([time].into_iter().chain(signals).enumerate().map(column)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::RowStatus;

    #[test]
    fn names_end_in_the_unit() {
        let named = |name: &str| vec![name.to_owned()];
        let info = DatasetInfo { hammers: named("left"), castings: named("part"), twins: 1, ..DatasetInfo::empty() };
        let columns = Columns::new(&info).expect("unique");
        for column in TableName::ALL.into_iter().flat_map(|table| columns.describe(table)) {
            let ColumnDescription { name, unit, kind, description, .. } = column;
            assert_eq!(unit.is_empty(), kind.is_text(), "{name}");
            assert!(description.ends_with('.'), "{name}: {description}");
            let suffix = match unit.as_str() {
                "1" | "" => continue,
                "s" => "_s",
                "J" => "_j",
                "N" => "_n",
                "N s" => "_n_s",
                "m/s" => "_m_s",
                "Hz" => "_hz",
                "NL" => "_nl",
                "W" => "_w",
                "J/NL" => "_j_per_nl",
                other => panic!("unit {other} of {name} has no suffix here"),
            };
            assert!(name.trim_end_matches("_scatter").ends_with(suffix), "{name} [{unit}]");
        }
    }

    /// What is declared of a row's end and not in a table would be lost.
    #[test]
    fn every_quantity_of_an_outcome_has_a_column() {
        let columns = Columns::new(&DatasetInfo::empty()).expect("unique");
        let names: Vec<String> =
            TableName::ALL.into_iter().flat_map(|table| columns.describe(table)).map(|column| column.name).collect();
        assert!(
            RowOutcome::QUANTITIES.iter().all(|quantity| names.iter().any(|name| name == quantity.name)),
            "{names:?}"
        );
        let text = RowOutcome::status.description();
        assert!(RowStatus::ALL.iter().all(|status| text.contains(status.name())), "{text}");
    }
}
