//! `decore help`: the commands, one command, or a page of the guide.

use clap::{Args, Command};

use super::exit::{Exit, Failure};
use super::markdown::render;
use super::pager::show;
use super::study_keys::study_keys;
use super::text::{fit, print_line, terminal_columns};
use crate::guide::TOPICS;
use decore_dataset::{
    ColumnDescription, ColumnGroup, Columns, DatasetInfo, FactorColumn, PartColumn, SignalColumn, TableName,
};
use decore_quantity::Kind;
use decore_quantity::units::{NO_UNIT, accepted, endings};
use decore_quantity::words::{did_you_mean, nearest};
use decore_study::{hammer_schema, study_schema};

/// Columns of generated lists in a file or a pipe.
const GUIDE_COLUMNS: usize = 80;
/// Columns up to which a page follows its terminal: longer lines are hard to read.
const MOST_COLUMNS: usize = 110;

#[derive(Debug, Args)]
pub(super) struct HelpArguments {
    /// A command or a page of the guide
    topic: Option<String>,
}

pub(super) fn help(mut program: Command, arguments: &HelpArguments) -> Result<Exit, Failure> {
    let Some(name) = arguments.topic.as_deref() else {
        show(&program.render_long_help().ansi().to_string())?;
        return Ok(Exit::Done);
    };
    if let Some(topic) = TOPICS.iter().find(|topic| topic.name == name) {
        let list = match name {
            "outputs" => columns()?,
            "theory" => hammer_parameters(),
            "study" => study_keys(),
            _ => String::new(),
        };
        let page = filled(topic.text);
        match terminal_columns() {
            Some(columns) => show(&render(&format!("{page}\n\n{list}"), columns.min(MOST_COLUMNS)))?,
            None => {
                // Programs read a line per column.
                let list = if name == "outputs" { list } else { fit(&list, GUIDE_COLUMNS) };
                print_line(&format!("{}\n\n{}", page.trim_end(), list.trim_end()).trim_end())?;
            }
        }
        return Ok(Exit::Done);
    }
    // Usage lines name the command by its whole path only once the program is built.
    program.build();
    let commands: Vec<String> = program.get_subcommands().map(|one| one.get_name().to_owned()).collect();
    if let Some(command) = program.find_subcommand_mut(name) {
        show(&command.render_long_help().ansi().to_string())?;
        return Ok(Exit::Done);
    }
    let topics: Vec<&str> = TOPICS.iter().map(|topic| topic.name).collect();
    let known = topics.iter().copied().chain(commands.iter().map(String::as_str));
    let hint = did_you_mean(nearest(name, known));
    Err(Failure::Argument(format!(
        "help {name}: no such topic{hint}\n  pages of the guide: {}\n  commands: {}",
        topics.join(", "),
        commands.join(", "),
    )))
}

/// A page, with the entries of a closed set in the place of a line `{Set}`: a row of a table for each, as it is declared.
fn filled(page: &str) -> String {
    let schema = study_schema();
    let set = |line: &str| {
        let name = line.strip_prefix('{')?.strip_suffix('}')?;
        if name == "Units" {
            return Some(units());
        }
        let entries = schema["$defs"][name]["oneOf"].as_array()?;
        let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().replace('\n', " ");
        let row =
            |entry: &serde_json::Value| format!("| `{}` | {} |", text(&entry["const"]), text(&entry["description"]));
        Some(entries.iter().map(row).collect::<Vec<_>>().join("\n"))
    };
    page.lines().map(|line| set(line).unwrap_or_else(|| line.to_owned())).collect::<Vec<_>>().join("\n")
}

/// Rows of the table of units: a key's unit, the ending of its name, the units that are converted.
fn units() -> String {
    let row = |(ending, unit): (&str, &'static str)| {
        let others = accepted(unit).skip(1).collect::<Vec<_>>().join(", ");
        let others = if others.is_empty() { "none" } else { &others };
        format!("| {unit} | `{ending}` | {others} |")
    };
    let none = accepted(NO_UNIT).skip(1).collect::<Vec<_>>().join(", ");
    endings().map(row).chain([format!("| {NO_UNIT} | no unit | {none} |")]).collect::<Vec<_>>().join("\n")
}

/// All parameters of a hammer, group by group: key, text with symbol, range, default and source.
fn hammer_parameters() -> String {
    let schema = hammer_schema();
    let entries = |table: &serde_json::Value| table["properties"].as_object().cloned().unwrap_or_default();
    let mut text = "# Parameters of a hammer\n".to_owned();
    for (group, entry) in entries(&schema) {
        let about = |entry: &serde_json::Value| entry["description"].as_str().unwrap_or_default().replace('\n', " ");
        text.push_str(&format!("\n{}\n\n", about(&entry)));
        let definition = entry["$ref"].as_str().and_then(|path| schema.pointer(path.trim_start_matches('#')));
        for (key, parameter) in definition.map(entries).unwrap_or_default() {
            text.push_str(&format!("- `{group}.{key}`: {}\n", about(&parameter)));
        }
    }
    text
}

/// All columns of all tables with their units and descriptions, as the writer puts them together for a study with one of each part.
///
/// # Errors
/// Two columns of one name, which these names do not give.
fn columns() -> Result<String, Failure> {
    let named = |name: &str| vec![name.to_owned()];
    let factor = FactorColumn {
        name: "NAME".to_owned(),
        kind: Kind::Real,
        unit: "the factor's".to_owned(),
        description: "the paths of the study that it drives.".to_owned(),
    };
    let signal = SignalColumn {
        name: "SIGNAL".to_owned(),
        unit: "the signal's".to_owned(),
        description: "One for each of `[outputs] signals`: what it is, and over what it is averaged.".to_owned(),
    };
    let columns = Columns::new(&DatasetInfo {
        factors: vec![factor],
        hammers: named("HAMMER"),
        castings: named("CASTING"),
        elastic_castings: named("CASTING"),
        cores: vec![PartColumn { casting: "CASTING".to_owned(), name: "NAME".to_owned() }],
        pads: vec![PartColumn { casting: "CASTING".to_owned(), name: "NAME".to_owned() }],
        fixture_energies: vec![PartColumn { casting: "CASTING".to_owned(), name: "NAME".to_owned() }],
        core_spectra: true,
        twins: 1,
        numerical_twins: true,
        signals: vec![signal],
        ..DatasetInfo::empty()
    })?;
    let section = |group: &[ColumnDescription]| format!("{}\n\n{}\n", title(group[0].group), list(group));
    let tables = columns.tables().map(|table| {
        let columns = columns.describe(table);
        let text: String = match table {
            TableName::Runs => columns.chunk_by(|one, next| one.group == next.group).map(section).collect(),
            TableName::Blows | TableName::Timings | TableName::Signals => format!("{}\n", list(&columns)),
        };
        format!("# Columns of `{}`\n\n{text}", table.folder())
    });
    Ok(tables.collect())
}

/// Heading of a group of columns of `runs`.
fn title(group: ColumnGroup) -> &'static str {
    match group {
        ColumnGroup::Row => "## The row",
        ColumnGroup::Factor => "## Factors",
        ColumnGroup::Aggregate => "## Outputs over all hammers and castings",
        ColumnGroup::Hammer => "## Outputs per hammer (HAMMER_..., as left_...)",
        ColumnGroup::Casting => "## Outputs per casting (CASTING_..., as part_...)",
        ColumnGroup::Fixture => "## Outputs per fixture (CASTING_fixture_NAME_..., as part_fixture_left_...)",
        ColumnGroup::Core => "## Outputs per core point (CASTING_core_NAME_..., as part_core_left_...)",
        ColumnGroup::Run => "## Outputs per run",
        ColumnGroup::Solver => "## The solver's work",
        ColumnGroup::Blow | ColumnGroup::Signal | ColumnGroup::Other => "## Further columns",
    }
}

/// A line for each column: of hammers and castings without what is before their quantities.
fn list(columns: &[ColumnDescription]) -> String {
    let line = |column: &ColumnDescription| {
        let unit = match column.unit.as_str() {
            "" | "1" => String::new(),
            unit => format!(" ({unit})"),
        };
        let (name, text) = match column.group {
            ColumnGroup::Hammer | ColumnGroup::Casting | ColumnGroup::Fixture | ColumnGroup::Core => (
                &column.quantity,
                column.description.split_once("`: ").map_or(column.description.as_str(), |(_, text)| text),
            ),
            _ => (&column.name, column.description.as_str()),
        };
        format!("- `{name}`{unit}: {text}\n")
    };
    // A spectrum has a column for each of its frequencies.
    columns
        .chunk_by(|one, next| one.group == ColumnGroup::Core && one.quantity == next.quantity)
        .map(|of| line(&of[0]))
        .collect()
}
