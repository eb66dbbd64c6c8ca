//! What commands write for other programs: designs, completions of shells, manual pages.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

/// Runs decore in a folder and gives what it printed.
fn decore(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).current_dir(folder).output();
    let output = output.expect("started");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Commands as the help of the program lists them.
fn commands(folder: &Path) -> Vec<String> {
    let help = decore(folder, &["--help"]);
    let groups = help.split_once("Usage:").and_then(|(_, rest)| rest.split_once("\nOptions:")).expect("commands").0;
    let names = groups.lines().filter_map(|line| line.strip_prefix("  ").filter(|name| !name.starts_with(' ')));
    names.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

/// Factors of every type: a range, a logarithmic one, whole numbers, a list, names, one derived of others.
const FACTORS: &str = r#"
[design.factor.position]
path = "hammer.hammer.rail_position_m"
range = [-0.1, 0.1]

[design.factor.pressure]
path = "hammer.hammer.supply_bar"
range = [4.0, 6.0]
scale = "log"

[design.factor.mass]
path = "casting.part.mass_kg"
values = [3, 3.1, 3.25]

[design.factor.twin_stride]
path = "outputs.settling_blows"
range = [3, 7]
integer = true

[design.factor.law]
path = "hammer.hammer.file"
values = ["default.toml", "hammers/default.toml"]

[design.factor.standoff]
path = "hammer.hammer.standoff_m"
expression = "0.085 + position / 7"
"#;

#[test]
fn a_written_design_read_back_gives_the_same_rows() {
    let folder = TempDir::new().expect("scratch folder");
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let text = fs::read_to_string(studies.join("placement.toml")).expect("a study");
    let (scene, _) = text.split_once("[design]").expect("a design");
    fs::create_dir(folder.path().join("hammers")).expect("made");
    for copy in ["default.toml", "hammers/default.toml"] {
        fs::copy(studies.join("hammers/default.toml"), folder.path().join(copy)).expect("copied");
    }
    let write = |name: &str, design: &str| {
        fs::write(folder.path().join(name), format!("{scene}[design]\n{design}\n{FACTORS}")).expect("written");
    };
    write("first.toml", "kind = \"random\"\nrows = 40\nseed = 3");
    decore(folder.path(), &["design", "first.toml", "--output", "rows.csv"]);
    let rows = fs::read_to_string(folder.path().join("rows.csv")).expect("rows");
    assert_eq!(rows.lines().count(), 41, "{rows}");
    for ending in ["csv", "parquet"] {
        decore(folder.path(), &["design", "first.toml", "--output", &format!("rows.{ending}"), "--replace"]);
        write("second.toml", &format!("kind = \"table\"\nfile = \"rows.{ending}\""));
        decore(folder.path(), &["design", "second.toml", "--output", "again.csv", "--replace"]);
        assert!(rows == fs::read_to_string(folder.path().join("again.csv")).expect("again"), "{ending}");
    }
}

#[test]
fn every_command_has_its_completions_and_its_manual_page() {
    let folder = TempDir::new().expect("scratch folder");
    let commands = commands(folder.path());
    assert!(commands.len() > 15, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = decore(folder.path(), &["completions", shell]);
        assert!(commands.iter().all(|command| script.contains(command.as_str())), "{shell}");
        assert!(script.contains("--max-failed") || script.contains("-l max-failed"), "{shell}");
    }
    decore(folder.path(), &["man", "--output", "man/man1"]);
    let pages = folder.path().join("man/man1");
    let page = |name: &str| fs::read_to_string(pages.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(page("decore.1").contains("decore\\-run"));
    for command in &commands {
        assert!(page(&format!("decore-{command}.1")).contains("SYNOPSIS"), "{command}");
    }
    assert_eq!(fs::read_dir(&pages).expect("pages").count(), commands.len() + 1);
}

/// Bash itself completes a command and an option.
#[cfg(target_os = "linux")]
#[test]
fn bash_completes() {
    let folder = TempDir::new().expect("scratch folder");
    let script = folder.path().join("decore.bash");
    fs::write(&script, decore(folder.path(), &["completions", "bash"])).expect("written");
    let complete = |before: &str, word: &str| {
        let words =
            format!("source decore.bash; COMP_WORDS=({before} {word}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))");
        let line = format!("{words}; _decore decore {word} {before}; echo ${{COMPREPLY[@]}}");
        let output = Command::new("bash").args(["-c", &line]).current_dir(folder.path()).output().expect("bash");
        String::from_utf8(output.stdout).expect("UTF-8").trim().to_owned()
    };
    assert_eq!(complete("decore", "comp"), "compare completions");
    assert_eq!(complete("decore compare", "--rel"), "--relative");
}

/// What the design says of its rows reaches the table of features through the dataset.
#[test]
fn rows_of_a_trajectory_are_one_group() {
    let folder = TempDir::new().expect("scratch folder");
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml"));
    let (scene, _) = text.as_deref().expect("a study").split_once("[design]").expect("a design");
    let parts = "[[design.part]]\nkind = \"morris\"\ntrajectories = 2\n[[design.part]]\nkind = \"random\"\nrows = 3\n";
    let pressure = "path = \"hammer.hammer.supply_bar\"\nrange = [4.0, 6.0]\n";
    let standoff = "path = \"hammer.hammer.standoff_m\"\nrange = [0.07, 0.09]\n";
    let factors = format!("[design.factor.pressure]\n{pressure}[design.factor.standoff]\n{standoff}");
    let design = format!("{scene}[design]\nkind = \"union\"\n{parts}{factors}");
    fs::write(folder.path().join("study.toml"), design).expect("written");
    fs::create_dir(folder.path().join("hammers")).expect("made");
    let hammer = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hammers/default.toml");
    fs::copy(hammer, folder.path().join("hammers/default.toml")).expect("copied");
    decore(folder.path(), &["run", "study.toml", "--output", "sweep", "--set", "duration_s=0.002"]);
    let splits = ["--splits", "0.5,0.5", "--seed", "3"];
    let arguments = [&["export", "sweep", "--features", "table", "--format", "csv"][..], &splits].concat();
    let printed = decore(folder.path(), &arguments);
    assert!(printed.contains("split: "), "{printed}");
    let mut table = csv::Reader::from_path(folder.path().join("table/features.csv")).expect("a table");
    let header = table.headers().expect("names").clone();
    let place = |name: &str| header.iter().position(|column| column == name).unwrap_or_else(|| panic!("no {name}"));
    let places = ["group_trajectory", "group_id", "split"].map(place);
    let lines: Vec<[String; 3]> =
        table.records().map(|line| places.map(|place| line.as_ref().expect("a line")[place].to_owned())).collect();
    let column = |index: usize| lines.iter().map(|line| line[index].as_str()).collect::<Vec<_>>();
    assert_eq!(column(0), ["0", "0", "0", "1", "1", "1", "", "", ""]);
    assert_eq!(column(1), ["0", "0", "0", "1", "1", "1", "2", "3", "4"]);
    let split = column(2);
    assert!(split[..3].iter().all(|part| *part == split[0]) && split[3..6].iter().all(|part| *part == split[3]));
    // What lies in the dataset is refused, and so is a share too many.
    for (more, told) in [
        (&["--features", "sweep/table"][..], "lies in the dataset"),
        (&["--features", "other", "--splits", "0.7,0.7"], "add up to 1"),
    ] {
        let arguments = [&["export", "sweep"], more].concat();
        let output = Command::new(env!("CARGO_BIN_EXE_decore")).args(&arguments).current_dir(folder.path()).output();
        let output = output.expect("started");
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(told), "{said}");
    }
}
