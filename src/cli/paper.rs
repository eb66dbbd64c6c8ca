//! `decore paper`: the publication that the model follows, beside what decore gives.

use std::fmt::Write as _;

use clap::Args;

use super::exit::{Exit, Failure};
use super::json::say_json;
use super::text::{fit, say, terminal_columns};
use crate::paper::{Against, Agreement, Evidence, Figure, Group, PaperComparison, Tolerance, compare};

/// Columns of a text that no terminal reads.
const PLAIN_COLUMNS: usize = 80;
/// Width of what a line is about, and of a value of a table of evidence.
const NAME: usize = 30;
const VALUE: usize = 16;

#[derive(Debug, Args)]
pub(super) struct PaperArguments {
    /// Print the comparison as JSON (schemas/paper.schema.json).
    #[arg(long)]
    json: bool,
}

pub(super) fn paper(arguments: &PaperArguments) -> Result<Exit, Failure> {
    let comparison = compare()?;
    if arguments.json {
        say_json(&comparison)?;
    } else {
        let columns = terminal_columns().unwrap_or(PLAIN_COLUMNS);
        say(&fit(&readable(&comparison), columns).trim_end())?;
    }
    Ok(Exit::Done)
}

/// The comparison as text; writing to a string cannot fail.
fn readable(comparison: &PaperComparison) -> String {
    let counted = |Agreement { agree, of }: Agreement| format!("{agree} of {of}");
    let mut text = format!(
        "{}\n\nIts rig: a hammer at the middle of the rail (R5) of the built-in station, 5 bar,\n85 mm above the casting, 1.5 s. By the \
         tolerances below ours agrees with\n  {} figures that the paper calculated\n  {} that it measured\n  {} differences of both that \
         it quotes\n* marks those that do not.\n",
        comparison.citation,
        counted(comparison.calculations),
        counted(comparison.measurements),
        counted(comparison.quoted_differences)
    );
    for group in &comparison.groups {
        section(&mut text, group);
    }
    text
}

fn section(text: &mut String, group: &Group) {
    let Group { name, source, tolerance, figures, remarks, evidence } = group;
    let _ = writeln!(text, "\n{name} ({source})");
    if !figures.is_empty() {
        heading(text, tolerance);
        figures.iter().for_each(|one| figure(text, one));
    }
    for remark in remarks {
        let _ = writeln!(text, "- {remark}");
    }
    for table in evidence {
        rows(text, table);
    }
}

/// The tolerance, and what the columns of figures are.
fn heading(text: &mut String, tolerance: &Tolerance) {
    let (within, columns) = match tolerance {
        Tolerance::Share { of_calculation, of_measurement } => (
            format!("{} % of the calculation, {} % of the measurement", 100.0 * of_calculation, 100.0 * of_measurement),
            ["calculated", "measured", "ours", "to calc.", "to meas."],
        ),
        Tolerance::PercentagePoints { most } => {
            (format!("{most} percentage points"), ["quoted", "", "ours", "points", ""])
        }
    };
    let [one, two, three, four, five] = columns;
    let line = format!("{:<NAME$} {one:>10} {two:>9} {three:>9} {four:>9} {five:>8}", "");
    let _ = writeln!(text, "agrees: within {within}\n{}", line.trim_end());
}

fn figure(text: &mut String, Figure { name, unit, calculated, measured, quoted, ours }: &Figure) {
    let none = if quoted.is_some() { "" } else { "-" };
    let printed = |against: Option<Against>| against.map_or(none.to_owned(), |one| one.paper.to_string());
    let first = calculated.or(*quoted);
    let difference = |against: Option<Against>| {
        against.map_or(String::new(), |one| {
            let star = if one.agrees { ' ' } else { '*' };
            match *unit {
                "%" => format!("{:+.1}{star}", one.difference),
                _ => format!("{:+.1} %{star}", 100.0 * one.difference),
            }
        })
    };
    let line = format!(
        "{:<NAME$} {:>10} {:>9} {:>9} {:>9} {:>8}",
        format!("{name} ({unit})"),
        printed(first),
        printed(*measured),
        four_digits(*ours),
        difference(first),
        difference(*measured)
    );
    let _ = writeln!(text, "{}", line.trim_end());
}

/// Ours to four digits: more than the paper prints.
fn four_digits(value: f64) -> String {
    let decimals = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.decimals$}")
}

fn rows(text: &mut String, Evidence { name, columns, rows }: &Evidence) {
    let _ = write!(text, "{name}\n{:NAME$}", "");
    for column in columns {
        let _ = write!(text, "{column:>VALUE$}");
    }
    let _ = writeln!(text);
    for row in rows {
        let mut line = format!("  {:<1$}", row.label, NAME - 2);
        for value in &row.values {
            let _ = write!(line, "{:>VALUE$}", value.map_or("-".to_owned(), four_digits));
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
}
