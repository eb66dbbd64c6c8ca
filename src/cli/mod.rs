//! The command line: one file per command.

mod accuracy;
mod address_space;
mod analyse;
mod best;
// Only the Python package calls commands.
#[cfg_attr(not(feature = "python"), allow(dead_code))]
pub(crate) mod caller;
mod check;
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
mod measured;
mod merge;
mod mobility;
mod more_rows;
mod outputs;
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
mod surrogate;
mod text;
mod verify;
mod written;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

pub use exit::Exit;
pub(crate) use exit::Failure;
pub use schemas::output_schemas;

use decore_model::run::thread_count;

/// What the exit codes mean, as `--help` shows it.
const EXIT_CODES: &str = "Exit codes:
  0  all rows are done
  2  the command line, the study or the machine is wrong; nothing was run or written
  3  results or what was to be printed could not be written; what is on disk is whole
  4  finished, but some rows are not done (audit failed, invalid, diverged, budget exhausted); the table
     says why; check: no row can run; analyse: intervals are not as narrow as --grow-until asks
  5  interrupted; the rows that had started are finished and written: the same command goes on
  6  more rows failed than --max-failed allows; what is done is written
  7  another decore writes to the dataset, or changed it while it was read
  8  files of the dataset are damaged, missing or foreign; verify: rows still to come are missing too
  9  compare: the datasets differ";

/// Coupled simulation of pneumatic de-coring hammers, castings and a reduced machine structure.
#[derive(Debug, Parser)]
#[command(name = "decore", version, about, disable_help_subcommand = true)]
#[command(after_help = format!("{}\n{EXIT_CODES}", help::topics()))]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run all rows of a study and write its tables.
    Run(run::RunArguments),
    /// Validate a study; print its size, the machine's modes, and the time it will take.
    Check(check::CheckArguments),
    /// Write the rows of a study's design to a file, without running them.
    Design(design::DesignArguments),
    /// Compare a machine's reduction with its full model: frequencies, shapes, statics, mobilities, time and memory.
    Structure(structure::StructureArguments),
    /// Simulate one row of a study and print all its outputs.
    Scene(scene::SceneArguments),
    /// Measure speed against error on one row of a study.
    Accuracy(accuracy::AccuracyArguments),
    /// Tell how far sweeps are or how they ended.
    Status(status::StatusArguments),
    /// Read all files of datasets and say whether they are whole.
    Verify(verify::VerifyArguments),
    /// Summarise a dataset: best rows, ranges, distributions.
    Report(report::ReportArguments),
    /// Tell which factors matter to a dataset's outputs: Sobol' indices or elementary effects, with intervals.
    Analyse(analyse::AnalyseArguments),
    /// Model a dataset's outputs, so that rows not run can be predicted, with intervals.
    Surrogate(surrogate::SurrogateArguments),
    /// Predict the rows of a table with models that `decore surrogate` wrote.
    Predict(surrogate::PredictArguments),
    /// Run a table of rows, and add those that teach or promise the most, batch by batch.
    Refine(refine::RefineArguments),
    /// Find the best values for the study's goal, and prove them by runs.
    Best(best::BestArguments),
    /// Find the dose at which cores are out from tests, and the time until the cores of each row are out.
    Cores(cores::CoresArguments),
    /// Compare two datasets: rows matched by their factors, outputs beyond their scatter listed.
    Compare(compare::CompareArguments),
    /// Write a dataset as a flat table that predictors are trained on, with its dictionary.
    Export(export::ExportArguments),
    /// Make one dataset of the shards of a sweep.
    Merge(merge::MergeArguments),
    /// Set the publication that the model follows beside what decore gives for its rig: figures, differences, why.
    Paper(paper::PaperArguments),
    /// Write, and on request submit, a Slurm job array for a sweep and the job that merges its shards.
    Slurm(cluster::SlurmArguments),
    /// Write a Python script that runs a sweep and its merge on HyperQueue.
    Hyperqueue(cluster::HyperQueueArguments),
    /// Write a commented study to start from.
    Init(init::InitArguments),
    /// Print a script by which a shell completes the command line.
    Completions(completions::CompletionsArguments),
    /// Write a manual page of the program and of each command.
    Man(completions::ManArguments),
    /// Print the help of a command or a page of the guide.
    Help(help::HelpArguments),
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
            text::eprint_line(&format_args!("decore: {failure}"));
            failure.exit().into()
        }
    }
}

/// The command that the command line asks for; `None` where it was for `--help` or `--version`, which are printed here. A
/// command line that is wrong ends the process with [`Exit::BadInput`].
fn parse() -> Result<Option<Command>, Failure> {
    match Arguments::try_parse() {
        Ok(arguments) => Ok(Some(arguments.command)),
        Err(error) if error.use_stderr() => error.exit(),
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
        Command::Completions(arguments) => completions::completions(Arguments::command(), &arguments),
        Command::Man(arguments) => completions::man(Arguments::command(), &arguments),
        Command::Help(arguments) => help::help(Arguments::command(), &arguments),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::Arguments;

    /// Commands that print no result for programs, and why.
    const WITHOUT_JSON: [(&str, &str); 2] =
        [("completions", "prints a script, which a shell reads"), ("help", "prints pages, which people read")];

    #[test]
    fn every_command_that_prints_a_result_prints_it_as_json() {
        let program = Arguments::command();
        let with = |command: &clap::Command| command.get_arguments().any(|one| one.get_long() == Some("json"));
        let without: Vec<&str> = program.get_subcommands().filter(|one| !with(one)).map(|one| one.get_name()).collect();
        assert_eq!(without, WITHOUT_JSON.map(|(name, _)| name));
    }
}
