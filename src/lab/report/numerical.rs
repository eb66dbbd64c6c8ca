//! Numerical errors of the main outputs over the rows that have a numerical twin.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::numbers::significant;
use decore_dataset::{ColumnDescription, DatasetError, DatasetReader, TableName};
use decore_model::metrics::NumericalErrors;
use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::{Cell, Value};

/// Decades of relative errors: from 10^-17 to 10^3.
const DECADES: std::ops::Range<i32> = -17..3;
/// Classes of a decade: the median is sure to a hundredth.
const CLASSES: f64 = 100.0;

/// Numerical errors of one output, relative to its value, over all hammers or castings that have it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OutputError {
    /// Name of the output, without hammer or casting.
    pub output: String,
    /// Number of values with an error.
    pub count: u64,
    /// Median of the relative errors, to 2 %.
    pub median: f64,
    /// Largest relative error.
    pub worst: f64,
    /// Row with the largest relative error.
    pub worst_row: u64,
    /// Column of the output that has the largest relative error.
    pub worst_column: String,
}

/// Numerical twins of rows, and their results.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NumericalTwins {
    /// Rows that are done and whose numerical twin was simulated to its end.
    pub rows: u64,
    /// Rows that are done and whose numerical twin did not reach its end.
    pub not_done: u64,
    /// Rows with an error beyond the promise of their preset.
    pub beyond_promise: u64,
    /// Row with the largest error relative to its promise; null without such an error.
    pub worst_row: Option<u64>,
    /// Largest error of that row over its promise.
    pub worst_over_promise: f64,
    /// Share of the rows' wall time that numerical twins took; null if no time is known.
    pub share_of_time: Option<f64>,
    /// Errors output by output.
    pub outputs: Vec<OutputError>,
}

/// An output whose errors are gathered.
struct Gathered<'a> {
    error: OutputError,
    /// Number of errors by class.
    classes: Vec<u64>,
    /// Columns of the output, each with the column of its error.
    columns: Vec<(&'a ColumnDescription, String)>,
}

impl<'a> Gathered<'a> {
    fn new(output: &str) -> Self {
        let error = OutputError {
            output: output.to_owned(),
            count: 0,
            median: 0.0,
            worst: 0.0,
            worst_row: 0,
            worst_column: String::new(),
        };
        Self { error, classes: vec![0; DECADES.len() * CLASSES as usize], columns: Vec::new() }
    }

    fn add(&mut self, row: u64, column: usize, relative: f64) {
        let decade = relative.log10() - f64::from(DECADES.start);
        // No error at all is in the first class, one that is not a number in the last.
        let class = if decade.is_nan() { self.classes.len() - 1 } else { (decade * CLASSES) as usize };
        let last = self.classes.len() - 1;
        self.classes[class.min(last)] += 1;
        let error = &mut self.error;
        error.count += 1;
        if error.count == 1 || relative > error.worst {
            let name = self.columns.get(column).map_or(String::new(), |(column, _)| column.name.clone());
            (error.worst, error.worst_row, error.worst_column) = (relative, row, name);
        }
    }

    /// The errors with their median: the middle of the class that half of them do not exceed.
    fn finish(self) -> OutputError {
        let mut seen = 0;
        let reaches_half = |count: &u64| {
            seen += count;
            2 * seen >= self.error.count
        };
        let class = self.classes.iter().position(reaches_half).unwrap_or(0);
        let middle = 10_f64.powf((class as f64 + 0.5) / CLASSES + f64::from(DECADES.start));
        let median = if class == 0 { 0.0 } else { middle.min(self.error.worst) };
        OutputError { median, ..self.error }
    }
}

/// Gathers the numerical errors of a dataset; `None` if no row has a numerical twin. Memory is bounded, whatever the number of rows.
pub(super) fn numerical_twins(reader: &DatasetReader) -> Result<Option<NumericalTwins>, DatasetError> {
    let columns = reader.columns(TableName::Runs);
    let mut gathered = gathered(columns);
    if gathered.is_empty() {
        return Ok(None);
    }
    let pairs = gathered.iter().flat_map(|one| &one.columns);
    let names: Vec<String> = pairs.flat_map(|(column, error)| [column.name.clone(), error.clone()]).collect();
    let fixed = [
        decore_dataset::RowRecord::row.name,
        RowOutcome::status.name,
        NumericalErrors::numerical_twin_done.name,
        NumericalErrors::numerical_errors_beyond_promise.name,
        NumericalErrors::worst_numerical_error_over_promise.name,
    ];
    let all: Vec<&str> = fixed.into_iter().chain(names.iter().map(String::as_str)).collect();
    let mut found = NumericalTwins {
        rows: 0,
        not_done: 0,
        beyond_promise: 0,
        worst_row: None,
        worst_over_promise: 0.0,
        share_of_time: share_of_time(reader)?,
        outputs: Vec::new(),
    };
    reader.visit(TableName::Runs, &all, |cells| found.take(&mut gathered, cells))?;
    found.outputs = gathered.into_iter().filter(|one| one.error.count > 0).map(Gathered::finish).collect();
    Ok(Some(found).filter(|found| found.rows + found.not_done > 0))
}

/// The main outputs that are numbers and have columns of errors, in the order of the table.
fn gathered(columns: &[ColumnDescription]) -> Vec<Gathered<'_>> {
    let mut all: Vec<Gathered<'_>> = Vec::new();
    for column in columns.iter().filter(|column| column.main && !column.kind.is_text()) {
        let error = column.numerical_error_name();
        if !columns.iter().any(|other| other.name == error) {
            continue;
        }
        let place = all.iter().position(|one| one.error.output == column.quantity).unwrap_or_else(|| {
            all.push(Gathered::new(&column.quantity));
            all.len() - 1
        });
        all[place].columns.push((column, error));
    }
    all
}

/// Share of the rows' wall time that their numerical twins took.
fn share_of_time(reader: &DatasetReader) -> Result<Option<f64>, DatasetError> {
    let (mut all_s, mut twins_s) = (0.0, 0.0);
    let names = [RowOutcome::wall_time_s.name, RowOutcome::numerical_twin_wall_time_s.name];
    reader.visit(TableName::Timings, &names, |cells| {
        let [wall_s, twin_s] = [0, 1].map(|at| cells.get(at).and_then(|cell| cell.as_ref()?.number()).unwrap_or(0.0));
        (all_s, twins_s) = (all_s + wall_s, twins_s + twin_s);
    })?;
    Ok((all_s > 0.0).then(|| twins_s / all_s))
}

impl NumericalTwins {
    fn take(&mut self, gathered: &mut [Gathered<'_>], cells: &[Cell<'_>]) {
        let [Some(Value::Count(row)), Some(Value::Text(status)), Some(Value::Count(done)), beyond, worst, errors @ ..] =
            cells
        else {
            return;
        };
        if *status != RowStatus::Done.name() {
            return;
        }
        self.rows += done;
        self.not_done += 1 - done.min(&1);
        self.beyond_promise += u64::from(matches!(beyond, Some(Value::Count(count)) if *count > 0));
        if let Some(Value::Real(worst)) = worst
            && *worst > self.worst_over_promise
        {
            (self.worst_row, self.worst_over_promise) = (Some(*row), *worst);
        }
        let mut pairs = errors.chunks_exact(2);
        for one in gathered {
            for column in 0..one.columns.len() {
                let Some([Some(value), Some(error)]) = pairs.next() else { continue };
                let (Some(value), Some(error)) = (value.number(), error.number()) else { continue };
                one.add(*row, column, if error == 0.0 { 0.0 } else { error / value.abs() });
            }
        }
    }
}

impl fmt::Display for NumericalTwins {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows, not_done, beyond_promise, .. } = self;
        let words = if *rows == 1 { "row" } else { "rows" };
        write!(f, "Numerical errors (relative; {rows} {words} run again with better numerics")?;
        if *not_done > 0 {
            write!(f, ", {not_done} more without result")?;
        }
        if let Some(share) = self.share_of_time {
            write!(f, "; {} % of the rows' time", significant((1000.0 * share).round() / 10.0))?;
        }
        writeln!(f, ")")?;
        if self.outputs.is_empty() {
            return Ok(());
        }
        let width = self.outputs.iter().map(|output| output.output.len()).max().unwrap_or(0);
        writeln!(f, "  {:<width$} {:>9} {:>9}", "", "median", "worst")?;
        for OutputError { output, median, worst, worst_row, .. } in &self.outputs {
            writeln!(f, "  {output:<width$} {median:>9.1e} {worst:>9.1e}  row {worst_row}")?;
        }
        match (beyond_promise, self.worst_row) {
            (0, _) | (_, None) => writeln!(f, "  all within the promises of their presets (`decore help accuracy`)"),
            (count, Some(row)) => writeln!(
                f,
                "  BEYOND the promise of its preset in {count} of {rows} rows, at worst {} times (row {row}): see \
                 `decore help accuracy`",
                significant(self.worst_over_promise)
            ),
        }
    }
}
