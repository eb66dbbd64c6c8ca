//! Surrogates of datasets by the command: rows that fail, predictions, files that were damaged, NumPy beside decore.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use decore_dataset::DatasetReader;
use decore_lab::surrogate::{SurrogateSettings, fit, write};
use serde_json::Value;
use tempfile::TempDir;

use crate::growth::{FACTORS, MACHINE};
use crate::sweeps::decore;

const OUTPUTS: [&str; 3] = ["--outputs", "delivered_work_j", "left_hit_frequency_hz"];

struct Dataset {
    scratch: TempDir,
}

impl Dataset {
    /// A dataset of made-up rows, some of which fail.
    fn new(rows: u64) -> Self {
        let design = format!("kind = \"latin_hypercube\"\nrows = {rows}\nseed = 3");
        Self::of(&format!("{MACHINE}\n[design]\n{design}\n{FACTORS}"), "")
    }

    /// One of this study, which may read the rows `given.csv`.
    fn of(study: &str, given: &str) -> Self {
        let dataset = Self { scratch: TempDir::new().expect("scratch folder") };
        fs::write(dataset.file("given.csv"), given).expect("rows");
        fs::write(dataset.file("study.toml"), study).expect("study");
        let mut command = decore();
        command.current_dir(dataset.scratch.path()).args([
            "run",
            "study.toml",
            "--output",
            "out",
            "--stub-row-ms",
            "0",
        ]);
        let output = command.output().expect("runs");
        assert!(matches!(output.status.code(), Some(0 | 4)), "{}", text(&output.stderr));
        dataset
    }

    fn file(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    fn surrogate(&self, arguments: &[&str]) -> Output {
        let mut command = decore();
        command.current_dir(self.scratch.path()).args(["surrogate", "out"]).args(arguments);
        command.output().expect("runs")
    }

    fn predict(&self, model: &str, table: &str) -> Output {
        let mut command = decore();
        command.current_dir(self.scratch.path()).args([
            "predict",
            model,
            table,
            "--output",
            "predicted.parquet",
            "--replace",
        ]);
        command.output().expect("runs")
    }

    /// Holds what NumPy predicts of a table to the predictions that are there.
    fn holds_numpy_to(&self, table: &str) {
        let Some(python) = std::env::var_os("DECORE_PYTHON") else {
            eprintln!("DECORE_PYTHON is not set: the NumPy predictor was not tried");
            return;
        };
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/predicted_alike.py");
        let mut command = Command::new(python);
        command.current_dir(self.scratch.path()).arg(script);
        let output = command.args(["predict.py", "model.parquet", table, "predicted.parquet"]).output();
        let output = output.expect("interpreter started");
        assert!(output.status.success(), "{table}: {}", text(&output.stderr));
        eprintln!("{}", text(&output.stdout).trim_end());
    }

    /// A table of places, the last of which lies outside.
    fn table(&self) -> &'static str {
        let place = |row: u32| {
            let share = f64::from(row) / 99.0;
            let guide = if row.is_multiple_of(3) { "tied" } else { "spring" };
            format!("{},{},{guide}\n", -0.1 + 0.2 * share, 4.0 + 2.0 * (7.3 * share).fract())
        };
        let rows: String = (0..100).map(place).collect();
        fs::write(self.file("rows.csv"), format!("position,factor_pressure,guide\n{rows}0.2,5,tied\n")).expect("rows");
        "rows.csv"
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn failed_rows_are_left_out_and_outputs_without_a_model_say_why() {
    let dataset = Dataset::new(700);
    let constant = ["--outputs", "delivered_work_j", "left_contact_count", "left_arm_rms_steady_m_s", "--json"];
    let output = dataset.surrogate(&constant);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let [work, count, steady] = [0, 1, 2].map(|place| &found["outputs"][place]);
    assert!(work["used"].as_u64().is_some_and(|used| used < 700), "{work}");
    assert!(work["left_out"][0]["reason"].as_str().is_some_and(|reason| reason.contains(": ")), "{work}");
    assert!(work["success"]["share"].as_f64().is_some_and(|share| share > 0.9 && share < 1.0), "{work}");
    assert!(count["refused"].as_str().is_some_and(|why| why.contains("constant (30)")), "{count}");
    assert!(steady["refused"].as_str().is_some_and(|why| why.contains("0 different rows are too few")), "{steady}");
    let shown = text(&dataset.surrogate(&OUTPUTS).stdout);
    for expected in ["FROM 69", "Gaussian process    Q2 ", "noise  ", "polynomial chaos", "success  "] {
        assert!(shown.contains(expected), "{expected} in\n{shown}");
    }
    let twice = dataset.surrogate(&["--outputs", "delivered_work_j", "delivered_work_j"]);
    assert_eq!(twice.status.code(), Some(2), "{}", text(&twice.stderr));
}

#[test]
fn a_poor_model_warns_when_it_is_made_and_when_it_is_used() {
    let dataset = Dataset::new(60);
    let strict = [&OUTPUTS[..], &["--least-q2", "1", "--output", "model.parquet"]].concat();
    let made = dataset.surrogate(&strict);
    assert!(made.status.success() && text(&made.stderr).contains("do not rely on it"), "{}", text(&made.stderr));
    let used = dataset.predict("model.parquet", dataset.table());
    let told = text(&used.stderr);
    assert!(used.status.success() && told.contains("do not rely on it"), "{told}");
    assert!(told.contains("1 of 101 rows lie outside the ranges"), "{told}");
}

#[test]
fn bytes_are_the_same_for_any_number_of_threads() {
    let dataset = Dataset::new(120);
    let bytes = |threads: &str| {
        let mut command = decore();
        command.current_dir(dataset.scratch.path()).env("RAYON_NUM_THREADS", threads).args([
            "surrogate",
            "out",
            "--json",
        ]);
        let output = command.args(OUTPUTS).args(["--output", "model.parquet", "--replace"]).output().expect("runs");
        assert!(output.status.success(), "{}", text(&output.stderr));
        let predicted = dataset.predict("model.parquet", dataset.table());
        assert!(predicted.status.success(), "{}", text(&predicted.stderr));
        let files = ["model.parquet", "predicted.parquet"].map(|file| fs::read(dataset.file(file)).expect("written"));
        (output.stdout, files)
    };
    assert!(bytes("1") == bytes("2"), "threads change bytes");
}

#[test]
fn the_library_writes_a_model_over_nothing_of_a_dataset() {
    let dataset = Dataset::new(60);
    let reader = DatasetReader::open(&dataset.file("out")).expect("a dataset");
    let settings = SurrogateSettings { outputs: vec!["delivered_work_j".to_owned()], ..SurrogateSettings::default() };
    let model = fit(&reader, &settings).expect("a model");
    let refused = [
        ("out/runs/runs-000000000000.parquet", "keeps its own files"),
        ("out/blows/new.parquet", "keeps its own files"),
        ("out/manifest.json", "a file name that ends in `.parquet`"),
        ("study.toml", "a file name that ends in `.parquet`"),
        ("out", "is a folder"),
    ];
    for (name, words) in refused {
        let before = fs::read(dataset.file(name)).ok();
        let said = write(&model, &dataset.file(name)).expect_err("refused").to_string();
        assert!(said.contains(words), "{name}: {said}");
        assert!(before == fs::read(dataset.file(name)).ok(), "{name} was written");
    }
    write(&model, &dataset.file("out/model.parquet")).expect("beside what is the dataset's own");
}

#[test]
fn damaged_models_and_wrong_tables_are_errors() {
    let dataset = Dataset::new(60);
    assert!(dataset.surrogate(&[&OUTPUTS[..], &["--output", "model.parquet"]].concat()).status.success());
    let whole = fs::read(dataset.file("model.parquet")).expect("a model");
    let table = dataset.table();
    let refused = |bytes: &[u8]| {
        fs::write(dataset.file("damaged.parquet"), bytes).expect("written");
        let output = dataset.predict("damaged.parquet", table);
        let told = text(&output.stderr);
        assert!(output.status.code() == Some(2) && told.contains("not a usable model"), "{told}");
    };
    for cut in [0, 3, 200, whole.len() / 2, whole.len() - 1] {
        refused(&whole[..cut]);
    }
    for place in (0..whole.len()).step_by(whole.len() / 40) {
        let mut edited = whole.clone();
        edited[place] ^= 0x11;
        refused(&edited);
    }
    for (rows, expected) in [
        ("position,pressure\n0,5\n", "has no column `guide`"),
        ("position,pressure,guide\n0,much,tied\n", "line 2, column `pressure`: `much` is no number"),
        ("position,pressure,guide\n0,5,loose\n", "none of the names that the model knows: `spring`, `tied`"),
        ("position,pressure,guide\n", "has no rows"),
    ] {
        fs::write(dataset.file("wrong.csv"), rows).expect("written");
        let output = dataset.predict("model.parquet", "wrong.csv");
        let told = text(&output.stderr);
        assert!(output.status.code() == Some(2) && told.contains(expected), "{told}");
    }
}

#[test]
fn a_model_that_predicts_nothing_is_neither_written_nor_used() {
    let dataset = Dataset::new(60);
    let refused = |output: Output, words: &[&str]| {
        let told = text(&output.stderr);
        assert!(output.status.code() == Some(2) && words.iter().all(|word| told.contains(word)), "{told}");
        assert!(!dataset.file("predicted.parquet").exists() && output.stdout.is_empty(), "{}", text(&output.stdout));
    };
    let unusable = ["--outputs", "left_contact_count", "left_arm_rms_steady_m_s", "--output", "model.parquet"];
    let words = ["no output has a model", "constant (30)", "0 different rows are too few"];
    refused(dataset.surrogate(&unusable), &words);
    refused(dataset.surrogate(&unusable[..3]), &words);
    assert!(!dataset.file("model.parquet").exists() && !dataset.file("predict.py").exists());
    let settings = SurrogateSettings { outputs: vec![unusable[1].to_owned()], ..SurrogateSettings::default() };
    let model = fit(&DatasetReader::open(&dataset.file("out")).expect("a dataset"), &settings).expect("figures");
    assert!(write(&model, &dataset.file("model.parquet")).is_err_and(|error| error.to_string().contains(words[1])));
    // One that an earlier version wrote, and files that are no models.
    let empty = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables/empty_model.parquet");
    fs::write(dataset.file("rows.csv"), "pressure\n4.5\n").expect("rows");
    refused(dataset.predict(empty.to_str().expect("a path"), "rows.csv"), &["not a usable model"]);
    for foreign in ["out/runs/runs-000000000000.parquet", "out/manifest.json", "rows.csv"] {
        refused(dataset.predict(foreign, "rows.csv"), &["not a usable model"]);
    }
    // A model of other factors than the table has.
    assert!(dataset.surrogate(&[&OUTPUTS[..], &["--output", "model.parquet"]].concat()).status.success());
    refused(dataset.predict("model.parquet", "rows.csv"), &["has no column `position`"]);
}

/// A factor of few values is told wherever models are: rows left out lie on values that others have.
#[test]
fn few_values_and_names_that_no_row_has_are_told() {
    let factors = |more: &str| FACTORS.replace("[4.0, 6.0]\n", &format!("[4.0, 6.0]\n{more}"));
    let grid = "\n[design]\nkind = \"full_factorial\"\n";
    let levels = factors("levels = 4\n").replace("[-0.10, 0.10]\n", "[-0.10, 0.10]\nlevels = 5\n");
    let grid = Dataset::of(&format!("{MACHINE}{grid}{levels}"), "");
    let notes = |dataset: &Dataset| {
        let shown = dataset.surrogate(&["--outputs", "delivered_work_j", "--json"]);
        let found: Value = serde_json::from_slice(&shown.stdout).expect("JSON");
        found["notes"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|note| note.as_str().expect("a text").to_owned())
            .collect()
    };
    let told: Vec<String> = notes(&grid);
    assert!(told.len() == 1 && told[0].contains("few values of `position` (5), `pressure` (4). "), "{told:?}");
    assert!(text(&grid.surrogate(&["--outputs", "delivered_work_j"]).stdout).contains(&told[0]));
    let mut report = decore();
    report.current_dir(grid.scratch.path()).args(["report", "out", "--html", "page.html"]);
    assert!(report.output().expect("runs").status.success());
    let page = fs::read_to_string(grid.file("page.html")).expect("a page");
    assert!(page.contains("few values of `position` (5)"));
    assert_eq!(notes(&Dataset::new(60)), Vec::<String>::new());

    let given: String =
        (0..20).map(|row| format!("{},{},tied\n", 0.01 * f64::from(row - 10), 4.0 + 0.1 * f64::from(row))).collect();
    let table = "\n[design]\nkind = \"table\"\nfile = \"given.csv\"\n";
    let one = Dataset::of(&format!("{MACHINE}{table}{FACTORS}"), &format!("position,pressure,guide\n{given}"));
    let told: Vec<String> = notes(&one);
    assert!(told.len() == 1 && told[0].starts_with("None of the used rows has `spring` of `guide`: "), "{told:?}");
}

/// Names may look like numbers, or like nothing, and begin with anything; tables of datasets have them with a letter first.
#[test]
fn names_that_look_like_numbers_are_found_in_any_table() {
    let castings =
        |text: &str| ["103", "NA"].map(|name| text.replace("casting.part", &format!("casting.{name}"))).concat();
    let (before, casting) = MACHINE.split_once("[casting.part]").expect("a casting");
    let hammer = before.replace("[hammer.left]\n", "[hammer.left]\ncasting = \"103\"\n");
    let machine = format!("{hammer}{}", castings(&format!("[casting.part]{casting}")));
    let factors = FACTORS.replace("factor.position", "factor.103").replace("factor.pressure", "factor.-a_b-");
    let factors = factors.replace("factor.guide", "factor.1e3").replace("solver.guide", "hammer.left.casting");
    let factors = factors.replace("[\"spring\", \"tied\"]", "[\"103\", \"NA\"]");
    let dataset =
        Dataset::of(&format!("{machine}\n[design]\nkind = \"latin_hypercube\"\nrows = 60\nseed = 3\n{factors}"), "");
    let mut design = decore();
    design.current_dir(dataset.scratch.path()).args(["design", "study.toml", "--output", "rows.csv"]);
    assert!(design.output().expect("runs").status.success());
    let outputs = ["--outputs", "delivered_work_j", "casting_103_peak_velocity_m_s", "--output", "model.parquet"];
    let made = dataset.surrogate(&outputs);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let mut bytes = Vec::new();
    for table in ["rows.csv", "out/runs/runs-000000000000.parquet", "named.parquet"] {
        let output = dataset.predict("model.parquet", table);
        assert!(output.status.success(), "{table}: {}", text(&output.stderr));
        bytes.push(fs::read(dataset.file("predicted.parquet")).expect("predictions"));
        dataset.holds_numpy_to(table);
        fs::copy(dataset.file("predicted.parquet"), dataset.file("named.parquet")).expect("copied");
    }
    assert!(bytes[0] == bytes[2] && bytes[0] == bytes[1], "a table's names change what is predicted");
}

#[test]
fn numpy_predicts_the_same() {
    let dataset = Dataset::new(700);
    assert!(dataset.surrogate(&[&OUTPUTS[..], &["--output", "model.parquet"]].concat()).status.success());
    assert!(dataset.predict("model.parquet", dataset.table()).status.success());
    // The same rows as they were given, and with the names of their columns as Parquet.
    dataset.holds_numpy_to(dataset.table());
    dataset.holds_numpy_to("predicted.parquet");
}

/// Fault 10: each factor is covered there, and no row is near.
#[test]
fn empty_corners_of_a_correlated_design_are_extrapolated() {
    let correlation = "[design.correlation]\nfactors = [\"position\", \"pressure\"]\nmatrix = [[1.0, 0.9], [0.9, 1.0]]";
    let design = "kind = \"latin_hypercube\"\nrows = 60\nseed = 3";
    let dataset = Dataset::of(&format!("{MACHINE}\n[design]\n{design}\n{correlation}\n{FACTORS}"), "");
    assert!(dataset.surrogate(&[&OUTPUTS[..], &["--output", "model.parquet"]].concat()).status.success());
    let rows = "-0.08,5.8,tied\n0.08,4.2,spring\n-0.05,4.5,tied\n0.0,5.0,spring\n0.05,5.5,tied\n";
    fs::write(dataset.file("corners.csv"), format!("position,pressure,guide\n{rows}")).expect("rows");
    let used = dataset.predict("model.parquet", "corners.csv");
    let told = text(&used.stderr);
    assert!(used.status.success() && told.contains("2 of 5 rows lie outside"), "{told}");
    dataset.holds_numpy_to("corners.csv");
}

/// A model file of runs at one place that differ, as made-up rows do.
#[test]
fn numpy_predicts_the_same_of_runs_at_one_place() {
    let place = |row: u32| {
        let place = row % 30;
        format!("{},{},tied\n", -0.1 + 0.2 * f64::from(place) / 29.0, 4.0 + 2.0 * (f64::from(place) * 0.618).fract())
    };
    let given: String = (0..90).map(place).collect();
    let table = "\n[design]\nkind = \"table\"\nfile = \"given.csv\"\n";
    let dataset = Dataset::of(&format!("{MACHINE}{table}{FACTORS}"), &format!("position,pressure,guide\n{given}"));
    let output = dataset.surrogate(&["--outputs", "delivered_work_j", "--output", "model.parquet", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let process = &found["outputs"][0]["process"];
    assert_eq!((process["places"].as_u64(), process["run_freedom"].as_f64()), (Some(30), Some(60.0)), "{process}");
    assert!(process["spread"].as_f64().is_some_and(|spread| spread > 0.0), "{process}");
    assert!(dataset.predict("model.parquet", dataset.table()).status.success());
    dataset.holds_numpy_to(dataset.table());
}
