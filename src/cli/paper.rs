//! `decore paper`: compares decore with the publication that the model follows.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::json::{print_json, wants_words};
use super::outputs::{Form, Output, check_outputs};
use super::text::{fit, print_line, terminal_columns};
use crate::paper::{
    Agreement, Evidence, FigureGroup, PaperComparison, PaperFigure, Tolerance, compare, four_digits, paper_page,
};

/// Columns of a text that no terminal reads.
const PLAIN_COLUMNS: usize = 80;
/// Width of the name of a line, and of a value in a table of evidence.
const NAME: usize = 30;
const VALUE: usize = 16;

#[derive(Debug, Args)]
pub(super) struct PaperArguments {
    /// Print the comparison as JSON (schemas/paper.schema.json)
    #[arg(long)]
    json: bool,
    /// Write the comparison as an HTML page
    ///
    /// The page also shows the mobilities of the paper's Figure 14.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Replace an existing page
    #[arg(long, requires = "html")]
    replace: bool,
}

pub(super) fn paper(arguments: &PaperArguments) -> Result<Exit, Failure> {
    let page = Output {
        flag: "--html",
        path: arguments.html.as_deref(),
        form: Form::File { endings: &["html"], replace: arguments.replace },
    };
    check_outputs(&[], &[page])?;
    let comparison = compare()?;
    if let Some(path) = &arguments.html {
        write_file(path, paper_page(&comparison)?)?;
    }
    if arguments.json {
        print_json(&comparison)?;
    }
    if wants_words(arguments.json) {
        let columns = terminal_columns().unwrap_or(PLAIN_COLUMNS);
        print_line(&fit(&readable(&comparison), columns).trim_end())?;
        if let Some(path) = &arguments.html {
            print_line(&format_args!("\nthe page is in {}", path.display()))?;
        }
    }
    Ok(Exit::Done)
}

/// The comparison as text; writing to a string cannot fail.
fn readable(comparison: &PaperComparison) -> String {
    let counted = |Agreement { agree, of }: Agreement| format!("{agree} of {of}");
    let mut text = format!(
        "{}\n\nThe rig: a hammer at the middle of the rail (R5) of the built-in station, 5 bar,\n85 mm above the casting, 1.5 s. Within the \
         tolerances below, decore agrees with\n  {} figures that the paper calculated\n  {} figures that it measured\n  {} differences of \
         calculation and measurement that it quotes\n* marks the other figures.\n",
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

fn section(text: &mut String, group: &FigureGroup) {
    let FigureGroup { name, source, tolerance, figures, remarks, evidence } = group;
    let _ = writeln!(text, "\n{name} ({source})");
    if !figures.is_empty() {
        heading(text, *tolerance);
        figures.iter().for_each(|one| figure(text, one));
    }
    for remark in remarks {
        let _ = writeln!(text, "- {remark}");
    }
    for table in evidence {
        rows(text, table);
    }
}

/// The tolerance and the headings of the columns.
fn heading(text: &mut String, tolerance: Tolerance) {
    let [one, two, three, four, five] = tolerance.columns();
    let line = format!("{:<NAME$} {one:>10} {two:>9} {three:>9} {four:>9} {five:>8}", "");
    let _ = writeln!(text, "agrees: within {tolerance}\n{}", line.trim_end());
}

fn figure(text: &mut String, figure: &PaperFigure) {
    let [first, measured, ours, to_first, to_measured] = figure.cells();
    let name = format!("{} ({})", figure.name, figure.unit);
    let line = format!("{name:<NAME$} {first:>10} {measured:>9} {ours:>9} {to_first:>9} {to_measured:>8}");
    let _ = writeln!(text, "{}", line.trim_end());
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
