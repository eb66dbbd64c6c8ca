//! What the README and the guide say is what the program does: their commands run, their figures are the program's.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use decore_dataset::{ColumnDescription, ColumnGroup, DatasetReader, TableName};
use serde_json::Value;
use tempfile::TempDir;

/// Rows of the README's table of the paper's rig, and the outputs that they show.
const RIG: [(&str, &str, &str); 10] = [
    ("first-impact energy (J)", "hammers", "first_impact_energy_j"),
    ("first impact at (s)", "hammers", "first_impact_time_s"),
    ("chisel velocity (m/s)", "hammers", "first_impact_chisel_velocity_m_s"),
    ("work of the first impact (J)", "hammers", "first_impact_work_j"),
    ("casting peak velocity (m/s)", "castings", "peak_velocity_m_s"),
    ("periodic energy (J)", "hammers", "periodic_energy_mean_j"),
    ("hit frequency (Hz)", "hammers", "hit_frequency_hz"),
    ("arm velocity, extension (m/s RMS)", "hammers", "arm_rms_extension_m_s"),
    ("arm velocity, hammering (m/s RMS)", "hammers", "arm_rms_hammering_m_s"),
    ("delivered work (J)", "hammers", "delivered_work_j"),
];
/// Added to commands of the README that would take too long as they stand.
const SHORTER: [(&str, &[&str]); 2] = [
    ("accuracy", &["--quick", "--set", "duration_s=0.06"]),
    ("best", &["--rows", "16", "--checks", "10", "--batch", "4", "--set", "goal.limits=[]"]),
];

fn readme() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("README.md")
}

/// Lines of a text that are commands of decore, without comments, as arguments.
fn commands(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("    decore "));
    let bare = lines.map(|line| line.split('#').next().unwrap_or_default());
    // A shell takes the quotes away; none of them holds a blank.
    bare.map(|line| line.split_whitespace().map(|word| word.trim_matches('"').to_owned()).collect()).collect()
}

fn decore(scratch: &TempDir) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    command.current_dir(scratch.path());
    command
}

#[test]
fn the_readme_s_commands_run_in_their_order() {
    let scratch = TempDir::new().expect("scratch");
    let commands = commands(&readme());
    assert!(commands.len() >= 8, "{commands:?}");
    for arguments in commands {
        let shorter = SHORTER.iter().find(|(command, _)| arguments.first().is_some_and(|first| first == command));
        let more = shorter.map_or(&[][..], |(_, more)| more);
        let output = decore(&scratch).args(&arguments).args(more).output().expect("started");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

/// The tables of kinds, formats and laws have a row for each that the schema declares, and no line stands for something unknown.
#[test]
fn the_guide_lists_what_a_study_can_name() {
    let scratch = TempDir::new().expect("scratch");
    let schema = decore_study::study_schema();
    for (page, set) in [
        ("clamps", "PadMaterial"),
        ("designs", "DesignKind"),
        ("machine", "MatrixFormat"),
        ("limits", "ContactLawName"),
    ] {
        let output = decore(&scratch).args(["help", page]).output().expect("started");
        let text = String::from_utf8(output.stdout).expect("text");
        let names: Vec<&str> = schema["$defs"][set]["oneOf"]
            .as_array()
            .expect("entries")
            .iter()
            .filter_map(|entry| entry["const"].as_str())
            .collect();
        assert!(names.len() >= 4, "{set}: {names:?}");
        for name in names {
            let is_row = |line: &str| line.starts_with(&format!("| `{name}` | ")) && line.len() > name.len() + 12;
            assert!(text.lines().any(is_row), "{page}: {name}");
        }
        assert!(!text.lines().any(|line| line.starts_with('{')), "{page}");
    }
}

/// The page on theory lists every parameter of a hammer, both pages fit into 80 columns, and every name in them is one of a column, a
/// key or a value.
#[test]
fn theory_and_glossary_name_what_there_is() {
    let scratch = TempDir::new().expect("scratch");
    let help = |page: &str| {
        let output = decore(&scratch).args(["help", page]).output().expect("started");
        String::from_utf8(output.stdout).expect("text")
    };
    let (theory, glossary) = (help("theory"), help("glossary"));
    let hammer = decore_study::hammer_schema();
    for (group, entry) in hammer["properties"].as_object().expect("groups") {
        let definition = entry["$ref"].as_str().expect("a reference").trim_start_matches('#');
        let parameters = hammer.pointer(definition).expect("a group")["properties"].as_object().expect("parameters");
        for key in parameters.keys() {
            assert!(theory.contains(&format!("\n- `{group}.{key}`: ")), "{group}.{key}");
        }
    }
    let known = format!("{}{}{hammer}", help("outputs"), decore_study::study_schema());
    for text in [&theory, &glossary] {
        let long: Vec<&str> = text.lines().filter(|line| line.chars().count() > 80).collect();
        assert!(long.is_empty(), "{long:#?}");
        // Shorter words are symbols.
        let words = text.split(|c: char| !(c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'));
        let names = words.filter(|word| word.len() >= 10 && word.contains('_'));
        let unknown: BTreeSet<&str> = names.filter(|name| !known.contains(name)).collect();
        assert!(unknown.is_empty(), "{unknown:#?}");
    }
}

/// Every column of the tables of a study that uses all there is stands in the guide with its unit and description, and no other does.
#[test]
fn the_guide_lists_every_column() {
    let scratch = TempDir::new().expect("scratch");
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let text = fs::read_to_string(studies.join("three_hammers.toml")).expect("a study");
    let more = "[casting.a.core.middle]\nat_m = [0.0, 0.0, 0.0]\n[outputs]\ncore_spectra = true\nfixture_energy = true\ntwins = 1\nsignals = [\"a_heave_velocity_m_s\"]\n[design]\nkind = \"random\"\nrows = 1\n\
        [design.factor.pressure]\npath = \"hammer.one.supply_bar\"\nrange = [4.0, 6.0]\nunit = \"bar\"\n";
    let elastic = "[casting.e]\nmass_kg = 1.0368\ninertia_kg_m2 = [4.49280e-4, 2.350080e-3]\n[casting.e.structure]\n\
        stiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\nnodes_file = \"nodes.csv\"\n\
        point_radius_m = 0.025\ncutoff_hz = 2000.0\n[casting.e.fixture.middle]\npoint = \"T3\"\nat_m = [0.0, 0.0]\n";
    crate::solid::write_block(70e9, scratch.path());
    fs::write(scratch.path().join("study.toml"), format!("{text}\n{elastic}{more}")).expect("written");
    let run = ["run", "study.toml", "--output", "out", "--set", "duration_s=0.05"];
    let pads = ["front_left", "front_right", "back_left", "back_right"];
    let pads = pads.map(|name| format!("casting.a.fixture.{name}.one_sided=true"));
    let run = run.into_iter().chain(pads.iter().flat_map(|pad| ["--set", pad]));
    let output = decore(&scratch).args(run).output().expect("started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let reader = DatasetReader::open(&scratch.path().join("out")).expect("a dataset");
    let help = decore(&scratch).args(["help", "outputs"]).output().expect("started");
    let help = String::from_utf8(help.stdout).expect("text");
    for table in TableName::KNOWN {
        let listed = help.split(&format!("# Columns of `{}`", table.folder())).nth(1).expect("a list");
        let listed = listed.split("\n# ").next().expect("its lines");
        // Several hammers, and several castings, have the same lines.
        let listed: BTreeSet<String> =
            listed.lines().filter(|line| line.starts_with("- `")).map(str::to_owned).collect();
        let expected: BTreeSet<String> = reader.columns(table).iter().map(line).collect();
        let far: Vec<&String> = listed.symmetric_difference(&expected).collect();
        assert!(far.is_empty() && listed.len() >= 2, "{table:?}: {far:#?}");
    }
}

/// The guide's line of a column of a dataset.
fn line(column: &ColumnDescription) -> String {
    let unit = |unit: &str| if matches!(unit, "" | "1") { String::new() } else { format!(" ({unit})") };
    let ColumnDescription { name, description, .. } = column;
    match (column.group, &column.subject) {
        (ColumnGroup::Hammer | ColumnGroup::Casting | ColumnGroup::Fixture | ColumnGroup::Core, Some(subject)) => {
            let text = description.split_once(&format!("`{subject}`: ")).expect("a subject").1;
            format!("- `{}`{}: {text}", column.quantity, unit(&column.unit))
        }
        (ColumnGroup::Factor, _) => {
            "- `factor_NAME` (the factor's): Factor `NAME`: the paths of the study that it drives.".to_owned()
        }
        (ColumnGroup::Signal, _) if name != "time_s" => "- `SIGNAL` (the signal's): One for each of `[outputs] \
             signals`: what it is, and over what it is averaged."
            .to_owned(),
        _ => format!("- `{name}`{}: {description}", unit(&column.unit)),
    }
}

/// Texts of all source files below a folder.
fn sources(folder: &Path, all: &mut String) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, all);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            all.push_str(&fs::read_to_string(&path).expect("a text"));
        }
    }
}

#[test]
fn the_types_of_the_architecture_page_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let mut code = String::new();
    sources(&root.join("src"), &mut code);
    let words: BTreeSet<&str> = page.split(|c: char| !c.is_ascii_alphanumeric()).collect();
    let is_type = |word: &&&str| {
        let capitals = word.chars().filter(char::is_ascii_uppercase).count();
        capitals > 1
            && word.starts_with(|c: char| c.is_ascii_uppercase())
            && word.contains(|c: char| c.is_ascii_lowercase())
    };
    let types: Vec<&str> = words.iter().filter(is_type).copied().collect();
    assert!(types.len() > 20, "{types:?}");
    // `from`: the table of a study that `parameters!` declares.
    let declared = |name: &&&str| {
        ["struct", "enum", "trait", "type", "from"].iter().any(|kind| code.contains(&format!("{kind} {name}")))
    };
    let unknown: Vec<&&str> = types.iter().filter(|name| !declared(name)).collect();
    assert!(unknown.is_empty(), "rename them in ARCHITECTURE.md: {unknown:?}");
}

/// Two significant digits, as the guide prints them.
fn two_digits(value: f64) -> String {
    let decimals = (1 - value.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

#[test]
fn the_guide_s_scatter_is_that_of_its_command() {
    let scratch = TempDir::new().expect("scratch");
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let page = decore::guide::TOPICS.iter().find(|topic| topic.name == "scatter").expect("a page").text;
    let rows = page.lines().filter(|line| line.contains("| aperiodic |") || line.contains("| unsettled |"));
    let rows: Vec<Vec<&str>> = rows.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect();
    assert!(rows.len() >= 5, "{rows:?}");
    for row in rows {
        let mass = format!("casting.part.mass_kg={}", row[0]);
        let command = ["--set", "outputs.twins=10", "--set", &mass, "--json"];
        let output = decore(&scratch).arg("scene").arg(&study).args(command).output().expect("started");
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let (hammer, scatter) = (&found["outcome"]["metrics"]["hammers"][0], &found["outcome"]["metrics"]["scatter"]);
        let share =
            |part: &Value, name: &str| part.as_f64().map(|part| 100.0 * part / hammer[name].as_f64().expect(name));
        let of = |name: &str| share(&scatter["hammers"][0][name], name).expect(name);
        let error = share(&hammer["periodic_energy_mean_error_j"], "periodic_energy_mean_j");
        let [energy, work, frequency, delivered] =
            ["periodic_energy_mean_j", "periodic_work_mean_j", "hit_frequency_hz", "delivered_work_j"].map(of);
        let error = error.map_or("none".to_owned(), two_digits);
        let shown = [two_digits(energy), error, two_digits(work), two_digits(frequency), two_digits(delivered)];
        assert_eq!(
            (hammer["percussion"].as_str(), &row[2..]),
            (Some(row[1]), &shown.each_ref().map(String::as_str)[..])
        );
    }
}

#[test]
fn the_guide_s_commands_are_understood() {
    let scratch = TempDir::new().expect("scratch");
    let commands: Vec<_> = decore::guide::TOPICS.iter().flat_map(|topic| commands(topic.text)).collect();
    assert!(commands.len() >= 6, "{commands:?}");
    for arguments in commands {
        // Arguments before it are read first: an unknown one is an error.
        let output = decore(&scratch).args(&arguments).arg("--help").output().expect("started");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_readme_s_figures_of_the_rig_are_those_that_scene_prints() {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let scratch = TempDir::new().expect("scratch");
    let output = decore(&scratch).arg("scene").arg(study).arg("--json").output().expect("started");
    let outcome: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let text = readme();
    for (title, of, name) in RIG {
        let row = text.lines().find_map(|line| line.strip_prefix(&format!("| {title} | ")));
        let figure = row.and_then(|row| row.split(" |").next()).unwrap_or_else(|| panic!("no row `{title}`"));
        let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let value = outcome["outcome"]["metrics"][of][0][name].as_f64().expect(name);
        assert_eq!(format!("{value:.decimals$}"), figure, "{title}");
    }
}

#[test]
fn the_readme_s_picture_is_what_scene_draws() {
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    assert!(readme().contains("](studies/paper_rig.svg)"));
    let scratch = TempDir::new().expect("scratch");
    let drawn = decore(&scratch).arg("scene").arg(studies.join("paper_rig.toml")).args(["--plot", "rig.svg"]).output();
    assert!(drawn.expect("started").status.success());
    let picture = fs::read_to_string(scratch.path().join("rig.svg")).expect("a picture");
    for text in ["cylinder", "piston in it", "casting at the strike", "blow, its peak", "work on the casting", "mount"]
    {
        assert!(picture.contains(text), "{text}");
    }
    assert!(picture == fs::read_to_string(studies.join("paper_rig.svg")).expect("shipped"), "draw it anew");
}
