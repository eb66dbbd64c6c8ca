//! `decore init`: a commented study to start from, for the user's casting, hammers, pressure and limit.

use std::fs::OpenOptions;
use std::io::{ErrorKind, IsTerminal, Write, stdin, stdout};
use std::path::PathBuf;

use clap::Args;

use super::exit::{Exit, Failure};
use super::outputs::{Form, Output, check_outputs, exists};
use super::text::{print_line, shell_word};
use super::written::Written;
use decore_study::template;

/// Hammers over one casting at most: their strike points must fit on it.
const MOST_HAMMERS: usize = 4;
/// Share of the usable extent that strike points of several hammers are spread over.
const SPREAD: f64 = 0.5;
/// Least distance of two hammers, m: their telescopes must not touch.
const LEAST_DISTANCE_M: f64 = 0.06;
/// Least distance that the hammers can move both ways, m.
const LEAST_REACH_M: f64 = 0.005;
/// Share of half the casting's extent along the rail that strike points may reach.
const REACH: f64 = 0.8;
/// Half the length of the built-in station's rail that a study uses, m.
const RAIL_M: f64 = 0.3;
/// Height of the box that gives the casting's moments of inertia, over its shorter side.
const HEIGHT: f64 = 0.6;

#[derive(Debug, Args)]
pub(super) struct InitArguments {
    /// File to write; `-` prints the study
    #[arg(default_value = "study.toml")]
    file: PathBuf,
    /// Mass of the casting in kg (default: 3)
    ///
    /// In a terminal, `decore init` asks for this and the following values. Give one of them on the command line to skip the questions.
    #[arg(long, value_name = "KG", value_parser = positive)]
    casting_mass_kg: Option<f64>,
    /// Size of the casting in x and y, in m, for example `0.3x0.2`
    ///
    /// The hammers' rail of the built-in machine runs along y.
    #[arg(long, value_name = "XxY", value_parser = size)]
    casting_size_m: Option<[f64; 2]>,
    /// Number of hammers, 1 to 4 (default: 1)
    #[arg(long, value_name = "N", value_parser = hammers)]
    hammers: Option<usize>,
    /// Supply pressure in bar above ambient (default: 5); the study varies it by 1 bar
    #[arg(long, value_name = "BAR", value_parser = positive)]
    pressure_bar: Option<f64>,
    /// Largest velocity of the casting's points in m/s (default: 4.5)
    #[arg(long, value_name = "M/S", value_parser = positive)]
    limit_m_s: Option<f64>,
    /// Replace an existing file
    #[arg(long)]
    replace: bool,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

/// Purpose of the study.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Case {
    mass_kg: f64,
    size_m: [f64; 2],
    hammers: usize,
    pressure_bar: f64,
    limit_m_s: f64,
}

impl Default for Case {
    /// Values of the template.
    fn default() -> Self {
        Self { mass_kg: 3.0, size_m: [0.30, 0.20], hammers: 1, pressure_bar: 5.0, limit_m_s: 4.5 }
    }
}

/// Reads a positive number.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a positive number with a point, for example 4.5".to_owned())
}

/// Reads the extent in x and y.
fn size(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split([',', 'x']).map(|part| positive(part).ok()).collect();
    let sides = numbers.and_then(|numbers| <[f64; 2]>::try_from(numbers).ok());
    sides
        .filter(|sides| sides.iter().all(|side| *side <= 10.0))
        .ok_or_else(|| "expected the size in x and y in m, for example 0.3x0.2".to_owned())
}

/// Reads a number of hammers.
fn hammers(text: &str) -> Result<usize, String> {
    let count = text.trim().parse::<usize>().ok().filter(|count| (1..=MOST_HAMMERS).contains(count));
    count.ok_or_else(|| format!("expected a whole number from 1 to {MOST_HAMMERS}"))
}

impl InitArguments {
    /// The case by the options, or by questions if there is a terminal and no option was given; `None`: the template as it is.
    fn case(&self) -> Result<Option<Case>, Failure> {
        let base = Case::default();
        let given = [self.casting_mass_kg, self.pressure_bar, self.limit_m_s].iter().any(Option::is_some)
            || self.casting_size_m.is_some()
            || self.hammers.is_some();
        if given {
            return Ok(Some(Case {
                mass_kg: self.casting_mass_kg.unwrap_or(base.mass_kg),
                size_m: self.casting_size_m.unwrap_or(base.size_m),
                hammers: self.hammers.unwrap_or(base.hammers),
                pressure_bar: self.pressure_bar.unwrap_or(base.pressure_bar),
                limit_m_s: self.limit_m_s.unwrap_or(base.limit_m_s),
            }));
        }
        let asks = stdin().is_terminal() && stdout().is_terminal() && self.file.as_os_str() != "-" && !self.json;
        if !asks {
            return Ok(None);
        }
        print_line(&"Press Enter to keep the value in brackets.")?;
        let [x, y] = base.size_m;
        Ok(Some(Case {
            mass_kg: ask("Mass of the casting, kg", base.mass_kg, positive)?,
            size_m: ask_as("Size in x and y (y along the rail), m", &format!("{x}x{y}"), size)?,
            hammers: ask("Number of hammers", base.hammers, hammers)?,
            pressure_bar: ask("Supply pressure, bar above ambient", base.pressure_bar, positive)?,
            limit_m_s: ask("Largest velocity of the casting's points, m/s", base.limit_m_s, positive)?,
        }))
    }
}

/// Asks until the answer can be read; an empty one keeps the default.
fn ask<T: std::fmt::Display>(question: &str, default: T, read: fn(&str) -> Result<T, String>) -> Result<T, Failure> {
    ask_as(question, &default.to_string(), read)
}

fn ask_as<T>(question: &str, default: &str, read: fn(&str) -> Result<T, String>) -> Result<T, Failure> {
    loop {
        let prompt = write!(stdout(), "{question} [{default}]: ").and_then(|()| stdout().flush());
        prompt.map_err(Failure::Print)?;
        let mut answer = String::new();
        let ended = stdin().read_line(&mut answer).map_or(true, |bytes| bytes == 0);
        let answer = answer.trim();
        match read(if answer.is_empty() { default } else { answer }) {
            Ok(value) => return Ok(value),
            Err(_) if ended => return Err(Failure::Argument("the input ended before the last question".to_owned())),
            Err(expected) => print_line(&expected)?,
        }
    }
}

/// The template with the values of a case.
///
/// # Errors
/// A line that the template does not have.
fn fill(template: &str, case: &Case) -> Result<String, Failure> {
    let [x, y] = case.size_m;
    let height = HEIGHT * x.min(y);
    // About x and y.
    let inertia = [y, x].map(|side| rounded(case.mass_kg * (side * side + height * height) / 12.0));
    // Strike points of the hammers before and behind the middle, and how far all can move together.
    let last = case.hammers.saturating_sub(1) as f64;
    let extent = 2.0 * (REACH * 0.5 * y).min(RAIL_M);
    let least = last * LEAST_DISTANCE_M;
    if least + 2.0 * LEAST_REACH_M > extent {
        return Err(Failure::Argument(format!(
            "{} hammers do not fit on a casting of {y} m along the rail: they need {} m; give fewer hammers or another size",
            case.hammers,
            rounded((least + 2.0 * LEAST_REACH_M) / REACH)
        )));
    }
    let spread = if case.hammers > 1 { (SPREAD * extent).max(least) } else { 0.0 };
    let places: Vec<f64> =
        (0..case.hammers).map(|index| if last > 0.0 { spread * (index as f64 / last - 0.5) } else { 0.0 }).collect();
    let reach = rounded_down(0.5 * (extent - spread));
    let first = places.first().copied().unwrap_or_default();
    let link = |key: &str, offset: fn(f64, f64) -> f64| {
        let entry = |(index, place): (usize, &f64)| {
            let offset = rounded(offset(*place, first));
            let offset = if offset == 0.0 { String::new() } else { format!(", offset = {offset}") };
            format!("{{ path = \"hammer.hammer_{}.{key}\"{offset} }}", index + 1)
        };
        let entries: Vec<String> = places.iter().enumerate().skip(1).map(entry).collect();
        if entries.is_empty() { String::new() } else { format!("link = [{}]\n", entries.join(", ")) }
    };
    let more: String = (2..=case.hammers)
        .zip(places.iter().skip(1))
        .map(|(number, place)| {
            format!("[hammer.hammer_{number}]\nrail = \"rail\"\nrail_position_m = {}\n\n", rounded(*place))
        })
        .collect();
    let (low, high) = ((case.pressure_bar - 1.0).max(0.5 * case.pressure_bar), case.pressure_bar + 1.0);
    let name = if case.hammers > 1 { "hammer_1" } else { "left" };
    let ends = [rounded(first - reach), rounded(first + reach)];
    let edits = [
        ("mass_kg = 3.0", format!("mass_kg = {:?}", case.mass_kg)),
        ("size_m = [0.30, 0.20]", format!("size_m = [{x:?}, {y:?}]")),
        ("inertia_kg_m2 = [0.0135, 0.026]", format!("inertia_kg_m2 = {inertia:?}")),
        ("rail_position_m = 0.0 ", format!("rail_position_m = {:?} ", rounded(first))),
        ("# supply_bar = 5.0", format!("supply_bar = {:?}", case.pressure_bar)),
        ("max_casting_point_velocity_m_s <= 4.5", format!("max_casting_point_velocity_m_s <= {:?}", case.limit_m_s)),
        (
            "range = [-0.08, 0.08]\n",
            format!("range = {ends:?}\n{}", link("rail_position_m", |place, first| place - first)),
        ),
        ("range = [4.0, 6.0]\n", format!("range = [{low:?}, {high:?}]\n{}", link("supply_bar", |_, _| 0.0))),
        ("[casting.part]\n", format!("{more}[casting.part]\n")),
    ];
    let mut text = template.to_owned();
    for (old, new) in edits {
        if !text.contains(old) {
            return Err(Failure::Argument(format!(
                "the template has no line `{old}` (a defect of decore: please report it)"
            )));
        }
        text = text.replacen(old, &new, 1);
    }
    // The hammer is named in its sections, in comments and in paths.
    let renamed = ["hammer.left", "\"left_", "(left)"]
        .iter()
        .fold(text, |text, old| text.replace(old, &old.replace("left", name)));
    Ok(renamed)
}

/// A number to four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// A length to a mm, not above it.
fn rounded_down(value: f64) -> f64 {
    (value * 1e3 + 1e-9).floor() / 1e3
}

pub(super) fn init(arguments: &InitArguments) -> Result<Exit, Failure> {
    let text = template().map_err(|error| Failure::Argument(error.to_string()))?;
    let is_file = arguments.file.as_os_str() != "-";
    if is_file {
        // Before the questions, not after.
        check_outputs(
            &[],
            &[Output {
                flag: "FILE",
                path: Some(&arguments.file),
                form: Form::File { endings: &[], replace: arguments.replace },
            }],
        )?;
    }
    let text = arguments.case()?.map_or(Ok(text.clone()), |case| fill(&text, &case))?;
    if !is_file {
        if arguments.json {
            let message = "--json lists a file that was written, and `-` prints the study itself: give a file name";
            return Err(Failure::Argument(message.to_owned()));
        }
        print_line(&text.trim_end())?;
        return Ok(Exit::Done);
    }
    write(arguments, &text)
}

fn write(arguments: &InitArguments, text: &str) -> Result<Exit, Failure> {
    let path = arguments.file.display().to_string();
    let mut options = OpenOptions::new();
    options.write(true);
    if arguments.replace {
        options.create(true).truncate(true)
    } else {
        options.create_new(true)
    };
    let written = options.open(&arguments.file).and_then(|mut file| {
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
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(exists("FILE", &arguments.file)),
        Err(source) => Err(Failure::Write { path, source }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_study::Study;
    use decore_study::engine::checked;
    use std::path::Path;

    #[test]
    fn studies_of_any_case_can_be_read() {
        let template = template().expect("a template");
        for hammers in 1..=MOST_HAMMERS {
            for size_m in [[0.1, 0.05], [0.3, 0.2], [2.0, 1.0]] {
                let case = Case { mass_kg: 12.5, size_m, hammers, pressure_bar: 6.2, limit_m_s: 3.0 };
                let needed = (hammers - 1) as f64 * LEAST_DISTANCE_M + 2.0 * LEAST_REACH_M;
                let filled = fill(&template, &case);
                if needed > REACH * size_m[1] {
                    assert!(
                        filled.is_err_and(|error| error.to_string().contains("do not fit")),
                        "{hammers} on {size_m:?}"
                    );
                    continue;
                }
                let text = filled.unwrap_or_else(|error| panic!("{error}"));
                let study = Study::parse(&text, Path::new(""), "study.toml").unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(study.hammer_names().len(), hammers);
                let checked = checked(study.clone()).unwrap_or_else(|error| panic!("{error}"));
                for row in 0..checked.row_count() {
                    assert!(checked.scene(row).is_ok(), "{hammers} on {size_m:?}: {:?}", checked.scene(row).err());
                }
                let driven: Vec<String> = study.factors().iter().flat_map(|factor| factor.paths()).collect();
                assert_eq!(driven.len(), 2 * hammers, "{driven:?}");
            }
        }
    }

    #[test]
    fn answers_are_read() {
        assert_eq!(size("0.3, 0.2"), Ok([0.3, 0.2]));
        assert_eq!(size("0.3x0.2"), Ok([0.3, 0.2]));
        assert!(size("0.3").is_err() && size("300,-2").is_err() && positive("4,5").is_err() && hammers("9").is_err());
    }
}
