//! Options of the command line: exit codes as documented, and values that are refused before any row is run.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use tempfile::TempDir;

/// Settings that make a shipped study quick.
const QUICK: [&str; 4] = ["--set", "solver.fidelity=draft", "--set", "duration_s=0.06"];

fn decore(scratch: &TempDir) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    command.current_dir(scratch.path());
    command
}

fn study(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name)
}

/// Runs the program; exit code, standard output, standard error.
fn ran(command: &mut Command) -> (Option<i32>, String, String) {
    let output = command.output().expect("started");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn exit_codes_are_documented() {
    let (code, help, _) = ran(decore(&TempDir::new().expect("scratch")).arg("--help"));
    assert_eq!(code, Some(0));
    for exit in [0, 2, 3, 4, 5] {
        assert!(help.lines().any(|line| line.starts_with(&format!("  {exit}  "))), "{exit} in\n{help}");
    }
}

#[test]
fn results_that_cannot_be_written_have_their_exit_code() {
    let scratch = TempDir::new().expect("scratch");
    fs::write(scratch.path().join("file"), "").expect("written");
    let grid = study("pressure_grid.toml");
    let (code, _, log) = ran(decore(&scratch).arg("run").arg(&grid).args(["--output", "file/below"]).args(QUICK));
    assert_eq!(code, Some(3), "{log}");
    let rig = study("paper_rig.toml");
    let (code, _, log) =
        ran(decore(&scratch).arg("scene").arg(&rig).args(["--signals", "file/below.parquet"]).args(QUICK));
    assert_eq!(code, Some(3), "{log}");
}

#[test]
fn the_ranking_is_checked_before_the_rows_are_run() {
    let scratch = TempDir::new().expect("scratch");
    let run = |column: &str| {
        let mut command = decore(&scratch);
        command.arg("run").arg(study("pressure_grid.toml")).args(["--rank-by", column]).args(QUICK);
        ran(&mut command)
    };
    let (code, _, log) = run("mean_hit_frequenzy_hz");
    assert_eq!(code, Some(2));
    assert!(log.contains("did you mean `mean_hit_frequency_hz`?"), "{log}");
    let (code, _, log) = run("status");
    assert_eq!(code, Some(2));
    assert!(log.contains("holds text"), "{log}");
    assert!(!scratch.path().join("out").exists(), "nothing may be written");
    let (code, text, log) = run("hammer_first_impact_energy_j");
    assert_eq!(code, Some(0), "{log}");
    assert!(text.contains("Best rows by `hammer_first_impact_energy_j`"), "{text}");
}

#[test]
fn an_absurd_number_of_threads_is_refused() {
    let scratch = TempDir::new().expect("scratch");
    for command in ["run", "check"] {
        let mut command_line = decore(&scratch);
        command_line.arg(command).arg(study("pressure_grid.toml")).args(["--threads", "100000"]);
        let (code, _, log) = ran(&mut command_line);
        assert_eq!(code, Some(2), "{log}");
        assert!(log.contains("to 1024"), "{log}");
    }
    assert!(!scratch.path().join("out").exists());
}

#[test]
fn a_scene_is_printed_without_trailing_blanks() {
    let scratch = TempDir::new().expect("scratch");
    let (code, text, log) = ran(decore(&scratch).arg("scene").arg(study("paper_rig.toml")).args(QUICK));
    assert_eq!((code, log.as_str()), (Some(0), ""));
    assert!(text.lines().any(|line| line.starts_with("  first_impact_energy_j") && line.ends_with(" J")), "{text}");
    assert!(text.lines().all(|line| line == line.trim_end()), "{text:?}");
}
