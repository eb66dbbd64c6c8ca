//! The help of the program as a whole: commands in groups, pages of the guide, exit codes, and examples of each command.

use clap::{Command, CommandFactory};

use super::Arguments;
use super::text::{hang, help_columns};
use crate::guide::TOPICS;

/// All commands, grouped by purpose, in the order of the help.
pub(super) const GROUPS: [(&str, &[&str]); 6] = [
    ("Start here", &["init", "check", "scene"]),
    ("Run a study", &["run", "status", "best", "refine", "design"]),
    ("Look at results", &["report", "analyse", "compare", "surrogate", "predict", "cores", "export", "verify"]),
    ("Your own machine", &["structure", "accuracy"]),
    ("Clusters", &["slurm", "hyperqueue", "merge"]),
    ("Reference", &["help", "paper", "completions", "man"]),
];

/// Meanings of the exit codes.
const EXIT_CODES: [(&str, &str); 9] = [
    ("0", "All rows are done."),
    ("2", "The command line, the study or the machine is wrong. Nothing was run or written."),
    ("3", "Results could not be written or printed. Files on disk are intact."),
    (
        "4",
        "Finished, but some rows failed (audit failed, invalid, diverged, budget exhausted); the table has the reasons. \
         check: no row can run, or with --strict one cannot. analyse: intervals are wider than --grow-until.",
    ),
    ("5", "Interrupted. Rows that had started are finished and written. Run the same command again to continue."),
    ("6", "Stopped: more rows failed than --max-failed allows. Finished rows are written."),
    ("7", "Another decore process writes to the dataset, or changed it while it was read."),
    ("8", "Files of the dataset are damaged, missing or foreign. verify: some rows have not been run yet."),
    ("9", "compare: the datasets differ."),
];

/// Examples of commands: purpose and command line.
const EXAMPLES: &[(&str, &[(&str, &str)])] = &[
    (
        "init",
        &[
            ("Answer some questions, get a study", "init my_study.toml"),
            ("Without questions", "init my_study.toml --casting-mass-kg 8 --casting-size-m 0.4x0.3 --hammers 2"),
        ],
    ),
    (
        "check",
        &[
            ("Find mistakes, and estimate the time", "check my_study.toml"),
            ("Try another number of rows", "check my_study.toml --set design.rows=500"),
            ("In a script: fail if a row cannot be simulated", "check my_study.toml --strict"),
        ],
    ),
    (
        "scene",
        &[
            ("Print all outputs of row 3", "scene my_study.toml --row 3"),
            ("See the hammer move, in a browser", "scene my_study.toml --row 3 --html row.html"),
            ("Run a stored row again, and compare", "scene out/my_study --row 3"),
        ],
    ),
    (
        "run",
        &[
            ("Run all rows, or continue", "run my_study.toml"),
            ("Start over", "run my_study.toml --replace"),
            ("Give failed rows more steps", "run my_study.toml --only-failed --set solver.max_steps=100000000"),
        ],
    ),
    ("status", &[("From another terminal", "status out/my_study")]),
    ("best", &[("Answer the study's [goal]", "best my_study.toml")]),
    ("refine", &[("Improve a model, up to 200 rows", "refine table.toml --learn delivered_work_j --most-rows 200")]),
    ("design", &[("Look at the rows before you run them", "design my_study.toml --output rows.csv")]),
    (
        "report",
        &[
            ("Best rows, ranges and distributions", "report out/my_study"),
            ("As a page for a browser", "report out/my_study --html report.html"),
        ],
    ),
    ("analyse", &[("Which factors matter?", "analyse out/my_study --output delivered_work_j")]),
    ("compare", &[("Two pressures", "compare out/low out/high")]),
    ("surrogate", &[("Fit and keep the models", "surrogate out/my_study --output model.parquet")]),
    ("predict", &[("Predict the rows of a file", "predict model.parquet rows.csv --output predicted.parquet")]),
    ("cores", &[("When is each core out?", "cores out/my_study --tests tests.csv")]),
    ("export", &[("Training and test data", "export out/my_study --features features --splits \"0.8,0.2\"")]),
    ("verify", &[("After a copy or a crash", "verify out/my_study")]),
    (
        "structure",
        &[
            ("Is the reduction good enough?", "structure my_study.toml"),
            ("Measured frequency responses", "structure my_study.toml --measured frf.uff"),
        ],
    ),
    ("accuracy", &[("Speed and error on your scene", "accuracy my_study.toml --row 3")]),
    ("slurm", &[("20 tasks, 8 h each", "slurm my_study.toml --tasks 20 --sbatch=--time=08:00:00")]),
    ("hyperqueue", &[("20 tasks", "hyperqueue my_study.toml --tasks 20")]),
    ("merge", &[("Two shards", "merge out/shard-1 out/shard-2 --output out/all")]),
    ("help", &[("A page of the guide", "help units"), ("A command", "help run")]),
    ("paper", &[("As a page for a browser", "paper --html paper.html")]),
    ("completions", &[("For bash", "completions bash")]),
    ("man", &[("For man(1)", "man --output man/man1")]),
];

/// The program with its commands in groups and all further texts of the help.
pub(super) fn program() -> Command {
    let columns = help_columns();
    let program = Arguments::command().term_width(columns);
    let list = groups(&program, columns);
    let topics = TOPICS.iter().map(|topic| (topic.name, topic.about));
    let more = format!(
        "{}\n{}",
        section("The guide (decore help TOPIC)", topics, columns),
        section("Exit codes", EXIT_CODES, columns)
    );
    let short = "Print a page of the guide: decore help TOPIC. List all topics: decore --help.";
    let program = program
        .help_template(format!(
            "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}\n{}\n{{options}}{{after-help}}",
            heading("Options")
        ))
        .after_help(short)
        .after_long_help(more.trim_end().to_owned());
    EXAMPLES.iter().fold(program, |program, (command, examples)| {
        let lines = examples.iter().map(|(purpose, line)| format!("  # {purpose}\n  decore {line}\n"));
        let text = format!("{}\n{}", heading("Examples"), lines.collect::<String>().trim_end());
        program.mut_subcommand(command, |command| command.after_long_help(text))
    })
}

/// The commands with a line for each, group by group.
fn groups(program: &Command, columns: usize) -> String {
    let about = |name: &&'static str| {
        let command = program.find_subcommand(name);
        (*name, command.and_then(Command::get_about).map(ToString::to_string).unwrap_or_default())
    };
    let group = |(title, names): &(&str, &[&'static str])| section(title, names.iter().map(about), columns);
    GROUPS.iter().map(group).collect::<Vec<_>>().join("\n")
}

/// A heading, and a line for each name with its text in a column of its own.
fn section<T: AsRef<str>>(title: &str, lines: impl IntoIterator<Item = (&'static str, T)>, columns: usize) -> String {
    let lines: Vec<(&str, T)> = lines.into_iter().collect();
    let widest = lines.iter().map(|(name, _)| name.len()).max().unwrap_or_default();
    let width = if widest > 2 { widest.max(11) } else { widest };
    let line = |(name, text): &(&str, T)| hang(&format!("  {name:width$}  "), text.as_ref(), columns);
    format!("{}\n{}", heading(title), lines.iter().map(line).collect::<String>())
}

/// A heading in the style of clap's own.
fn heading(title: &str) -> String {
    let style = clap::builder::Styles::styled().get_header().to_owned();
    format!("{style}{title}:{style:#}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_is_in_one_group_in_the_order_of_its_declaration() {
        let program = program();
        let grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let declared: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
        assert_eq!(grouped, declared);
    }

    #[test]
    fn every_command_has_examples_that_are_understood() {
        let named: Vec<&str> = EXAMPLES.iter().map(|(name, _)| *name).collect();
        assert_eq!(named, GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect::<Vec<_>>());
        for (name, examples) in EXAMPLES {
            for (_, line) in *examples {
                assert_eq!(line.split(' ').next(), Some(*name));
                let words = line.split(' ').map(|word| word.trim_matches('"'));
                let words = std::iter::once("decore").chain(words);
                let read = program().try_get_matches_from(words);
                assert!(read.is_ok(), "{line}: {}", read.unwrap_err());
            }
        }
    }

    /// Lines of the help at a width: none longer, and no short help longer than a screen.
    #[test]
    fn helps_fit() {
        for columns in [60, 80, 120] {
            let list = groups(&program(), columns);
            assert!(list.lines().all(|line| console::measure_text_width(line) <= columns), "{list}");
        }
        let mut program = program().term_width(80);
        program.build();
        let lines = program.render_help().to_string().lines().count();
        assert!(lines <= 50, "{lines}");
        for command in program.get_subcommands_mut() {
            let long: Vec<String> = command
                .render_long_help()
                .to_string()
                .lines()
                .filter(|line| line.chars().count() > 80 && !line.starts_with("  decore "))
                .map(str::to_owned)
                .collect();
            assert!(long.is_empty(), "{}: {long:#?}", command.get_name());
        }
    }
}
