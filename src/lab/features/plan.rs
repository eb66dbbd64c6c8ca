//! Columns of the table, and the sources of their cells.

use super::column::{FeatureColumn, Role};
use super::figures::{CastingFigure, Combine, Origin};
use super::settings::FeatureSettings;
use super::signals::{HeaveFigures, SignalRows, not_negative};
use super::struck::Struck;
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetReader, TableName};
use decore_model::metrics::{CoreMetrics, CoreTotals, RunTotals};
use decore_quantity::words::identifier;
use decore_quantity::{Cell, CellColumn, Kind, Value};
use decore_study::{DesignOutline, FactorOutline};

/// Columns of `runs` to read, each once.
#[derive(Default)]
pub(super) struct Reads<'a>(Vec<&'a str>);

impl<'a> Reads<'a> {
    /// The place of a column among those read.
    pub fn place(&mut self, name: &'a str) -> usize {
        self.0.iter().position(|known| *known == name).unwrap_or_else(|| {
            self.0.push(name);
            self.0.len() - 1
        })
    }

    /// Names in the order of their places.
    pub fn names(&self) -> &[&'a str] {
        &self.0
    }
}

/// The column of a factor in `runs`.
pub(super) fn factor_column<'a>(reader: &'a DatasetReader, factor: &str) -> Option<&'a ColumnDescription> {
    let of_it =
        |column: &&ColumnDescription| column.group == ColumnGroup::Factor && column.subject.as_deref() == Some(factor);
    reader.columns(TableName::Runs).iter().find(of_it)
}

/// Source of a column's cells; places refer to [`Reads`].
enum CellSource {
    /// The name of the casting.
    CastingName,
    /// A cell of the run.
    Run(usize),
    /// A cell of the run for each casting.
    Castings(Vec<Option<usize>>),
    /// Cells of the run for each hammer; the hammers of the casting are combined.
    Hammers(Vec<Option<usize>>, Combine),
    /// The number of hammers on the casting.
    HammerCount,
    /// Figure summed over the blows.
    Blows(fn(&Struck) -> Option<f64>),
    /// The same as a number of blows.
    BlowCount(fn(&Struck) -> u64),
    /// A figure of the heave velocity, by its place.
    Heave(usize),
    /// The least of some cells of the run for each casting.
    Least(Vec<Vec<usize>>),
    /// Sand and binder of the cores.
    Binder,
}

/// A column and where its cells come from.
struct ColumnPlan {
    column: FeatureColumn,
    source: CellSource,
}

/// One run and one of its castings.
pub(super) struct View<'a> {
    /// Cells of the run.
    pub cells: &'a [Cell<'a>],
    /// Name of the casting.
    pub name: &'a str,
    /// Place among the castings.
    pub casting: usize,
    /// The casting of each hammer.
    pub castings: &'a [usize],
    /// Sums over the blows on the casting.
    pub struck: Struck,
    /// Figures of the heave velocity, if it is stored.
    pub heave: Option<&'a HeaveFigures>,
    /// Sand and binder of its cores, where the study states them.
    pub binder: Option<&'a str>,
}

impl View<'_> {
    fn at(&self, place: usize) -> Cell<'_> {
        self.cells.get(place).copied().flatten()
    }

    /// A cell of the table; `has_outputs`: whether the run has any.
    fn cell(&self, source: &CellSource, has_outputs: bool) -> Cell<'_> {
        match source {
            CellSource::CastingName => Some(Value::Text(self.name)),
            CellSource::Binder => self.binder.map(Value::Text),
            CellSource::Least(places) => {
                let own = places.get(self.casting)?.iter().filter_map(|place| self.at(*place)?.number());
                Combine::Least.of(own).map(Value::Real)
            }
            CellSource::Run(place) => self.at(*place),
            CellSource::Castings(places) => self.at((*places.get(self.casting)?)?),
            CellSource::HammerCount => {
                Some(Value::Count(self.castings.iter().filter(|casting| **casting == self.casting).count() as u64))
            }
            CellSource::Heave(place) => self.heave?.get(*place).copied().flatten().map(Value::Real),
            // A run without outputs has no blows either: nothing is not zero there.
            _ if !has_outputs => None,
            CellSource::Hammers(places, combine) => {
                let own = places.iter().zip(self.castings).filter(|(_, casting)| **casting == self.casting);
                combine.of(own.filter_map(|(place, _)| self.at((*place)?)?.number())).map(Value::Real)
            }
            CellSource::Blows(figure) => figure(&self.struck).map(Value::Real),
            CellSource::BlowCount(figure) => Some(Value::Count(figure(&self.struck))),
        }
    }
}

/// The columns of the table, filled row by row.
pub(super) struct Planned<'a> {
    reader: &'a DatasetReader,
    plans: Vec<ColumnPlan>,
    /// Place of a cell that every run with outputs has.
    outputs: usize,
    /// Whether blows may be too weak for the dose.
    has_threshold: bool,
}

impl<'a> Planned<'a> {
    /// A table without columns.
    pub fn new(reader: &'a DatasetReader, reads: &mut Reads<'a>, settings: &FeatureSettings) -> Self {
        let outputs = reads.place(RunTotals::energy_residual.name);
        Self { reader, plans: Vec::new(), outputs, has_threshold: settings.dose_threshold_j > 0.0 }
    }

    /// Adds a row.
    pub fn push(&mut self, view: &View<'_>) {
        let has_outputs = view.at(self.outputs).is_some();
        self.plans.iter_mut().for_each(|plan| plan.column.values.push(view.cell(&plan.source, has_outputs)));
    }

    /// The columns with their rows.
    pub fn columns(self) -> Vec<FeatureColumn> {
        self.plans.into_iter().map(|plan| plan.column).collect()
    }

    /// The name of the casting.
    pub fn add_casting(&mut self) {
        let column = FeatureColumn {
            name: "casting".to_owned(),
            unit: String::new(),
            role: Role::Key,
            description: "Name of the casting, as in the study.".to_owned(),
            formula: "castings of the study".to_owned(),
            valid: [None, None],
            derived_from: Vec::new(),
            values: CellColumn::new(Kind::Category),
        };
        self.plans.push(ColumnPlan { column, source: CellSource::CastingName });
    }

    /// The sand and binder of the cores.
    pub fn add_binder(&mut self) {
        let column = FeatureColumn {
            name: "sand_binder".to_owned(),
            unit: String::new(),
            role: Role::Group,
            description: "Sand and binder of the casting's cores, as in the study.".to_owned(),
            formula: "casting.NAME.sand_binder of the study".to_owned(),
            valid: [None, None],
            derived_from: Vec::new(),
            values: CellColumn::new(Kind::Category),
        };
        self.plans.push(ColumnPlan { column, source: CellSource::Binder });
    }

    /// The figures of core points: a column per figure and name of a core point, null for castings without a core point of that name; and
    /// the least over the core points of the casting.
    pub fn add_cores(&mut self, reads: &mut Reads<'a>) {
        let info = &self.reader.manifest().study;
        let mut names: Vec<&str> = Vec::new();
        for core in &info.cores {
            if !names.contains(&core.name.as_str()) {
                names.push(&core.name);
            }
        }
        for (quantity, title, text) in LEAST_CORE {
            let own = |casting: &String| {
                let cores = info.cores.iter().filter(|core| core.casting == *casting);
                cores.filter_map(|core| self.core_place(reads, (casting, &core.name), quantity)).collect()
            };
            let places: Vec<Vec<usize>> = info.castings.iter().map(own).collect();
            if let Some(unit) = self.unit_of(&places, reads) {
                let formula = format!("least of runs.CASTING_core_NAME_{quantity} over the core points of the casting");
                self.add_core(CellSource::Least(places), (title.to_owned(), unit), [text.to_owned(), formula]);
            }
        }
        for name in names {
            for quantity in CoreMetrics::QUANTITIES {
                let places: Vec<Option<usize>> = info
                    .castings
                    .iter()
                    .map(|casting| self.core_place(reads, (casting, name), quantity.name))
                    .collect();
                if places.iter().any(Option::is_some) {
                    let title = identifier(&format!("core_{name}_{}", quantity.name), "core");
                    let texts = [
                        format!("Core point `{name}`: {}", quantity.description()),
                        format!("runs.CASTING_core_{name}_{}", quantity.name),
                    ];
                    self.add_core(CellSource::Castings(places), (title, quantity.unit.to_owned()), texts);
                }
            }
        }
    }

    fn add_core(&mut self, source: CellSource, (name, unit): (String, String), [description, formula]: [String; 2]) {
        let column = not_negative(name, &unit, (description, formula));
        self.plans.push(ColumnPlan { column, source });
    }

    /// Place of a figure of a casting's core point.
    fn core_place(&self, reads: &mut Reads<'a>, (casting, name): (&str, &str), quantity: &str) -> Option<usize> {
        let subject = format!("{casting}.{name}");
        let of_it = |column: &&ColumnDescription| {
            column.group == ColumnGroup::Core
                && column.subject.as_deref() == Some(&subject)
                && column.quantity == quantity
        };
        self.reader.columns(TableName::Runs).iter().find(of_it).map(|column| reads.place(&column.name))
    }

    /// Unit of the columns at some places; `None` if there are none.
    fn unit_of(&self, places: &[Vec<usize>], reads: &Reads<'a>) -> Option<String> {
        let name = reads.names().get(*places.iter().flatten().next()?)?;
        self.reader.column(TableName::Runs, name).ok().map(|column| column.unit.clone())
    }

    /// A column of `runs` as it is.
    pub fn add_run(&mut self, reads: &mut Reads<'a>, name: &str, role: Role) {
        let reader = self.reader;
        let Some(description) = reader.columns(TableName::Runs).iter().find(|column| column.name == name) else {
            return;
        };
        let column = FeatureColumn {
            name: name.to_owned(),
            unit: description.unit.clone(),
            role,
            description: description.description.clone(),
            formula: format!("runs.{name}"),
            valid: [Some(0.0).filter(|_| !description.kind.is_text()), None],
            derived_from: Vec::new(),
            values: CellColumn::new(description.kind),
        };
        self.plans.push(ColumnPlan { column, source: CellSource::Run(reads.place(&description.name)) });
    }

    /// Adds the factors, with their ranges in the study.
    pub fn add_factors(&mut self, reads: &mut Reads<'a>, outline: &DesignOutline) {
        let reader = self.reader;
        let factors = reader.columns(TableName::Runs).iter().filter(|column| column.group == ColumnGroup::Factor);
        for factor in factors {
            self.add_run(reads, &factor.name, Role::Factor);
            let said = outline.factors.iter().find(|said| Some(&said.name) == factor.subject.as_ref());
            if let (Some(ColumnPlan { column, .. }), Some(said)) = (self.plans.last_mut(), said) {
                column.valid = valid(said);
                column.derived_from = ancestors(reader, outline, said);
                if let Some(expression) = &said.expression {
                    column.formula = expression.clone();
                }
            }
        }
    }

    /// Adds a figure, its standard error, and its scatter if the dataset has twins.
    pub fn add_figure(&mut self, reads: &mut Reads<'a>, figure: &CastingFigure) {
        let (name, words) = (figure.name, figure.description.trim_end_matches('.'));
        let kind = figure.kind();
        self.add(
            reads,
            figure,
            ColumnTitle { name: name.to_owned(), description: figure.description.to_owned(), kind },
        );
        let kind = Kind::Real;
        let scatter = figure.scatter.filter(|_| self.reader.manifest().study.twins > 0);
        if let (Some(combine), Some(quantity)) = (scatter, figure.origin.quantity()) {
            let quantity = format!("{quantity}_scatter");
            let origin = match figure.origin {
                Origin::Hammers(..) => Origin::Hammers(&quantity, combine),
                _ => Origin::Casting(&quantity),
            };
            let description = format!("Scatter over the run and its twins, half the range, of: {words}.");
            self.add(
                reads,
                &figure.sureness(origin),
                ColumnTitle { name: format!("{name}_scatter"), description, kind },
            );
        }
        if let Some(error) = figure.error {
            let description = format!("Standard error of: {words}.");
            let shown = ColumnTitle { name: error.to_owned(), description, kind };
            self.add(reads, &figure.sureness(Origin::Hammers(error, Combine::ErrorOfMean)), shown);
        }
    }

    /// The figures of the heave velocities that are kept.
    pub fn add_signals(&mut self, signals: &SignalRows) {
        let plans = signals
            .columns()
            .into_iter()
            .map(|(place, column)| ColumnPlan { column, source: CellSource::Heave(place) });
        self.plans.extend(plans);
    }

    fn add(&mut self, reads: &mut Reads<'a>, figure: &CastingFigure<'_>, shown: ColumnTitle) {
        let source = match figure.origin {
            Origin::Run(name) => {
                self.add_run(reads, name, figure.role);
                return self.describe_last(figure);
            }
            Origin::Casting(quantity) => CellSource::Castings(self.places(reads, ColumnGroup::Casting, quantity)),
            Origin::Hammers(quantity, combine) => {
                CellSource::Hammers(self.places(reads, ColumnGroup::Hammer, quantity), combine)
            }
            Origin::HammerCount => CellSource::HammerCount,
            Origin::Blows(figure, _) => CellSource::Blows(figure),
            Origin::BlowCount(figure, _) => CellSource::BlowCount(figure),
        };
        let derived_from = if self.has_threshold { &[] } else { figure.without_threshold };
        let column = FeatureColumn {
            name: shown.name,
            unit: figure.unit.to_owned(),
            role: figure.role,
            description: shown.description,
            formula: figure.formula(),
            valid: [figure.least, None],
            derived_from: derived_from.iter().map(|name| (*name).to_owned()).collect(),
            values: CellColumn::new(shown.kind),
        };
        self.plans.push(ColumnPlan { column, source });
    }

    fn describe_last(&mut self, figure: &CastingFigure<'_>) {
        if let Some(ColumnPlan { column, .. }) = self.plans.last_mut() {
            column.description = figure.description.to_owned();
            column.valid = [figure.least.filter(|_| !column.values.kind().is_text()), None];
        }
    }

    /// The places of a quantity's columns, one per hammer or casting.
    fn places(&self, reads: &mut Reads<'a>, group: ColumnGroup, quantity: &str) -> Vec<Option<usize>> {
        let (reader, info) = (self.reader, &self.reader.manifest().study);
        let names = if group == ColumnGroup::Hammer { &info.hammers } else { &info.castings };
        let of = |name: &String| {
            let of_it = |column: &&ColumnDescription| {
                column.group == group && column.subject.as_ref() == Some(name) && column.quantity == quantity
            };
            reader.columns(TableName::Runs).iter().find(of_it).map(|column| reads.place(&column.name))
        };
        names.iter().map(of).collect()
    }
}

/// Figures of which the least over the core points of a casting is a column: quantity, name of the column, text.
const LEAST_CORE: [(&str, &str, &str); 2] = [
    (
        CoreMetrics::pseudo_velocity_98hz_10khz_m_s.name,
        CoreTotals::least_core_pseudo_velocity_98hz_10khz_m_s.name,
        "Least over the casting's core points of the largest pseudo-velocity of the run, 98 Hz to 10 kHz.",
    ),
    (
        CoreMetrics::dose_98hz_10khz.name,
        CoreTotals::least_core_dose_98hz_10khz.name,
        "Least dose over the casting's core points.",
    ),
];

/// Title of a figure's column.
struct ColumnTitle {
    name: String,
    description: String,
    kind: Kind,
}

/// The ends of a factor's values as the study gives them.
fn valid(said: &FactorOutline) -> [Option<f64>; 2] {
    match said.range {
        Some([low, high]) => [Some(low), Some(high)],
        None => {
            let numbers = || said.values.iter().filter_map(|value| value.number());
            [numbers().reduce(f64::min), numbers().reduce(f64::max)]
        }
    }
}

/// Columns of the factors that the expression of a derived one names.
fn ancestors(reader: &DatasetReader, outline: &DesignOutline, said: &FactorOutline) -> Vec<String> {
    let text = said.expression.as_deref().unwrap_or_default();
    let words = || text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    let named = outline.factors.iter().filter(|factor| words().any(|word| word == factor.name));
    named.filter_map(|factor| factor_column(reader, &factor.name)).map(|column| column.name.clone()).collect()
}
