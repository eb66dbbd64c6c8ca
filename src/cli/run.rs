//! `decore run`: all rows of a study, or a shard's, into its tables; the same command again goes on.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;

use super::caller::Caller;
use super::exit::{Exit, Failure};
use super::inputs::default_folder;
use super::json::print_result;
use super::outputs::{Form, Output, StudyArguments};
use super::progress::{DEFAULT_INTERVAL, Progress};
use super::rows::RowList;
use super::shard::Shard;
use super::signals::{keep_nohup, progress_wanted};
use super::summary::summary;
use super::text::{self, eprint_line, plural};
use decore_dataset::{
    Columns, DatasetError, DatasetInfo, DatasetReader, Existing, RerunSelection, SweepState, SweepStatus, TableName,
};
use decore_lab::best::{self, Verdict};
use decore_lab::report::{ReportSettings, summarise};
use decore_model::run::DEFAULT_RETRIES;
use decore_study::CheckedStudy;
use decore_study::engine::{RowRunner, StubRows, SweepEvent, SweepSettings, sweep};

/// Rows up to which a sweep ends with the answer to its study's goal.
const MOST_MODELLED: usize = 1000;

/// Set by the first interrupt, or by too many failed rows: no new rows are started.
static STOP: AtomicBool = AtomicBool::new(false);
/// The folder of the sweep that runs.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

#[derive(Debug, Args)]
pub(super) struct RunArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Folder for the tables (default: out/STUDY)
    ///
    /// A folder that already contains rows of the same study is continued. The default for a shard is `out/STUDY.shards/shard-I-of-N`.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Number of threads, at most 1024; 0: one per core
    ///
    /// With 0, `RAYON_NUM_THREADS` can set the number. Results do not depend on the number of threads.
    #[arg(short, long, default_value_t = 0, value_parser = text::threads)]
    threads: usize,
    /// Replace a dataset that is already in the folder
    #[arg(long)]
    replace: bool,
    /// Run only the failed rows again, for example with a larger `solver.max_steps`
    ///
    /// A row has failed if its status is audit failed, invalid, diverged or budget exhausted. Raise a budget with `--set
    /// solver.max_steps=...`, `--set solver.max_wall_time_s=...` or `--retries`. Rows that are done keep their results.
    #[arg(long, conflicts_with_all = ["replace", "rows"])]
    only_failed: bool,
    /// Run only these rows again, for example "3,17-20"
    ///
    /// A failed re-run does not replace a finished row.
    #[arg(long, value_name = "ROWS", conflicts_with = "replace")]
    rows: Option<RowList>,
    /// Set a value of the study, for example `hammer.left.supply_bar=4.5`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Rank the rows in the summary by this column; `-NAME` reverses the order
    ///
    /// The better end comes first. Any number column of the table of runs can be used.
    #[arg(long, default_value = decore_lab::report::DEFAULT_RANKING, allow_hyphen_values = true)]
    rank_by: String,
    /// Run only the I-th of N shares of the rows
    ///
    /// `decore merge` combines the shards into one dataset.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Stop when more than this number of rows have failed (default: no limit)
    ///
    /// A row has failed if its status is audit failed, invalid, diverged or budget exhausted. Rows of earlier runs count too.
    #[arg(long, value_name = "ROWS")]
    max_failed: Option<u64>,
    /// Retry diverged rows this many times, with a 100 times tighter tolerance each time
    #[arg(long, default_value_t = DEFAULT_RETRIES, value_name = "TIMES")]
    retries: u32,
    /// Write the final status of the sweep to this file (JSON)
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    /// Print the summary as JSON (schemas/report.schema.json)
    #[arg(long)]
    json: bool,
    /// Built-in test scene: rows that take this time in ms and whose outcomes are made up.
    #[arg(long, value_name = "MS", hide = true)]
    stub_row_ms: Option<f64>,
    /// Rows of the test scene compute for their time instead of sleeping.
    #[arg(long, hide = true, requires = "stub_row_ms")]
    stub_busy: bool,
}

pub(super) fn run(arguments: &RunArguments) -> Result<Exit, Failure> {
    stop_on_interrupt();
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let whole = default_folder(&arguments.study);
        arguments.shard.map_or(whole.clone(), |shard| shard.folder(&whole))
    });
    let outputs = [
        Output { flag: "--summary", path: arguments.summary.as_deref(), form: Form::Status },
        Output { flag: "--output", path: Some(&folder), form: Form::Dataset },
    ];
    let study = StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs };
    let rows: Box<dyn RowRunner> = match arguments.stub_row_ms {
        Some(milliseconds) => Box::new(stub_rows(study.checked()?, arguments, milliseconds)?),
        None => Box::new(study.engine()?.with_retries(arguments.retries)),
    };
    // Before the rows are run, not after.
    let report = ReportSettings { rank_by: arguments.rank_by.clone(), ..ReportSettings::default() };
    check_number(&rows.info(), report.ranking())?;
    let again = chosen(arguments, rows.checked().row_count() as u64)?;
    let settings = SweepSettings {
        threads: arguments.threads,
        rows: arguments.shard.map(|shard| shard.rows(rows.checked().row_count() as u64)),
        existing: if arguments.replace { Existing::Replace } else { Existing::Resume },
        again: again.as_ref(),
        max_failed: arguments.max_failed,
        summary: arguments.summary.as_deref(),
        ..SweepSettings::default()
    };
    let status = shown(rows.as_ref(), &folder, settings)?;
    if !status.message.is_empty() {
        let (message, done) = (&status.message, status.rows_done);
        let advice = match status.state {
            SweepState::TooManyFailed => " (`decore status` shows the last ones; a larger --max-failed goes on)",
            SweepState::Interrupted => "; the same command goes on",
            _ => "",
        };
        eprint_line(&format_args!("{message}{advice}: {done} of {} rows are in {}", status.rows, folder.display()));
    }
    let reader = DatasetReader::open(&folder)?;
    let found = summarise(&reader, &report)?;
    // The rows of a shard are a share of the study's: the answer comes from the merged dataset.
    let is_whole = arguments.shard.is_none() && status.state == SweepState::Complete;
    let answer = match arguments.stub_row_ms.is_none() && !arguments.json && is_whole {
        true => answer(rows.checked(), &reader, &arguments.study),
        false => String::new(),
    };
    print_result(arguments.json, &found, || summary(&found, &answer, text::terminal_columns()))?;
    Caller::wrote(&folder);
    Ok(match status.state {
        SweepState::TooManyFailed => Exit::TooManyFailed,
        SweepState::Interrupted => Exit::Interrupted,
        _ if status.rows_failed > 0 => Exit::RowsFailed,
        _ => Exit::Done,
    })
}

/// The answer to the study's goal as a model of the rows expects it, and the next step; empty for a study without a goal, or with so many
/// rows that the model takes long.
fn answer(study: &CheckedStudy, reader: &DatasetReader, file: &Path) -> String {
    if study.study().goal().is_none() || study.row_count() > MOST_MODELLED {
        return String::new();
    }
    match best::expected(study, reader) {
        Ok(answer) => {
            let command = format!("`decore best {}`", text::shell_word(file));
            let next = match answer.verdict {
                Verdict::Infeasible => "Relax a limit or widen a range, then run the study again.".to_owned(),
                Verdict::Unsure => format!("{command} runs them."),
                _ => format!("{command} confirms it by runs."),
            };
            format!("{}\n{next}", answer.sentence)
        }
        Err(error) => {
            eprint_line(&format_args!("note: the goal of the study has no answer yet: {error}"));
            String::new()
        }
    }
}

/// Runs rows for another command and shows them as this one does: those that are missing, or the chosen ones again.
pub(super) fn run_rows(
    rows: &dyn RowRunner,
    folder: &Path,
    again: Option<&RerunSelection>,
) -> Result<SweepStatus, Failure> {
    shown(rows, folder, SweepSettings { again, ..SweepSettings::default() })
}

/// Runs a sweep, shown to whoever called the command and stopped by them.
fn shown(rows: &dyn RowRunner, folder: &Path, settings: SweepSettings<'_>) -> Result<SweepStatus, Failure> {
    let display = Display { folder, again: settings.again.is_some(), progress: OnceLock::new() };
    let caller = Caller::current();
    let listener = |event: SweepEvent<'_>| match &caller {
        Some(caller) => (caller.listener)(event),
        None => display.show(event),
    };
    let stop = caller.as_ref().map_or(&STOP, |caller| &caller.stop);
    // The command line runs the sweeps of one dataset.
    let _ = FOLDER.set(folder.to_owned());
    Ok(sweep(rows, folder, &SweepSettings { stop: Some(stop), listener: &listener, ..settings })?)
}

/// The rows that are asked for, which must be the study's.
fn chosen(arguments: &RunArguments, rows: u64) -> Result<Option<RerunSelection>, Failure> {
    let Some(list) = &arguments.rows else { return Ok(arguments.only_failed.then_some(RerunSelection::Failed)) };
    match list.last() {
        Some(last) if last < rows => Ok(Some(RerunSelection::Rows(list.spans().to_vec()))),
        last => Err(Failure::Argument(format!(
            "--rows names row {}, but the study has the rows 0 to {}",
            last.unwrap_or_default(),
            rows - 1
        ))),
    }
}

/// Rows of the built-in test scene that take `milliseconds` each, computing or sleeping.
fn stub_rows(study: CheckedStudy, arguments: &RunArguments, milliseconds: f64) -> Result<StubRows, Failure> {
    let duration = Duration::try_from_secs_f64(milliseconds * 1e-3);
    let duration = duration.map_err(|error| Failure::Argument(format!("--stub-row-ms: {error}")))?;
    Ok(StubRows { study, duration, busy: arguments.stub_busy })
}

/// A column of the table of runs that is worked with must be there and hold numbers.
pub(super) fn check_number(info: &DatasetInfo, name: &str) -> Result<(), DatasetError> {
    let table = TableName::Runs;
    let columns = Columns::new(info)?.describe(table);
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

/// Tells of a sweep on stderr.
struct Display<'a> {
    folder: &'a Path,
    /// Whether chosen rows are run again.
    again: bool,
    /// Made when the rows begin.
    progress: OnceLock<Progress>,
}

impl Display<'_> {
    fn show(&self, event: SweepEvent<'_>) {
        let (folder, progress) = (self.folder.display(), self.progress.get());
        match event {
            SweepEvent::Grown { growth, rows } => {
                let before = growth.rows_before;
                eprint_line(&format_args!(
                    "the study has grown from {before} to {rows} rows: rows that are done are kept"
                ));
                tell_of_damage(&growth.damaged, &growth.notes);
            }
            SweepEvent::Found { damaged, notes } => tell_of_damage(damaged, notes),
            SweepEvent::Begins { rows, done, failed } => {
                match done {
                    done if self.again => match rows - done {
                        0 => eprint_line(&format_args!("no row of {folder} is to be run again")),
                        again => eprint_line(&format_args!(
                            "running {} of {folder} again; what is there stays until they are done",
                            plural(again as usize, "row")
                        )),
                    },
                    0 => {}
                    done if done == rows => eprint_line(&format_args!("all {done} rows are in {folder} already")),
                    done => eprint_line(&format_args!("continuing: {done} of {rows} rows are in {folder} already")),
                }
                self.progress.get_or_init(|| Progress::to_stderr(rows, DEFAULT_INTERVAL).resumed(done, failed));
            }
            SweepEvent::Repeats { rows: 0 } => {}
            SweepEvent::Repeats { rows } => {
                let are = if rows == 1 { "row has" } else { "rows have" };
                eprint_line(&format_args!(
                    "{rows} {are} the same factors as another one: each of these is run once and stored for all"
                ));
            }
            SweepEvent::RowEnded(status) => progress.into_iter().for_each(|progress| progress.row_ended(status)),
            SweepEvent::Tick => progress.into_iter().for_each(|progress| match progress_wanted() {
                true => progress.show_now(),
                false => progress.tick(),
            }),
            SweepEvent::Ends => progress.into_iter().for_each(Progress::finish),
            SweepEvent::SummaryNotWritten(path) => {
                eprint_line(&format_args!("warning: the summary could not be written to {}", path.display()));
            }
            SweepEvent::Failed => {
                eprint_line(&format_args!("finished rows are kept in {folder}; run the same command to continue"));
            }
        }
    }
}

fn tell_of_damage(damaged: &[DatasetError], notes: &[String]) {
    notes.iter().for_each(|note| eprint_line(note));
    for damage in damaged {
        eprint_line(&format_args!("damaged: {damage}"));
    }
    if !damaged.is_empty() {
        eprint_line(
            &"the rows of the damaged parts are computed again; the parts are kept in the folder .damaged of the dataset",
        );
    }
}

/// The first interrupt lets the running rows finish, the second ends the program; what is on disk is whole either way.
pub(super) fn stop_on_interrupt() {
    if Caller::current().is_some() {
        return;
    }
    let handler = || {
        if STOP.swap(true, Ordering::SeqCst) {
            eprint_line(&"stopped at once: rows that ended are kept, those that ran are not; the same command goes on");
            // The words for `decore status`; the rows do not depend on them.
            let _ = FOLDER.get().map(|folder| SweepStatus::note_stop(folder));
            std::process::exit(Exit::Interrupted as i32);
        }
        eprint_line(
            &"interrupted: finishing the rows that run; interrupt again to stop at once (the same command goes on)",
        );
    };
    if let Err(error) = keep_nohup(|| ctrlc::set_handler(handler)) {
        eprint_line(&format_args!("warning: interrupts end the program at once ({error})"));
    }
}
