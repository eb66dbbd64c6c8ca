//! Fits a model to a dataset.

use rayon::prelude::*;

use super::error::SurrogateError;
use super::levels::remarks;
use super::model::{Model, OutputModel, RowsProcess};
use super::result::{ChaosFigures, OutputSurrogate, ProcessFigures, SuccessFigures, Surrogate};
use super::rows::FactorRows;
use super::space::covered_distance;
use crate::sensitivity::{DEFAULT_OUTPUTS, OutputColumn, Table, UnitName, Units};
use decore_dataset::{ColumnDescription, ColumnGroup, DatasetReader, TableName};
use decore_quantity::Kind;
use decore_statistics::regression::{
    GaussianProcess, LEAST_NOISE, Places, Points, PolynomialChaos, RegressionError, Spread, Success, check,
};

/// Probability of an interval.
const LEVEL: f64 = 0.95;

/// Message for values whose squares are out of range.
const NOT_FINITE: &str = "its values are too large or too small to be squared, or rounding is all that they differ by";

/// Settings of the models.
#[derive(Debug, Clone, PartialEq)]
pub struct SurrogateSettings {
    /// Columns of `runs`; empty (default): [`DEFAULT_OUTPUTS`].
    pub outputs: Vec<String>,
    /// Q2 below which a model warns at every use. Default 0.9.
    pub least_q2: f64,
    /// Least noise, as a share of an output's variance. Default [`LEAST_NOISE`].
    pub least_noise: f64,
}

impl Default for SurrogateSettings {
    fn default() -> Self {
        Self { outputs: Vec::new(), least_q2: 0.9, least_noise: LEAST_NOISE }
    }
}

/// A value that rows have: a column of `runs`, or computed from several.
pub struct Derived<'a> {
    /// Name: of a column, or of its own.
    pub name: String,
    /// Unit; `1` if there is none.
    pub unit: String,
    /// Columns that it is computed from.
    pub columns: Vec<String>,
    /// Value from the values of the columns.
    pub value: &'a (dyn Fn(&[f64]) -> f64 + Sync),
}

/// Reads a dataset and models its outputs. If the dataset is still being written, its present rows count.
///
/// # Errors
/// Those of reading, [`SurrogateError::NoFactors`], [`SurrogateError::Twice`]. An output that has no model (constant, too few rows)
/// is no error: it says why.
pub fn fit(reader: &DatasetReader, settings: &SurrogateSettings) -> Result<Model, SurrogateError> {
    fit_with(reader, &[], settings)
}

/// As [`fit`], with the rows of other datasets with the same factors.
///
/// # Errors
/// As [`fit`].
pub fn fit_with(
    reader: &DatasetReader,
    others: &[&DatasetReader],
    settings: &SurrogateSettings,
) -> Result<Model, SurrogateError> {
    let known = |name: &str| reader.columns(TableName::Runs).iter().any(|column| column.name == name);
    let outputs: Vec<String> = match settings.outputs.as_slice() {
        [] => DEFAULT_OUTPUTS.iter().filter(|name| known(name)).map(|name| (*name).to_owned()).collect(),
        some => some.to_vec(),
    };
    if let Some(output) = (1..outputs.len()).find(|place| outputs[..*place].contains(&outputs[*place])) {
        return Err(SurrogateError::Twice { output: outputs[output].clone() });
    }
    let alone =
        |name: String| Derived { columns: vec![name.clone()], name, unit: String::new(), value: &|values| values[0] };
    let derived: Vec<Derived<'_>> = outputs.into_iter().map(alone).collect();
    fit_derived(reader, others, (&derived, settings))
}

/// Reads a dataset, and others with the same factors, and models values of their rows. A value that is not finite is none.
///
/// # Errors
/// Those of reading, [`SurrogateError::NoFactors`].
pub fn fit_derived(
    reader: &DatasetReader,
    others: &[&DatasetReader],
    (derived, settings): (&[Derived<'_>], &SurrogateSettings),
) -> Result<Model, SurrogateError> {
    let info = &reader.manifest().study;
    let known = |name: &str| reader.columns(TableName::Runs).iter().any(|column| column.name == name);
    let mut read: Vec<String> = Vec::new();
    for name in derived.iter().flat_map(|derived| &derived.columns) {
        if !read.contains(name) {
            read.push(name.clone());
        }
    }
    let columns = read.len();
    read.extend(derived.iter().map(|derived| scatter_of(&derived.name)).filter(|name| known(name)));
    let FactorRows { mut table, mut factors, points, rows_there, mut notes } = FactorRows::read(reader, others, &read)?;
    let scatters = table.outputs.split_off(columns);
    table.outputs = derived.iter().map(|derived| derived.column(&table.outputs)).chain(scatters).collect();
    let rows = info.rows + others.iter().map(|other| other.manifest().study.rows).sum::<u64>();
    let units = Units {
        name: UnitName::Rows,
        size: 1,
        rows: if rows_there > table.rows.len() { table.rows.len() as u64 } else { rows },
    };
    let task = FitRows { table: &table, points: &points, units, least_noise: settings.least_noise };
    let (figures, models): (Vec<OutputSurrogate>, Vec<OutputModel>) = table.outputs[..derived.len()]
        .par_iter()
        .map(|output| task.output(output))
        .collect::<Vec<_>>()
        .into_iter()
        .unzip();
    let used = Model::used(&models, table.rows.len());
    if !used.is_empty() {
        for (factor, column) in factors.iter_mut().zip(&table.factors) {
            factor.cover(&used.iter().map(|row| column.values[*row]).collect::<Vec<f64>>());
        }
        notes.extend(remarks(&factors, &table, &used, info));
    }
    let surrogate = Surrogate {
        study: info.study_name.clone(),
        study_hash: info.study_hash.clone(),
        program_version: info.program_version.clone(),
        rows,
        rows_there: rows_there as u64,
        factors,
        covered_distance: covered_distance(&points.select(&used)),
        least_q2: settings.least_q2,
        level: LEVEL,
        notes,
        outputs: figures,
    };
    Ok(Model { surrogate, info: info.clone(), rows: table.rows, points, outputs: models })
}

impl Derived<'_> {
    /// The values from columns that were read; a column as it is where it is one.
    fn column(&self, read: &[OutputColumn]) -> OutputColumn {
        let own = |name: &String| read.iter().find(|column| column.description.name == *name);
        let columns: Vec<&OutputColumn> = self.columns.iter().filter_map(own).collect();
        if let [column] = columns.as_slice()
            && column.description.name == self.name
        {
            return (*column).clone();
        }
        let rows = columns.first().map_or(0, |column| column.values.len());
        let value = |row: usize| (self.value)(&columns.iter().map(|column| column.values[row]).collect::<Vec<f64>>());
        let description = ColumnDescription {
            name: self.name.clone(),
            kind: Kind::Real,
            unit: self.unit.clone(),
            description: format!("Computed from {}.", self.columns.join(", ")),
            group: ColumnGroup::Other,
            subject: None,
            quantity: self.name.clone(),
            main: false,
            less: false,
        };
        OutputColumn { description, values: (0..rows).map(value).collect() }
    }
}

/// Column with an output's scatter over twins.
fn scatter_of(output: &str) -> String {
    format!("{output}_scatter")
}

/// Rows that outputs are modelled from.
struct FitRows<'a> {
    table: &'a Table,
    points: &'a Points,
    units: Units,
    least_noise: f64,
}

impl FitRows<'_> {
    fn output(&self, output: &OutputColumn) -> (OutputSurrogate, OutputModel) {
        let whole = self.units.whole(self.table, output);
        let rows = whole.starts;
        let values: Vec<f64> = rows.iter().map(|row| output.values[*row]).collect();
        let description = output.description.clone();
        let mut figures = OutputSurrogate {
            output: description.name,
            unit: description.unit,
            description: description.description,
            used: rows.len() as u64,
            left_out: whole.used.left_out,
            refused: None,
            process: None,
            chaos: None,
            chaos_refused: None,
            success: None,
            twin_scatter: self.twin_scatter(&output.description.name),
        };
        let mut model = OutputModel::default();
        match self.process((&values, &rows), figures.twin_scatter) {
            Ok((process, found)) => {
                let (points, groups) = (process.process.places().points(), process.process.groups());
                match PolynomialChaos::fit(points, &process.values, groups) {
                    Ok(of) if of.residuals.q2().is_finite() => {
                        figures.chaos =
                            Some(ChaosFigures { degree: of.degree, terms: of.terms, q2: of.residuals.q2() });
                    }
                    Ok(_) => figures.chaos_refused = Some(NOT_FINITE.to_owned()),
                    Err(error) => figures.chaos_refused = Some(error.to_string()),
                }
                figures.process = Some(found);
                model.process = Some(process);
                match self.success(&rows) {
                    Ok(found) => (figures.success, model.success) = found,
                    Err(error) => figures.refused = Some(format!("no probability of success: {error}")),
                }
            }
            Err(reason) => figures.refused = Some(format!("no model: {reason}")),
        }
        if let (None, Err(RegressionError::Constant { value })) =
            (&model.process, check(&self.points.select(&rows), &values))
        {
            model.constant = Some(value);
        }
        (figures, model)
    }

    /// The process of rows with these values, and its figures.
    ///
    /// # Errors
    /// Reason for the missing model.
    fn process(
        &self,
        (values, rows): (&[f64], &[usize]),
        twin_scatter: Option<f64>,
    ) -> Result<(RowsProcess, ProcessFigures), String> {
        let words = |error: RegressionError| error.to_string();
        let places = Places::new(&self.points.select(rows), values).map_err(words)?;
        // The scatter of twins counts as one more run per place.
        let places = match twin_scatter {
            Some(scatter) => {
                let freedom = places.values().len() as f64;
                places.with_spread(Spread { squares: freedom * scatter * scatter, freedom })
            }
            None => places,
        };
        let process = GaussianProcess::fit_above(&places, self.least_noise).map_err(words)?;
        let folds = process.folds().map_err(words)?;
        let process = RowsProcess::new(process, rows);
        let figures = process.figures(folds.as_ref(), LEVEL);
        if figures.are_finite() { Ok((process, figures)) } else { Err(NOT_FINITE.to_owned()) }
    }

    /// Probability that a row has the output, if some have not; `with`: the rows that have it.
    fn success(&self, with: &[usize]) -> Result<(Option<SuccessFigures>, Option<RowsProcess>), RegressionError> {
        let all = self.points.rows();
        if with.len() == all {
            return Ok((None, None));
        }
        let succeeded: Vec<bool> = (0..all).map(|row| with.binary_search(&row).is_ok()).collect();
        let share = with.len() as f64 / all as f64;
        Ok(match Success::fit(self.points, &succeeded)? {
            Success::Everywhere(probability) => {
                let figures = SuccessFigures { share, everywhere: Some(probability), process: None, scaling: None };
                (Some(figures), None)
            }
            Success::ByPlace { process, scaling } => {
                let of = RowsProcess::new(*process, &(0..all).collect::<Vec<usize>>());
                let own = Some(of.figures(None, LEVEL));
                (Some(SuccessFigures { share, everywhere: None, process: own, scaling: Some(scaling) }), Some(of))
            }
        })
    }

    /// Median scatter of the rows' twins.
    fn twin_scatter(&self, output: &str) -> Option<f64> {
        let name = scatter_of(output);
        let column = self.table.outputs.iter().find(|column| column.description.name == name)?;
        let mut values: Vec<f64> = column.values.iter().copied().filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    }
}
