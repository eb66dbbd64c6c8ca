//! The command line: one file per command.

mod accuracy;
mod address_space;
mod analyse;
mod best;
// Only the Python package calls commands.
#[cfg_attr(not(feature = "python"), allow(dead_code))]
pub(crate) mod caller;
mod check;
mod check_invalid;
mod check_links;
mod check_result;
mod cluster;
mod compare;
mod completions;
mod cores;
mod design;
mod exit;
mod export;
mod help;
mod init;
mod inputs;
mod json;
mod markdown;
mod measured;
mod merge;
mod mobility;
mod more_rows;
mod outputs;
mod overview;
mod pager;
mod paper;
mod progress;
mod refine;
mod report;
mod rows;
mod run;
mod scene;
mod scene_plot;
mod scene_result;
mod schemas;
mod shard;
mod signals;
mod status;
mod stored;
mod structure;
mod study_keys;
mod summary;
mod surrogate;
mod text;
mod verify;
mod written;

use std::process::ExitCode;

use clap::{FromArgMatches, Parser, Subcommand};
use overview::program;

pub use exit::Exit;
pub(crate) use exit::Failure;
pub use schemas::output_schemas;

use decore_model::run::thread_count;

/// Simulate pneumatic de-coring hammers, castings and the machine that carries them
///
/// Start with `decore init`, then `decore check` and `decore run`.
#[derive(Debug, Parser)]
#[command(name = "decore", version, disable_help_subcommand = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// The commands in the order of [`overview::GROUPS`].
#[derive(Debug, Subcommand)]
enum Command {
    /// Write a commented study to start from
    Init(init::InitArguments),
    /// Check a study: mistakes, size, time it will take
    Check(check::CheckArguments),
    /// Simulate one row of a study and print all its outputs
    Scene(scene::SceneArguments),
    /// Run all rows of a study and store the results
    ///
    /// Run the same command again to continue after a stop. Results do not depend on the number of threads or on stops.
    Run(run::RunArguments),
    /// Show how far a sweep is, or how it ended
    Status(status::StatusArguments),
    /// Find the best values for the study's goal and confirm them by runs
    Best(best::BestArguments),
    /// Run a table of rows and add the most useful ones, batch by batch
    ///
    /// Choose one aim: --learn, --maximise, --minimise, --boundary, --failures or --goal.
    Refine(refine::RefineArguments),
    /// Write the rows of a design to a file without running them
    Design(design::DesignArguments),
    /// Summarise a dataset: best rows, ranges, distributions
    Report(report::ReportArguments),
    /// Rank the factors by their influence on each output
    ///
    /// Prints Sobol' indices or elementary effects with 95 % intervals, depending on the design.
    #[command(alias = "analyze")]
    Analyse(analyse::AnalyseArguments),
    /// List the outputs that differ between two datasets
    ///
    /// Rows with the same factors are compared. Differences within the scatter of an output are not listed.
    Compare(compare::CompareArguments),
    /// Fit models that predict the outputs of a dataset
    Surrogate(surrogate::SurrogateArguments),
    /// Predict results without running them
    ///
    /// Uses models that `decore surrogate --output` wrote. Each prediction has a 95 % interval.
    Predict(surrogate::PredictArguments),
    /// Predict when cores are out, from tests of cores
    ///
    /// Finds the dose at which the tested cores broke, and the time until the cores of each row are out, with intervals.
    Cores(cores::CoresArguments),
    /// Write a flat table to train predictors, with its dictionary
    Export(export::ExportArguments),
    /// Check that all files of a dataset are intact
    Verify(verify::VerifyArguments),
    /// Compare the reduced machine with its full finite element model
    ///
    /// Compares frequencies, mode shapes, static flexibility and mobilities, and measures time and memory.
    Structure(structure::StructureArguments),
    /// Measure speed and error of the solver settings on one row
    Accuracy(accuracy::AccuracyArguments),
    /// Write a Slurm job array for a sweep, and submit it on request
    Slurm(cluster::SlurmArguments),
    /// Write a Python script that runs a sweep on HyperQueue
    Hyperqueue(cluster::HyperQueueArguments),
    /// Combine the shards of a sweep into one dataset
    Merge(merge::MergeArguments),
    /// Print the help of a command or a page of the guide
    Help(help::HelpArguments),
    /// Compare decore with the results of the paper
    Paper(paper::PaperArguments),
    /// Print a completion script for your shell
    Completions(completions::CompletionsArguments),
    /// Write manual pages of the program and of each command
    Man(completions::ManArguments),
}

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    signals::install();
    address_space::bound();
    let result = match parse() {
        // Also for what rayon starts by itself, which bounds nothing.
        Ok(Some(command)) => thread_count(0).map_err(Failure::from).and_then(|_| execute(command)),
        Ok(None) => Ok(Exit::Done),
        Err(failure) => Err(failure),
    };
    match result {
        Ok(exit) => exit.into(),
        Err(failure) => {
            text::eprint_line(&format_args!("error: {failure}"));
            failure.exit().into()
        }
    }
}

/// The command that the command line asks for; `None` where it was for `--help` or `--version`, which are printed here. A
/// command line that is wrong ends the process with [`Exit::BadInput`].
fn parse() -> Result<Option<Command>, Failure> {
    let matches = program().try_get_matches();
    match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => Ok(Some(arguments.command)),
        Err(error) if error.use_stderr() => {
            text::eprint_styled(&error.render().ansi().to_string());
            std::process::exit(error.exit_code())
        }
        Err(help) => text::printed(help.print()).map(|()| None),
    }
}

fn execute(command: Command) -> Result<Exit, Failure> {
    match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::Design(arguments) => design::design(&arguments),
        Command::Structure(arguments) => structure::structure(&arguments),
        Command::Scene(arguments) => scene::scene(&arguments),
        Command::Accuracy(arguments) => accuracy::accuracy(&arguments),
        Command::Status(arguments) => status::status(&arguments),
        Command::Verify(arguments) => verify::verify(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Analyse(arguments) => analyse::analyse(&arguments),
        Command::Surrogate(arguments) => surrogate::surrogate(&arguments),
        Command::Predict(arguments) => surrogate::predict(&arguments),
        Command::Refine(arguments) => refine::refine(&arguments),
        Command::Best(arguments) => best::best(&arguments),
        Command::Cores(arguments) => cores::cores(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Merge(arguments) => merge::merge(&arguments),
        Command::Paper(arguments) => paper::paper(&arguments),
        Command::Slurm(arguments) => cluster::slurm(&arguments),
        Command::Hyperqueue(arguments) => cluster::hyperqueue(&arguments),
        Command::Init(arguments) => init::init(&arguments),
        Command::Completions(arguments) => completions::completions(program(), &arguments),
        Command::Man(arguments) => completions::man(program(), &arguments),
        Command::Help(arguments) => help::help(program(), &arguments),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::Arguments;

    /// Commands that print no result for programs, and why.
    const WITHOUT_JSON: [(&str, &str); 2] =
        [("help", "prints pages, which people read"), ("completions", "prints a script, which a shell reads")];

    #[test]
    fn every_command_that_prints_a_result_prints_it_as_json() {
        let program = Arguments::command();
        let with = |command: &clap::Command| command.get_arguments().any(|one| one.get_long() == Some("json"));
        let without: Vec<&str> = program.get_subcommands().filter(|one| !with(one)).map(|one| one.get_name()).collect();
        assert_eq!(without, WITHOUT_JSON.map(|(name, _)| name));
    }
}
