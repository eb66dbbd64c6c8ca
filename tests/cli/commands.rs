//! The command line end to end: shipped studies, outputs, exit codes, thread independence, interruption.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
#[cfg(unix)]
use std::time::{Duration, Instant};

use decore_dataset::{DatasetReader, TableName};
use tempfile::TempDir;

const DONE: i32 = 0;
const BAD_INPUT: i32 = 2;
const ROWS_FAILED: i32 = 4;
#[cfg(unix)]
const INTERRUPTED: i32 = 5;

fn studies() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies")
}

fn decore(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_decore"))
        .args(arguments)
        .current_dir(studies())
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs the program and holds it to an exit code.
fn ends(arguments: &[&str], code: i32) -> Output {
    let output = decore(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{}\n{}", stdout(&output), stderr(&output));
    output
}

/// Settings that make any shipped study quick.
const QUICK: [&str; 4] = ["--set", "solver.guide=tied", "--set", "duration_s=0.15"];

/// All values of a text or number column, as text.
fn column(folder: &Path, name: &str) -> Vec<String> {
    let mut values = Vec::new();
    let reader = DatasetReader::open(folder).unwrap();
    reader
        .visit(TableName::Runs, &[name], |cells| {
            values.push(cells[0].map_or("null".to_owned(), |value| value.to_string()));
        })
        .unwrap();
    values
}

/// Bytes of every file of a dataset that must not depend on threads or time.
fn fixed_bytes(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("manifest.json".to_owned(), fs::read(folder.join("manifest.json")).unwrap())];
    for table in ["runs", "blows"] {
        for entry in fs::read_dir(folder.join(table)).unwrap() {
            let path = entry.unwrap().path();
            files.push((path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()));
        }
    }
    files.sort();
    files
}

#[test]
fn every_shipped_study_checks() {
    for entry in fs::read_dir(studies()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let text = stdout(&ends(&["check", path.to_str().unwrap(), "--set", "solver.guide=tied"], DONE));
        for word in ["design", "modes", "states", "time", "hash"] {
            assert!(text.contains(word), "{}: no `{word}` in\n{text}", path.display());
        }
    }
}

#[test]
fn the_results_do_not_depend_on_threads() {
    let scratch = TempDir::new().unwrap();
    let folders = ["1", "2"].map(|threads| {
        let folder = scratch.path().join(threads);
        let mut arguments = vec!["run", "placement.toml", "--set", "design.rows=70", "--threads", threads, "--output"];
        arguments.push(folder.to_str().unwrap());
        arguments.extend(QUICK);
        let text = stdout(&ends(&arguments, DONE));
        let report = format!("decore report {}", folder.display());
        assert!(text.contains("70 of 70 (70 done)") && text.contains(&report), "{text}");
        folder
    });
    let [one, two] = folders.map(|folder| fixed_bytes(&folder));
    assert!(one.len() >= 5, "two parts of each table: {:?}", one.iter().map(|file| &file.0).collect::<Vec<_>>());
    assert!(one == two, "bytes differ between one and two threads");
}

#[test]
fn a_grid_runs_and_its_dataset_is_continued_or_replaced() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path().join("grid");
    let mut arguments = vec!["run", "pressure_grid.toml", "--output", folder.to_str().unwrap()];
    arguments.extend(QUICK);
    ends(&arguments, DONE);
    let first = fixed_bytes(&folder);
    assert!(column(&folder, "energy_residual").iter().all(|value| value.parse::<f64>().unwrap().abs() < 1e-3));
    ends(&arguments, DONE);
    assert!(fixed_bytes(&folder) == first, "nothing is left to run");
    let mut changed = arguments.clone();
    changed.extend(["--set", "hammer.hammer.start_time_s=0.003"]);
    let refused = ends(&changed, BAD_INPUT);
    assert!(stderr(&refused).contains("start_time_s"), "{}", stderr(&refused));
    assert!(fixed_bytes(&folder) == first, "a refused run must touch nothing");
    arguments.push("--replace");
    ends(&arguments, DONE);
    assert!(fixed_bytes(&folder) == first, "the same study gives the same bytes");
}

#[test]
fn a_row_that_misses_its_casting_is_invalid_and_the_others_are_done() {
    let scratch = TempDir::new().unwrap();
    let study = scratch.path().join("miss.toml");
    let text = fs::read_to_string(studies().join("placement.toml")).unwrap();
    let text =
        text.replace("range = [-0.12, 0.12]", "range = [-0.4, 0.4]").replace("file = \"hammers/default.toml\"\n", "");
    fs::write(&study, text).unwrap();
    let folder = scratch.path().join("out");
    let mut arguments = vec!["run", study.to_str().unwrap(), "--set", "design.rows=8", "--output"];
    arguments.push(folder.to_str().unwrap());
    arguments.extend(QUICK);
    ends(&arguments, ROWS_FAILED);
    let (statuses, reasons) = (column(&folder, "status"), column(&folder, "reason"));
    assert_eq!(statuses.len(), 8);
    assert!(statuses.iter().any(|status| status == "done") && statuses.iter().any(|status| status == "invalid"));
    for (status, reason) in statuses.iter().zip(&reasons) {
        assert_eq!(status == "invalid", reason.contains("miss"), "{status}: {reason}");
    }
}

#[test]
fn budgets_end_rows_not_studies() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path().join("out");
    let mut arguments = vec!["run", "pressure_grid.toml", "--set", "solver.max_steps=500", "--output"];
    arguments.push(folder.to_str().unwrap());
    arguments.extend(QUICK);
    ends(&arguments, ROWS_FAILED);
    assert!(column(&folder, "status").iter().all(|status| status == "budget_exhausted"));
    assert!(column(&folder, "reason").iter().all(|reason| reason.contains("solver.max_steps")));
    assert!(column(&folder, "time_reached_s").iter().all(|time| time.parse::<f64>().unwrap() > 0.0));
}

#[test]
fn a_scene_prints_every_output_by_its_name() {
    let mut arguments = vec!["scene", "paper_rig.toml"];
    arguments.extend(QUICK);
    let text = stdout(&ends(&arguments, DONE));
    arguments.push("--json");
    let json: serde_json::Value = serde_json::from_slice(&ends(&arguments, DONE).stdout).unwrap();
    let metrics = &json["outcome"]["metrics"];
    assert_eq!([&metrics["hammers"][0]["name"], &metrics["blows"][0]["hammer"]], ["hammer", "hammer"]);
    assert_eq!(metrics["castings"][0]["name"], "part");
    for quantity in decore_model::metrics::HammerMetrics::QUANTITIES {
        assert!(text.contains(quantity.name), "{} is not in\n{text}", quantity.name);
        assert!(metrics["hammers"][0].get(quantity.name).is_some(), "{} is not in the JSON", quantity.name);
    }
    let energy = metrics["hammers"][0]["first_impact_energy_j"].as_f64().unwrap();
    assert!((energy - 69.9).abs() < 0.1, "{energy}");
    assert!(text.contains("energy_residual") && text.contains("first impact"));
    assert_eq!(json["outcome"]["status"], "done");
    ends(&["scene", "paper_rig.toml", "--row", "7"], BAD_INPUT);
}

#[test]
fn signals_are_a_parquet_file_with_units() {
    let scratch = TempDir::new().unwrap();
    let file = scratch.path().join("signals.parquet");
    let mut arguments = vec!["scene", "paper_rig.toml", "--signals", file.to_str().unwrap()];
    arguments.extend(QUICK);
    ends(&arguments, DONE);
    let reader = parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder::try_new(fs::File::open(&file).unwrap());
    let builder = reader.unwrap();
    let schema = builder.schema().clone();
    assert_eq!(builder.metadata().file_metadata().num_rows(), 1501, "0 to 0.15 s every 0.1 ms");
    for (name, unit) in [("time_s", "s"), ("hammer_pressure_top_pa", "Pa"), ("part_heave_velocity_m_s", "m/s")] {
        assert_eq!(schema.field_with_name(name).unwrap().metadata()["unit"], unit, "{name}");
    }
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 1, "nothing else is left behind");
}

#[test]
fn init_writes_a_study_that_runs_and_never_overwrites() {
    let scratch = TempDir::new().unwrap();
    let file = scratch.path().join("mine.toml");
    ends(&["init", file.to_str().unwrap()], DONE);
    ends(&["check", file.to_str().unwrap(), "--set", "solver.guide=tied"], DONE);
    let refused = ends(&["init", file.to_str().unwrap()], BAD_INPUT);
    assert!(stderr(&refused).contains("exists and was not changed"), "{}", stderr(&refused));
}

#[test]
fn a_log_has_no_control_characters() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path().join("out");
    let mut arguments = vec!["run", "pressure_grid.toml", "--output", folder.to_str().unwrap()];
    arguments.extend(QUICK);
    let log = stderr(&ends(&arguments, DONE));
    assert!(log.contains("of 8 rows") && log.contains("rows/s"), "{log:?}");
    assert!(log.chars().all(|c| c == '\n' || !c.is_control()), "{log:?}");
}

#[test]
fn a_reader_that_goes_away_causes_no_panic() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_decore"))
        .args(["scene", "paper_rig.toml", "--set", "duration_s=0.01"])
        .current_dir(studies())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_done() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path().join("out");
    let child = Command::new(env!("CARGO_BIN_EXE_decore"))
        .args(["run", "placement.toml", "--set", "solver.guide=tied", "--threads", "1", "--output"])
        .arg(&folder)
        .args(["--set", "design.rows=2000"])
        .current_dir(studies())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A busy machine takes a while to the first row.
    let begin = Instant::now();
    let done = || -> Option<u64> {
        let text = fs::read_to_string(folder.join("status.json")).ok()?;
        serde_json::from_str::<serde_json::Value>(&text).ok()?["rows_done"].as_u64()
    };
    while done().unwrap_or(0) == 0 && begin.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(INTERRUPTED), "{}", stderr(&output));
    let rows = column(&folder, "status").len();
    assert!(rows > 0 && rows < 2000, "{rows} rows");
    assert!(stderr(&output).contains(&format!("{rows} of 2000 rows")), "{}", stderr(&output));
}

/// A study of the paper's rig with one line replaced.
fn altered(scratch: &Path, from: &str, to: &str) -> PathBuf {
    let text = fs::read_to_string(studies().join("paper_rig.toml")).unwrap();
    let text = text.replace("file = \"hammers/default.toml\"\n", "");
    assert!(text.contains(from), "`{from}` is not in the study");
    let path = scratch.join("study.toml");
    fs::File::create(&path).unwrap().write_all(text.replace(from, to).as_bytes()).unwrap();
    path
}

#[test]
fn bad_values_name_file_line_key_and_hint() {
    let scratch = TempDir::new().unwrap();
    let cases: [(&str, &str, &[&str]); 9] = [
        (
            "supply_bar = 5.0",
            "suply_bar = 5.0",
            &["study.toml:", "suply_bar", "unknown key", "did you mean `supply_bar`"],
        ),
        ("standoff_m = 0.085", "standoff_m = \"far\"", &["standoff_m", "expected", "number"]),
        ("mass_kg = 0.517", "mass_kg = -0.517", &["casting.part.mass_kg", "positive"]),
        ("stiffness_n_per_m = 3e7", "stiffness_n_per_m = 0.0", &["stiffness_n_per_m", "positive"]),
        (
            "mount = \"R5\"",
            "mount = \"R55\"",
            &["hammer.hammer.mount", "no interface point `R55`", "did you mean `R5`"],
        ),
        ("standoff_m = 0.085", "standoff_m = nan", &["standoff_m", "NaN"]),
        (
            "[solver]",
            "[design]\nkind = \"latin_hypercube\"\nrows = 3\n[design.factor.p]\npath = \"hammer.hammer.supply_bar\"\nrange = [6.0, 4.0]\n[solver]",
            &["range"],
        ),
        (
            "[solver]",
            "[design]\nkind = \"latin_hypercube\"\nrows = 3\n[design.factor.p]\npath = \"hammer.hammer.suply_bar\"\nrange = [4.0, 6.0]\n[solver]",
            &["suply_bar", "did you mean"],
        ),
        ("duration_s = 1.5", "duration_s = = 1.5", &["study.toml:"]),
    ];
    for (from, to, words) in cases {
        let study = altered(scratch.path(), from, to);
        let folder = scratch.path().join("out");
        let output = ends(&["run", study.to_str().unwrap(), "--output", folder.to_str().unwrap()], BAD_INPUT);
        for word in words {
            assert!(stderr(&output).contains(word), "{to}: no `{word}` in\n{}", stderr(&output));
        }
        assert!(!folder.exists(), "{to}: nothing may be written");
    }
}

/// Text of a Matrix Market file.
fn matrix(kind: &str, size: &str, entries: &str) -> String {
    format!("%%MatrixMarket matrix coordinate real {kind}\n{size}\n{entries}")
}

#[test]
fn bad_matrices_name_file_and_reason() {
    let scratch = TempDir::new().unwrap();
    let good = matrix("symmetric", "6 6 6", "1 1 9\n2 2 9\n3 3 9\n4 4 9\n5 5 9\n6 6 9\n");
    let cut = matrix("symmetric", "6 6 6", "1 1 9\n2 2 9\n3 3 9\n");
    let asymmetric = matrix("general", "6 6 7", "1 1 9\n2 2 9\n3 3 9\n4 4 9\n5 5 9\n6 6 9\n1 2 3\n");
    let oblong = matrix("general", "6 5 1", "1 1 9\n");
    let not_positive = matrix("symmetric", "6 6 6", "1 1 -9\n2 2 9\n3 3 9\n4 4 9\n5 5 9\n6 6 9\n");
    let cases = [
        ("K.mtx", &cut, "K.mtx"),
        ("K.mtx", &asymmetric, "symmetric"),
        ("K.mtx", &oblong, "square"),
        ("M.mtx", &not_positive, "a mass is not negative"),
    ];
    fs::write(
        scratch.path().join("points.csv"),
        "name,role,first_row_0based,x_m,y_m,z_m\nR5,mount,0,0.36,0,1\nT5,fixture,0,0.36,0,0\n",
    )
    .unwrap();
    let source =
        "source = \"matrices\"\nstiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\npoints_file = \"points.csv\"";
    let study = altered(scratch.path(), "source = \"station\"", source);
    for (name, text, word) in cases {
        fs::write(scratch.path().join("K.mtx"), &good).unwrap();
        fs::write(scratch.path().join("M.mtx"), &good).unwrap();
        fs::write(scratch.path().join(name), text).unwrap();
        let folder = scratch.path().join("out");
        let output = ends(&["run", study.to_str().unwrap(), "--output", folder.to_str().unwrap()], BAD_INPUT);
        assert!(stderr(&output).contains(word), "no `{word}` in\n{}", stderr(&output));
        assert!(!folder.exists(), "nothing may be written");
    }
}

#[test]
fn a_modal_table_gives_what_the_matrices_give() {
    let modes_of =
        |path: &std::path::Path| decore_study::engine::Engine::load(path, &[]).unwrap().scene(0).unwrap().modes;
    let scratch = TempDir::new().unwrap();
    let modes = modes_of(&studies().join("paper_rig.toml"));
    let fixture = decore_model::scene::FixtureId { casting: 0, fixture: 0, axis: 0 };
    let points = [decore_model::scene::PointId::Mount { hammer: 0 }, decore_model::scene::PointId::Support(fixture)];
    let mut table = "mode,frequency_hz,damping_ratio,R5.z,T5.z\n".to_owned();
    for (s, omega) in modes.omega_rad_s.iter().enumerate() {
        // A strike points downwards, the table's z upwards.
        let [mount, fixture] = points.map(|point| -modes.shapes[&point][s]);
        let (number, frequency, damping) = (s + 1, omega / std::f64::consts::TAU, modes.damping_ratio[s]);
        table += &format!("{number},{frequency:?},{damping:?},{mount:?},{fixture:?}\n");
    }
    fs::write(scratch.path().join("modes.csv"), table).unwrap();
    let table = "name,role,x_m,y_m,z_m\nR5,mount,0.36,0,1.605\nT5,fixture,0.36,0,0.41\n";
    fs::write(scratch.path().join("points.csv"), table).unwrap();
    let source =
        "source = \"modal_table\"\nmodal_file = \"modes.csv\"\npoints_file = \"points.csv\"\nhousings = \"included\"";
    let modal = altered(scratch.path(), "source = \"station\"", source);
    let read = modes_of(&modal);
    let close = |a: &[f64], b: &[f64]| {
        let largest = a.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14 * largest)
    };
    assert!(close(&modes.omega_rad_s, &read.omega_rad_s) && close(&modes.damping_ratio, &read.damping_ratio));
    points.iter().for_each(|point| assert!(close(&modes.shapes[point], &read.shapes[point])));
    // Rounding of the frequencies may move a step: the outputs then agree as well as the tolerance has them.
    let energies = ["paper_rig.toml", modal.to_str().unwrap()].map(|study| {
        let mut arguments = vec!["scene", study, "--json"];
        arguments.extend(QUICK);
        let json: serde_json::Value = serde_json::from_slice(&ends(&arguments, DONE).stdout).unwrap();
        json["outcome"]["metrics"]["hammers"][0]["first_impact_energy_j"].as_f64().unwrap()
    });
    assert!((energies[0] / energies[1] - 1.0).abs() < 1e-6, "{energies:?}");
}

/// Speed against error of a shipped study, shortened: text, table and plot.
#[test]
fn accuracy_writes_its_table_text_and_plot() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path().join("accuracy");
    let at = folder.to_str().unwrap();
    let set = ["--set", "duration_s=0.06", "--set", "structure.cutoff_hz=100"];
    let mut arguments = vec!["accuracy", "paper_rig.toml", "--repeats", "1", "--full-cutoff-hz", "300", "--output", at];
    arguments.extend(set);
    let output = ends(&arguments, DONE);
    let words = stdout(&output);
    assert!(words.contains("standard") && words.contains("modes left out") && words.contains(at), "{words}");
    let text = fs::read_to_string(folder.join("accuracy.txt")).unwrap();
    assert!(words.contains(text.trim()));
    assert!(fs::read_to_string(folder.join("accuracy.svg")).unwrap().contains("ms per simulated second"));
    assert!(fs::metadata(folder.join("accuracy.parquet")).unwrap().len() > 1000);
    let missing = ends(&["accuracy", "paper_rig.toml", "--row", "7"], BAD_INPUT);
    assert!(stderr(&missing).contains("--row is 7"));
}
