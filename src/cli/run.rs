//! `decore run`: all rows of a study, or a shard's, into its tables; the same command again goes on.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;

use super::exit::{Exit, Failure};
use super::monitor::{Beginning, Monitor};
use super::shard::Shard;
use super::text::{self, say, tell};
use crate::dataset::{
    Columns, DatasetError, DatasetInfo, DatasetReader, DatasetWriter, Existing, Growth, RowRecorder, RowSpan,
    StoredRow, SweepState, SweepStatus, TableName, grow,
};
use crate::engine::{Engine, Rows, constrained};
use crate::report::{ReportSettings, summarise};
use crate::run::{
    BatchError, BatchSettings, BatchSummary, DEFAULT_INTERVAL, DEFAULT_RETRIES, DEFAULT_WINDOW, Progress, RowOutcome,
    RowTask, StubRows, run_batch,
};
use crate::study::Study;

/// Set by the first interrupt, or by too many failed rows: no new rows are started.
static STOP: AtomicBool = AtomicBool::new(false);

#[derive(Debug, Args)]
pub(super) struct RunArguments {
    /// Study file (TOML).
    study: PathBuf,
    /// Folder for the tables; one that holds rows of the same study is continued. Default: `out/` and the study's name,
    /// for a shard `out/<study>.shards/shard-<i>-of-<n>`.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Threads that run rows, at most 1024; 0: as many as the machine has. Results do not depend on it.
    #[arg(short, long, default_value_t = 0, value_parser = text::threads)]
    threads: usize,
    /// Start anew: replace a dataset that is already in the folder.
    #[arg(long)]
    replace: bool,
    /// Set a value of the study, e.g. `hammer.left.supply_bar=4.5`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Column of the table of runs by which the summary ranks rows.
    #[arg(long, default_value = crate::report::DEFAULT_RANKING)]
    rank_by: String,
    /// Run only the i-th of n shares of the rows; `decore merge` makes one dataset of them.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Stop when more rows than this are not done (invalid, diverged, budget exhausted), those of earlier runs included.
    /// Default: no limit.
    #[arg(long, value_name = "ROWS")]
    max_failed: Option<u64>,
    /// Times a row that diverged is run again, each time with a hundredth of the tolerance before.
    #[arg(long, default_value_t = DEFAULT_RETRIES, value_name = "TIMES")]
    retries: u32,
    /// Write how the sweep ended to this file (JSON) when it ends.
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    /// Built-in test scene: rows that take this time in ms and whose outcomes are made up.
    #[arg(long, value_name = "MS", hide = true)]
    stub_row_ms: Option<f64>,
    /// Rows of the test scene compute for their time instead of sleeping.
    #[arg(long, hide = true, requires = "stub_row_ms")]
    stub_busy: bool,
}

pub(super) fn run(arguments: &RunArguments) -> Result<Exit, Failure> {
    stop_on_interrupt();
    let rows = match arguments.stub_row_ms {
        Some(milliseconds) => stub_rows(arguments, milliseconds)?,
        None => {
            let engine = Engine::load(&arguments.study, &arguments.overrides)?;
            Rows::Simulated(Box::new(engine.with_retries(arguments.retries)))
        }
    };
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let whole = default_folder(&arguments.study);
        arguments.shard.map_or(whole.clone(), |shard| shard.folder(&whole))
    });
    // Before the rows are run, not after.
    let settings = ReportSettings { rank_by: arguments.rank_by.clone(), ..ReportSettings::default() };
    let info = rows.info();
    check_ranking(&info, &settings.rank_by)?;
    let exit = sweep((&rows, &info), &folder, arguments)?;
    let reader = DatasetReader::open(&folder)?;
    say(&summarise(&reader, &settings)?.to_string().trim_end());
    Ok(exit)
}

/// Rows of the built-in test scene that take `milliseconds` each, computing or sleeping.
fn stub_rows(arguments: &RunArguments, milliseconds: f64) -> Result<Rows, Failure> {
    let duration = Duration::try_from_secs_f64(milliseconds * 1e-3);
    let duration = duration.map_err(|error| Failure::Argument(format!("--stub-row-ms: {error}")))?;
    let study = constrained(&Study::load(&arguments.study)?.with_overrides(&arguments.overrides)?)?;
    let (hammers, castings) = (study.hammer_names().len(), study.casting_names().len());
    let rows = StubRows { duration, busy: arguments.stub_busy, hammers, castings };
    Ok(Rows::Stub { study: Box::new(study), rows })
}

/// `out/<name of the study file>`.
pub(super) fn default_folder(study: &Path) -> PathBuf {
    Path::new("out").join(study.file_stem().unwrap_or(study.as_os_str()))
}

/// The column that the summary ranks by must be there and hold numbers.
fn check_ranking(info: &DatasetInfo, name: &str) -> Result<(), DatasetError> {
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

/// A row's way from its simulation into the journal.
struct SweepTask<'a> {
    rows: &'a Rows,
    recorder: RowRecorder,
    monitor: &'a Monitor,
    max_failed: Option<u64>,
}

impl RowTask for SweepTask<'_> {
    type Kept = Result<StoredRow, DatasetError>;

    fn run(&self, row: u64) -> RowOutcome {
        self.rows.run(row)
    }

    fn keep(&self, row: u64, outcome: RowOutcome) -> Self::Kept {
        let failed = self.monitor.note(row, &outcome);
        if self.max_failed.is_some_and(|most| failed > most) {
            STOP.store(true, Ordering::SeqCst);
        }
        self.recorder.record(&self.rows.record(row, outcome))
    }
}

/// Runs the rows that are still to be run.
fn sweep((rows, info): (&Rows, &DatasetInfo), folder: &Path, arguments: &RunArguments) -> Result<Exit, Failure> {
    let whole = RowSpan { first: 0, end: info.rows };
    let range = arguments.shard.map_or(whole, |shard| shard.rows(info.rows));
    let existing = if arguments.replace { Existing::Replace } else { Existing::Resume };
    if existing == Existing::Resume && range == whole {
        let growth = grow(folder, info, &|first| rows.study().rows_hash(first as usize))?;
        growth.iter().for_each(|growth| tell_of_growth(growth, info.rows));
    }
    let mut writer = DatasetWriter::open(folder, info, range, existing)?;
    let recovered = writer.recovered();
    tell_of_earlier_runs(&writer, range, folder);
    let place = writer.place();
    let monitor = Monitor::new(Beginning {
        place: place.clone(),
        rows: range.len(),
        recovered,
        threads: threads(arguments.threads),
        progress: Progress::to_stderr(range.len(), DEFAULT_INTERVAL).resumed(recovered.0, recovered.1),
    });
    let task = SweepTask { rows, recorder: writer.recorder(), monitor: &monitor, max_failed: arguments.max_failed };
    if arguments.max_failed.is_some_and(|most| recovered.1 > most) {
        STOP.store(true, Ordering::SeqCst);
    }
    let settings =
        BatchSettings { threads: arguments.threads, window: DEFAULT_WINDOW, stop: &STOP, progress: &monitor };
    let left = writer.rows_left();
    let summary =
        run_batch(left.iter().flat_map(|span| span.first..span.end), &settings, &task, |_, row| writer.accept(row?));
    monitor.end_line();
    // What was handed over before a failure is kept.
    let finished = writer.finish();
    let (status, exit) = match (&summary, &finished) {
        (Ok(_), Err(error)) => (monitor.status(SweepState::NotWritten, error.to_string()), Exit::NotWritten),
        _ => ending(&monitor, &summary, arguments.max_failed),
    };
    monitor.finish(&status, arguments.summary.as_deref());
    if (summary.is_err() || finished.is_err()) && place.is_there() {
        tell(&format_args!("what is done is kept in {}; the same command goes on", folder.display()));
    }
    summary?;
    finished?;
    if !status.message.is_empty() {
        tell(&format_args!(
            "{}: {} of {} rows are in {}",
            status.message,
            status.rows_done,
            status.rows,
            folder.display()
        ));
    }
    Ok(exit)
}

/// How a sweep ended, as status and exit code.
fn ending(
    monitor: &Monitor,
    summary: &Result<BatchSummary, BatchError<DatasetError>>,
    max_failed: Option<u64>,
) -> (SweepStatus, Exit) {
    let failed = monitor.status(SweepState::Running, String::new()).rows_failed;
    let (state, message, exit) = match (summary, max_failed) {
        (Err(error), _) => (SweepState::NotWritten, error.to_string(), Exit::NotWritten),
        (Ok(summary), Some(most)) if summary.stopped && failed > most => {
            let message = format!(
                "stopped: {failed} rows are not done, more than --max-failed {most} allows (`decore status` shows the \
                 last ones); a larger limit goes on"
            );
            (SweepState::TooManyFailed, message, Exit::TooManyFailed)
        }
        (Ok(summary), _) if summary.stopped => {
            let message = "interrupted; the same command goes on".to_owned();
            (SweepState::Interrupted, message, Exit::Interrupted)
        }
        (Ok(_), _) if failed > 0 => (SweepState::Complete, String::new(), Exit::RowsFailed),
        (Ok(_), _) => (SweepState::Complete, String::new(), Exit::Done),
    };
    (monitor.status(state, message), exit)
}

fn tell_of_earlier_runs(writer: &DatasetWriter, range: RowSpan, folder: &Path) {
    tell_of_damage(writer.damaged(), writer.notes());
    match writer.recovered().0 {
        0 => {}
        done if done == range.len() => tell(&format_args!("all {done} rows are in {} already", folder.display())),
        done => tell(&format_args!("continuing: {done} of {} rows are in {} already", range.len(), folder.display())),
    }
}

fn tell_of_growth(growth: &Growth, rows: u64) {
    tell(&format_args!("the study has grown from {} to {rows} rows: rows that are done are kept", growth.rows_before));
    tell_of_damage(&growth.damaged, &growth.notes);
}

fn tell_of_damage(damaged: &[DatasetError], notes: &[String]) {
    notes.iter().for_each(|note| tell(note));
    for damage in damaged {
        tell(&format_args!("damaged: {damage}"));
    }
    if !damaged.is_empty() {
        tell(
            &"the rows of the damaged parts are computed again; the parts are kept in the folder .damaged of the dataset",
        );
    }
}

fn threads(asked: usize) -> u64 {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    (if asked == 0 { all() } else { asked }) as u64
}

/// The first interrupt lets the running rows finish, the second ends the program; what is on disk is whole either way.
fn stop_on_interrupt() {
    let handler = || {
        if STOP.swap(true, Ordering::SeqCst) {
            tell(&"stopped at once: rows that ended are kept, those that ran are not; the same command goes on");
            std::process::exit(Exit::Interrupted as i32);
        }
        tell(&"interrupted: finishing the rows that run; interrupt again to stop at once (the same command goes on)");
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        tell(&format_args!("warning: interrupts end the program at once ({error})"));
    }
}
