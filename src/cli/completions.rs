//! `decore completions` and `decore man`: scripts for shells and manual pages, from the definition of the command line.

use std::fs;
use std::io::{Write, stdout};
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use super::exit::{Exit, Failure};
use super::outputs::{Form, Output, check_outputs};
use super::text::{plural, printed};
use super::written::Written;

#[derive(Debug, Args)]
pub(super) struct CompletionsArguments {
    /// Your shell
    shell: Shell,
}

#[derive(Debug, Args)]
pub(super) struct ManArguments {
    /// Folder to write to
    ///
    /// It gets `decore.1`, and `decore-COMMAND.1` for each command.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Replace existing files
    #[arg(long)]
    replace: bool,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

pub(super) fn completions(mut program: Command, arguments: &CompletionsArguments) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "decore", &mut script);
    printed(stdout().write_all(&script)).map(|()| Exit::Done)
}

pub(super) fn man(mut program: Command, arguments: &ManArguments) -> Result<Exit, Failure> {
    let folder = &arguments.output;
    program.build();
    let commands = program.get_subcommands().map(|command| format!("decore-{}.1", command.get_name()));
    let pages: Vec<String> = ["decore.1".to_owned()].into_iter().chain(commands).collect();
    let names: Vec<&str> = pages.iter().map(String::as_str).collect();
    let form = Form::Folder { names: &names, replace: arguments.replace };
    check_outputs(&[], &[Output { flag: "--output", path: Some(folder), form }])?;
    let failed = |source| Failure::Write { path: folder.display().to_string(), source };
    fs::create_dir_all(folder).map_err(failed)?;
    clap_mangen::generate_to(program, folder).map_err(failed)?;
    let mut written = Written::default();
    pages.iter().try_for_each(|page| written.file("manual page", &folder.join(page)))?;
    let words = format_args!("wrote {} to {}", plural(pages.len(), "page"), folder.display());
    written.print(arguments.json, &words)?;
    Ok(Exit::Done)
}
