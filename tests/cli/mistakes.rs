//! Common mistakes, and what the program says to do about them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A folder with the shipped studies.
fn folder() -> TempDir {
    let scratch = TempDir::new().expect("a folder");
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    fs::create_dir(scratch.path().join("hammers")).expect("a folder");
    for name in ["paper_rig.toml", "pressure_grid.toml", "hammers/default.toml"] {
        fs::copy(studies.join(name), scratch.path().join(name)).expect("copied");
    }
    scratch
}

/// Exit code and what is said on both streams.
fn says(scratch: &TempDir, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    let output = command.args(arguments).current_dir(scratch.path()).output().expect("the program starts");
    let text = String::from_utf8_lossy(&[output.stderr, output.stdout].concat()).into_owned();
    (output.status.code(), if cfg!(windows) { text.replace('\\', "/") } else { text })
}

#[test]
fn what_is_given_in_place_of_a_study_or_a_dataset_is_named() {
    let scratch = folder();
    let quick = ["--set", "duration_s=0.01", "--set", "solver.guide=tied"];
    let run = says(&scratch, &[&["run", "pressure_grid.toml"], &quick[..]].concat());
    assert!(run.0 == Some(0) || run.0 == Some(4), "{}", run.1);
    for (arguments, words) in [
        (vec!["run", "paper_rg.toml"], "there is no study paper_rg.toml; did you mean paper_rig.toml?"),
        (vec!["run", "no/paper_rig.toml"], "the folder no does not exist"),
        (vec!["check", "zzz"], "`decore init zzz` writes one to start from"),
        (
            vec!["scene", "."],
            ". is a folder, where a study (a TOML file) is expected; it holds paper_rig.toml, pressure_grid.toml",
        ),
        (vec!["run", "out/pressure_grid"], "out/pressure_grid is a dataset, where a study (a TOML file) is expected"),
        (vec!["accuracy", "out/pressure_grid/manifest.json"], "is no study: a TOML file is expected"),
        (vec!["status", "pressure_grid.toml"], "`decore run pressure_grid.toml` wrote out/pressure_grid"),
        (vec!["report", "out/presure_grid"], "there is no dataset out/presure_grid; did you mean out/pressure_grid?"),
        (vec!["report", "out/pressure_grid/runs"], "give out/pressure_grid"),
        (vec!["verify", "out/pressure_grid/manifest.json"], "give the folder out/pressure_grid"),
        (vec!["report", "out/pressure_grid", "--best", "0"], "expected a whole number from 1 on"),
        (vec!["help", "accuarcy"], "did you mean `accuracy`?"),
        (
            vec!["scene", "paper_rig.toml", "--plot", "rig.png"],
            "the output format is SVG: use a file name that ends in `.svg`",
        ),
        (vec!["scene", "paper_rig.toml", "--signals", "out"], "--signals out is a folder"),
        (vec!["scene", "paper_rig.toml", "--row", "1"], "--row is 1, but the study has row 0 only"),
        (vec!["scene", "paper_rig.toml", "--set", "hammer.hammer.supply_bar=5,0"], "a number, with a point as in 5.0"),
        (vec!["scene", "paper_rig.toml", "--set", "solver.fidelity=standart"], "did you mean `standard`?"),
    ] {
        let (code, text) = says(&scratch, &arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {text}");
        assert!(text.contains(words), "{arguments:?}: {text}");
    }
    let (code, text) = says(&scratch, &["init", "no/study.toml"]);
    assert!(code == Some(3) && text.contains("make the folder no first"), "{text}");
}

/// What is to be copied to a shell is one word there, whatever the name.
#[cfg(unix)]
#[test]
fn commands_that_are_suggested_can_be_copied() {
    let scratch = folder();
    let name = "it's my $(touch forged) study";
    let file = format!("{name}.toml");
    let (code, text) = says(&scratch, &["init", &file]);
    assert_eq!(code, Some(0), "{text}");
    let copied = |command: &str| {
        let program = Path::new(env!("CARGO_BIN_EXE_decore")).display();
        let line = format!("decore() {{ '{program}' \"$@\"; }}; {command}");
        let output = Command::new("sh").args(["-c", &line]).current_dir(scratch.path()).output().expect("a shell");
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let (_, next) = text.trim_end().split_once("next: ").expect("commands");
    let (check, run) = next.split_once(", ").expect("two commands");
    assert!(run.starts_with("decore run "), "{run}");
    copied(check);
    let (_, text) = says(&scratch, &["check", "no such one"]);
    copied(text.split('`').nth(1).expect("a command"));
    let quick = ["run", "pressure_grid.toml", "--stub-row-ms", "0", "--output", name];
    assert_ne!(says(&scratch, &quick).0, Some(2));
    let (_, text) = says(&scratch, &["status", name]);
    copied(text.split('`').nth(1).expect("a command"));
    let (_, text) = says(&scratch, &["run", name]);
    text.split('`').skip(1).step_by(2).take(2).for_each(copied);
    assert!(!scratch.path().join("forged").exists());
}

#[test]
fn a_report_shows_distributions_and_fits_its_reader() {
    let scratch = folder();
    let quick = ["run", "pressure_grid.toml", "--set", "duration_s=0.1", "--set", "solver.guide=tied"];
    assert_eq!(says(&scratch, &quick).0, Some(0));
    let report = |locale: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
        command.args(["report", "out/pressure_grid"]).current_dir(scratch.path()).env("LC_ALL", locale);
        String::from_utf8(command.output().expect("the program starts").stdout).expect("UTF-8")
    };
    let (blocks, plain) = (report("C.UTF-8"), report("C"));
    for text in [&blocks, &plain] {
        assert!(
            text.contains("Best rows by `strike_energy_j`") && text.contains("Distributions (rows done)"),
            "{text}"
        );
        assert!(text.contains("`strike_energy_j` over factor `"), "{text}");
    }
    assert!(blocks.contains('\u{2588}') && plain.is_ascii(), "{blocks}{plain}");
    let tables: PathBuf = scratch.path().join("out/pressure_grid/runs");
    let named = Path::new("out/pressure_grid").join("runs");
    assert!(tables.is_dir() && plain.contains(named.to_str().expect("a path")), "{plain}");
}

/// Slips of units are told once, and the row is run nevertheless.
#[test]
fn warnings_are_told_once() {
    let scratch = folder();
    let slip = ["--set", "environment.temperature_k=20", "--set", "duration_s=0.01"];
    for command in ["scene", "run", "check"] {
        let (code, text) = says(&scratch, &[&[command, "paper_rig.toml"], &slip[..]].concat());
        assert_ne!(code, Some(2), "{text}");
        assert_eq!(text.matches("20 K is unusual").count(), 1, "{command}: {text}");
        assert!(
            text.contains("warning: ") && text.contains("is it in degrees Celsius (293.1 K)?"),
            "{command}: {text}"
        );
    }
}
