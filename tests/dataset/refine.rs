//! `decore refine`: rows that are added to a table, the same whatever happened meanwhile.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use decore_dataset::{DatasetReader, TableName};
use decore_quantity::Cell;
use serde_json::Value;
use tempfile::TempDir;

use crate::growth::MACHINE;
use crate::sweeps::{assert_same, decore, errors, expect_code};

/// A constraint that only some of the range meets.
const FACTORS: &str = r#"
constraints = ["pressure + 10 * position <= 5.5"]
[design.factor.position]
path = "hammer.left.rail_position_m"
range = [-0.10, 0.10]
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
"#;
/// Rows before any is added.
const START: usize = 10;
/// What `refine` ends with where a row of the study fails, as `run` does: one of the first rows of [`Study::new`] misses its casting.
const FAILED: i32 = 4;

struct Study {
    scratch: TempDir,
}

impl Study {
    /// A study of a table of rows, which `decore design` wrote.
    fn new() -> Self {
        Self::of(&format!("kind = \"latin_hypercube\"\nrows = {START}"), FACTORS)
    }

    /// One whose first rows are of a kind of design, and its factors.
    fn of(kind: &str, factors: &str) -> Self {
        let study = Self { scratch: TempDir::new().expect("scratch folder") };
        let write = |name: &str, design: &str| {
            let text = format!("duration_s = 0.1\n{MACHINE}\n[design]\nseed = 5\n{design}\n{factors}");
            fs::write(study.file(name), text).expect("study");
        };
        write("start.toml", kind);
        write("study.toml", "kind = \"table\"\nfile = \"rows.csv\"");
        let mut design = decore();
        design.current_dir(study.scratch.path()).args(["design", "start.toml", "--output", "rows.csv"]);
        expect_code(design, 0);
        study
    }

    fn file(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    fn refine(&self, arguments: &[&str]) -> Command {
        let mut command = decore();
        command.current_dir(self.scratch.path()).args(["refine", "study.toml", "--output", "out"]).args(arguments);
        command
    }

    fn learn(&self, most_rows: &str) -> Command {
        self.refine(&["--learn", "delivered_work_j", "--until-q2", "0.9999", "--most-rows", most_rows, "--json"])
    }

    fn rows(&self) -> String {
        fs::read_to_string(self.file("rows.csv")).expect("rows")
    }

    /// The numbers of each row, its index left out.
    fn values(&self) -> Vec<Vec<f64>> {
        let rows = self.rows();
        let number = |cell: &str| cell.parse().expect("a number");
        rows.lines().skip(1).map(|line| line.split(',').skip(1).map(number).collect()).collect()
    }
}

/// What a command prints that ends with this code.
fn text(command: Command, code: i32) -> String {
    String::from_utf8_lossy(&expect_code(command, code).stdout).into_owned()
}

/// Runs a command that ends well; rows may fail.
fn expect_end(command: &mut Command) {
    let output = command.output().expect("runs");
    assert!(matches!(output.status.code(), Some(0 | 4)), "{}", errors(&output));
}

fn progress(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn rows_are_the_same_after_a_kill_and_a_pause_and_meet_the_constraints() {
    let whole = Study::new();
    let first = whole.rows();
    let ended = progress(&expect_code(whole.learn("19"), FAILED));
    assert_eq!(ended["rows"], 18, "no batch goes beyond the budget");
    assert!(whole.rows().starts_with(&first));
    for line in whole.rows().lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        assert!(cells[2] + 10.0 * cells[1] <= 5.5, "{line}");
    }

    let paused = Study::new();
    expect_code(paused.learn("14"), FAILED);
    assert_eq!(paused.rows().lines().count(), 1 + START + 4);
    expect_code(paused.learn("18"), FAILED);
    assert_eq!(paused.rows(), whole.rows());
    assert_same(&paused.file("out"), &whole.file("out"));

    let killed = Study::new();
    let mut child = killed.learn("18").spawn().expect("starts");
    let begun = Instant::now();
    while killed.rows().lines().count() == 1 + START && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    expect_code(killed.learn("18"), FAILED);
    assert_eq!(killed.rows(), whole.rows());
    assert_same(&killed.file("out"), &whole.file("out"));
}

#[test]
fn it_ends_where_the_target_is_reached_and_finds_better_rows_within_a_limit() {
    let study = Study::new();
    let learn = ["--learn", "delivered_work_j", "--until-q2", "0.01", "--most-rows", "60", "--json"];
    let ended = progress(&expect_code(study.refine(&learn), FAILED));
    assert_eq!(ended["reached"], true);
    assert!(ended["outputs"][0]["q2"].as_f64().expect("Q2") >= 0.01 && ended["rows"].as_u64().expect("rows") < 60);

    let rows = ended["rows"].as_u64().expect("rows");
    let best = |most: u64| {
        let most = most.to_string();
        let goal = ["--maximise", "delivered_work_j", "--limit", "max_casting_point_velocity_m_s<=1000", "--json"];
        progress(&expect_code(study.refine(&[&goal[..], &["--most-rows", &most]].concat()), FAILED))["best"].clone()
    };
    let (before, after) = (best(rows), best(rows + 8));
    assert!(after["value"].as_f64() > before["value"].as_f64(), "{before} {after}");
}

/// One figure for one thing: what `refine` tells of its models is what `surrogate` and `predict` tell of the same rows.
#[test]
fn what_it_tells_of_models_is_what_surrogate_tells() {
    let study = Study::new();
    let ended = |goal: &[&str]| {
        progress(&expect_code(study.refine(&[goal, &["--most-rows", "18", "--json"]].concat()), FAILED))
    };
    for goal in [&["--maximise", "delivered_work_j"][..], &["--learn", "delivered_work_j", "--until-q2", "0.999999"]] {
        let told = ended(goal);
        let mut surrogate = decore();
        surrogate.current_dir(study.scratch.path()).args(["surrogate", "out", "--output", "model.parquet", "--json"]);
        surrogate.args(["--replace", "--outputs", "delivered_work_j"]);
        let process = progress(&expect_code(surrogate, 0))["outputs"][0]["process"].clone();
        let least = process["q2"].as_f64().expect("Q2").min(process["q2_folds"].as_f64().expect("Q2"));
        assert_eq!(told["outputs"][0]["q2"].as_f64(), Some(least), "{goal:?}");
        if told["best"].is_null() {
            continue;
        }
        let model = decore_lab::surrogate::read(&study.file("model.parquet")).expect("a model");
        let predicted = decore_lab::surrogate::predict(&model, &study.file("rows.csv")).expect("predictions");
        let column = predicted.columns.iter().find(|column| column.name == "delivered_work_j").expect("a column");
        let expected = column.values.number(told["best"]["row"].as_u64().expect("a row") as usize).expect("a number");
        let own = told["best"]["expected"].as_f64().expect("a number");
        assert!((own - expected).abs() < 1e-9 * expected.abs(), "{own} {expected}");
    }
}

#[test]
fn rows_at_peaks_meet_the_constraints_and_are_the_same_after_a_pause() {
    let maximise = |study: &Study, most: &str| {
        let goal = ["--maximise", "delivered_work_j", "--most-rows", most, "--json"];
        progress(&expect_code(study.refine(&goal), FAILED))
    };
    let whole = Study::new();
    let ended = maximise(&whole, "18");
    assert!(ended["gain"].as_f64().is_some_and(|gain| gain >= 0.0), "{ended}");
    let rows = whole.rows();
    assert_eq!(rows.lines().count(), 1 + START + 8);
    for line in rows.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        assert!(cells[2] + 10.0 * cells[1] <= 5.5 && (4.0..=6.0).contains(&cells[2]), "{line}");
        assert_eq!(rows.lines().filter(|other| *other == line).count(), 1, "{line}");
    }
    let paused = Study::new();
    maximise(&paused, "14");
    maximise(&paused, "18");
    assert_eq!(paused.rows(), rows);
    assert_same(&paused.file("out"), &whole.file("out"));
}

#[test]
fn rows_stay_where_a_distribution_without_ends_has_rows() {
    let normal = FACTORS.replace("range = [4.0, 6.0]", "distribution = \"normal\"\nmean = 5.0\nstd_dev = 0.1");
    let study = Study::of(&format!("kind = \"sobol\"\nrows = {START}"), &normal);
    expect_code(study.refine(&["--maximise", "delivered_work_j", "--most-rows", "18"]), 0);
    let values = study.values();
    assert_eq!(values.len(), START + 8);
    // 3.2905 standard deviations to either side.
    assert!(values.iter().all(|row| (row[1] - 5.0).abs() < 0.3291), "{values:?}");
}

#[test]
fn no_row_that_is_added_is_a_copy() {
    let study = Study::new();
    expect_code(study.refine(&["--maximise", "delivered_work_j", "--most-rows", "34"]), FAILED);
    let values = study.values();
    assert_eq!(values.len(), START + 24);
    for (row, own) in values.iter().enumerate().skip(START) {
        for (other, earlier) in values[..row].iter().enumerate() {
            // Batches of four.
            let share = if other >= row - (row - START) % 4 { 0.05 } else { 1e-3 };
            let away = [(0, 0.2), (1, 2.0)].map(|(factor, range)| (own[factor] - earlier[factor]).abs() / range);
            assert!(away.iter().any(|away| *away > 0.999 * share), "{row} {own:?}, {other} {earlier:?}");
        }
    }
}

#[test]
fn a_table_is_refined_by_one_at_a_time() {
    let study = Study::new();
    let words = study.file("words");
    let mut first = study.learn("400");
    first.stderr(fs::File::create(&words).expect("a file"));
    let mut first = first.spawn().expect("starts");
    let begun = Instant::now();
    while study.rows().lines().count() == 1 + START && begun.elapsed() < Duration::from_secs(120) {
        let ended = first.try_wait().expect("known");
        assert_eq!(ended, None, "before it added a row: {}", fs::read_to_string(&words).expect("words"));
        std::thread::sleep(Duration::from_millis(2));
    }
    for folder in ["out", "other"] {
        let mut second = decore();
        second.current_dir(study.scratch.path()).args(["refine", "study.toml", "--output", folder]);
        second.args(["--learn", "delivered_work_j", "--most-rows", "400"]);
        let text = errors(&expect_code(second, 7));
        assert!(text.contains("rows.csv is being written by another decore (process "), "{text}");
        assert!(!study.file("other").exists());
    }
    first.kill().expect("killed");
    first.wait().expect("ended");
    let rows = study.rows().lines().count() - 1;
    expect_code(study.learn(&rows.to_string()), FAILED);
    assert_eq!(study.rows().lines().count() - 1, rows);
    assert!(!study.file(".rows.csv.lock").exists());
}

#[test]
fn it_ends_well_where_all_combinations_are_rows() {
    let factors = r#"
[design.factor.position]
path = "hammer.left.rail_position_m"
values = [-0.06, 0.0, 0.06]
[design.factor.pressure]
path = "hammer.left.supply_bar"
values = [4.0, 4.5, 5.0, 5.5]
"#;
    let goals: [&[&str]; 3] = [
        &["--maximise", "delivered_work_j"],
        &["--learn", "delivered_work_j", "--until-width", "delivered_work_j=1e-9"],
        &["--boundary", "delivered_work_j<=60", "--until-unsure", "1e-9"],
    ];
    for goal in goals {
        let study = Study::of("kind = \"full_factorial\"", factors);
        let first: Vec<String> = study.rows().lines().take(10).map(str::to_owned).collect();
        fs::write(study.file("rows.csv"), first.join("\n") + "\n").expect("rows");
        let text = text(study.refine(&[goal, &["--most-rows", "40"]].concat()), 0);
        assert_eq!(study.values().len(), 12, "{text}");
        assert!(text.starts_with("all places that may be run are rows already, or next to one: 12 rows"), "{text}");
        assert_eq!(text.contains("best row "), goal[0] == "--maximise", "{text}");
        let ended = progress(&expect_code(study.refine(&[goal, &["--most-rows", "40", "--json"]].concat()), 0));
        assert!(ended["exhausted"] == true && ended["reached"] == false, "{ended}");
    }
}

#[test]
fn a_constant_column_needs_no_model_and_it_is_said_where_no_row_is_within_the_limits() {
    let study = Study::new();
    let limited = |limit: &str, rows: &str| {
        text(study.refine(&["--maximise", "delivered_work_j", "--limit", limit, "--most-rows", rows]), FAILED)
    };
    let holds = limited("solver_retries<=1", "14");
    assert!(holds.contains("solver_retries: 0 in all rows that have it") && holds.contains("best row "), "{holds}");
    assert!(!holds.contains("no row is within"), "{holds}");
    for limit in ["solver_retries>=1", "max_casting_point_velocity_m_s<=1e-9"] {
        let broken = limited(limit, "14");
        assert!(broken.contains("no row is within all limits") && !broken.contains("best row "), "{broken}");
    }
    let known = text(study.refine(&["--learn", "solver_retries", "--most-rows", "14"]), FAILED);
    assert!(known.starts_with("the goal is reached"), "{known}");
    let bound = text(study.refine(&["--boundary", "solver_retries<=1", "--most-rows", "14"]), FAILED);
    assert!(bound.contains("within the limit 100.0 % of the places that meet the constraints"), "{bound}");
    let none = errors(&expect_code(study.refine(&["--maximise", "solver_retries", "--most-rows", "14"]), 2));
    assert!(none.contains("it is 0 in all rows that have it"), "{none}");
}

#[test]
fn shards_of_a_batch_give_the_same_rows_and_bytes() {
    let whole = Study::new();
    expect_code(whole.learn("18"), FAILED);
    let sharded = Study::new();
    for [shard, folder] in [["1/2", "first"], ["2/2", "second"]] {
        let mut run = decore();
        run.current_dir(sharded.scratch.path());
        expect_end(run.args(["run", "study.toml", "--shard", shard, "--output", folder]));
    }
    let mut merge = decore();
    merge.current_dir(sharded.scratch.path());
    expect_end(merge.args(["merge", "first", "second", "--output", "out"]));
    expect_code(sharded.learn("18"), FAILED);
    assert_eq!(sharded.rows(), whole.rows());
    assert_same(&sharded.file("out"), &whole.file("out"));
}

#[test]
fn it_ends_where_intervals_are_narrow_or_no_run_improves_and_seeks_the_boundary() {
    let study = Study::new();
    let learn = |width: &str| {
        let width = format!("delivered_work_j={width}");
        let goal = ["--learn", "delivered_work_j", "--until-width", &width, "--most-rows", "14", "--json"];
        progress(&expect_code(study.refine(&goal), FAILED))
    };
    let wide = learn("1000");
    assert!(wide["reached"] == true && wide["rows"] == START, "{wide}");
    let narrow = learn("1e-9");
    assert!(narrow["reached"] == false && narrow["rows"] == START + 4, "{narrow}");

    let optimum = ["--maximise", "delivered_work_j", "--until-gain", "1000", "--most-rows", "60", "--json"];
    let optimum = progress(&expect_code(study.refine(&optimum), FAILED));
    assert!(optimum["reached"] == true && optimum["rows"] == START + 4, "{optimum}");

    // Half of the rows lie on either side.
    let value = middle(&study);
    let limit = format!("delivered_work_j<={value}");
    let bound = |most_rows: &str| {
        let goal = ["--boundary", &limit, "--until-unsure", "1e-9", "--most-rows", most_rows, "--json"];
        progress(&expect_code(study.refine(&goal), FAILED))["boundary"].clone()
    };
    let (before, after) = (bound("14"), bound("26"));
    let [before, unsure] = [&before, &after].map(|found| found["unsure"].as_f64().expect("a share"));
    assert!(unsure < 0.7 * before, "{before} {unsure}");
    assert!(after["within"].as_f64().is_some_and(|within| within > 0.2 && within < 0.8), "{after}");
    // The rows added lie nearer to it than those before.
    let off: Vec<f64> = works(&study).into_iter().map(|work| (work - value).abs()).collect();
    let mean = |off: &[f64]| off.iter().sum::<f64>() / off.len() as f64;
    let (first, last) = (&off[..START - 1], &off[off.len() - 12..]);
    assert!(mean(last) < 0.6 * mean(first), "{off:?}");
}

/// What each row delivers that is done.
fn works(study: &Study) -> Vec<f64> {
    let reader = DatasetReader::open(&study.file("out")).expect("dataset");
    let mut works = Vec::new();
    let visit = |cells: &[Cell<'_>]| works.extend(cells[0].and_then(|value| value.number()));
    reader.visit(TableName::Runs, &["delivered_work_j"], visit).expect("read");
    works
}

/// The middle of what the rows deliver.
fn middle(study: &Study) -> f64 {
    let mut works = works(study);
    works.sort_by(f64::total_cmp);
    0.5 * (works[works.len() / 2 - 1] + works[works.len() / 2])
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let study = Study::new();
    let mut other = decore();
    other.current_dir(study.scratch.path());
    other.args(["refine", "start.toml", "--learn", "delivered_work_j", "--most-rows", "20"]);
    assert!(errors(&expect_code(other, 2)).contains("kind = \"table\""));
    let text = errors(&expect_code(
        study.refine(&["--maximise", "delivered_work_j", "--limit", "air<1", "--most-rows", "20"]),
        2,
    ));
    assert!(text.contains("NAME<=VALUE"), "{text}");
    for (arguments, expected) in [
        (["--maximise", "delivered_wrk_j"], "did you mean `delivered_work_j`?"),
        (["--minimise", "status"], "holds text, expected numbers"),
        (["--learn", "left_arm_rms_steady_m_s"], "cannot be predicted"),
    ] {
        let text = errors(&expect_code(study.refine(&[&arguments[..], &["--most-rows", "20"]].concat()), 2));
        assert!(text.contains(expected), "{text}");
    }
    assert_eq!(study.rows().lines().count(), 1 + START);
}

#[test]
fn what_is_a_mistake_is_refused_before_rows_are_run() {
    let study = Study::new();
    for (arguments, expected) in [
        (&["--learn", "delivered_work_j", "--most-rows", "9"][..], "--most-rows 9: "),
        (&["--learn", "delivered_work_j", "--most-rows", "9"], "rows.csv has 10 rows already"),
        (
            &["--learn", "delivered_work_j", "delivered_work_j", "--most-rows", "20"],
            "--learn names delivered_work_j twice",
        ),
    ] {
        let text = errors(&expect_code(study.refine(arguments), 2));
        assert!(text.contains(expected), "{text}");
    }
    assert!(!study.file("out").exists());
}

#[test]
fn rows_are_added_where_rows_fail_on_either_side_and_the_same_after_a_pause() {
    let study = Study::new();
    // Half of the rows need more steps than this.
    let mut run = decore();
    expect_end(run.current_dir(study.scratch.path()).args(["run", "study.toml", "--output", "all"]));
    let mut steps: Vec<u64> = Vec::new();
    let reader = DatasetReader::open(&study.file("all")).expect("dataset");
    let visit = |cells: &[Cell<'_>]| steps.extend(cells[0].and_then(|value| value.number()).map(|steps| steps as u64));
    reader.visit(TableName::Runs, &["solver_steps"], visit).expect("read");
    steps.sort_unstable();
    let most = format!("solver.max_steps={}", steps[START / 2]);
    let refine = |study: &Study, rows: &str| {
        let goal = ["--failures", "--until-unsure", "1e-9", "--most-rows", rows, "--set", &most, "--json"];
        // Rows that fail are told as `run` tells them, also where they are what is sought.
        progress(&expect_code(study.refine(&goal), FAILED))
    };
    let before = refine(&study, "13");
    assert!(before["failed"].as_u64().is_some_and(|failed| (4..=6).contains(&failed)), "{before}");
    let after = refine(&study, "30");
    assert!(after["rows"] == 30 && after["outputs"].as_array().is_some_and(Vec::is_empty), "{after}");
    let share = |name: &str| after["boundary"][name].as_f64().expect("a share");
    assert!(share("unsure") < 0.15 && (0.2..0.8).contains(&share("within")), "{after}");
    let failed = after["failed"].as_u64().expect("a number") - before["failed"].as_u64().expect("a number");
    assert!((4..=16).contains(&failed), "of 20 rows, {failed} fail: {after}");
    for line in study.rows().lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        assert!(cells[2] + 10.0 * cells[1] <= 5.5, "{line}");
    }

    let whole = Study::new();
    refine(&whole, "30");
    assert_eq!(study.rows(), whole.rows());
    assert_same(&study.file("out"), &whole.file("out"));
}
