//! Predictions for rows that were not run.

use std::path::Path;

use rayon::prelude::*;

use super::error::SurrogateError;
use super::model::{Model, OutputModel};
use super::result::OutputSurrogate;
use super::space::{FactorSpace, nearest, places};
use decore_dataset::TableColumn;
use decore_quantity::CellColumn;
use decore_statistics::regression::{Points, Prediction, RegressionError};
use decore_study::{TableRow, factor_rows};

/// Note on a row whose values the rows cover separately but not together.
const FAR: &str = "far from all rows";

/// Predictions of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// The factors as given, and for each output its expected value, standard deviation, interval and probability.
    pub columns: Vec<TableColumn>,
    /// Number of rows.
    pub rows: usize,
    /// Rows outside the ranges of the factors or far from the model's rows: their predictions are guesses.
    pub outside: usize,
}

impl Predicted {
    /// Returns warnings, a sentence each: rows whose prediction is a guess, poor models.
    pub fn warnings(&self, model: &Model) -> Vec<String> {
        let (outside, rows) = (self.outside, self.rows);
        let guess = (outside > 0).then(|| {
            format!(
                "{outside} of {rows} rows lie outside the ranges of the factors or far from the model's rows (column `extrapolated`): their \
                 predictions are guesses"
            )
        });
        guess.into_iter().chain(model.surrogate.warnings()).collect()
    }
}

/// Predicts the rows of a CSV or Parquet file with a column for each factor, named like it or `factor_` and its name.
///
/// # Errors
/// [`SurrogateError::Table`] for a file or a cell that cannot be read, naming the row and the column; [`SurrogateError::Empty`].
pub fn predict(model: &Model, table: &Path) -> Result<Predicted, SurrogateError> {
    let factors = &model.surrogate.factors;
    let names: Vec<&str> = factors.iter().map(|factor| factor.name.as_str()).collect();
    let rows = factor_rows(table, &names).map_err(SurrogateError::Table)?;
    let place = |row: &TableRow| format!("{}, {}", table.display(), row.place);
    predict_rows(model, &rows.iter().map(|row| QueryRow { place: place(row), cells: &row.cells }).collect::<Vec<_>>())
}

/// A row to be predicted.
#[derive(Debug, Clone)]
pub struct QueryRow<'a> {
    /// Place of the table, for errors.
    pub place: String,
    /// Values of the factors, in the model's order, as texts.
    pub cells: &'a [String],
}

/// Predicts rows.
///
/// # Errors
/// [`SurrogateError::Table`] for a cell that cannot be read, naming the row and the factor; [`SurrogateError::Empty`] for a model that
/// predicts nothing.
pub fn predict_rows(model: &Model, rows: &[QueryRow<'_>]) -> Result<Predicted, SurrogateError> {
    model.check()?;
    let factors = &model.surrogate.factors;
    let values = rows.iter().map(|row| read_row(model, row)).collect::<Result<Vec<Vec<f64>>, _>>()?;
    let named = |output: &str| {
        let output = output.to_owned();
        move |source| SurrogateError::Regression { output, source }
    };
    let places = places(factors, &values).map_err(named("the factors"))?;
    let outside = outside(model, &values, &places);
    let mut columns = vec![TableColumn {
        name: "row".to_owned(),
        unit: "1".to_owned(),
        description: "Place of the row in the table, from 0.".to_owned(),
        values: CellColumn::integers(0..rows.len() as i64),
    }];
    for (place, factor) in factors.iter().enumerate() {
        let values = match factor.names.is_empty() {
            true => CellColumn::reals(values.iter().map(|row| row[place])),
            false => CellColumn::texts(rows.iter().map(|row| &row.cells[place])),
        };
        let description = format!("Factor `{}` of the study.", factor.name);
        columns.push(TableColumn {
            name: format!("factor_{}", factor.name),
            unit: factor.unit.clone(),
            description,
            values,
        });
    }
    columns.push(TableColumn {
        name: "extrapolated".to_owned(),
        unit: String::new(),
        description:
            "Factors outside the model's range, or beyond its rows; `far from all rows` if their values are covered \
             separately but not together; empty among the rows."
                .to_owned(),
        values: CellColumn::texts(&outside),
    });
    for (output, of) in model.surrogate.outputs.iter().zip(&model.outputs) {
        columns.extend(output_columns((output, of), &places).map_err(named(&output.output))?);
    }
    let outside = outside.iter().filter(|factors| !factors.is_empty()).count();
    Ok(Predicted { columns, rows: rows.len(), outside })
}

fn read_row(model: &Model, row: &QueryRow<'_>) -> Result<Vec<f64>, SurrogateError> {
    let cells = row.cells.iter().zip(&model.surrogate.factors);
    let value = |(cell, factor): (&String, &FactorSpace)| {
        let told = |message| SurrogateError::Table(format!("{}, column `{}`: {message}", row.place, factor.name));
        factor.read(cell).map_err(told)
    };
    cells.map(value).collect()
}

/// For each row the factors with values outside the model's range, or a note that it is far from all rows.
fn outside(model: &Model, values: &[Vec<f64>], places: &Points) -> Vec<String> {
    let used = model.points.select(&Model::used(&model.outputs, model.points.rows()));
    let covered = model.surrogate.covered_distance.filter(|_| used.rows() > 0);
    let row = |row: usize| {
        let factors = model.surrogate.factors.iter().zip(&values[row]);
        let outside = factors.filter(|(factor, value)| factor.is_outside(**value));
        let names: Vec<&str> = outside.map(|(factor, _)| factor.name.as_str()).collect();
        let is_far = || covered.is_some_and(|covered| nearest(&used, places.row(row), None) > covered);
        if names.is_empty() && is_far() { FAR.to_owned() } else { names.join(", ") }
    };
    (0..values.len()).into_par_iter().map(row).collect()
}

/// Returns the columns of an output; none if its model is refused.
fn output_columns(
    (output, model): (&OutputSurrogate, &OutputModel),
    places: &Points,
) -> Result<Vec<TableColumn>, RegressionError> {
    let (Some(process), Some(figures)) = (&model.process, &output.process) else { return Ok(Vec::new()) };
    let predicted = process.process.predict(places)?;
    let column = |suffix: &str, description: String, value: &dyn Fn(&Prediction) -> f64| TableColumn {
        name: format!("{}{suffix}", output.output),
        unit: output.unit.clone(),
        description,
        values: CellColumn::reals(predicted.iter().map(value)),
    };
    let reach = figures.reach;
    let mut columns = vec![
        column("", format!("{} Expected value.", output.description), &|at| at.mean),
        column("_std_dev", "Standard deviation of a new row, noise included.".to_owned(), &|at| at.std_dev),
        column("_low", "Lower end of the interval of a new row.".to_owned(), &|at| at.mean - reach * at.std_dev),
        column("_high", "Upper end of the interval of a new row.".to_owned(), &|at| at.mean + reach * at.std_dev),
    ];
    if let Some(of) = model.success_of(output) {
        columns.push(TableColumn {
            name: format!("{}_probability", output.output),
            unit: "1".to_owned(),
            description: "Probability that a row is done and has the output.".to_owned(),
            values: CellColumn::reals(of.predict(places)?),
        });
    }
    Ok(columns)
}
