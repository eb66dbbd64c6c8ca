//! Rows that an analysis asks for: failed ones run again, further ones until intervals are narrow.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use decore_dataset::{DatasetReader, TableName};
use decore_quantity::Cell;
use serde_json::Value;
use tempfile::TempDir;

use super::datasets::text;
use crate::growth::{FACTORS, MACHINE};
use crate::sweeps::decore;

/// A study of short rows that are really simulated, in a Saltelli design of 8 base points, 5 rows each.
struct Study(TempDir);

impl Study {
    fn new() -> Self {
        let study = Self(TempDir::new().expect("scratch folder"));
        let text = format!(
            "duration_s = 0.1\n{MACHINE}\n[solver]\nfidelity = \"draft\"\n[design]\nkind = \"saltelli\"\nbase_points = 8\n{FACTORS}"
        );
        fs::write(study.file(), text).expect("study");
        study
    }

    fn file(&self) -> PathBuf {
        self.0.path().join("study.toml")
    }

    fn folder(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, name: &str, settings: &[&str]) -> Option<i32> {
        let mut command = decore();
        command.arg("run").arg(self.file()).arg("--output").arg(self.folder(name));
        for setting in settings {
            command.args(["--set", setting]);
        }
        command.output().expect("runs").status.code()
    }

    fn analyse(&self, name: &str, arguments: &[&str]) -> Output {
        let mut command: Command = decore();
        command.arg("analyse").arg(self.folder(name)).args(["--json", "--output", "total_air_used_nl"]).args(arguments);
        command.output().expect("runs")
    }

    /// The largest number of steps that a row of each block took.
    fn most_steps(&self, name: &str) -> Vec<u64> {
        let reader = DatasetReader::open(&self.folder(name)).expect("dataset");
        let mut rows = Vec::new();
        let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).expect("a number") as u64;
        let names = ["solver_steps", "solver_rejected_steps"];
        reader.visit(TableName::Runs, &names, |cells| rows.push(cells.iter().map(number).sum())).expect("read");
        rows.chunks(5).map(|block: &[u64]| block.iter().copied().max().unwrap_or_default()).collect()
    }

    fn outputs(&self, name: &str, arguments: &[&str]) -> Value {
        let output = self.analyse(name, arguments);
        let found: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
        found["outputs"].clone()
    }
}

#[test]
fn failed_rows_are_run_again_before_the_analysis() {
    let study = Study::new();
    let file = study.file();
    let file = file.to_str().expect("a path");
    assert_eq!(study.run("whole", &[]), Some(0));
    // A budget that is enough for all rows of five blocks.
    let mut most = study.most_steps("whole");
    most.sort_unstable();
    study.run("failed", &[&format!("solver.max_steps={}", most[4])]);
    let failed = study.outputs("failed", &["--bootstrap", "0"]);
    assert_eq!(failed[0]["used"]["whole"], 5);
    assert!(failed[0]["used"]["left_out"].to_string().contains("budget_exhausted"), "{failed}");
    let repair = ["--bootstrap", "0", "--study", file, "--repair"];
    // More retries are no larger budget of steps.
    assert_eq!(study.analyse("failed", &repair).status.code(), Some(4));
    let same = study.outputs("failed", &repair);
    assert_eq!(same[0]["used"]["whole"], 5);
    let repaired = study.outputs("failed", &[&repair[..], &["--set", "solver.max_steps=1000000"]].concat());
    assert_eq!(repaired[0]["used"]["whole"], 8);
    assert_eq!(repaired, study.outputs("whole", &["--bootstrap", "0"]));
}

#[test]
fn base_points_are_added_until_intervals_are_narrow() {
    let study = Study::new();
    let file = study.file();
    let file = file.to_str().expect("a path");
    study.run("grown", &[]);
    let grow = |most: &str, width: &str| {
        study.analyse("grown", &["--study", file, "--grow-until", width, "--most-rows", most])
    };
    // Far too wide: four times as many at once, or none.
    let output = grow("159", "0.0001");
    assert!(text(&output.stderr).contains("more than --most-rows 159"), "{}", text(&output.stderr));
    assert_eq!(output.status.code(), Some(4), "the goal is missed");
    let output = grow("160", "0.0001");
    let told = text(&output.stderr);
    assert!(told.contains("--set design.base_points=32") && told.contains("more than --most-rows 160"), "{told}");
    study.run("fresh", &["design.base_points=32"]);
    assert_eq!(study.outputs("grown", &[]), study.outputs("fresh", &[]));
    // Any width is narrower than this one.
    let output = grow("160", "1000");
    assert!(output.status.success() && !text(&output.stderr).contains("going on"), "{}", text(&output.stderr));
}

#[test]
fn rows_cannot_be_run_without_their_study() {
    let study = Study::new();
    for flag in [&["--repair"][..], &["--grow-until", "0.1"], &["--grow-until", "-1", "--study", "x.toml"]] {
        assert_eq!(study.analyse("none", flag).status.code(), Some(2), "{flag:?}");
    }
}
