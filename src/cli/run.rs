//! `decore run`: all rows of a study into its tables.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;

use super::exit::{Exit, Failure};
use super::prepare::{Prepared, prepare};
use super::text::{say, tell, threads};
use crate::dataset::{Columns, DatasetError, DatasetReader, DatasetWriter, Existing, TableName};
use crate::report::{ReportSettings, summarise};
use crate::run::{BatchSettings, BatchSummary, DEFAULT_INTERVAL, DEFAULT_WINDOW, Progress, run_batch};

/// Set by the first interrupt: no new rows are started.
static STOP: AtomicBool = AtomicBool::new(false);

#[derive(Debug, Args)]
pub(super) struct RunArguments {
    /// Study file (TOML).
    study: PathBuf,
    /// Folder for the tables. Default: `out/` and the study's name.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Threads that run rows, at most 1024; 0: as many as the machine has. Results do not depend on it.
    #[arg(short, long, default_value_t = 0, value_parser = threads)]
    threads: usize,
    /// Replace a dataset that is already in the folder.
    #[arg(long)]
    replace: bool,
    /// Set a value of the study, e.g. `hammer.left.supply_bar=4.5`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Column of the table of runs by which the summary ranks rows.
    #[arg(long, default_value = crate::report::DEFAULT_RANKING)]
    rank_by: String,
}

pub(super) fn run(arguments: &RunArguments) -> Result<Exit, Failure> {
    let prepared = prepare(&arguments.study, &arguments.overrides)?;
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.study));
    // Before the rows are run, not after.
    let settings = ReportSettings { rank_by: arguments.rank_by.clone(), ..ReportSettings::default() };
    check_ranking(&prepared, &settings.rank_by)?;
    stop_on_interrupt();
    let summary = run_rows(&prepared, &folder, arguments)?;
    let reader = DatasetReader::open(&folder)?;
    say(&summarise(&reader, &settings)?.to_string().trim_end());
    if summary.stopped {
        tell(&format_args!(
            "interrupted: {} of {} rows are in {}",
            summary.rows,
            prepared.study.row_count(),
            folder.display()
        ));
        return Ok(Exit::Interrupted);
    }
    Ok(if summary.failed == 0 { Exit::Done } else { Exit::RowsFailed })
}

/// `out/<name of the study file>`.
fn default_folder(study: &Path) -> PathBuf {
    Path::new("out").join(study.file_stem().unwrap_or(study.as_os_str()))
}

/// The column that the summary ranks by must be there and hold numbers.
fn check_ranking(prepared: &Prepared, name: &str) -> Result<(), DatasetError> {
    let table = TableName::Runs;
    let columns = Columns::new(&prepared.info())?.describe(table);
    match columns.iter().find(|column| column.name == name) {
        Some(column) if column.unit.is_empty() => {
            Err(DatasetError::NotANumber { table: table.folder(), column: name.to_owned() })
        }
        Some(_) => Ok(()),
        None => Err(DatasetError::UnknownColumn {
            table: table.folder(),
            column: name.to_owned(),
            known: columns.into_iter().map(|column| column.name).collect(),
        }),
    }
}

fn run_rows(prepared: &Prepared, folder: &Path, arguments: &RunArguments) -> Result<BatchSummary, Failure> {
    let existing = if arguments.replace { Existing::Replace } else { Existing::Refuse };
    let mut writer = DatasetWriter::create(folder, &prepared.info(), existing)?;
    let rows = prepared.study.row_count() as u64;
    let progress = Progress::to_stderr(rows, DEFAULT_INTERVAL);
    let settings =
        BatchSettings { threads: arguments.threads, window: DEFAULT_WINDOW, stop: &STOP, progress: &progress };
    let summary = run_batch::<DatasetError>(
        0..rows,
        &settings,
        |row| prepared.run(row as usize),
        |row, outcome| writer.write(prepared.record(row, outcome)),
    );
    progress.finish();
    // What was handed over before a failure is kept.
    let finished = writer.finish();
    let summary = summary?;
    finished?;
    Ok(summary)
}

/// The first interrupt lets the running rows finish, the second ends the program; parts on disk are whole either way.
fn stop_on_interrupt() {
    let handler = || {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(Exit::Interrupted as i32);
        }
        tell(&"interrupted: finishing the rows that run; interrupt again to stop at once");
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        tell(&format_args!("warning: interrupts end the program at once ({error})"));
    }
}
