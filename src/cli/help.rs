//! `decore help`: the commands, one command, or a page of the guide.

use std::fmt::Write as _;

use clap::{Args, Command};

use super::exit::{Exit, Failure};
use super::text::say;
use crate::guide::TOPICS;
use crate::metrics::{CastingMetrics, HammerMetrics, RunTotals};
use crate::quantity::Quantity;
use crate::study::study_schema;
use crate::words::{did_you_mean, nearest};

#[derive(Debug, Args)]
pub(super) struct HelpArguments {
    /// A command, or a page of the guide.
    topic: Option<String>,
}

/// The pages of the guide, as the help of the whole program lists them.
pub(super) fn topics() -> String {
    let lines = TOPICS.iter().map(|topic| format!("  {:<10}  {}\n", topic.name, topic.about));
    format!("The guide (decore help TOPIC):\n{}", lines.collect::<String>())
}

pub(super) fn help(mut program: Command, arguments: &HelpArguments) -> Result<Exit, Failure> {
    let Some(name) = arguments.topic.as_deref() else {
        say(&program.render_long_help().to_string().trim_end())?;
        return Ok(Exit::Done);
    };
    if let Some(topic) = TOPICS.iter().find(|topic| topic.name == name) {
        say(&filled(topic.text).trim_end())?;
        if name == "outputs" {
            say(&format_args!("\n{}", columns().trim_end()))?;
        }
        return Ok(Exit::Done);
    }
    // Usage lines name the command by its whole path only once the program is built.
    program.build();
    let commands: Vec<String> = program.get_subcommands().map(|one| one.get_name().to_owned()).collect();
    if let Some(command) = program.find_subcommand_mut(name) {
        say(&command.render_long_help().to_string().trim_end())?;
        return Ok(Exit::Done);
    }
    let topics: Vec<&str> = TOPICS.iter().map(|topic| topic.name).collect();
    let known = topics.iter().copied().chain(commands.iter().map(String::as_str));
    let hint = did_you_mean(nearest(name, known));
    Err(Failure::Argument(format!(
        "help {name}: expected a page of the guide ({}) or a command ({}){hint}",
        topics.join(", "),
        commands.join(", ")
    )))
}

/// A page, with the entries of a closed set in the place of a line `{Set}`: a row of a table for each, as it is declared.
fn filled(page: &str) -> String {
    let schema = study_schema();
    let set = |line: &str| {
        let name = line.strip_prefix('{')?.strip_suffix('}')?;
        let entries = schema["$defs"][name]["oneOf"].as_array()?;
        let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().replace('\n', " ");
        let row =
            |entry: &serde_json::Value| format!("| `{}` | {} |", text(&entry["const"]), text(&entry["description"]));
        Some(entries.iter().map(row).collect::<Vec<_>>().join("\n"))
    };
    page.lines().map(|line| set(line).unwrap_or_else(|| line.to_owned())).collect::<Vec<_>>().join("\n")
}

/// All outputs with their units and descriptions, from where they are declared.
fn columns() -> String {
    let mut text = String::new();
    list(&mut text, "per hammer (left_..., right_...)", HammerMetrics::QUANTITIES);
    list(&mut text, "per casting (part_...)", CastingMetrics::QUANTITIES);
    list(&mut text, "per run", RunTotals::QUANTITIES);
    text
}

fn list<T>(text: &mut String, title: &str, quantities: &[Quantity<T>]) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "## Outputs {title}\n");
    for quantity in quantities {
        let unit = match quantity.unit {
            "" | "1" => String::new(),
            unit => format!(" ({unit})"),
        };
        let _ = writeln!(text, "- `{}`{unit}: {}", quantity.name, quantity.description());
    }
    let _ = writeln!(text);
}
