//! `decore best`: runs rows until the study's goal has an answer, proves it by runs, and prints it.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::{Exit, Failure, write_durable_file};
use super::inputs::{default_folder, is_dataset};
use super::json::print_result;
use super::outputs::{Form, Output, StudyArguments};
use super::run::{run_rows, stop_on_interrupt};
use super::stored::Stored;
use super::text::{eprint_line, plural};
use decore_dataset::{DatasetReader, Lock, SweepState, settle};
use decore_lab::best::{
    ADDED_COLUMNS, Added, Answer, BestError, BestSettings, Purpose, Step, There, Verdict, added_file, added_folder,
    next, question, read_added,
};
use decore_study::Study;
use decore_study::engine::{Course, Engine, RowRunner, Verdict as Enough, pursue};

#[derive(Debug, Args)]
pub(super) struct BestArguments {
    /// Study file with a [goal], or folder of a dataset of such a study
    ///
    /// The rows of a study are run first. The rows of a dataset are used as they are.
    study: PathBuf,
    /// Folder for the tables of the study's rows (default: out/STUDY)
    ///
    /// Added rows are written to the folder with this name plus `.best`.
    #[arg(short, long, conflicts_with = "files_in")]
    output: Option<PathBuf>,
    /// Maximum number of added rows, comparisons and checks included
    #[arg(long, default_value_t = 160, value_name = "ROWS")]
    rows: u32,
    /// Rows that confirm the proposal; 0: no check
    ///
    /// The uncertain factors vary over these rows.
    #[arg(long, default_value_t = 100, value_name = "ROWS", value_parser = clap::value_parser!(u32).range(..=100_000))]
    checks: u32,
    /// Rows that are chosen at a time; this number changes the result slightly
    #[arg(long, default_value_t = 12, value_name = "ROWS", value_parser = clap::value_parser!(u32).range(1..=256))]
    batch: u32,
    /// Set a value of the study, for example `goal.confidence=0.99`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// With a dataset: folder that contains the files its study names (default: .)
    #[arg(long, value_name = "FOLDER")]
    files_in: Option<PathBuf>,
    /// Print the answer as JSON (schemas/best.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn best(arguments: &BestArguments) -> Result<Exit, Failure> {
    stop_on_interrupt();
    let from_dataset = is_dataset(&arguments.study);
    let folder = match (from_dataset, &arguments.output) {
        (true, _) => arguments.study.clone(),
        (false, Some(output)) => output.clone(),
        (false, None) => default_folder(&arguments.study),
    };
    let added = added_folder(&folder);
    let outputs = [
        Output {
            flag: "--output",
            path: Some(&folder).filter(|_| !from_dataset).map(PathBuf::as_path),
            form: Form::Dataset,
        },
        Output { flag: "--output", path: Some(&added), form: Form::Dataset },
    ];
    let arguments_of = StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs };
    let engine = match from_dataset {
        true => {
            let stored = Stored::open(&folder)?;
            let files = arguments.files_in.as_deref().unwrap_or(Path::new("."));
            stored.settle(arguments_of.engine_of(stored.study(files)?)?)
        }
        false => arguments_of.engine()?,
    };
    if engine.study().goal().is_none() {
        return Err(BestError::NoGoal.into());
    }
    let file = added_file(&folder);
    if let Some(above) = file.parent() {
        std::fs::create_dir_all(above)
            .map_err(|source| Failure::Write { path: above.display().to_string(), source })?;
    }
    let mut course =
        Sought { arguments, engine, from_dataset, folder: &folder, added: &added, file: &file, answer: None };
    if !file.exists() {
        course.write(&[])?;
    }
    // Another one would decide from the same rows.
    let _lock = Lock::take_beside(&file)?;
    settle(&folder)?;
    if pursue(&added, &mut course)? != SweepState::Complete {
        return Ok(Exit::Interrupted);
    }
    let Some(answer) = course.answer else { return Ok(Exit::Interrupted) };
    print_result(arguments.json, &answer, || answer.to_string())?;
    let is_answered = matches!(answer.verdict, Verdict::Proven | Verdict::Unchecked);
    Ok(if is_answered { Exit::Done } else { Exit::RowsFailed })
}

/// Course of a search. Each decision adds rows to the table of added rows.
struct Sought<'a> {
    arguments: &'a BestArguments,
    engine: Engine,
    /// Whether the first dataset is taken as it is.
    from_dataset: bool,
    folder: &'a Path,
    /// Dataset of the added rows.
    added: &'a Path,
    /// Table of the added rows.
    file: &'a Path,
    answer: Option<Answer>,
}

impl Sought<'_> {
    /// Rows that were added, in their order.
    fn rows(&self) -> Result<Vec<Added>, Failure> {
        let advice = |message: String| {
            Failure::Argument(format!(
                "{message}; remove the file and the folder {} to start anew",
                self.added.display()
            ))
        };
        read_added(self.file, self.engine.study()).map_err(advice)
    }

    fn unwritten(&self, source: std::io::Error) -> Failure {
        Failure::Write { path: self.file.display().to_string(), source }
    }

    /// Writes the table of added rows, whole or not at all.
    fn write(&self, rows: &[Added]) -> Result<(), Failure> {
        let names = self.engine.study().factors().iter().map(|factor| factor.name.as_str());
        let failed = |source| self.unwritten(source);
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(names.chain(ADDED_COLUMNS)).map_err(|error| failed(error.into()))?;
        for row in rows {
            let cells = row.cells.iter().map(String::as_str).chain([row.purpose.name(), row.question.as_str()]);
            writer.write_record(cells).map_err(|error| failed(error.into()))?;
        }
        write_durable_file(self.file, writer.into_inner().map_err(|error| failed(error.into_error()))?)
    }

    /// The study with the added rows as its design.
    fn added_study(&self) -> Result<Study, Failure> {
        Ok(self.engine.study().with_rows(self.file)?)
    }
}

impl Course for Sought<'_> {
    type Error = Failure;

    fn run_missing(&mut self) -> Result<SweepState, Failure> {
        if !self.from_dataset {
            let state = run_rows(&self.engine, self.folder, None)?.state;
            if state != SweepState::Complete {
                return Ok(state);
            }
        }
        if self.rows()?.is_empty() {
            return Ok(SweepState::Complete);
        }
        Ok(run_rows(&Engine::new(self.added_study()?)?, self.added, None)?.state)
    }

    fn judge(&mut self) -> Result<Enough, Failure> {
        let rows = self.rows()?;
        let base = DatasetReader::open(self.folder)?;
        let added = if rows.is_empty() { None } else { Some(DatasetReader::open(self.added)?) };
        let there = There { base: &base, added: added.as_ref(), rows: &rows };
        let of = self.arguments;
        let settings = BestSettings { rows: of.rows as usize, checks: of.checks as usize, batch: of.batch as usize };
        match next(self.engine.checked(), there, &settings)? {
            Step::Done(answer) => {
                self.answer = Some(*answer);
                Ok(Enough::Enough)
            }
            Step::More { rows: more, purpose, progress } => {
                let what = match purpose {
                    Purpose::Learn => "to learn from",
                    Purpose::Compare => "to compare the best places",
                    Purpose::Check => "to prove a place",
                };
                eprint_line(&format_args!("{progress}; {} {what}", plural(more.len(), "row")));
                let question = self.engine.study().goal().map_or_else(String::new, question);
                let more = more.into_iter().map(|cells| Added { purpose, question: question.clone(), cells });
                self.write(&rows.iter().cloned().chain(more).collect::<Vec<Added>>())?;
                Ok(Enough::More)
            }
        }
    }
}
