//! The columns of all tables: name, type, unit, description and getter follow from the declarations of the quantities.
//!
//! Writer, reader and data dictionary use these columns.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cells::Segment;
use super::column::{
    Column, ColumnDescription, ColumnGroup, Get, Read, ReadSpectrum, ScatterGroup, Source, numerical_error_name,
    scatter_name,
};
use super::error::DatasetError;
use super::info::{DatasetInfo, PartColumn, RowRecord};
use decore_model::integrate::Counters;
use decore_model::metrics::{
    Aggregates, Blow, BlowStrain, CastingMetrics, CoreMetrics, CoreTotals, ElasticMetrics, FixtureMetrics,
    HammerMetrics, Instant, NumericalErrors, PadMetrics, RunTotals, Scatter, spectrum_frequencies_hz,
};
use decore_model::run::RowOutcome;
use decore_quantity::words::identifier;
use decore_quantity::{Kind, Quantity};

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
    /// All tables, including `signals`, which exists only if the study asks for it.
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

/// The columns of all tables of one dataset.
pub struct Columns {
    /// Of `runs`.
    pub runs: Vec<Column>,
    /// Of `blows`.
    pub blows: Vec<Column>,
    /// Of `timings`.
    pub timings: Vec<Column>,
    /// Of `signals`; empty if the dataset has no such table.
    pub signals: Vec<Column>,
    /// Writing order of each table's columns, in the order of [`TableName::KNOWN`].
    segments: [Vec<Segment>; 4],
}

impl Columns {
    /// Lists the columns of a dataset.
    ///
    /// # Errors
    /// [`DatasetError::DuplicateColumn`] if two names of the study give the same column.
    pub fn new(info: &DatasetInfo) -> Result<Self, DatasetError> {
        let [runs, blows, timings, signals] =
            [run_columns(info), blow_columns(info), timing_columns(), signal_columns(info)];
        let segments = [&runs, &blows, &timings, &signals].map(|columns| Segment::of(columns));
        let columns = Self { runs, blows, timings, signals, segments };
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

    /// Appends the cells of one row of a table to `bytes`, column by column.
    pub fn put(&self, table: TableName, source: &Source<'_>, bytes: &mut Vec<u8>) {
        let segments = self.segments.get(table as usize);
        segments.into_iter().flatten().for_each(|segment| segment.put(self.of(table), source, bytes));
    }

    /// Hash of the columns of all tables: name, type and unit, in order.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for column in TableName::KNOWN.into_iter().flat_map(|table| self.of(table)) {
            let ColumnDescription { name, kind, unit, .. } = &*column.description;
            hasher.update(format!("{name}\t{kind:?}\t{unit}\n").as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// The tables that the dataset has.
    pub fn tables(&self) -> impl Iterator<Item = TableName> {
        TableName::KNOWN.into_iter().filter(|table| !self.of(*table).is_empty())
    }

    /// The columns of a table without their getters, in order.
    pub fn describe(&self, table: TableName) -> Vec<ColumnDescription> {
        self.of(table).iter().map(|column| (*column.description).clone()).collect()
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

/// Subject of a group of columns.
struct About<'a> {
    group: ColumnGroup,
    /// Hammer or casting: its kind and name.
    subject: Option<(&'static str, &'a str)>,
    /// Prefix of the column's name.
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
            less: false,
            name,
        }
    }

    /// Columns of quantities; `get` selects their source.
    fn columns<T: 'static>(
        &self,
        quantities: &[Quantity<T>],
        get: impl Fn(Read<T>) -> Get,
    ) -> impl Iterator<Item = Column> {
        quantities.iter().map(move |quantity| {
            let described = self.describe(quantity.name, quantity.kind, quantity.unit, &quantity.description());
            let (main, less) = (quantity.main, quantity.less);
            Column::new(ColumnDescription { main, less, ..described }, get(quantity.value))
        })
    }

    /// Columns of the numerical errors of the main quantities, `<quantity>_numerical_error`.
    fn numerical_errors<T: 'static>(
        &self,
        quantities: &[Quantity<T>],
        group: ScatterGroup,
    ) -> impl Iterator<Item = Column> {
        quantities.iter().filter(|quantity| quantity.main).map(move |quantity| {
            let (name, column) = (quantity.name, numerical_error_name(quantity.name));
            let (of, unit) = match quantity.kind {
                Kind::Text | Kind::Category => ("1 if the row's numerical twin has another value, otherwise 0", "1"),
                Kind::Real | Kind::Count | Kind::Integer => {
                    ("difference of the row and its numerical twin", quantity.unit)
                }
            };
            let text = format!("Numerical error ({of}) of {name}; null without a numerical twin.");
            let described = self.describe(&column, Kind::Real, unit, &text);
            Column::new(ColumnDescription { less: true, ..described }, Get::NumericalError(group, name))
        })
    }

    /// Columns of the scatter of the main quantities, `<quantity>_scatter`.
    fn scatter<T: 'static>(&self, quantities: &[Quantity<T>], group: ScatterGroup) -> impl Iterator<Item = Column> {
        quantities.iter().filter(|quantity| quantity.main).map(move |quantity| {
            let (name, column) = (quantity.name, scatter_name(quantity.name));
            let (of, unit) = match quantity.kind {
                Kind::Text | Kind::Category => ("share of the row and its twins with another value", "1"),
                Kind::Real | Kind::Count | Kind::Integer => {
                    ("half the range over the row and its twins", quantity.unit)
                }
            };
            let text = format!("Scatter ({of}) of {name}.");
            let described = self.describe(&column, Kind::Real, unit, &text);
            Column::new(ColumnDescription { less: true, ..described }, Get::Scatter(group, name))
        })
    }
}

/// Columns of scatter and numerical errors for some quantities.
fn beside<T: 'static>(
    info: &DatasetInfo,
    about: &About<'_>,
    quantities: &[Quantity<T>],
    group: ScatterGroup,
) -> Vec<Column> {
    let scatter = (info.twins > 0).then(|| about.scatter(quantities, group));
    let errors = info.numerical_twins.then(|| about.numerical_errors(quantities, group));
    scatter.into_iter().flatten().chain(errors.into_iter().flatten()).collect()
}

fn run_columns(info: &DatasetInfo) -> Vec<Column> {
    let [row, aggregate, run, solver] =
        [ColumnGroup::Row, ColumnGroup::Aggregate, ColumnGroup::Run, ColumnGroup::Solver].map(About::all);
    let mut columns = row_column();
    let ending = [RowOutcome::status, RowOutcome::reason, RowOutcome::time_reached_s];
    columns.extend(row.columns(&ending, Get::Outcome));
    columns.extend(factor_columns(info));
    columns.extend(aggregate.columns(Aggregates::QUANTITIES, Get::Aggregates));
    for (index, name) in info.hammers.iter().enumerate() {
        let hammer = About::one(ColumnGroup::Hammer, "Hammer", name);
        columns.extend(hammer.columns(HammerMetrics::QUANTITIES, |read| Get::Hammer(index, read)));
        columns.extend(beside(info, &hammer, HammerMetrics::QUANTITIES, ScatterGroup::Hammer(index)));
    }
    for (index, name) in info.castings.iter().enumerate() {
        let casting = About::one(ColumnGroup::Casting, "Casting", name);
        columns.extend(casting.columns(CastingMetrics::QUANTITIES, |read| Get::Casting(index, read)));
        columns.extend(beside(info, &casting, CastingMetrics::QUANTITIES, ScatterGroup::Casting(index)));
    }
    for (index, name) in info.elastic_castings.iter().enumerate() {
        let casting = About::one(ColumnGroup::Casting, "Casting", name);
        columns.extend(casting.columns(ElasticMetrics::QUANTITIES, |read| Get::Elastic(index, read)));
    }
    columns.extend(fixture_columns(&info.pads, PadMetrics::QUANTITIES, Get::Pad));
    columns.extend(fixture_columns(&info.fixture_energies, FixtureMetrics::QUANTITIES, Get::Fixture));
    columns.extend(core_columns(info));
    columns.extend(run.columns(RunTotals::QUANTITIES, Get::Totals));
    columns.extend(beside(info, &run, RunTotals::QUANTITIES, ScatterGroup::Totals));
    if info.twins > 0 {
        columns.extend(run.columns(Scatter::QUANTITIES, Get::Twins));
    }
    if info.numerical_twins {
        columns.extend(run.columns(NumericalErrors::QUANTITIES, Get::Numerical));
    }
    columns.extend(solver.columns(&[RowOutcome::modes, RowOutcome::states], Get::Outcome));
    let counted = About { prefix: "solver_".to_owned(), ..solver };
    columns.extend(counted.columns(Counters::QUANTITIES, Get::Counters));
    columns
}

/// Columns `<casting>_fixture_<name>_<quantity>` of fixtures.
fn fixture_columns<T: 'static>(
    fixtures: &[PartColumn],
    quantities: &[Quantity<T>],
    get: impl Fn(usize, Read<T>) -> Get,
) -> Vec<Column> {
    let columns = fixtures.iter().enumerate().flat_map(|(index, PartColumn { casting, name })| {
        let subject = format!("{casting}.{name}");
        let prefix = identifier(&format!("{casting}_fixture_{name}_"), "casting");
        let about = About { group: ColumnGroup::Fixture, subject: Some(("Fixture", &subject)), prefix };
        about.columns(quantities, |read| get(index, read)).collect::<Vec<_>>()
    });
    columns.collect()
}

/// Columns `<casting>_core_<name>_<quantity>` of core points, and those over all of them.
fn core_columns(info: &DatasetInfo) -> Vec<Column> {
    let mut columns = Vec::new();
    for (index, PartColumn { casting, name }) in info.cores.iter().enumerate() {
        let subject = format!("{casting}.{name}");
        let prefix = identifier(&format!("{casting}_core_{name}_"), "casting");
        let about = About { group: ColumnGroup::Core, subject: Some(("Core point", &subject)), prefix };
        if !info.core_spectra {
            let peak = [CoreMetrics::peak_velocity_m_s];
            columns.extend(about.columns(&peak, |read| Get::Core(index, read)));
            continue;
        }
        columns.extend(about.columns(CoreMetrics::QUANTITIES, |read| Get::Core(index, read)));
        for (name, of, read) in SPECTRA {
            columns.extend(spectrum_frequencies_hz().into_iter().enumerate().map(|(place, frequency_hz)| {
                let quantity = format!("{name}_{frequency_hz:.0}hz_m_s");
                let text =
                    format!("Largest pseudo-velocity {of} of the oscillator at the frequency in the column's name.");
                let described = about.describe(&quantity, Kind::Real, "m/s", &text);
                let described = ColumnDescription { quantity: format!("{name}_spectrum"), ..described };
                Column::new(described, Get::CoreSpectrum(index, read, place))
            }));
        }
    }
    if info.core_spectra && !info.cores.is_empty() {
        columns.extend(About::all(ColumnGroup::Aggregate).columns(CoreTotals::QUANTITIES, Get::CoreTotals));
    }
    columns
}

/// Stored spectra: name, subject, source.
const SPECTRA: [(&str, &str, ReadSpectrum); 2] = [
    ("first_impact_pseudo_velocity", "within the windows of the first impacts", |of| {
        &of.first_impact_pseudo_velocity_m_s
    }),
    ("pseudo_velocity", "in the run", |of| &of.pseudo_velocity_m_s),
];

/// The index of the row, by which rows of all tables belong together.
fn row_column() -> Vec<Column> {
    About::all(ColumnGroup::Row).columns(RowRecord::QUANTITIES, Get::Record).collect()
}

fn factor_columns(info: &DatasetInfo) -> impl Iterator<Item = Column> {
    info.factors.iter().enumerate().map(|(index, factor)| {
        let description = ColumnDescription {
            name: format!("factor_{}", identifier(&factor.name, "n")),
            // Names among which a design chooses.
            kind: if factor.kind == Kind::Text { Kind::Category } else { factor.kind },
            unit: factor.unit.clone(),
            description: format!("Factor `{}`: {}", factor.name, factor.description),
            group: ColumnGroup::Factor,
            subject: Some(factor.name.clone()),
            quantity: "factor".to_owned(),
            main: false,
            less: false,
        };
        Column::new(description, Get::Factor(index))
    })
}

fn blow_columns(info: &DatasetInfo) -> Vec<Column> {
    let about = About::all(ColumnGroup::Blow);
    let named = |column: &str, text: &str, get: Get| Column::new(about.describe(column, Kind::Category, "", text), get);
    let mut columns = row_column();
    columns.push(named("hammer", "Name of the hammer, as in the study.", Get::BlowHammer));
    columns.push(named("casting", "Name of the casting struck, as in the study.", Get::BlowCasting));
    columns.extend(about.columns(Blow::QUANTITIES, Get::Blow));
    if !info.elastic_castings.is_empty() {
        columns.extend(about.columns(BlowStrain::QUANTITIES, Get::BlowStrain));
    }
    columns
}

fn timing_columns() -> Vec<Column> {
    let mut columns = row_column();
    let about = About::all(ColumnGroup::Solver);
    columns.extend(about.columns(&[RowOutcome::wall_time_s, RowOutcome::numerical_twin_wall_time_s], Get::Outcome));
    columns
}

/// Row, time, and the signals that the study keeps.
fn signal_columns(info: &DatasetInfo) -> Vec<Column> {
    if info.signals.is_empty() {
        return Vec::new();
    }
    let about = About::all(ColumnGroup::Signal);
    let column = |(place, description)| Column::new(description, Get::Instant(place));
    let time = about.describe(Instant::time_s.name, Kind::Real, Instant::time_s.unit, "Instant.");
    let signals =
        info.signals.iter().map(|signal| about.describe(&signal.name, Kind::Real, &signal.unit, &signal.description));
    row_column().into_iter().chain([time].into_iter().chain(signals).enumerate().map(column)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::info::FactorColumn;
    use super::*;
    use decore_model::run::RowStatus;

    #[test]
    fn names_end_in_the_unit() {
        let named = |name: &str| vec![name.to_owned()];
        let info = DatasetInfo {
            hammers: named("left"),
            castings: named("part"),
            twins: 1,
            numerical_twins: true,
            ..DatasetInfo::empty()
        };
        let columns = Columns::new(&info).expect("unique");
        for column in TableName::ALL.into_iter().flat_map(|table| columns.describe(table)) {
            let ColumnDescription { name, unit, kind, description, .. } = column;
            assert_eq!(unit.is_empty(), kind.is_text(), "{name}");
            assert!(description.ends_with('.'), "{name}: {description}");
            let suffix = match unit.as_str() {
                "1" | "" => continue,
                "s" => "_s",
                "J" => "_j",
                "m" => "_m",
                "N" => "_n",
                "N s" => "_n_s",
                "m/s" => "_m_s",
                "Hz" => "_hz",
                "NL" => "_nl",
                "W" => "_w",
                "J/NL" => "_j_per_nl",
                other => panic!("unit {other} of {name} has no suffix here"),
            };
            assert!(
                name.trim_end_matches("_scatter").trim_end_matches("_numerical_error").ends_with(suffix),
                "{name} [{unit}]"
            );
        }
    }

    /// The hash depends on names, types and units, not on descriptions.
    #[test]
    fn the_hash_is_of_names_types_and_units() {
        let factor = |kind: Kind, unit: &str, description: &str| {
            let [name, unit, description] = ["load", unit, description].map(str::to_owned);
            let factors = vec![FactorColumn { name, kind, unit, description }];
            Columns::new(&DatasetInfo { factors, ..DatasetInfo::empty() }).expect("unique").hash()
        };
        let hash = factor(Kind::Real, "N", "Load.");
        assert_eq!(hash, factor(Kind::Real, "N", "The load."));
        assert_ne!(hash, factor(Kind::Count, "N", "Load."));
        assert_ne!(hash, factor(Kind::Real, "kN", "Load."));
        assert_ne!(hash, Columns::new(&DatasetInfo::empty()).expect("unique").hash());
    }

    /// A quantity without a column would be lost.
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
