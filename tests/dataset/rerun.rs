//! Chosen rows of a dataset are run again, with other budgets: the others stay, and no kill loses one.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use decore_dataset::{DatasetReader, DatasetWriter, Existing, Rerun, RerunSelection, RowSpan, TableName, verify};
use decore_model::run::RowStatus;
use decore_quantity::Cell;
use tempfile::TempDir;

use crate::sweeps::{decore, errors, expect_code, output, status, was_killed};
use crate::synthetic::{ROWS, info, outcome, record};

const DONE: i32 = 0;
const BAD_INPUT: i32 = 2;
const ROWS_FAILED: i32 = 4;
/// Rows of the simulated sweep: two parts.
const SIMULATED_ROWS: u64 = 72;

/// A simulated sweep of short rows, whose budget of steps is `max_steps`.
fn sweep(folder: &Path, max_steps: u64, further: &[&str]) -> Command {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    let mut command = decore();
    command.arg("run").arg(study).arg("--output").arg(folder).args(further);
    for set in ["solver.fidelity=draft", "duration_s=0.1"] {
        command.args(["--set", set]);
    }
    command.args(["--set", &format!("design.rows={SIMULATED_ROWS}")]);
    command.args(["--set", &format!("solver.max_steps={max_steps}")]);
    command
}

/// All cells of a table but the wall times, row by row, as text.
fn cells(folder: &Path, table: TableName) -> Vec<Vec<String>> {
    let reader = DatasetReader::open(folder).expect("dataset");
    let names: Vec<String> = reader.columns(table).iter().map(|column| column.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut rows = Vec::new();
    let text = |cell: &Cell<'_>| cell.map_or("null".to_owned(), |cell| cell.to_string());
    reader.visit(table, &names, |cells| rows.push(cells.iter().map(text).collect())).expect("read");
    rows
}

/// The values of one column of `runs`.
fn column(folder: &Path, name: &str) -> Vec<String> {
    let reader = DatasetReader::open(folder).expect("dataset");
    let mut values = Vec::new();
    let visit = |cells: &[Cell<'_>]| values.push(cells[0].map_or(String::new(), |cell| cell.to_string()));
    reader.visit(TableName::Runs, &[name], visit).expect("read");
    values
}

/// A number of steps that about half of the rows exceed, and the steps of all rows.
fn half_of_the_steps(whole: &Path) -> (u64, Vec<u64>) {
    let [taken, rejected] = ["solver_steps", "solver_rejected_steps"].map(|name| column(whole, name));
    let steps: Vec<u64> = taken
        .iter()
        .zip(&rejected)
        .map(|(a, b)| [a, b].map(|n| n.parse::<u64>().expect("steps")).iter().sum())
        .collect();
    let mut sorted = steps.clone();
    sorted.sort_unstable();
    (sorted[sorted.len() / 2], steps)
}

fn parts(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for table in ["runs", "blows", "timings"] {
        for entry in fs::read_dir(folder.join(table)).expect("table").flatten() {
            found.push((entry.path(), fs::read(entry.path()).expect("part")));
        }
    }
    found.sort();
    found
}

#[test]
fn failed_rows_are_run_again_with_larger_budgets() {
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, folder) = (scratch.path().join("whole"), scratch.path().join("sweep"));
    expect_code(sweep(&whole, 1_000_000, &[]), DONE);
    let (few, _) = half_of_the_steps(&whole);
    expect_code(sweep(&folder, few, &[]), ROWS_FAILED);
    let failed = column(&folder, "status").iter().filter(|status| *status == "budget_exhausted").count();
    assert!((5..=60).contains(&failed), "{failed} of {SIMULATED_ROWS} rows");

    let refused = errors(&expect_code(sweep(&folder, 1_000_000, &[]), BAD_INPUT));
    assert!(refused.contains("solver.max_steps") && refused.contains("`--only-failed` runs these again"), "{refused}");
    // What is no budget makes another study, chosen rows or not.
    let other = errors(&expect_code(sweep(&folder, few, &["--only-failed", "--set", "duration_s=0.2"]), BAD_INPUT));
    assert!(other.contains("duration_s"), "{other}");

    let again = errors(&expect_code(sweep(&folder, 1_000_000, &["--only-failed"]), DONE));
    assert!(again.contains(&format!("running {failed} rows of ")), "{again}");
    for table in [TableName::Runs, TableName::Blows] {
        assert_eq!(cells(&folder, table), cells(&whole, table));
    }
    assert_eq!(verify(&folder).expect("read").faults, Vec::<String>::new());
    let status = status(&folder);
    assert_eq!((status["state"].as_str(), status["rows_failed"].as_u64()), (Some("complete"), Some(0)));
    let manifest = DatasetReader::open(&folder).expect("dataset").manifest().clone();
    // Rows side by side are one span.
    let apart = |rerun: &Rerun| rerun.rows.windows(2).all(|pair| pair[0].end < pair[1].first);
    assert!(manifest.reruns.iter().all(apart), "{:?}", manifest.reruns);
    let asked: u64 = manifest.reruns.iter().flat_map(|rerun| &rerun.rows).map(|span| span.len()).sum();
    assert_eq!((manifest.reruns.len(), asked), (1, failed as u64));
    assert!(manifest.reruns[0].changed.iter().any(|line| line.contains("max_steps")), "{:?}", manifest.reruns);

    // Both the old budgets and the new ones find nothing left to do.
    let before = parts(&folder);
    for (steps, further) in [(few, None), (1_000_000, None), (1_000_000, Some("--only-failed"))] {
        let text = errors(&expect_code(sweep(&folder, steps, &further.into_iter().collect::<Vec<_>>()), DONE));
        assert!(text.contains("are in") || text.contains("no row of"), "{text}");
    }
    assert!(parts(&folder) == before);
}

#[test]
fn chosen_rows_are_run_again_and_nothing_else() {
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, folder) = (scratch.path().join("whole"), scratch.path().join("sweep"));
    expect_code(sweep(&whole, 1_000_000, &[]), DONE);
    let (few, steps) = half_of_the_steps(&whole);
    expect_code(sweep(&folder, few, &[]), ROWS_FAILED);
    let failed: Vec<usize> = (0..64).filter(|row| steps[*row] > few).collect();
    let before = (cells(&folder, TableName::Runs), parts(&folder));
    let list = format!("{},{}-{}", failed[1], failed[0], failed[0]);
    expect_code(sweep(&folder, 1_000_000, &["--rows", &list]), ROWS_FAILED);
    let (now, expected) = (cells(&folder, TableName::Runs), cells(&whole, TableName::Runs));
    assert_eq!(now.len() as u64, SIMULATED_ROWS);
    for (row, cells) in now.iter().enumerate() {
        let wanted = if failed[..2].contains(&row) { &expected } else { &before.0 };
        assert_eq!(*cells, wanted[row], "row {row}");
    }
    // The other part keeps its bytes.
    let other = |parts: &[(PathBuf, Vec<u8>)]| {
        parts.iter().filter(|(path, _)| path.ends_with("runs-000000000064.parquet")).cloned().collect::<Vec<_>>()
    };
    assert!(other(&before.1) == other(&parts(&folder)) && other(&before.1).len() == 1);
    // With a smaller budget they would fail again: what is computed stays.
    expect_code(sweep(&folder, 10, &["--rows", &list]), ROWS_FAILED);
    assert_eq!(cells(&folder, TableName::Runs), now);
    let beyond = errors(&expect_code(sweep(&folder, few, &["--rows", "3,500-600"]), BAD_INPUT));
    assert!(beyond.contains("names row 600") && beyond.contains("0 to 71"), "{beyond}");
    let none = errors(&expect_code(sweep(&scratch.path().join("none"), few, &["--only-failed"]), BAD_INPUT));
    assert!(none.contains("is not a dataset"), "{none}");
}

/// Rows recorded before the end count, whatever they belong to.
#[test]
#[cfg_attr(windows, ignore = "the lock of a writer whose thread lives cannot be removed there")]
fn a_rerun_that_ends_early_keeps_old_rows_and_new_ones() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("dataset");
    let range = RowSpan { first: 0, end: ROWS };
    let mut writer = DatasetWriter::create(&folder, &info(), Existing::Refuse).expect("new");
    (0..ROWS).for_each(|row| writer.write(&record(row, outcome(row))).expect("written"));
    writer.finish().expect("finished");
    let failed: Vec<u64> = (0..ROWS).filter(|row| outcome(*row).status != RowStatus::Done).collect();
    let before = cells(&folder, TableName::Runs);
    // Rows that now end as done: those of the row before, under another index.
    let mended = |row: u64| record(row, outcome(row - 1));
    let mut mended_rows = 0;
    for (turn, rows) in failed.chunks(5).enumerate() {
        let mut writer = DatasetWriter::again(&folder, &info(), range, &RerunSelection::Failed).expect("again");
        let left: Vec<u64> = writer.rows_left().iter().flat_map(|span| span.first..span.end).collect();
        assert_eq!(left, failed[mended_rows..], "turn {turn}");
        rows.iter().for_each(|row| writer.write(&mended(*row)).expect("written"));
        mended_rows += rows.len();
        if turn % 2 == 0 {
            // As a process that is killed: no part is written by the end of it.
            std::mem::forget(writer);
            // Its thread lives on here, as it would not after a kill: what it is about to replace, it may.
            sleep(Duration::from_millis(700));
            fs::remove_file(folder.join(".lock")).expect("lock");
        } else {
            writer.finish().expect("finished");
        }
        // A reader sees whole parts whenever no part is just being replaced.
        let faults = verify(&folder).map_or(Vec::new(), |found| found.faults);
        assert!(faults.is_empty(), "turn {turn}: {faults:?}");
    }
    let writer = DatasetWriter::open(&folder, &info(), range, Existing::Resume).expect("resumed");
    assert_eq!((writer.rows_left(), writer.damaged().len()), (Vec::new(), 0));
    writer.finish().expect("finished");
    let after = cells(&folder, TableName::Runs);
    for row in 0..ROWS {
        let same = after[row as usize] == before[row as usize];
        assert_eq!(same, !failed.contains(&row), "row {row}");
    }
    assert_eq!(verify(&folder).expect("read").faults, Vec::<String>::new());
    assert_eq!(DatasetReader::open(&folder).expect("dataset").manifest().rows_failed(), 0);
}

/// How many rows a rerun says that it runs.
fn rows_asked(text: &str) -> Option<usize> {
    text.split_once("running ")?.1.split_once(" rows of ")?.0.parse().ok()
}

#[test]
fn kills_of_a_rerun_lose_nothing() {
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, folder) = (scratch.path().join("whole"), scratch.path().join("sweep"));
    expect_code(sweep(&whole, 1_000_000, &[]), DONE);
    let (few, _) = half_of_the_steps(&whole);
    expect_code(sweep(&folder, few, &[]), ROWS_FAILED);
    let failed = || column(&folder, "status").iter().filter(|status| *status != "done").count();
    // Rows wait beside the table until their part is whole: what a rerun has kept is seen by how many the next one runs.
    let all = failed();
    let (mut before, mut left, mut kills) = (all, all, 0);
    // From before its first row to its end, in steps that are short beside the time of its rows.
    let moments = std::iter::successors(Some(0.1), |moment_s| Some(1.04 * moment_s));
    for moment_s in moments.take(100) {
        let mut command = sweep(&folder, 1_000_000, &["--only-failed", "--threads", "1"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("decore runs");
        sleep(Duration::from_secs_f64(moment_s));
        child.kill().expect("killed");
        let ended = child.wait_with_output().expect("ended");
        if !was_killed(ended.status) {
            break;
        }
        kills += 1;
        let asked = rows_asked(&errors(&ended)).unwrap_or(left);
        assert!(asked <= left, "{asked} rows to run after {left}");
        left = asked;
        let verified = verify(&folder).expect("read");
        // A kill between two renames: nothing is lost, and that is said.
        let is_said = |fault: &String| fault.contains("the journal has all their rows");
        assert!(verified.faults.iter().all(is_said), "{:?}", verified.faults);
        // Readers refuse a dataset in this state; the next command completes it.
        if verified.faults.is_empty() {
            let now = failed();
            assert!(now <= before, "{now} failed rows after {before}");
            before = now;
        }
    }
    println!("{kills} kills of the rerun, {left} of {all} rows left before the last");
    assert!(kills > 3 && left < all, "{kills} kills, {left} of {all} rows left");
    output(sweep(&folder, 1_000_000, &["--only-failed"]));
    for table in [TableName::Runs, TableName::Blows] {
        assert_eq!(cells(&folder, table), cells(&whole, table));
    }
    assert_eq!(verify(&folder).expect("read").faults, Vec::<String>::new());
}
