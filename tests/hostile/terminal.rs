//! Texts of files reach the terminal without what makes it do more than show them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Clears the screen, colours, returns to the line's begin, C1's introducer, reverses the direction of writing.
const ORDERS: &str = "\u{1b}[2J\u{1b}[31m\r\u{9b}7m\u{7f}\u{202e}";

fn decore(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).current_dir(folder).output().expect("decore runs")
}

/// Runs a command; nothing of what it prints acts on a terminal. Returns what it printed.
fn shown(arguments: &[&str], folder: &Path, code: i32) -> String {
    let output = decore(arguments, folder);
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text:?}");
    let acts = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
    assert!(!text.contains(acts), "{text:?}");
    text
}

#[test]
fn messages_about_a_study_quote_it_without_its_orders() {
    let scratch = TempDir::new().expect("scratch folder");
    let studies = [
        // Syntax, unknown keys, choices, names, comments on the quoted line.
        format!("title = {ORDERS}\n"),
        "\"\\u001b[2J\\u202e\" = 1 # \u{202e}\n".to_owned(),
        "[design]\nkind = \"\\u001b[2J\\u009b\"\n".to_owned(),
        "[hammer.\"\\u001b[2J\"]\nrail_position_m = 0.1\n".to_owned(),
        "[hammer.left]\nfile = \"\u{202e}none.toml\"\nmount = \"R1\"\nsupply_bar = 5.0\nstandoff_m = 0.1\n".to_owned(),
    ];
    for text in studies {
        fs::write(scratch.path().join("study.toml"), &text).expect("study");
        shown(&["check", "study.toml"], scratch.path(), 2);
    }
    let named = format!("{ORDERS}.toml");
    fs::write(scratch.path().join(&named), "duration_s = \"long\"\n").expect("study");
    assert!(shown(&["check", &named], scratch.path(), 2).contains("\\u001b[2J"));
}

#[test]
fn a_title_is_one_line_without_control_characters() {
    let scratch = TempDir::new().expect("scratch folder");
    let rig = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml")).expect("study");
    let body: String = rig.lines().filter(|line| !line.starts_with("title")).map(|line| format!("{line}\n")).collect();
    for (escape, named) in [("\\n[design]", "'\\n'"), ("\\u001b[2J", "'\\u{1b}'"), ("\\u009b31m", "'\\u{9b}'")] {
        fs::write(scratch.path().join("study.toml"), format!("title = \"a{escape}\"\n{body}")).expect("study");
        let text = shown(&["check", "study.toml"], scratch.path(), 2);
        assert!(text.contains("`title`") && text.contains(&format!("control character {named}")), "{text}");
    }
}

#[test]
fn tables_matrices_and_datasets_of_others_give_no_orders() {
    let scratch = TempDir::new().expect("scratch folder");
    let at = |name: &str| scratch.path().join(name);
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    let study = study.to_str().expect("path");
    fs::write(at("design.csv"), format!("{ORDERS}\n1.0\n")).expect("table");
    let table = format!("design.file={}", at("design.csv").display());
    let cells = ["check", study, "--set", "design.kind=table", "--set", &table];
    shown(&cells, scratch.path(), 2);
    fs::write(at("k.mtx"), "%%MatrixMarket matrix coordinate real \u{9b}2J\u{202e}\n1 1 1\n1 1 1\n").expect("matrix");
    fs::write(at("p.csv"), "name,x,y,z,node\n").expect("points");
    let mut machine = vec!["check".to_owned(), study.to_owned()];
    for (key, file) in [("stiffness_file", "k.mtx"), ("mass_file", "k.mtx"), ("points_file", "p.csv")] {
        machine.extend(["--set".to_owned(), format!("structure.{key}={}", at(file).display())]);
    }
    machine.extend(["--set", "structure.source=matrices"].map(str::to_owned));
    shown(&machine.iter().map(String::as_str).collect::<Vec<_>>(), scratch.path(), 2);
    fs::create_dir(at("dataset")).expect("folder");
    fs::write(at("dataset/manifest.json"), "{\"schema\": \"\\u001b[2J\u{9b}\"}").expect("manifest");
    shown(&["status", "dataset"], scratch.path(), 8);
}
