//! `decore init`: a commented study to start from.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure};
use super::outputs::{Form, Output, check_outputs};
use super::text::{print_line, shell_word};
use super::written::Written;
use decore_study::template;

#[derive(Debug, Args)]
pub(super) struct InitArguments {
    /// File to write; `-` prints the study
    #[arg(default_value = "study.toml")]
    file: PathBuf,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn init(arguments: &InitArguments) -> Result<Exit, Failure> {
    let text = template().map_err(|error| Failure::Argument(error.to_string()))?;
    if arguments.file.as_os_str() == "-" {
        if arguments.json {
            let message =
                "--json tells of a file that was written, and `-` prints the study itself: give a file's name";
            return Err(Failure::Argument(message.to_owned()));
        }
        print_line(&text.trim_end())?;
        return Ok(Exit::Done);
    }
    check_outputs(&[], &[Output { flag: "FILE", path: Some(&arguments.file), form: Form::File(&[]) }])?;
    let path = arguments.file.display().to_string();
    let written = OpenOptions::new().write(true).create_new(true).open(&arguments.file).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    match written {
        Ok(()) => {
            let mut told = Written::default();
            told.file("study", &arguments.file)?;
            let next = ["check", "run"].map(|command| format!("decore {command} {}", shell_word(&arguments.file)));
            let words = format!("wrote {path}; next: {}", next.join(", "));
            next.into_iter().for_each(|command| told.next(command));
            told.print(arguments.json, &words)?;
            Ok(Exit::Done)
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            Err(Failure::Argument(format!("{path} is there already and was not touched: choose another name")))
        }
        Err(source) => Err(Failure::Write { path, source }),
    }
}
