//! Sweeps that are given more rows: the rows that are done stay, only the new ones are run, and the dataset has the bytes of
//! one that had all rows from the beginning.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::sweeps::{assert_same, contract, decore, errors, expect_code, status, was_killed};
use tempfile::TempDir;

/// A study without its duration and design.
pub const MACHINE: &str = r#"
title = "Hammer on a rail"
[hammer.left]
rail = "rail"
rail_position_m = 0.0
[casting.part]
mass_kg = 3.0
size_m = [0.30, 0.28]
inertia_kg_m2 = [0.0135, 0.026]
[casting.part.fixture.front]
point = "T1"
[casting.part.fixture.middle]
point = "T6"
[casting.part.fixture.back]
point = "T7"
"#;

/// Two factors that are numbers and one of names.
pub const FACTORS: &str = r#"
[design.factor.position]
path = "hammer.left.rail_position_m"
range = [-0.10, 0.10]
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
[design.factor.guide]
path = "solver.guide"
values = ["spring", "tied"]
"#;

struct Sweep {
    scratch: TempDir,
}

impl Sweep {
    fn new() -> Self {
        Self { scratch: TempDir::new().expect("scratch folder") }
    }

    fn folder(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// The command that runs the study with this design into a folder; `None`: really simulated.
    fn run(&self, design: &str, folder: &str, row_ms: Option<f64>) -> Command {
        let study = self.folder("study.toml");
        fs::write(&study, format!("duration_s = 0.3\n{MACHINE}\n[design]\n{design}\n{FACTORS}")).expect("study");
        let mut command = decore();
        command.arg("run").arg(study).arg("--output").arg(self.folder(folder)).args(["--threads", "2"]);
        if let Some(row_ms) = row_ms {
            command.args(["--stub-row-ms", &row_ms.to_string()]);
        }
        command
    }

    /// Runs `before`, then `after` into the same folder, and compares with `after` in one go.
    fn grows(&self, before: &str, after: &str, counts: (u64, u64)) {
        let code = |rows| if rows > 613 { 4 } else { 0 };
        for folder in ["grown", "fresh"] {
            let _ = fs::remove_dir_all(self.folder(folder));
        }
        expect_code(self.run(before, "grown", Some(0.0)), code(counts.0));
        let text = errors(&expect_code(self.run(after, "grown", Some(0.0)), code(counts.1)));
        let (first, all) = counts;
        assert!(text.contains(&format!("grown from {first} to {all} rows")), "{after}: {text}");
        assert!(text.contains(&format!("continuing: {first} of {all} rows")), "{after}: {text}");
        expect_code(self.run(after, "fresh", Some(0.0)), code(counts.1));
        assert_same(&self.folder("grown"), &self.folder("fresh"));
        assert_eq!(status(&self.folder("grown"))["rows_recovered"].as_u64(), Some(first));
    }
}

#[test]
fn every_kind_that_can_grow_goes_on_with_its_new_rows() {
    let sweep = Sweep::new();
    let kinds = [
        ("kind = 'sobol'\nrows = 100", "kind = 'sobol'\nrows = 150", (100, 150)),
        ("kind = 'halton'\nrows = 64", "kind = 'halton'\nrows = 65", (64, 65)),
        ("kind = 'random'\nrows = 700", "kind = 'random'\nrows = 20000", (700, 20_000)),
        ("kind = 'latin_hypercube'\nrows = 40", "kind = 'latin_hypercube'\nrows = 120\ngrown_from = [40]", (40, 120)),
        (
            "kind = 'latin_hypercube'\noptimise = 'maximin'\nrows = 90\ngrown_from = [30]",
            "kind = 'latin_hypercube'\noptimise = 'maximin'\nrows = 100\ngrown_from = [30, 90]",
            (90, 100),
        ),
        ("kind = 'morris'", "kind = 'morris'\ntrajectories = 12", (40, 48)),
        ("kind = 'saltelli'\nbase_points = 16", "kind = 'saltelli'\nbase_points = 32", (80, 160)),
        (
            "kind = 'random'\nrows = 100\nconstraints = ['pressure < 5.5', 'mount_x(left) > 0.3']",
            "kind = 'random'\nrows = 110\nconstraints = ['pressure < 5.5', 'mount_x(left) > 0.3']",
            (100, 110),
        ),
        (
            "kind = 'union'\n[[design.part]]\nkind = 'one_at_a_time'\n[[design.part]]\nkind = 'sobol'\nrows = 10",
            "kind = 'union'\n[[design.part]]\nkind = 'one_at_a_time'\n[[design.part]]\nkind = 'sobol'\nrows = 30",
            (16, 36),
        ),
        (
            "kind = 'product'\n[[design.part]]\nkind = 'sobol'\nrows = 8\nfactors = ['position', 'pressure']\n[[design.part]]\n\
             kind = 'full_factorial'\nfactors = ['guide']",
            "kind = 'product'\n[[design.part]]\nkind = 'sobol'\nrows = 16\nfactors = ['position', 'pressure']\n[[design.part]]\n\
             kind = 'full_factorial'\nfactors = ['guide']",
            (16, 32),
        ),
    ];
    for (before, after, counts) in kinds {
        sweep.grows(before, after, counts);
    }
}

#[test]
fn a_table_may_get_rows_at_its_end() {
    let sweep = Sweep::new();
    let table = sweep.folder("rows.csv");
    let rows = |range: std::ops::Range<u32>| {
        range
            .map(|row| format!("{},{},tied\n", 0.001 * f64::from(row), 5.0 - 0.01 * f64::from(row)))
            .collect::<String>()
    };
    let (begin, design) = ("position,pressure,guide\n", "kind = 'table'\nfile = 'rows.csv'");
    fs::write(&table, format!("{begin}{}", rows(0..50))).expect("table");
    expect_code(sweep.run(design, "grown", Some(0.0)), 0);
    fs::write(&table, format!("{begin}{}", rows(0..80))).expect("table");
    let text = errors(&expect_code(sweep.run(design, "grown", Some(0.0)), 0));
    assert!(text.contains("grown from 50 to 80 rows") && text.contains("continuing: 50 of 80"), "{text}");
    expect_code(sweep.run(design, "fresh", Some(0.0)), 0);
    assert_same(&sweep.folder("grown"), &sweep.folder("fresh"));
    // A row put before the others changes them.
    fs::write(&table, format!("{begin}{}{}", rows(90..91), rows(0..80))).expect("table");
    let text = errors(&expect_code(sweep.run(design, "grown", Some(0.0)), 2));
    assert!(text.contains("the first 80 are others than before"), "{text}");
}

#[test]
fn rows_that_are_done_are_not_run_again() {
    let sweep = Sweep::new();
    expect_code(sweep.run("kind = 'sobol'\nrows = 600", "grown", Some(0.0)), 0);
    expect_code(sweep.run("kind = 'sobol'\nrows = 610", "grown", Some(50.0)), 0);
    let status = status(&sweep.folder("grown"));
    assert_eq!((status["rows_recovered"].as_u64(), status["rows_done"].as_u64()), (Some(600), Some(610)));
    // Ten rows of 50 ms; all would have taken 30 s.
    let row_time_s = status["row_time_s"].as_f64().expect("a time");
    assert!((0.5..5.0).contains(&row_time_s), "{row_time_s}");
}

#[test]
fn a_simulated_sweep_grows() {
    let sweep = Sweep::new();
    expect_code(sweep.run("kind = 'halton'\nrows = 3", "grown", None), 0);
    let text = errors(&expect_code(sweep.run("kind = 'halton'\nrows = 5", "grown", None), 0));
    assert!(text.contains("grown from 3 to 5 rows") && text.contains("continuing: 3 of 5"), "{text}");
    expect_code(sweep.run("kind = 'halton'\nrows = 5", "fresh", None), 0);
    assert_same(&sweep.folder("grown"), &sweep.folder("fresh"));
}

#[test]
fn other_changes_are_refused_with_more_rows_too() {
    let sweep = Sweep::new();
    expect_code(sweep.run("kind = 'sobol'\nrows = 30", "sweep", Some(0.0)), 0);
    let before = contract(&sweep.folder("sweep"));
    let refused = |design: &str, words: &str| {
        let text = errors(&expect_code(sweep.run(design, "sweep", Some(0.0)), 2));
        assert!(text.contains(words), "{design}: {text}");
    };
    refused("kind = 'sobol'\nrows = 40\nseed = 1", "design.seed: absent -> 1");
    refused("kind = 'sobol'\nrows = 40\nscramble = false", "design.scramble");
    refused("kind = 'halton'\nrows = 40", "design.kind");
    refused("kind = 'sobol'\nrows = 40\nconstraints = ['pressure < 5.5']", "design.constraints");
    refused("kind = 'sobol'\nrows = 20", "design.rows: 30 -> 20");
    let mut set = sweep.run("kind = 'sobol'\nrows = 40", "sweep", Some(0.0));
    set.args(["--set", "duration_s=0.4"]);
    assert!(errors(&expect_code(set, 2)).contains("duration_s=0.4"));
    assert!(before == contract(&sweep.folder("sweep")));
    expect_code(sweep.run("kind = 'latin_hypercube'\nrows = 30", "cube", Some(0.0)), 0);
    let text = errors(&expect_code(sweep.run("kind = 'latin_hypercube'\nrows = 60", "cube", Some(0.0)), 2));
    assert!(text.contains("design.rows: 30 -> 60") && text.contains("grown_from = [30]"), "{text}");
    // The number of rows may come from the command line as well.
    let mut set = sweep.run("kind = 'sobol'\nrows = 30", "sweep", Some(0.0));
    set.args(["--set", "design.rows=35"]);
    assert!(errors(&expect_code(set, 0)).contains("grown from 30 to 35 rows"));
}

#[test]
fn an_interrupted_growth_leaves_no_trace() {
    let sweep = Sweep::new();
    let (before, after) = ("kind = 'sobol'\nrows = 6000", "kind = 'sobol'\nrows = 20000");
    let grown = sweep.folder("grown");
    // Not finished: rows of the journal grow with the others.
    let mut stopped = sweep.run(before, "grown", Some(1.0));
    stopped.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = stopped.spawn().expect("decore starts");
    let begin = Instant::now();
    while !(grown.join("status.json").exists() && status(&grown)["rows_done"].as_u64() >= Some(100)) {
        assert!(begin.elapsed() < Duration::from_secs(60), "100 rows within a minute");
        sleep(Duration::from_millis(100));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    let done = status(&grown)["rows_done"].as_u64().expect("a number");
    assert!(done < 6000, "{done} rows");
    let mut last = done;
    let mut within = 0;
    for step in 0..40 {
        let mut command = sweep.run(after, "grown", Some(1.0));
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().expect("decore starts");
        sleep(Duration::from_millis(4 + 4 * step));
        within += u32::from(grown.join(".growing").exists());
        child.kill().expect("killed");
        assert!(was_killed(child.wait().expect("ended")));
        within += u32::from(grown.join(".growing").exists());
        if !grown.join(".growing").exists() {
            let now = status(&grown)["rows_done"].as_u64().expect("a number");
            assert!(now >= last, "{now} rows after {last}: rows were lost");
            last = now;
        }
    }
    expect_code(sweep.run(after, "grown", Some(0.0)), 4);
    expect_code(sweep.run(after, "fresh", Some(0.0)), 4);
    assert_same(&grown, &sweep.folder("fresh"));
    assert!(!Path::new(&grown).join(".growing").exists());
    println!("{within} looks found a growth under way; {done} rows before, {last} before the last run");
}
