//! Runs commands inside another program, such as Python. That program receives the printed text and the progress, and can stop a command.

use std::cell::RefCell;
use std::ffi::OsString;
use std::mem::take;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use arrow_array::RecordBatch;
use clap::{ArgAction, CommandFactory, Parser};

use super::{Arguments, Failure, execute};
use decore_study::engine::SweepEvent;

/// Commands that a program has no use for: they print pages and scripts for people and shells.
const WITHOUT_RESULT: [&str; 3] = ["completions", "man", "help"];

thread_local! {
    static CALLER: RefCell<Option<Caller>> = const { RefCell::new(None) };
}

/// Hears of the rows that a command runs, on any thread.
pub(crate) type Listener = Arc<dyn Fn(SweepEvent<'_>) + Send + Sync>;

/// The program that called the command of this thread.
#[derive(Clone)]
pub(crate) struct Caller {
    /// Set once no more rows are to be started.
    pub stop: Arc<AtomicBool>,
    /// Hears of rows.
    pub listener: Listener,
    result: Arc<Mutex<Called>>,
}

/// Result of a command for the program that called it.
#[derive(Debug, Default)]
pub(crate) struct Called {
    /// Exit code of the command line.
    pub exit: i32,
    /// Result as JSON.
    pub json: String,
    /// Result in words, as the command line prints it; empty for commands that have none beside JSON.
    pub text: String,
    /// Lines for standard error.
    pub notes: Vec<String>,
    /// Folder of the dataset that the command wrote.
    pub dataset: Option<PathBuf>,
    /// Result as a table, with its name.
    pub table: Option<(&'static str, RecordBatch)>,
}

impl Caller {
    /// A program that stops a command by a flag and hears of its rows.
    pub fn new(stop: Arc<AtomicBool>, listener: Listener) -> Self {
        Self { stop, listener, result: Arc::default() }
    }

    /// The program that called the command of this thread; `None` on the command line.
    pub fn current() -> Option<Self> {
        CALLER.with_borrow(Clone::clone)
    }

    /// Names the dataset that the command of this thread wrote.
    pub fn wrote(dataset: &Path) {
        if let Some(caller) = Self::current() {
            caller.keep(|result| result.dataset = Some(dataset.to_owned()));
        }
    }

    /// Changes the result.
    pub fn keep(&self, change: impl FnOnce(&mut Called)) {
        change(&mut self.result.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Runs a command on this thread.
    ///
    /// # Errors
    /// Arguments that the command does not take; the command's own errors.
    pub fn call(self, words: &[OsString]) -> Result<Called, Failure> {
        let words = std::iter::once(OsString::from("decore")).chain(words.iter().cloned());
        let arguments = Arguments::try_parse_from(words).map_err(|error| Failure::Argument(reason(&error)))?;
        let result = Arc::clone(&self.result);
        let before = CALLER.replace(Some(self));
        let ended = execute(arguments.command);
        CALLER.set(before);
        let mut called = take(&mut *result.lock().unwrap_or_else(PoisonError::into_inner));
        called.exit = ended? as i32;
        Ok(called)
    }
}

/// The first paragraph of the command line's complaint; the others name the usage for a terminal.
fn reason(error: &clap::Error) -> String {
    let text = error.to_string();
    let first = text.split("\n\n").next().unwrap_or_default();
    first.trim_start_matches("error: ").trim_end().to_owned()
}

/// An argument of a command.
#[derive(Debug)]
pub(crate) struct Argument {
    /// Name in programs.
    pub name: String,
    /// Option without its dashes; `None` if the place gives the meaning.
    pub option: Option<String>,
    /// `flag`, `one` or `many`.
    pub kind: &'static str,
    /// Default as text.
    pub default: Option<String>,
    /// Whether it must be given.
    pub required: bool,
    /// Text of the help.
    pub help: String,
}

/// Commands with a result: name, text of the help, arguments.
pub(crate) fn commands() -> Vec<(String, String, Vec<Argument>)> {
    let mut program = Arguments::command();
    program.build();
    let text = |text: Option<&clap::builder::StyledStr>| text.map(ToString::to_string).unwrap_or_default();
    let argument = |one: &clap::Arg| Argument {
        name: one.get_id().to_string(),
        option: one.get_long().map(str::to_owned),
        kind: match one.get_action() {
            ArgAction::SetTrue => "flag",
            ArgAction::Append => "many",
            _ => "one",
        },
        default: one.get_default_values().first().map(|value| value.to_string_lossy().into_owned()),
        required: one.is_required_set(),
        help: text(one.get_long_help().or(one.get_help())),
    };
    let shown = |one: &&clap::Arg| !one.is_hide_set() && !["json", "help"].contains(&one.get_id().as_str());
    let commands = program.get_subcommands().filter(|one| !WITHOUT_RESULT.contains(&one.get_name()));
    commands
        .map(|one| {
            let arguments = one.get_arguments().filter(shown).map(argument).collect();
            (one.get_name().to_owned(), text(one.get_long_about().or(one.get_about())), arguments)
        })
        .collect()
}
