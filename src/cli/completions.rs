//! `decore completions` and `decore man`: what shells and manuals know of the command line, from its own definition.

use std::fs;
use std::io::{Write, stdout};
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use super::exit::{Exit, Failure};
use super::text::{plural, printed, say};

#[derive(Debug, Args)]
pub(super) struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

#[derive(Debug, Args)]
pub(super) struct ManArguments {
    /// Folder to write to, made where it is not there: `decore.1` and `decore-COMMAND.1` for each command.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

pub(super) fn completions(mut program: Command, arguments: &CompletionsArguments) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "decore", &mut script);
    printed(stdout().write_all(&script)).map(|()| Exit::Done)
}

pub(super) fn man(mut program: Command, arguments: &ManArguments) -> Result<Exit, Failure> {
    let folder = &arguments.output;
    let failed = |source| Failure::Write { path: folder.display().to_string(), source };
    fs::create_dir_all(folder).map_err(failed)?;
    program.build();
    let pages = 1 + program.get_subcommands().count();
    clap_mangen::generate_to(program, folder).map_err(failed)?;
    say(&format_args!("wrote {} to {}", plural(pages, "page"), folder.display()))?;
    Ok(Exit::Done)
}
