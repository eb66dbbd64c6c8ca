//! Options of the command line: exit codes as documented, and values that are refused before any row is run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use decore_model::run::RowStatus;
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

/// A text without its line breaks and indents.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn exit_codes_are_documented() {
    let (code, help, _) = ran(decore(&TempDir::new().expect("scratch")).arg("--help"));
    assert_eq!(code, Some(0));
    for exit in [0, 2, 3, 4, 5, 6, 7, 8, 9] {
        assert!(help.lines().any(|line| line.starts_with(&format!("  {exit}  "))), "{exit} in\n{help}");
    }
    // Every way in which a row is not done, wherever they are listed.
    let scratch = TempDir::new().expect("scratch");
    let texts =
        [&["--help"][..], &["help", "sweeps"], &["run", "--help"]].map(|command| ran(decore(&scratch).args(command)).1);
    for status in RowStatus::ALL.iter().filter(|status| **status != RowStatus::Done) {
        let words = status.name().replace('_', " ");
        assert!(texts.iter().all(|text| one_line(text).contains(&words)), "{words}");
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
    // What matters in a dozen lines of 80 columns.
    let lines: Vec<&str> = text.lines().collect();
    // In a pipe the study's title has a line of its own, however long.
    assert!(lines.len() <= 12 && lines[1..].iter().all(|line| line.chars().count() <= 80), "{text}");
    assert!(lines.iter().any(|line| line.trim_start().starts_with("(J)")) || text.contains("energy (J)"), "{text}");
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

/// Signals are bounded by what they would take, with the figure, before any row is run.
#[test]
fn signals_that_would_not_fit_are_refused() {
    let scratch = TempDir::new().expect("scratch");
    let run = |interval: &str| {
        let mut command = decore(&scratch);
        command.arg("scene").arg(study("paper_rig.toml")).args([
            "--signals",
            "s.parquet",
            "--signal-interval-s",
            interval,
        ]);
        ran(command.args(["--set", "solver.guide=tied"]))
    };
    for (interval, figure) in [("1e-9", "576.00 GB"), ("1e-7", "5.76 GB")] {
        let (code, _, log) = run(interval);
        assert_eq!(code, Some(2), "{log}");
        assert!(log.contains(figure) && log.contains("more than 1 GB; expected at least"), "{log}");
    }
    assert!(!scratch.path().join("s.parquet").exists());
    assert_eq!(run("1e-4").0, Some(0));
}

/// Twins add a column of scatter for every main output, and `check` tells what they cost; they cannot differ between rows.
#[test]
fn twins_have_columns_and_a_price() {
    let scratch = TempDir::new().expect("scratch");
    let run = |command: &str, more: &[&str]| {
        let mut command_line = decore(&scratch);
        command_line.arg(command).arg(study("pressure_grid.toml")).args(QUICK).args(more);
        ran(&mut command_line)
    };
    let twins = ["--set", "outputs.twins=2"];
    let (code, text, log) = run("check", &twins);
    assert_eq!(code, Some(0), "{log}");
    assert!(text.contains("twins          2 per row, "), "{text}");
    let (code, _, log) = run("run", &["--set", "outputs.twins=2", "--output", "out"]);
    assert_eq!(code, Some(0), "{log}");
    let reader = decore_dataset::DatasetReader::open(&scratch.path().join("out")).expect("opened");
    let table = decore_dataset::TableName::Runs;
    let names = ["hammer_first_impact_energy_j_scatter", "delivered_work_j_scatter", "part_peak_velocity_m_s_scatter"];
    let mut rows = 0;
    reader
        .visit(table, &names, |cells| {
            let scatter: Vec<f64> = cells.iter().filter_map(|cell| cell.and_then(|value| value.number())).collect();
            assert!(scatter.len() == 3 && scatter.iter().all(|value| *value >= 0.0 && *value < 0.05), "{cells:?}");
            rows += 1;
        })
        .expect("read");
    assert_eq!(rows, 8);
    let scatter = |column: &decore_dataset::ColumnDescription| column.name.ends_with("_scatter");
    // Without twins there is no such column.
    assert!(reader.columns(table).iter().filter(|column| scatter(column)).count() > 15);
    assert_eq!(run("run", &["--output", "plain"]).0, Some(0));
    let plain = decore_dataset::DatasetReader::open(&scratch.path().join("plain")).expect("opened");
    assert_eq!(plain.columns(table).iter().filter(|column| scatter(column)).count(), 0);
    let driven = "design.factor.pressure.path=outputs.twins";
    let (code, _, log) = run("check", &["--set", driven]);
    assert_eq!(code, Some(2));
    assert!(log.contains("is shared by all rows"), "{log}");
    // Known to amplify: several hammers on one casting, a heavy casting.
    let mut command = decore(&scratch);
    let (_, text, _) = ran(command.arg("check").arg(study("three_hammers.toml")).args(QUICK));
    assert!(text.contains("2 hammers strike casting `a`: its periodic figures may scatter"), "{text}");
    let mut command = decore(&scratch);
    let heavy = ["--set", "casting.part.mass_kg=20"];
    let (_, text, _) = ran(command.arg("check").arg(study("paper_rig.toml")).args(QUICK).args(heavy));
    assert!(text.contains("heavy for its hammer (20 kg)"), "{text}");
    let mut command = decore(&scratch);
    let (_, text, _) = ran(command.arg("check").arg(study("paper_rig.toml")).args(QUICK));
    assert!(!text.contains("scatter"), "{text}");
}

/// A sweep has a numerical twin of row 0 and of one row in every further hundred; `all` and `none`, `true` and `false` are taken, and
/// `run`, `report` and `scene` print the errors.
#[test]
fn numerical_twins_have_columns_and_lines() {
    let scratch = TempDir::new().expect("scratch");
    let run = |command: &str, more: &[&str]| {
        let mut command_line = decore(&scratch);
        command_line.arg(command).arg(study("pressure_grid.toml")).args(QUICK).args(more);
        ran(&mut command_line)
    };
    let done = |folder: &str| {
        let reader = decore_dataset::DatasetReader::open(&scratch.path().join(folder)).expect("opened");
        let names =
            ["numerical_twin_done", "numerical_errors_beyond_promise", "hammer_first_impact_energy_j_numerical_error"];
        let (table, mut rows) = (decore_dataset::TableName::Runs, Vec::new());
        let read = reader.visit(table, &names, |cells| {
            rows.push(cells.iter().map(|cell| cell.and_then(|value| value.number())).collect::<Vec<_>>());
        });
        read.map(|()| rows)
    };
    let sample = [("sample", "\"sample\""), ("true", "true"), ("default", "")];
    for (folder, value) in sample {
        let setting = format!("outputs.numerical_twin={value}");
        let set: &[&str] = if value.is_empty() { &[] } else { &["--set", &setting] };
        let (code, text, log) = run("run", &[&["--output", folder][..], set].concat());
        assert_eq!(code, Some(0), "{log}");
        assert!(
            one_line(&text).contains("Numerical error: at most 0.") && one_line(&text).contains("`, row 0)"),
            "{text}"
        );
        let (_, text, _) = ran(decore(&scratch).args(["report", folder]));
        assert!(text.contains("Numerical errors (relative; 1 row run again with better numerics; "), "{text}");
        assert!(text.contains("  first_impact_energy_j ") && text.contains("  row 0\n"), "{text}");
        let rows = done(folder).expect("columns");
        assert!(rows[0][0] == Some(1.0) && rows[0][1].is_some(), "{:?}", rows[0]);
        assert!(rows[0][2].is_some_and(|error| error > 0.0 && error < 0.1), "{:?}", rows[0]);
        assert!(rows[1..].iter().flatten().all(Option::is_none) && rows.len() == 8, "{rows:?}");
    }
    let (code, text, _) = ran(decore(&scratch).args(["report", "default"]));
    assert!(code == Some(0) && text.contains("Numerical errors (relative; 1 row run"), "{text}");
    assert_eq!(run("run", &["--set", "outputs.numerical_twin=all", "--output", "all"]).0, Some(0));
    assert!(done("all").expect("columns").iter().all(|row| row[0] == Some(1.0)));
    for (folder, value) in [("none", "none"), ("false", "false")] {
        let setting = format!("outputs.numerical_twin={value}");
        let (code, text, log) = run("run", &["--set", &setting, "--output", folder]);
        assert!(code == Some(0) && !text.contains("Numerical error"), "{text}{log}");
        assert!(done(folder).is_err(), "no such column");
    }
    let (code, _, log) = run("run", &["--set", "outputs.numerical_twin=some", "--output", "some"]);
    assert!(code == Some(2) && log.contains("\"sample\", \"all\", \"none\""), "{log}");
    let (code, _, log) = run("check", &["--set", "design.factor.pressure.path=outputs.numerical_twin"]);
    assert!(code == Some(2) && log.contains("is shared by all rows"), "{log}");
    // A scene alone has one when asked.
    let scene = |more: &[&str]| ran(decore(&scratch).arg("scene").arg(study("paper_rig.toml")).args(QUICK).args(more));
    assert!(!scene(&[]).1.contains("numerical"));
    let (code, text, log) = scene(&["--set", "outputs.numerical_twin=all"]);
    assert_eq!(code, Some(0), "{log}");
    assert!(text.contains(" J     numerical error ") && text.contains("\nnumerical twin: "), "{text}");
}

#[test]
fn the_guide_has_the_pages_that_the_readme_lists() {
    let scratch = TempDir::new().expect("scratch");
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("README");
    let rows = readme.split("## The guide").nth(1).expect("a section on the guide");
    let rows = rows.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` | "));
    let listed: Vec<(&str, &str)> = rows.map(|(name, about)| (name, about.trim_end_matches(" |"))).collect();
    let pages: Vec<(&str, &str)> = decore::guide::TOPICS.iter().map(|topic| (topic.name, topic.about)).collect();
    assert_eq!(listed, pages);
    for (name, about) in pages {
        let (code, text, _) = ran(decore(&scratch).args(["help", name]));
        assert_eq!(code, Some(0), "{name}");
        assert!(text.starts_with("# "), "{name}: {text}");
        let (_, help, _) = ran(decore(&scratch).arg("--help"));
        assert!(one_line(&help).contains(about), "{name}");
    }
    let (_, outputs, _) = ran(decore(&scratch).args(["help", "outputs"]));
    assert!(outputs.contains("- `first_impact_energy_j` (J): "), "{outputs}");
    let (code, text, _) = ran(decore(&scratch).args(["help", "merge"]));
    assert!(code == Some(0) && text.contains("decore merge"), "{text}");
    let (code, _, error) = ran(decore(&scratch).args(["help", "nonsense"]));
    assert!(code == Some(2) && error.contains("outputs") && error.contains("merge"), "{error}");
}

#[test]
fn no_output_overwrites_what_the_command_reads() {
    let scratch = TempDir::new().expect("scratch folder");
    let text = fs::read_to_string(study("placement.toml")).expect("a study");
    let own = scratch.path().join("own.toml");
    fs::write(&own, &text).expect("written");
    let table = scratch.path().join("rows.csv");
    fs::write(&table, "factor_position\n0.0\n").expect("written");
    let by_table = scratch.path().join("table.toml");
    let (scene, _) = text.split_once("[design]").expect("a design");
    let design = "[design]\nkind = \"table\"\nfile = \"rows.csv\"\n\n[design.factor.position]\npath = \"hammer.hammer.rail_position_m\"\n";
    fs::write(&by_table, format!("{scene}{design}")).expect("written");
    let hammer = scratch.path().join("hammers/default.toml");
    fs::create_dir(scratch.path().join("hammers")).expect("made");
    fs::copy(study("hammers/default.toml"), &hammer).expect("copied");
    let around = scratch.path().join(".").join("own.toml");
    let refused = |command: &mut Command| {
        let (code, _, errors) = ran(command);
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.contains("would overwrite what the command reads"), "{errors}");
    };
    refused(decore(&scratch).arg("run").arg(&own).arg("--summary").arg(&around));
    refused(decore(&scratch).arg("scene").arg(&own).arg("--signals").arg("own.toml"));
    refused(decore(&scratch).arg("check").arg(&own).arg("--scatter").arg(&own));
    refused(decore(&scratch).arg("check").arg(&own).arg("--scatter").arg(&hammer));
    refused(decore(&scratch).arg("design").arg(&by_table).arg("--output").arg(&table));
    #[cfg(unix)]
    {
        let link = scratch.path().join("link.parquet");
        std::os::unix::fs::symlink(&own, &link).expect("linked");
        refused(decore(&scratch).arg("scene").arg(&own).arg("--signals").arg(&link));
    }
    assert_eq!(fs::read_to_string(&own).expect("still there"), text);
}

/// `check` and `report` state the duration that a wanted standard error needs: errors fall with the root of the duration.
#[test]
fn durations_for_a_wanted_error() {
    let scratch = TempDir::new().expect("scratch");
    let rig = study("paper_rig.toml");
    let run = |arguments: &[&str]| {
        let (code, text, log) = ran(decore(&scratch).args(arguments));
        assert_eq!(code, Some(0), "{arguments:?}: {log}");
        text
    };
    let rig = rig.to_str().expect("UTF-8");
    let heavy = ["--set", "casting.part.mass_kg=40"];
    let text = run(&["check", rig, heavy[0], heavy[1], "--wanted-error", "0.02"]);
    assert!(text.contains("for 2.00 % set duration_s to about "), "{text}");
    assert!(run(&["check", rig]).contains("precision      standard errors of at most 0."));
    let json = run(&["check", rig, heavy[0], heavy[1], "--wanted-error", "0.02", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let needed = found["probe"]["precision"].as_array().expect("a list");
    assert!(needed.len() >= 7, "{json}");
    for one in needed {
        let number = |key: &str| one[key].as_f64().expect("a number");
        let expected = 1.5 * (number("relative_error") / 0.02).powi(2);
        assert!((number("needed_s") / expected - 1.0).abs() < 1e-9, "{one}");
    }
    run(&["run", rig, heavy[0], heavy[1], "--output", "heavy"]);
    let text = run(&["report", "heavy", "--wanted-error", "0.02"]);
    assert!(text.contains("Standard errors above 2.000 %") && text.contains(" s in row 0: needs "), "{text}");
    let json = run(&["report", "heavy", "--wanted-error", "0.02", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let precision = report["precision"].as_array().expect("a list");
    for one in needed {
        let same = precision.iter().find(|other| other["output"] == one["output"]).expect("the output");
        let worst = same["worst"]["needed_s"].as_f64().expect("a number");
        assert!((worst / one["needed_s"].as_f64().expect("a number") - 1.0).abs() < 1e-9, "{same}");
    }
    let (code, _, log) = ran(decore(&scratch).args(["report", "heavy", "--wanted-error", "0"]));
    assert!(code == Some(2) && log.contains("expected a number between 0 and 1"), "{log}");
}
