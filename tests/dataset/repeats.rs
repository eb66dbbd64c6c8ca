//! Rows with the same factors: run once, stored for each, whatever the threads, shards and reruns.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use decore_dataset::{DatasetReader, TableName};
use decore_study::engine::{Engine, RowRunner};
use tempfile::TempDir;

use crate::growth::{FACTORS, MACHINE};
use crate::sweeps::{assert_same, decore, errors, expect_code};

/// Two numbers only, for designs that take no names.
const NUMBERS: &str = r#"
[design.factor.position]
path = "hammer.left.rail_position_m"
range = [-0.10, 0.05]
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
"#;

struct Study {
    scratch: TempDir,
}

impl Study {
    fn new(design: &str, factors: &str) -> Self {
        let study = Self { scratch: TempDir::new().expect("scratch folder") };
        study.write(design, factors);
        study
    }

    fn write(&self, design: &str, factors: &str) {
        let text = format!("duration_s = 0.15\n{MACHINE}\n[design]\n{design}\n{factors}");
        fs::write(self.file("study.toml"), text).expect("study");
    }

    fn file(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = decore();
        command.current_dir(self.scratch.path()).args(arguments);
        command
    }

    fn run(&self, arguments: &[&str]) -> String {
        errors(&expect_code(self.command(&[&["run", "study.toml"], arguments].concat()), 0))
    }
}

/// Rows that took time, and all rows.
fn computed(folder: &Path) -> (usize, usize) {
    let reader = DatasetReader::open(folder).expect("a dataset");
    let (mut took, mut all) = (0, 0);
    let visited = reader.visit(TableName::Timings, &["wall_time_s"], |cells| {
        all += 1;
        took += usize::from(cells[0].and_then(|value| value.number()).is_some_and(|time| time > 0.0));
    });
    visited.expect("timings");
    (took, all)
}

#[test]
fn rows_with_the_same_factors_are_run_once() {
    // Row 0 has a numerical twin, so it is run by itself.
    let designs = [
        // Fault 11: 84 of 100 rows.
        ("kind = 'morris'\ntrajectories = 8\nmorris_levels = 2", NUMBERS, 19),
        ("kind = 'central_composite'\ncentre_points = 8", NUMBERS, 7),
        (
            "kind = 'union'\n[[design.part]]\nkind = 'full_factorial'\n[[design.part]]\nkind = 'full_factorial'",
            NUMBERS,
            3,
        ),
    ];
    for (design, factors, repeated) in designs {
        let factors = factors.replace("[4.0, 6.0]", "[4.0, 6.0]\nlevels = 2").replace("0.05]", "0.05]\nlevels = 2");
        let factors = if design.contains("full") { factors } else { NUMBERS.to_owned() };
        let study = Study::new(design, &factors);
        let said = study.run(&["--output", "two", "--threads", "2"]);
        assert!(said.contains(&format!("{repeated} rows have the same factors")), "{design}: {said}");
        study.run(&["--output", "one", "--threads", "1"]);
        assert_same(&study.file("one"), &study.file("two"));
        let (took, all) = computed(&study.file("two"));
        assert_eq!(all - took, repeated, "{design}: {took} of {all}");
        // Each row is the one that it is alone.
        let engine = Engine::load(&study.file("study.toml"), &[]).expect("an engine");
        let reader = DatasetReader::open(&study.file("two")).expect("a dataset");
        let mut work = Vec::new();
        let visited = reader.visit(TableName::Runs, &["delivered_work_j"], |cells| {
            work.push(cells[0].and_then(|value| value.number()));
        });
        visited.expect("runs");
        for (row, work) in work.iter().enumerate().rev().take(4) {
            let alone = engine.outcome(row).metrics.map(|metrics| metrics.totals.delivered_work_j);
            assert_eq!(*work, alone, "{design}: row {row}");
        }
        let plan = expect_code(study.command(&["check", "study.toml"]), 0);
        let plan = String::from_utf8_lossy(&plan.stdout).into_owned();
        assert!(plan.contains(&format!("repeats      {repeated} rows")), "{plan}");
    }
}

#[test]
fn shards_resumed_sweeps_and_reruns_have_the_same_bytes() {
    let study = Study::new("kind = 'morris'\ntrajectories = 6\nmorris_levels = 2", NUMBERS);
    study.run(&["--output", "whole"]);
    for shard in ["1/2", "2/2"] {
        study.run(&["--shard", shard, "--output", &format!("shard{}", &shard[..1])]);
    }
    expect_code(study.command(&["merge", "shard1", "shard2", "--output", "merged"]), 0);
    assert_same(&study.file("whole"), &study.file("merged"));
    // A row whose first equal one is stored already is computed again.
    study.run(&["--output", "merged", "--rows", "7-11"]);
    assert_same(&study.file("whole"), &study.file("merged"));
}

#[test]
fn tables_and_values_that_repeat_and_designs_that_grow() {
    let study = Study::new("kind = 'table'\nfile = 'rows.csv'", FACTORS);
    let rows = |count: usize| {
        let row = |row: usize| format!("{},{},tied\n", [-0.05, 0.0, 0.05][row % 3], [4.5, 5.5][row / 3 % 2]);
        format!("position,pressure,guide\n{}", (0..count).map(row).collect::<String>())
    };
    fs::write(study.file("rows.csv"), rows(9)).expect("rows");
    let said = study.run(&["--output", "grown"]);
    assert!(said.contains("2 rows have the same factors"), "{said}");
    fs::write(study.file("rows.csv"), rows(15)).expect("rows");
    study.run(&["--output", "grown"]);
    study.run(&["--output", "fresh"]);
    assert_same(&study.file("grown"), &study.file("fresh"));
    assert_eq!(computed(&study.file("fresh")), (7, 15));
}

/// Fault 11: numbers of rows that are not those of the sweep.
#[test]
fn a_table_with_other_numbers_of_rows_is_refused() {
    let study = Study::new("kind = 'table'\nfile = 'rows.csv'", NUMBERS);
    let check = |rows: &str, code| {
        fs::write(study.file("rows.csv"), format!("row,position,pressure\n{rows}")).expect("rows");
        let mut command = study.command(&["design", "study.toml", "--output", "design.csv", "--replace"]);
        let output = command.output().expect("runs");
        assert_eq!(output.status.code(), Some(code), "{}", errors(&output));
        errors(&output)
    };
    let said = check("7,0.0,5.0\n3,0.05,5.0\n", 2);
    assert!(said.contains("column `row`: it is 7") && said.contains("line 2"), "{said}");
    check("0,0.0,5.0\n1,0.05,5.0\n", 0);
    check("first,0.0,5.0\nsecond,0.05,5.0\n", 0);
}

/// Fault 11: Sobol' points in a number that leaves them unbalanced.
#[test]
fn numbers_of_sobol_points_are_hinted_at() {
    let study = Study::new("kind = 'sobol'\nrows = 100", NUMBERS);
    let plan = |study: &Study| {
        let output = expect_code(study.command(&["check", "study.toml"]), 0);
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let said = plan(&study);
    assert!(said.contains("`rows = 64` or `rows = 128`"), "{said}");
    study.write("kind = 'saltelli'\nbase_points = 100", NUMBERS);
    assert!(plan(&study).contains("`base_points = 64` or `base_points = 128`"));
    study.write("kind = 'sobol'\nrows = 64", NUMBERS);
    assert!(!plan(&study).contains("hint"), "{}", plan(&study));
}
