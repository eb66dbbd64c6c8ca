//! `decore report`: summary of a dataset as text or as a page.

use std::path::{Path, PathBuf};

use clap::Args;

use super::caller::Caller;
use super::exit::{Exit, Failure, write_file};
use super::inputs::expect_dataset;
use super::json::{print_json, wants_words};
use super::outputs::{Form, Output, check_outputs};
use super::stored::Stored;
use super::text::{fit, print_line, terminal_columns, wanted_error};
use super::written::Written;
use crate::page::{MOST_ROWS, PageOf, dataset_page};
use decore_dataset::DatasetReader;
use decore_lab::report::{Charts, Paper, ReportSettings, summarise};
use decore_study::CheckedStudy;
use decore_study::engine::checked;

#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Folder of the dataset
    dataset: PathBuf,
    /// Rank the rows by this column; `-NAME` reverses the order
    ///
    /// The better end comes first. Any number column of the table of runs can be used.
    #[arg(long, default_value = decore_lab::report::DEFAULT_RANKING, allow_hyphen_values = true)]
    rank_by: String,
    /// Number of best rows, at least 1
    #[arg(long, default_value_t = ReportSettings::default().best, value_name = "ROWS", value_parser = best)]
    best: usize,
    /// Write an HTML page instead of the summary
    ///
    /// The page shows the whole dataset in a browser and needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// With --html: replace an existing page
    #[arg(long, requires = "html")]
    replace: bool,
    /// With --html: folder that contains the files the study names (default: .)
    ///
    /// The page needs them to answer the study's goal.
    #[arg(long, value_name = "FOLDER", requires = "html")]
    files_in: Option<PathBuf>,
    /// Relative standard error for which the run duration is estimated
    #[arg(long, default_value_t = decore_lab::report::WANTED_ERROR, value_name = "SHARE", value_parser = wanted_error)]
    wanted_error: f64,
    /// Print the summary as JSON (schemas/report.schema.json)
    ///
    /// With --html, print the list of written files (schemas/written.schema.json).
    #[arg(long)]
    json: bool,
}

/// Reads a number of best rows.
fn best(text: &str) -> Result<usize, String> {
    let rows = text.parse::<usize>().ok().filter(|rows| *rows > 0);
    rows.ok_or_else(|| format!("expected a whole number from 1 on, e.g. {}", ReportSettings::default().best))
}

pub(super) fn report(arguments: &ReportArguments) -> Result<Exit, Failure> {
    expect_dataset(&arguments.dataset)?;
    let page = Output {
        flag: "--html",
        path: arguments.html.as_deref(),
        form: Form::File { endings: &["html"], replace: arguments.replace },
    };
    check_outputs(std::slice::from_ref(&arguments.dataset), &[page])?;
    let settings = ReportSettings {
        rank_by: arguments.rank_by.clone(),
        best: arguments.best,
        wanted_error: arguments.wanted_error,
    };
    let reader = DatasetReader::open(&arguments.dataset)?;
    if let Some(path) = &arguments.html {
        let study = study_of(arguments);
        let of = PageOf { reader: &reader, study: study.as_ref().map_err(String::as_str) };
        let page = dataset_page(of, &settings, MOST_ROWS)?;
        write_file(path, &page)?;
        let mut written = Written::default();
        written.file("page", path)?;
        let words = format_args!("wrote {} ({:.1} MB)", path.display(), page.len() as f64 / 1e6);
        written.print(arguments.json, &words)?;
        return Ok(Exit::Done);
    }
    let summary = summarise(&reader, &settings)?;
    if arguments.json {
        print_json(&summary)?;
    }
    if !wants_words(arguments.json) {
        return Ok(Exit::Done);
    }
    let paper = Paper { columns: terminal_columns(), blocks: Caller::current().is_some() || shows_blocks() };
    let charts = Charts::of(&reader, &summary)?.text(paper);
    let summary = match paper.columns {
        None => summary.to_string(),
        Some(columns) => fit(&format!("{summary:columns$}"), columns),
    };
    print_line(&format_args!("{}\n{}", summary.trim_end(), charts.trim_end()))?;
    Ok(Exit::Done)
}

/// The study of the dataset, whose goal the page answers.
///
/// # Errors
/// A message if the study cannot be read again; empty if it has no goal.
fn study_of(arguments: &ReportArguments) -> Result<CheckedStudy, String> {
    let words = |error: &dyn std::fmt::Display| format!("The goal of the study is not answered: {error}");
    let stored = Stored::open(&arguments.dataset).map_err(|error| words(&error))?;
    if !stored.asks() {
        return Err(String::new());
    }
    let files = arguments.files_in.as_deref().unwrap_or(Path::new("."));
    let study = stored.study(files).map_err(|error| words(&error))?;
    checked(study).map_err(|error| words(&error))
}

/// Whether the locale uses UTF-8.
fn shows_blocks() -> bool {
    let set = ["LC_ALL", "LC_CTYPE", "LANG"].iter().filter_map(|name| std::env::var(name).ok());
    let locale = set.into_iter().find(|value| !value.is_empty()).unwrap_or_default().to_lowercase();
    locale.contains("utf-8") || locale.contains("utf8")
}
