//! `decore export`: a dataset as other programs want it.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::outputs::{Form, Output, check_outputs};
use super::text::plural;
use super::written::Written;
use decore_dataset::{DatasetReader, place};
use decore_lab::features::{FeatureColumn, FeatureSettings, Format, GroupBy, Role, Splits, files};

/// Contents of the files of an export, in their order.
const KINDS: [&str; 5] = ["features", "dictionary", "dictionary", "metadata", "card"];

#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// Folder of the dataset
    dataset: PathBuf,
    /// Folder for the table and its dictionary
    ///
    /// The table has one row per run and casting.
    #[arg(long, value_name = "FOLDER", required = true)]
    features: PathBuf,
    /// Format of the table
    #[arg(long, default_value = Format::default().name(), value_parser = format())]
    format: Format,
    /// Count only blows with at least this energy in the dose, in J
    #[arg(long, default_value_t = 0.0, value_name = "J", value_parser = not_negative)]
    dose_threshold_j: f64,
    /// Add a column: the time at which the cumulative work reaches this value, in J
    #[arg(long, value_name = "J", value_parser = not_negative)]
    work_j: Option<f64>,
    /// Shares for training and testing, or training, validation and testing
    ///
    /// Example: "0.7,0.15,0.15", in quotes for PowerShell. Rows of one group are never in two parts.
    #[arg(long, value_name = "SHARES", value_delimiter = ',')]
    splits: Vec<f64>,
    /// Seed for the assignment of groups to parts
    #[arg(long, default_value_t = 0, requires = "splits")]
    seed: u64,
    /// Further reasons to keep rows together
    ///
    /// `machine`: rows on the same machine. `grown_part`: rows that were added to a Latin hypercube at the same time.
    #[arg(long, value_name = "REASON", value_delimiter = ',', value_parser = reason())]
    group_by: Vec<GroupBy>,
    /// Replace existing files
    #[arg(long)]
    replace: bool,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

/// Reads a format by its name.
fn format() -> impl TypedValueParser<Value = Format> {
    let named = |name: String| Format::ALL.into_iter().find(|one| one.name() == name).unwrap_or_default();
    PossibleValuesParser::new(Format::ALL.map(Format::name)).map(named)
}

/// Reads a reason for rows to be kept together by its name.
fn reason() -> impl TypedValueParser<Value = GroupBy> {
    let named = |name: String| GroupBy::ALL.into_iter().find(|one| one.name() == name).unwrap_or(GroupBy::Machine);
    PossibleValuesParser::new(GroupBy::ALL.map(GroupBy::name)).map(named)
}

/// Reads a number that is not negative.
fn not_negative(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| *number >= 0.0 && number.is_finite());
    number.ok_or_else(|| "expected a number from 0 on, e.g. 12.5".to_owned())
}

pub(super) fn export(arguments: &ExportArguments) -> Result<Exit, Failure> {
    let ExportArguments { dataset, features: folder, format, .. } = arguments;
    expect_dataset(dataset)?;
    refuse_inside(folder, dataset)?;
    let names = files(*format);
    let form = Form::Folder { names: &names, replace: arguments.replace };
    let output = Output { flag: "--features", path: Some(folder), form };
    check_outputs(std::slice::from_ref(dataset), &[output])?;
    let settings = FeatureSettings {
        dose_threshold_j: arguments.dose_threshold_j,
        work_j: arguments.work_j,
        splits: splits(arguments)?,
        group_by: arguments.group_by.clone(),
        format: *format,
        replace: arguments.replace,
    };
    let found = decore_lab::features::export(&DatasetReader::open(dataset)?, folder, &settings)?;
    let features = &found.features;
    let rows = features.columns.first().map_or(0, |column| column.values.count);
    let mut written = Written::default();
    for (index, (kind, path)) in KINDS.into_iter().zip(&found.files).enumerate() {
        if index == 0 { written.table(kind, path, rows)? } else { written.file(kind, path)? }
    }
    let done = format!("{} of {} done", features.done, plural(features.runs as usize, "run"));
    let columns = plural(features.columns.len(), "column");
    let table = folder.join(format.file());
    let mut words = format!("wrote {}: {}, {columns} ({done})", table.display(), plural(rows, "row"));
    written.note(done);
    if let Some(split) = features.columns.iter().find(|column| column.name == "split") {
        let shares = format!("split: {}", shares(split));
        words += &format!("\n{shares}");
        written.note(shares);
    }
    for derived in &features.derived {
        let own = features.columns.iter().find(|column| column.name == derived.column);
        if own.is_some_and(|own| own.role == Role::Factor) {
            written.warn(format!(
                "the factor column {} is {} in every row: who trains on it trains on the answer",
                derived.column, derived.rule
            ));
        }
    }
    written.print(arguments.json, &words)?;
    Ok(Exit::Done)
}

/// The splits that are asked for.
fn splits(arguments: &ExportArguments) -> Result<Option<Splits>, Failure> {
    match arguments.splits.as_slice() {
        [] => Ok(None),
        shares => Ok(Some(Splits::new(shares, arguments.seed)?)),
    }
}

/// Number of rows in each part of the splits.
fn shares(split: &FeatureColumn) -> String {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for part in (0..split.values.count).map(|row| split.values.text(row)) {
        match counts.iter_mut().find(|(name, _)| *name == part) {
            Some((_, count)) => *count += 1,
            None => counts.push((part, 1)),
        }
    }
    let words = counts.iter().map(|(name, count)| format!("{name} {}", plural(*count, "row")));
    words.collect::<Vec<_>>().join(", ")
}

/// Refuses a folder for outputs that lies in the dataset that is read.
fn refuse_inside(folder: &Path, dataset: &Path) -> Result<(), Failure> {
    let inside = place(dataset);
    if !place(folder).starts_with(&inside) {
        return Ok(());
    }
    Err(Failure::Argument(format!(
        "--features {}: the folder lies in the dataset {}, which is read: give a folder outside of it",
        folder.display(),
        inside.display()
    )))
}
