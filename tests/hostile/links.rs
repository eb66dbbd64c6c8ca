//! Files that are written appear whole, follow no planted link, and leave nothing beside them.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Writes the rows of a shipped design, as signals are written too.
fn write_table(target: &Path) -> Output {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    command.arg("design").arg(study).args(["--set", "design.rows=5", "--output"]).arg(target);
    command.output().expect("decore runs")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("folder").map(|entry| entry.expect("entry").file_name());
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_planted_link_is_not_followed() {
    let scratch = TempDir::new().expect("scratch folder");
    let (table, victim) = (scratch.path().join("rows.parquet"), scratch.path().join("victim"));
    fs::write(&victim, "mine").expect("written");
    symlink(&victim, scratch.path().join("rows.parquet.partial")).expect("link");
    let output = write_table(&table);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_to_string(&victim).expect("there"), "mine");
    // The link is nobody's business.
    assert_eq!(names(scratch.path()), ["rows.parquet", "rows.parquet.partial", "victim"]);
    assert!(fs::symlink_metadata(&table).expect("there").is_file());
}

#[test]
fn a_status_follows_no_planted_link_and_what_a_kill_left_of_one_goes() {
    let scratch = TempDir::new().expect("scratch folder");
    let (dataset, victim) = (scratch.path().join("dataset"), scratch.path().join("victim"));
    fs::write(&victim, "mine").expect("written");
    fs::create_dir(&dataset).expect("folder");
    for left in [".status.json.partial", ".status.json.Ab1.partial"] {
        symlink(&victim, dataset.join(left)).expect("link");
    }
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
    let sets = ["--set", "design.rows=1", "--set", "duration_s=0.001", "--output"];
    let output = command.arg("run").arg(study).args(sets).arg(&dataset).output().expect("decore runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_to_string(&victim).expect("there"), "mine");
    let hidden: Vec<String> = names(&dataset).into_iter().filter(|name| name.starts_with('.')).collect();
    assert_eq!(hidden, [] as [String; 0]);
}

/// A file of the journal and the lock are written where they are, not put in place: a link there is refused.
#[test]
fn a_link_in_the_journal_or_in_place_of_the_lock_is_refused_and_its_target_stays() {
    let scratch = TempDir::new().expect("scratch folder");
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    let contents = [vec![b'x'; 5000], Vec::new()];
    for (number, place) in [".journal/000000000000.rows", ".journal/000000000064.rows", ".lock"].iter().enumerate() {
        let (dataset, victim) = (scratch.path().join(format!("dataset {number}")), scratch.path().join("victim"));
        let run = |code: i32| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_decore"));
            let sets = ["--set", "design.rows=100", "--stub-row-ms", "0", "--max-failed", "0", "--output"];
            let output = command.arg("run").arg(&study).args(sets).arg(&dataset).output().expect("decore runs");
            assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8_lossy(&output.stderr).into_owned()
        };
        for (content, fresh) in contents.iter().flat_map(|content| [(content, true), (content, false)]) {
            let _ = fs::remove_dir_all(&dataset);
            if !fresh {
                run(0);
            }
            fs::create_dir_all(dataset.join(".journal")).expect("folder");
            fs::write(&victim, content).expect("written");
            symlink(&victim, dataset.join(place)).expect("link");
            let told = run(3);
            assert!(told.contains(place) && told.contains("symbolic link"), "{told}");
            assert!(fs::read(&victim).expect("there") == *content, "{place}: the target was written to");
        }
        fs::remove_file(&victim).expect("removed");
        let told = run(3);
        assert!(told.contains("symbolic link") && !victim.exists(), "{told}");
    }
}

#[test]
fn a_folder_in_the_place_of_a_table_leaves_nothing_beside_it() {
    let scratch = TempDir::new().expect("scratch folder");
    let table = scratch.path().join("rows.parquet");
    fs::create_dir(&table).expect("folder");
    let output = write_table(&table);
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(scratch.path()), ["rows.parquet"]);
}
