//! A column: its description, and the source of its value for a row.

use schemars::JsonSchema;
use serde::Serialize;

use super::info::{DatasetInfo, RowRecord};
use decore_model::integrate::Counters;
use decore_model::metrics::{
    Aggregates, Blow, BlowStrain, CastingMetrics, CoreMetrics, CoreSpectrum, CoreTotals, ElasticMetrics,
    FixtureMetrics, HammerMetrics, NumericalErrors, PadMetrics, RunMetrics, RunTotals, Scatter, ScatterOf,
};
use decore_model::run::RowOutcome;
use decore_quantity::{Cell, Kind, Value};

/// Subject of a column.
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
    /// An output of one fixture.
    Fixture,
    /// An output of one core point.
    Core,
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
    /// Description in words.
    pub description: String,
    /// Subject of the column.
    pub group: ColumnGroup,
    /// The factor, hammer or casting, named as in the study.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subject: Option<String>,
    /// Name of the quantity, without hammer or casting.
    pub quantity: String,
    /// Whether it is a main output, whose scatter twins measure. No entry of the dictionary.
    #[serde(skip)]
    pub main: bool,
    /// Whether small values are better; large ones otherwise. No entry of the dictionary.
    #[serde(skip)]
    pub less: bool,
}

impl ColumnDescription {
    /// Name of the column that holds the scatter of this one, where its row has twins.
    pub fn scatter_name(&self) -> String {
        scatter_name(&self.name)
    }

    /// Name of the column that holds the numerical error of this one, where its row has a numerical twin.
    pub fn numerical_error_name(&self) -> String {
        numerical_error_name(&self.name)
    }
}

/// Name of the column that holds the scatter of the column with this name.
pub fn scatter_name(name: &str) -> String {
    format!("{name}_scatter")
}

/// Name of the column that holds the numerical error of the column with this name.
pub fn numerical_error_name(name: &str) -> String {
    format!("{name}_numerical_error")
}

/// Data from which a row of a table is made.
pub struct Source<'a> {
    info: &'a DatasetInfo,
    record: &'a RowRecord,
    pub(super) aggregates: Option<Aggregates>,
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

    pub(super) fn outcome(&self) -> &RowOutcome {
        &self.record.outcome
    }

    pub(super) fn metrics(&self) -> Option<&RunMetrics> {
        self.outcome().metrics.as_ref()
    }

    fn scatter(&self) -> Option<&Scatter> {
        self.metrics()?.scatter.as_ref()
    }

    fn numerical(&self) -> Option<&NumericalErrors> {
        self.metrics()?.numerical.as_ref()
    }

    fn numerical_of(&self, group: ScatterGroup) -> Option<&ScatterOf> {
        let numerical = self.numerical()?;
        match group {
            ScatterGroup::Hammer(index) => numerical.hammers.get(index),
            ScatterGroup::Casting(index) => numerical.castings.get(index),
            ScatterGroup::Totals => Some(&numerical.totals),
        }
    }

    fn scatter_of(&self, group: ScatterGroup) -> Option<&ScatterOf> {
        let scatter = self.scatter()?;
        match group {
            ScatterGroup::Hammer(index) => scatter.hammers.get(index),
            ScatterGroup::Casting(index) => scatter.castings.get(index),
            ScatterGroup::Totals => Some(&scatter.totals),
        }
    }
}

/// Reads a value of a `T`, as [`Quantity::value`] does.
pub type Read<T> = for<'a> fn(&'a T) -> Cell<'a>;

/// Reads a spectrum of a core point.
pub type ReadSpectrum = fn(&CoreSpectrum) -> &[f64];

/// Source of a column's value. As plain data it shows which columns a struct provides.
#[derive(Clone, Copy)]
pub enum Get {
    Record(Read<RowRecord>),
    Outcome(Read<RowOutcome>),
    Counters(Read<Counters>),
    /// Index of the factor.
    Factor(usize),
    Aggregates(Read<Aggregates>),
    /// Index of the hammer.
    Hammer(usize, Read<HammerMetrics>),
    /// Index of the casting.
    Casting(usize, Read<CastingMetrics>),
    /// Index of the elastic casting among these.
    Elastic(usize, Read<ElasticMetrics>),
    /// Index of the one-sided fixture.
    Pad(usize, Read<PadMetrics>),
    /// Index of the fixture.
    Fixture(usize, Read<FixtureMetrics>),
    /// Index of the core point.
    Core(usize, Read<CoreMetrics>),
    /// Index of the core point, its spectrum, and the oscillator's place in it.
    CoreSpectrum(usize, ReadSpectrum, usize),
    CoreTotals(Read<CoreTotals>),
    Totals(Read<RunTotals>),
    Twins(Read<Scatter>),
    /// Group and name of the quantity.
    Scatter(ScatterGroup, &'static str),
    Numerical(Read<NumericalErrors>),
    /// Group and name of the quantity.
    NumericalError(ScatterGroup, &'static str),
    Blow(Read<Blow>),
    /// Null for a blow on a rigid casting.
    BlowStrain(Read<BlowStrain>),
    /// The name of the blow's hammer.
    BlowHammer,
    /// The name of the blow's casting.
    BlowCasting,
    /// Place in an instant of the table of signals.
    Instant(usize),
}

/// Subject of a scatter or of a numerical error.
#[derive(Clone, Copy)]
pub enum ScatterGroup {
    Hammer(usize),
    Casting(usize),
    Totals,
}

/// A column of a table.
pub struct Column {
    /// Everything but where its value comes from; apart, as a row that is written does not need it.
    pub description: Box<ColumnDescription>,
    pub(super) get: Get,
}

impl Column {
    /// A column that is described and read like this.
    pub fn new(description: ColumnDescription, get: Get) -> Self {
        Self { description: Box::new(description), get }
    }

    /// The column's value for one row of its table.
    pub fn cell<'s>(&self, source: &'s Source<'_>) -> Cell<'s> {
        let name = |names: &'s [String], index: usize| names.get(index).map(|name| Value::Text(name.as_str()));
        match self.get {
            Get::Record(read) => read(source.record),
            Get::Outcome(read) => read(source.outcome()),
            Get::Counters(read) => read(&source.outcome().counters),
            Get::Factor(index) => source.record.factors.get(index).map(Value::borrowed),
            Get::Aggregates(read) => source.aggregates.as_ref().and_then(read),
            Get::Hammer(index, read) => source.metrics()?.hammers.get(index).and_then(read),
            Get::Casting(index, read) => source.metrics()?.castings.get(index).and_then(read),
            Get::Elastic(index, read) => source.metrics()?.elastic.get(index).and_then(read),
            Get::Pad(index, read) => source.metrics()?.pads.get(index).and_then(read),
            Get::Fixture(index, read) => source.metrics()?.fixtures.get(index).and_then(read),
            Get::Core(index, read) => source.metrics()?.cores.get(index).and_then(read),
            Get::CoreSpectrum(index, read, place) => {
                let spectrum = source.metrics()?.cores.get(index)?.spectrum.as_ref()?;
                read(spectrum).get(place).copied().map(Value::Real)
            }
            Get::CoreTotals(read) => source.metrics()?.core_totals.as_ref().and_then(read),
            Get::Totals(read) => read(&source.metrics()?.totals),
            Get::Twins(read) => source.scatter().and_then(read),
            Get::Numerical(read) => source.numerical().and_then(read),
            Get::NumericalError(group, name) => source.numerical_of(group)?.get(name).copied()?.map(Value::Real),
            Get::Scatter(group, name) => source.scatter_of(group)?.get(name).copied()?.map(Value::Real),
            Get::Blow(read) => source.blow.and_then(read),
            Get::BlowStrain(read) => source.blow?.strain.as_ref().and_then(read),
            Get::BlowHammer => name(&source.info.hammers, source.blow?.hammer),
            Get::BlowCasting => name(&source.info.castings, source.blow?.casting),
            Get::Instant(place) => source.instant?.get(place).copied().map(Value::Real),
        }
    }
}
