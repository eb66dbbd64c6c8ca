//! What commands print arrives, or the command says that it did not.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

const DONE: i32 = 0;
const NOT_WRITTEN: i32 = 3;

/// A machine that is reduced at once, a row that takes no time.
const QUICK: [&str; 6] = ["--set", "solver.fidelity=draft", "--set", "duration_s=0.02", "--set", "design.rows=2"];

/// Every command that prints, each with what it needs in the folder. Those that would take long run with [`QUICK`].
fn printing(study: &str) -> Vec<Vec<String>> {
    let quick = |words: &[&str]| words.iter().chain(&QUICK).map(|word| (*word).to_owned()).collect();
    let plain = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
    vec![
        quick(&["run", study, "--stub-row-ms", "0", "--output", "out"]),
        quick(&["check", study]),
        quick(&["scene", study]),
        quick(&["scene", study, "--json"]),
        quick(&["design", study, "--output", "design.csv"]),
        quick(&["structure", study, "--json"]),
        quick(&["structure", study]),
        quick(&["accuracy", study, "--quick", "--no-truncation", "--repeats", "1", "--output", "accuracy"]),
        quick(&["slurm", study, "--tasks", "2", "--stub-row-ms", "0", "--output", "cluster"]),
        quick(&["hyperqueue", study, "--tasks", "2", "--stub-row-ms", "0", "--output", "cluster"]),
        plain(&["merge", "out", "--output", "merged", "--replace"]),
        plain(&["status", "out"]),
        plain(&["status", "out", "--json"]),
        plain(&["verify", "out"]),
        plain(&["paper"]),
        plain(&["init", "-"]),
        plain(&["completions", "bash"]),
        plain(&["man", "--output", "man"]),
        plain(&["help"]),
        plain(&["help", "outputs"]),
        plain(&["help", "run"]),
        plain(&["--help"]),
        plain(&["run", "--help"]),
        plain(&["--version"]),
    ]
}

fn run(folder: &Path, arguments: &[String], stdout: Stdio) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null()).stdout(stdout).stderr(Stdio::piped());
    command.spawn().and_then(|child| child.wait_with_output()).expect("decore runs")
}

fn scratch() -> (TempDir, String) {
    let folder = TempDir::new().expect("scratch folder");
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    (folder, study.to_str().expect("path").to_owned())
}

#[test]
fn output_that_cannot_be_printed_is_a_failure() {
    let (folder, study) = scratch();
    for arguments in printing(&study) {
        let full = File::options().write(true).open("/dev/full").expect("a full device");
        let output = run(folder.path(), &arguments, full.into());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(NOT_WRITTEN), "{arguments:?}: {said}");
        let last = said.lines().last().unwrap_or_default();
        assert!(last.starts_with("error: failed to write to standard output: No space left"), "{arguments:?}: {said}");
    }
    // What the commands wrote into files is whole.
    let table = fs::read_to_string(folder.path().join("design.csv")).expect("design");
    assert_eq!(table.lines().count(), 3, "{table}");
}

#[test]
fn a_reader_that_has_enough_is_no_failure() {
    let (folder, study) = scratch();
    for arguments in printing(&study) {
        let (reader, writer) = std::io::pipe().expect("pipe");
        drop(reader);
        let output = run(folder.path(), &arguments, writer.into());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(DONE), "{arguments:?}: {said}");
        assert!(!said.contains("pipe") && !said.contains("panicked"), "{arguments:?}: {said}");
    }
}
