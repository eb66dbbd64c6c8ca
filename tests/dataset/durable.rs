//! Sweeps that are killed, interrupted, starved of disk space, sharded: always the bytes of an undisturbed one.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

#[cfg(unix)]
use crate::sweeps::signal;
use crate::sweeps::{assert_same, contract, decore, errors, expect_code, output, status, sweep, sweep_on, was_killed};
use tempfile::TempDir;

/// Exit code of a sweep of the test scene with more than 613 rows: one of them diverges.
const ROWS_FAILED: i32 = 4;

/// Starts a sweep with nothing on the test's terminal.
fn start(mut command: Command) -> Child {
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("decore starts")
}

/// Numbers that look random, from a linear congruential generator.
fn moments(seed: u64) -> impl Iterator<Item = u64> {
    let next =
        |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
    std::iter::successors(Some(seed), next).skip(1).map(|state| state >> 33)
}

fn rows_done(folder: &Path) -> u64 {
    if !folder.join("manifest.json").exists() {
        return 0;
    }
    status(folder)["rows_done"].as_u64().expect("a number")
}

#[test]
fn fifty_kills_leave_no_trace() {
    let scratch = TempDir::new().expect("scratch folder");
    let (undisturbed, killed) = (scratch.path().join("undisturbed"), scratch.path().join("killed"));
    let kills: u64 = std::env::var("DECORE_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(50);
    let rows = 600 * kills;
    expect_code(sweep(&undisturbed, rows, 0.0), ROWS_FAILED);
    let mut done = 0;
    let mut kills_within = 0;
    // A machine that is busy takes longer to begin.
    let mut longest_ms = 250;
    for moment in moments(4).take(kills as usize) {
        let mut child = start(sweep(&killed, rows, 2.0));
        sleep(Duration::from_millis(5 + moment % longest_ms));
        child.kill().expect("killed");
        let ended = child.wait().expect("ended");
        assert!(was_killed(ended), "the sweep must be too long to end by itself");
        let now = rows_done(&killed);
        assert!(now >= done, "{now} rows after {done}: rows were lost");
        kills_within += u32::from(now > 0 && now < rows);
        longest_ms = if now > done { 250 } else { (longest_ms * 2).min(4000) };
        done = now;
    }
    assert!(kills_within > 10 && done > 100, "{kills_within} kills within the sweep, {done} rows");
    let last = expect_code(sweep(&killed, rows, 0.0), ROWS_FAILED);
    let text = errors(&last);
    assert!(text.contains(&format!("continuing: {done} of {rows} rows")) && !text.contains("damaged"), "{text}");
    assert_same(&undisturbed, &killed);
    println!("{kills_within} of {kills} kills within the sweep; {done} of {rows} rows before the last run");
}

#[test]
fn threads_and_seven_shards_give_the_bytes_of_the_whole() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = |name: &str| scratch.path().join(name);
    let rows = 1000;
    expect_code(sweep(&folder("two"), rows, 0.1), ROWS_FAILED);
    let mut one_thread = sweep_on(1, &folder("one"), rows, 0.0);
    one_thread.arg("--summary").arg(folder("summary.json"));
    expect_code(one_thread, ROWS_FAILED);
    assert_same(&folder("two"), &folder("one"));
    let summary: serde_json::Value =
        serde_json::from_slice(&fs::read(folder("summary.json")).expect("completion file")).expect("JSON");
    assert_eq!((summary["state"].as_str(), summary["rows_done"].as_u64()), (Some("complete"), Some(rows)));
    assert_eq!((summary["rows_failed"].as_u64(), summary["threads"].as_u64()), (Some(1), Some(1)));
    assert_eq!(summary["last_errors"][0]["row"].as_u64(), Some(613));

    let shards: Vec<PathBuf> = (1..=7).map(|index| folder(&format!("shard-{index}"))).collect();
    let merge = |shards: &[PathBuf]| {
        let mut command = decore();
        command.arg("merge").args(shards).arg("--output").arg(folder("merged"));
        command
    };
    for (index, shard) in shards.iter().enumerate() {
        let mut command = sweep(shard, rows, 0.0);
        command.arg("--shard").arg(format!("{}/7", index + 1));
        let code = output(command).status.code();
        assert!(code == Some(0) || code == Some(ROWS_FAILED), "{code:?}");
    }
    let refused = expect_code(merge(&shards[1..]), 2);
    assert!(errors(&refused).contains("no shard has rows 0 to 141"), "{}", errors(&refused));
    expect_code(merge(&shards), ROWS_FAILED);
    assert_same(&folder("two"), &folder("merged"));
}

#[test]
fn a_truncated_part_is_named_and_computed_again() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    expect_code(sweep(&folder, 300, 0.0), 0);
    let whole = contract(&folder);
    let part = folder.join("runs/runs-000000000128.parquet");
    let bytes = fs::read(&part).expect("part");
    fs::write(&part, &bytes[..bytes.len() - 7]).expect("cut short");
    let again = expect_code(sweep(&folder, 300, 0.0), 0);
    let text = errors(&again);
    assert!(text.contains("runs-000000000128.parquet") && text.contains("236 of 300 rows"), "{text}");
    assert!(whole == contract(&folder));
    // A third time there is nothing to do.
    let text = errors(&expect_code(sweep(&folder, 300, 1e6), 0));
    assert!(text.contains("all 300 rows"), "{text}");
}

#[test]
#[cfg(unix)]
fn one_interrupt_finishes_the_running_rows_and_a_second_ends_at_once() {
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, folder) = (scratch.path().join("whole"), scratch.path().join("sweep"));
    expect_code(sweep(&whole, 1000, 0.0), ROWS_FAILED);
    for name in ["INT", "TERM"] {
        let child = start(sweep(&folder, 1000, 5.0));
        wait_for_rows(&folder, rows_done(&folder) + 20);
        signal(name, child.id());
        let ended = child.wait_with_output().expect("ended");
        assert_eq!(ended.status.code(), Some(5), "{}", errors(&ended));
        assert!(errors(&ended).contains("the same command goes on"), "{}", errors(&ended));
        let status = status(&folder);
        assert_eq!(status["state"], "interrupted");
        let manifest = fs::read_to_string(folder.join("manifest.json")).expect("manifest");
        let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
        assert_eq!(manifest["rows_done"], status["rows_done"], "all that was done is in the tables");
    }
    let long = start(sweep(&folder, 1000, 60_000.0));
    sleep(Duration::from_millis(700));
    let begin = Instant::now();
    signal("INT", long.id());
    sleep(Duration::from_millis(300));
    signal("INT", long.id());
    let ended = long.wait_with_output().expect("ended");
    assert_eq!(ended.status.code(), Some(5), "{}", errors(&ended));
    assert!(begin.elapsed() < Duration::from_secs(20));
    assert!(errors(&ended).contains("stopped at once: rows that ended are kept"), "{}", errors(&ended));
    assert_eq!(status(&folder)["state"], "stopped_at_once");
    let mut command = decore();
    command.arg("status").arg(&folder);
    let words = String::from_utf8(expect_code(command, 0).stdout).expect("UTF-8");
    assert!(words.contains("stopped at once by a second interrupt") && !words.contains("machine"), "{words}");
    expect_code(sweep(&folder, 1000, 0.0), ROWS_FAILED);
    assert_same(&whole, &folder);
}

fn wait_for_rows(folder: &Path, rows: u64) {
    let begin = Instant::now();
    // The status of a running sweep comes every two seconds; the journal shows rows at once.
    while begin.elapsed() < Duration::from_secs(60) {
        let is_of_rows = |entry: &fs::DirEntry| entry.path().extension().is_some_and(|ending| ending == "rows");
        let entries = fs::read_dir(folder.join(".journal")).into_iter().flatten().flatten().filter(is_of_rows);
        let bytes: u64 = entries.filter_map(|entry| entry.metadata().ok()).map(|data| data.len()).sum();
        if bytes > rows.min(20) * 200 {
            return;
        }
        sleep(Duration::from_millis(10));
    }
    panic!("no rows within a minute");
}

#[test]
fn a_manifest_damaged_before_the_first_part_costs_no_row() {
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, folder) = (scratch.path().join("whole"), scratch.path().join("sweep"));
    expect_code(sweep(&whole, 60, 0.0), 0);
    let mut child = start(sweep(&folder, 60, 40.0));
    wait_for_rows(&folder, 10);
    sleep(Duration::from_millis(200));
    child.kill().expect("killed");
    child.wait().expect("ended");
    fs::write(folder.join("manifest.json"), "x\n").expect("written");
    let text = errors(&expect_code(sweep(&folder, 60, 0.0), 0));
    assert!(text.contains("rebuilt from the journal") && text.contains("continuing: "), "{text}");
    assert_same(&whole, &folder);
}

#[test]
fn one_writer_at_a_time_and_others_can_watch() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let mut child = start(sweep(&folder, 1000, 20.0));
    wait_for_rows(&folder, 5);
    let refused = expect_code(sweep(&folder, 1000, 0.0), 7);
    assert!(errors(&refused).contains(&format!("process {}", child.id())), "{}", errors(&refused));
    sleep(Duration::from_secs(3));
    let seen = status(&folder);
    assert_eq!(seen["state"], "running");
    assert!(seen["rows_done"].as_u64() > Some(10) && seen["seconds_left"].as_f64() > Some(1.0), "{seen}");
    child.kill().expect("killed");
    child.wait_with_output().expect("ended");
    let dead = status(&folder);
    assert_eq!(dead["state"], "lost");
    assert!(dead["rows_done"].as_u64() >= seen["rows_done"].as_u64(), "{dead}");
}

#[test]
fn a_changed_study_is_refused_with_the_difference() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    expect_code(sweep(&folder, 200, 0.0), 0);
    let before = contract(&folder);
    let mut other = sweep(&folder, 200, 0.0);
    other.args(["--set", "duration_s=1.25"]);
    let text = errors(&expect_code(other, 2));
    assert!(text.contains("--set: design.rows=200 -> design.rows=200, duration_s=1.25"), "{text}");
    // A real run does not mix with the test scene.
    let mut real = decore();
    real.args(["run", crate::sweeps::STUDY, "--set", "design.rows=200", "--output"]).arg(&folder);
    let text = errors(&expect_code(real, 2));
    assert!(text.contains("--stub-row-ms"), "{text}");
    assert!(before == contract(&folder));
    let mut anew = sweep(&folder, 100, 0.0);
    anew.arg("--replace");
    expect_code(anew, 0);
    assert_eq!(rows_done(&folder), 100);
}

#[test]
fn too_many_failed_rows_stop_the_sweep() {
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, folder) = (scratch.path().join("whole"), scratch.path().join("sweep"));
    expect_code(sweep(&whole, 4000, 0.0), ROWS_FAILED);
    let limited = |limit: &str| {
        let mut command = sweep(&folder, 4000, 0.2);
        command.args(["--max-failed", limit]);
        command
    };
    let text = errors(&expect_code(limited("1"), 6));
    assert!(text.contains("2 rows are not done, more than the 1 allowed (`decore status`"), "{text}");
    let stopped = status(&folder);
    assert_eq!((stopped["state"].as_str(), stopped["rows_failed"].as_u64()), (Some("too_many_failed"), Some(2)));
    assert!(stopped["rows_done"].as_u64() < Some(2000), "{stopped}");
    expect_code(limited("1"), 6);
    expect_code(limited("4"), ROWS_FAILED);
    assert_same(&whole, &folder);
}

/// A file system of its own, unmounted at the end; `None` where mounting is not allowed.
struct Mounted(PathBuf);

impl Mounted {
    fn new(folder: &Path, options: &str) -> Option<Self> {
        fs::create_dir_all(folder).expect("mount point");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(folder).output();
        if mounted.is_ok_and(|output| output.status.success()) {
            return Some(Self(folder.to_owned()));
        }
        println!("skipped: this needs the right to mount a file system");
        None
    }

    fn remount(&self, options: &str) {
        let options = format!("remount,{options}");
        let remounted = Command::new("mount").args(["-o", &options]).arg(&self.0).status();
        assert!(remounted.expect("mount runs").success());
    }
}

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_stops_the_sweep_and_harms_nothing() {
    let scratch = TempDir::new().expect("scratch folder");
    let whole = scratch.path().join("whole");
    expect_code(sweep(&whole, 2000, 0.0), ROWS_FAILED);
    for kilobytes in [40, 300, 700, 1100] {
        let Some(disk) = Mounted::new(&scratch.path().join("disk"), &format!("size={kilobytes}k")) else {
            return;
        };
        let folder = disk.0.join("sweep");
        let full = output(sweep(&folder, 2000, 0.2));
        assert_eq!(full.status.code(), Some(3), "{kilobytes} kB: {}", errors(&full));
        assert!(errors(&full).contains("check free space"), "{}", errors(&full));
        disk.remount("size=64M");
        let text = errors(&expect_code(sweep(&folder, 2000, 0.0), ROWS_FAILED));
        assert!(!text.contains("damaged"), "{text}");
        assert_same(&whole, &folder);
    }
}

#[test]
fn a_read_only_folder_is_an_error_that_says_so() {
    let scratch = TempDir::new().expect("scratch folder");
    let Some(disk) = Mounted::new(&scratch.path().join("disk"), "size=8M") else {
        return;
    };
    let folder = disk.0.join("sweep");
    let mut limited = sweep(&folder, 2000, 0.0);
    limited.args(["--max-failed", "0"]);
    expect_code(limited, 6);
    let before = contract(&folder);
    disk.remount("ro");
    let text = errors(&expect_code(sweep(&folder, 2000, 0.0), 3));
    assert!(text.to_lowercase().contains("read-only"), "{text}");
    assert!(before == contract(&folder));
}

#[test]
fn memory_stays_bounded() {
    let scratch = TempDir::new().expect("scratch folder");
    let peak = |rows: u64| {
        let summary = scratch.path().join("summary.json");
        let mut command = sweep(&scratch.path().join(rows.to_string()), rows, 0.0);
        command.arg("--summary").arg(&summary);
        expect_code(command, ROWS_FAILED);
        let summary: serde_json::Value = serde_json::from_slice(&fs::read(summary).expect("file")).expect("JSON");
        summary["peak_memory_bytes"].as_u64()
    };
    let Some(peak) = peak(60_000) else {
        println!("skipped: this system does not tell a process's memory");
        return;
    };
    println!("peak memory of 60000 rows: {} MB", peak / 1_000_000);
    assert!(peak < 300_000_000, "{peak} bytes");
}
