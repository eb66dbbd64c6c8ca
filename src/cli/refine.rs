//! `decore refine`: runs the rows of a table, and adds those that teach or promise the most, batch by batch.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

use super::exit::{Exit, Failure, write_durable_file};
use super::inputs::{default_folder, expect_ending};
use super::json::print_result;
use super::outputs::{Form, Output, StudyArguments};
use super::run::{check_number, run_rows, stop_on_interrupt};
use super::text::{eprint_line, plural};
use decore_dataset::{DatasetReader, Lock, SweepState};
use decore_lab::best;
use decore_lab::refinement::{Aim, Goal, Limit, Progress, Proposal, RefinementSettings, Side, Target, propose};
use decore_study::engine::{Course, Engine, RowRunner, Verdict, pursue};
use decore_study::{CheckedStudy, Study};

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("aim").required(true).args(["learn", "maximise", "minimise", "boundary", "failures", "goal"]))]
#[command(override_usage = "decore refine [OPTIONS] --most-rows <ROWS> <AIM> <STUDY>")]
pub(super) struct RefineArguments {
    /// Study file with `design.kind = "table"`
    ///
    /// New rows are appended to the design's file of rows (CSV).
    study: PathBuf,
    /// Folder for the tables (default: out/STUDY)
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Add rows that improve the models of these columns
    #[arg(long, num_args = 1.., value_name = "NAME")]
    learn: Vec<String>,
    /// Add rows that may increase this column
    #[arg(long, value_name = "NAME")]
    maximise: Option<String>,
    /// Add rows that may decrease this column
    #[arg(long, value_name = "NAME")]
    minimise: Option<String>,
    /// Add rows near this limit, for example `max_casting_point_velocity_m_s<=1.5`
    #[arg(long, value_name = "NAME<=VALUE")]
    boundary: Option<Limit>,
    /// Add rows near the boundary between done and failed rows
    #[arg(long)]
    failures: bool,
    /// Add rows that help to answer the study's [goal]
    ///
    /// Uncertain factors are not chosen. The answer is printed at the end.
    #[arg(long)]
    goal: bool,
    /// Constraint on the best row, for example `total_air_used_nl<=300`; repeatable
    #[arg(long = "limit", value_name = "NAME<=VALUE", conflicts_with_all = ["learn", "boundary", "failures", "goal"])]
    limits: Vec<Limit>,
    /// With --learn: stop when the Q2 of each column is at least this
    ///
    /// `decore surrogate` prints the same Q2.
    #[arg(long, default_value_t = 0.95, value_name = "Q2", value_parser = q2, conflicts_with_all = NOT_LEARNT)]
    until_q2: f64,
    /// With --learn: stop when the 95 % intervals are this narrow; repeatable
    ///
    /// Example: `delivered_work_j=5`, in the column's unit. The width is the average over the ranges of the factors. It replaces the Q2 of
    /// this column.
    #[arg(long, value_name = "NAME=WIDTH", value_parser = width, conflicts_with_all = NOT_LEARNT)]
    until_width: Vec<(String, f64)>,
    /// With --maximise or --minimise: stop when no run promises a larger gain
    ///
    /// The gain is in the column's unit. By default, all rows are used.
    #[arg(long, value_name = "GAIN", value_parser = positive, conflicts_with_all = ["learn", "boundary", "failures", "goal"])]
    until_gain: Option<f64>,
    /// With --boundary or --failures: stop when this share of the ranges is unsure
    ///
    /// The share is the model's own estimate of points on the wrong side.
    #[arg(long, default_value_t = 0.01, value_name = "SHARE", value_parser = positive, conflicts_with_all = OPTIMA, conflicts_with_all = ["learn", "goal"])]
    until_unsure: f64,
    /// Rows that are added at a time; this number changes the result slightly
    #[arg(long, default_value_t = 4, value_name = "ROWS", value_parser = clap::value_parser!(u64).range(1..=256))]
    batch: u64,
    /// Maximum number of rows of the design
    #[arg(long, value_name = "ROWS")]
    most_rows: u64,
    /// Set a value of the study, for example `hammer.left.supply_bar=4.5`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Print the progress as JSON (schemas/refinement.schema.json)
    ///
    /// With --goal, print the answer (schemas/best.schema.json).
    #[arg(long)]
    json: bool,
}

/// Goals that are an optimum.
const OPTIMA: [&str; 2] = ["maximise", "minimise"];
/// Goals that are no model of outputs.
const NOT_LEARNT: [&str; 5] = ["maximise", "minimise", "boundary", "failures", "goal"];

/// Reads a Q2.
fn q2(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..1.0).contains(share));
    share.ok_or_else(|| "expected a number from 0 to below 1, e.g. 0.95".to_owned())
}

/// Reads a number above 0.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "expected a number above 0, e.g. 0.01".to_owned())
}

/// Reads the width of a column's intervals.
fn width(text: &str) -> Result<(String, f64), String> {
    let wrong = || "expected NAME=WIDTH with a width above 0, e.g. delivered_work_j=5".to_owned();
    let (name, width) = text.split_once('=').ok_or_else(wrong)?;
    Ok((name.trim().to_owned(), positive(width).map_err(|_| wrong())?))
}

impl RefineArguments {
    fn settings(&self) -> Result<RefinementSettings, Failure> {
        let limits = self.limits.clone();
        let optimise = |output: &String, side: Side| {
            let gain = self.until_gain;
            Goal::Optimise { output: output.clone(), side, limits, gain }
        };
        let goal = match (&self.maximise, &self.minimise, &self.boundary) {
            (Some(output), ..) => optimise(output, Side::Most),
            (_, Some(output), _) => optimise(output, Side::Least),
            (.., Some(limit)) => Goal::Bound { limit: limit.clone(), unsure: self.until_unsure },
            _ if self.failures => Goal::Separate { unsure: self.until_unsure },
            _ => Goal::Learn { targets: self.targets()? },
        };
        Ok(RefinementSettings { goal, batch: self.batch as usize })
    }

    fn targets(&self) -> Result<Vec<Target>, Failure> {
        if let Some(place) = (1..self.learn.len()).find(|place| self.learn[..*place].contains(&self.learn[*place])) {
            let twice = &self.learn[place];
            return Err(Failure::Argument(format!("--learn names {twice} twice: name each column once")));
        }
        if let Some((name, _)) = self.until_width.iter().find(|(name, _)| !self.learn.contains(name)) {
            return Err(Failure::Argument(format!(
                "--until-width {name}: it is not learnt; name it with --learn, or one of those there: {}",
                self.learn.join(", ")
            )));
        }
        let target = |output: &String| {
            let width = self.until_width.iter().find(|(name, _)| name == output).map(|(_, width)| *width);
            Target { output: output.clone(), aim: width.map_or(Aim::Q2(self.until_q2), Aim::Width) }
        };
        Ok(self.learn.iter().map(target).collect())
    }
}

pub(super) fn refine(arguments: &RefineArguments) -> Result<Exit, Failure> {
    stop_on_interrupt();
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.study));
    let outputs = [Output { flag: "--output", path: Some(&folder), form: Form::Dataset }];
    let study = StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs };
    let settings = arguments.settings()?;
    // Before anything is run, not after.
    let file = row_file(&study.study()?)?;
    // Whatever the folder: another one that adds to the table would do so from the same rows.
    let _lock = Lock::take_beside(&file)?;
    let mut course = Refined { arguments, study, folder: &folder, file: &file, settings: &settings, engine: None };
    if pursue(&folder, &mut course)? != SweepState::Complete {
        return Ok(Exit::Interrupted);
    }
    let rows_failed = DatasetReader::open(&folder)?.manifest().rows_failed();
    Ok(if rows_failed == 0 { Exit::Done } else { Exit::RowsFailed })
}

/// Course of a refinement. Each decision adds rows to the table of rows.
struct Refined<'a> {
    arguments: &'a RefineArguments,
    study: StudyArguments<'a>,
    folder: &'a Path,
    /// The table.
    file: &'a Path,
    settings: &'a RefinementSettings,
    /// The study with the rows that the table has now.
    engine: Option<Engine>,
}

impl Course for Refined<'_> {
    type Error = Failure;

    fn run_missing(&mut self) -> Result<SweepState, Failure> {
        let engine = self.engine.insert(self.study.engine()?);
        check_budget(self.arguments.most_rows, engine.checked().row_count() as u64, self.file)?;
        self.settings.goal.outputs().iter().try_for_each(|name| check_number(&engine.info(), name))?;
        Ok(run_rows(engine, self.folder, None)?.state)
    }

    fn judge(&mut self) -> Result<Verdict, Failure> {
        let Some(engine) = &self.engine else { return Ok(Verdict::More) };
        let rows_then = engine.checked().row_count() as u64 + self.arguments.batch;
        if self.arguments.goal {
            return self.judge_goal(engine, rows_then <= self.arguments.most_rows);
        }
        let Proposal { progress, rows } = propose(engine.checked(), &DatasetReader::open(self.folder)?, self.settings)?;
        if progress.reached || progress.exhausted || rows_then > self.arguments.most_rows {
            ended(&progress, self.arguments)?;
            return Ok(Verdict::Enough);
        }
        eprint_line(&progress);
        append(self.file, engine.checked(), &rows)?;
        eprint_line(&format_args!("{} added to {}", plural(rows.len(), "row"), self.file.display()));
        Ok(Verdict::More)
    }
}

impl Refined<'_> {
    /// Adds rows that narrow the choice by the study's goal, while there is room for them; else answers.
    fn judge_goal(&self, engine: &Engine, room: bool) -> Result<Verdict, Failure> {
        let reader = DatasetReader::open(self.folder)?;
        let rows = match room {
            true => best::learn(engine.checked(), &reader, self.arguments.batch as usize)?,
            false => Vec::new(),
        };
        if rows.is_empty() {
            let answer = best::expected(engine.checked(), &reader)?;
            print_result(self.arguments.json, &answer, || answer.sentence.clone())?;
            return Ok(Verdict::Enough);
        }
        append(self.file, engine.checked(), &rows)?;
        eprint_line(&format_args!("{} added to {}", plural(rows.len(), "row"), self.file.display()));
        Ok(Verdict::More)
    }
}

/// A budget that is spent before anything is added is a mistake.
fn check_budget(most_rows: u64, rows: u64, file: &Path) -> Result<(), Failure> {
    if rows <= most_rows {
        return Ok(());
    }
    let file = file.display();
    Err(Failure::Argument(format!(
        "--most-rows {most_rows}: {file} has {rows} rows already; give at least as many as the design is to have in the end (`decore \
         run` runs the rows that are there)"
    )))
}

/// Prints the result as text or as JSON.
fn ended(progress: &Progress, arguments: &RefineArguments) -> Result<(), Failure> {
    let most = arguments.most_rows;
    print_result(arguments.json, progress, || match progress.reached {
        true => format!("the goal is reached: {progress}"),
        false if progress.exhausted => {
            format!("all places that may be run are rows already, or next to one: {progress}")
        }
        false => format!("the next batch would go beyond --most-rows {most}: {progress}"),
    })
}

/// The file of rows of the study's design.
fn row_file(study: &Study) -> Result<PathBuf, Failure> {
    let file = study.row_file().ok_or_else(|| {
        Failure::Argument(
            "refine adds rows to a table: it needs `kind = \"table\"` and `file = \"rows.csv\"` in [design]; `decore design \
             STUDY --output rows.csv` writes the first rows, from a study with any kind of design"
                .into(),
        )
    })?;
    expect_ending("the file of rows", &file, &["csv"])?;
    Ok(file)
}

/// Adds rows at the end of a table, on the disk when it returns; those that are there stay as they are, also if the program ends
/// meanwhile.
fn append(file: &Path, study: &CheckedStudy, rows: &[Vec<String>]) -> Result<(), Failure> {
    let failed = |source: std::io::Error| Failure::Write { path: file.display().to_string(), source };
    let text = decore_files::read_text(file, decore_files::Limit::ROWS).map_err(failed)?;
    let header = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes()).headers().cloned();
    let header = header.map_err(|error| failed(error.into()))?;
    let names: Vec<&str> = study.study().factors().iter().map(|factor| factor.name.as_str()).collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (index, row) in rows.iter().enumerate() {
        let cell = |column: &str| {
            let column = column.trim_start_matches('\u{feff}');
            let own = |name: &&str| column == *name || column.strip_prefix("factor_") == Some(name);
            match names.iter().position(own) {
                Some(place) => row[place].clone(),
                None if column == "row" => (study.row_count() + index).to_string(),
                None => String::new(),
            }
        };
        writer.write_record(header.iter().map(cell)).map_err(|error| failed(error.into()))?;
    }
    let added = writer.into_inner().map_err(|error| failed(error.into_error()))?;
    let mut bytes = text.into_bytes();
    if !bytes.ends_with(b"\n") {
        bytes.push(b'\n');
    }
    bytes.extend(added);
    write_durable_file(file, bytes)
}
