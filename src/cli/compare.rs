//! `decore compare`: the difference of two datasets.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure};
use super::inputs::expect_dataset;
use super::json::print_result;
use super::text::{plural, six_digits, terminal_columns};
use decore_dataset::DatasetReader;
use decore_lab::comparison::{
    Comparison, ComparisonSettings, Listed, OutputDifference, PairDifference, Side, compare as compare_datasets,
};
use decore_quantity::Value;

/// Columns that are assumed where there is no terminal.
const PLAIN_COLUMNS: usize = 100;
/// Characters of a hash that are shown.
const SHOWN_HASH: usize = 12;

#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// Folder of the first dataset
    #[arg(value_name = "A")]
    first: PathBuf,
    /// Folder of the second dataset
    #[arg(value_name = "B")]
    second: PathBuf,
    /// Columns of the table of runs
    ///
    /// By default: the main outputs, whose scatter `[outputs] twins` measures.
    #[arg(short, long = "output", num_args = 1.., value_name = "NAME")]
    outputs: Vec<String>,
    /// Relative difference that counts where no scatter was measured
    #[arg(long, default_value_t = ComparisonSettings::default().relative, value_name = "SHARE", value_parser = share)]
    relative: f64,
    /// Number of rows to list of each kind; all rows are counted
    #[arg(long, default_value_t = ComparisonSettings::default().most, value_name = "ROWS")]
    most: usize,
    /// Print the differences as JSON (schemas/comparison.schema.json)
    #[arg(long)]
    json: bool,
}

/// Reads a relative difference.
fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| *share >= 0.0 && share.is_finite());
    share.ok_or_else(|| "expected a number from 0, e.g. 1e-4".to_owned())
}

pub(super) fn compare(arguments: &CompareArguments) -> Result<Exit, Failure> {
    let folders = [&arguments.first, &arguments.second];
    folders.iter().try_for_each(|folder| expect_dataset(folder))?;
    let [a, b] = folders.map(|folder| DatasetReader::open(folder));
    let settings =
        ComparisonSettings { outputs: arguments.outputs.clone(), relative: arguments.relative, most: arguments.most };
    let found = compare_datasets(&a?, &b?, &settings)?;
    print_result(arguments.json, &found, || readable(&found))?;
    Ok(if found.is_same() { Exit::Done } else { Exit::Differ })
}

/// The difference as text; writing to a string cannot fail.
fn readable(found: &Comparison) -> String {
    let mut text = String::new();
    side(&mut text, "A", &found.a);
    side(&mut text, "B", &found.b);
    let by = match found.factors.as_slice() {
        [] => "in their order (no factors)".to_owned(),
        factors => format!("by {}", factors.join(", ")),
    };
    let _ = writeln!(text, "\n{} matched {by}", plural(found.matched as usize, "row"));
    for (name, rows) in [("A", &found.only_in_a), ("B", &found.only_in_b)] {
        if rows.count > 0 {
            let shown: Vec<String> = rows.listed.iter().map(u64::to_string).collect();
            let _ = writeln!(text, "only in {name}: {} ({}{})", rows.count, shown.join(", "), more(rows, ", ..."));
        }
    }
    for (words, names) in [
        ("only A has", &found.outputs_only_in_a),
        ("only B has", &found.outputs_only_in_b),
        ("not of one unit", &found.outputs_of_other_units),
    ] {
        if !names.is_empty() {
            let _ = writeln!(text, "{words}: {}", names.join(", "));
        }
    }
    statuses(&mut text, found);
    outputs(&mut text, found);
    beyond(&mut text, found);
    let verdict = if found.is_same() { "Nothing differs." } else { "They differ." };
    let _ = writeln!(text, "\n{verdict}");
    text
}

fn side(text: &mut String, name: &str, side: &Side) {
    let hash: String = side.study_hash.chars().take(SHOWN_HASH).collect();
    let twins =
        if side.twins > 0 { format!(", {} of each", plural(side.twins as usize, "twin")) } else { String::new() };
    let _ = writeln!(
        text,
        "{name}  {}: study `{}` (hash {hash}), {}{twins}, decore {}",
        side.folder.display(),
        side.study,
        plural(side.rows as usize, "row"),
        side.program_version
    );
}

/// `sign` where a list goes on.
fn more<T>(list: &Listed<T>, sign: &'static str) -> &'static str {
    if list.count > list.listed.len() as u64 { sign } else { "" }
}

fn statuses(text: &mut String, found: &Comparison) {
    let list = &found.statuses;
    if list.count == 0 {
        return;
    }
    let _ = writeln!(text, "\nOther status: {}", plural(list.count as usize, "row"));
    for entry in &list.listed {
        let rows = rows_of(entry.row_a, entry.row_b);
        let _ = writeln!(text, "  {rows:<16} {} -> {}", entry.status_a, entry.status_b);
    }
    text.push_str(more(list, "  ...\n"));
}

/// One row's index, or those in A and in B where they are not the same.
fn rows_of(a: u64, b: u64) -> String {
    if a == b { format!("row {a}") } else { format!("rows {a}, {b}") }
}

/// A line per output, those with values beyond their scatter first.
fn outputs(text: &mut String, found: &Comparison) {
    let (differ, same): (Vec<&OutputDifference>, Vec<&OutputDifference>) =
        found.outputs.iter().filter(|output| output.pairs > 0).partition(|output| output.beyond > 0);
    let lines: Vec<&OutputDifference> = differ.into_iter().chain(same).collect();
    let width = lines.iter().map(|output| output.name.len()).max().unwrap_or(0).max("output".len());
    let one_line = width + 50 <= terminal_columns().unwrap_or(PLAIN_COLUMNS);
    let gap = if one_line { " " } else { "\n    " };
    let _ = writeln!(
        text,
        "\n{:<width$}{gap}{:>8} {:>8} {:>11} {:>11}",
        "output", "pairs", "beyond", "median |d|", "worst |d|"
    );
    for output in &lines {
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3e}"));
        // Without a median no pair has two numbers, and none can be the worst.
        let worst = output.median.and_then(|_| output.worst.as_ref().map_or(Some(0.0), PairDifference::difference));
        let line = format!(
            "{:<width$}{gap}{:>8} {:>8} {:>11} {:>11} {}",
            output.name,
            output.pairs,
            output.beyond,
            number(output.median),
            number(worst),
            if output.unit == "1" { "" } else { &output.unit }
        );
        let one_sided = if output.one_sided > 0 { format!("  {} one-sided", output.one_sided) } else { String::new() };
        let _ = writeln!(text, "{}{one_sided}", line.trim_end());
    }
    let measured: u64 = lines.iter().map(|output| output.measured).sum();
    let pairs: u64 = lines.iter().map(|output| output.pairs).sum();
    let _ = writeln!(
        text,
        "beyond: what twins cannot account for, |d| > 2 (scatter of A + of B), for {measured} of {pairs} pairs of values; for the \
         others |d| > {:e} of the larger value",
        found.relative
    );
    if lines.iter().any(|output| output.one_sided > 0) {
        text.push_str("one-sided: pairs of which only A or only B has a value; they are beyond, and have no |d|\n");
    }
}

/// The values beyond their scatter that are listed.
fn beyond(text: &mut String, found: &Comparison) {
    let list = &found.beyond;
    if list.count == 0 {
        return;
    }
    let values = plural(list.count as usize, "value");
    let _ = writeln!(text, "\nBeyond: {values}, the farthest first");
    for entry in &list.listed {
        let value = |value: &Option<Value>| match value {
            None => "none".to_owned(),
            Some(Value::Real(value)) => six_digits(*value),
            Some(other) => other.to_string(),
        };
        let unit = if entry.unit == "1" || entry.unit.is_empty() { String::new() } else { format!(" {}", entry.unit) };
        let how = match (entry.difference(), entry.allowed) {
            (Some(difference), Some(allowed)) => {
                let by = if entry.measured { "twins" } else { "rule" };
                format!("  |d| {difference:.2e}, allowed {allowed:.2e} ({by})")
            }
            _ => String::new(),
        };
        let _ = writeln!(
            text,
            "  {}: {} {} -> {}{unit}{how}",
            rows_of(entry.row_a, entry.row_b),
            entry.output,
            value(&entry.value_a),
            value(&entry.value_b)
        );
    }
    text.push_str(more(list, "  ...\n"));
}
