//! What the runner costs: a sweep of the built-in test scene with rows of 1 ms on two threads.
//!
//! `cargo bench --bench runner`; `DECORE_BENCH_ROWS` sets the number of rows (default 1,000,000: eleven minutes). Fails if the
//! memory or the overhead is above its limit, or if DuckDB (`pip install duckdb`) does not open the dataset in a second.

#[path = "support/mod.rs"]
mod support;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Largest resident memory in bytes.
const MEMORY_LIMIT_BYTES: u64 = 300_000_000;
/// Largest overhead: wall time of all threads over the rows' own time, less one.
const OVERHEAD_LIMIT: f64 = 0.02;
/// Longest time in s in which DuckDB opens the dataset and counts its rows.
const OPEN_LIMIT_S: f64 = 1.0;

const HEAD: &str = "# Runner

Written by `cargo bench --bench runner`: a sweep of the built-in test scene, whose rows of 1 ms sleep, on two threads. Overhead is
the wall time of both threads over the rows' own time, less one: what starting rows, the journal, parts and progress take. A tenth
of the rows run before with a scene that computes for 1 ms of processor time: on two processors the runner's threads, and whatever
else the machine does, then take their time from the rows.

|||
|---|---|
";

fn main() {
    let rows = std::env::var("DECORE_BENCH_ROWS").map_or(1_000_000, |rows| rows.parse::<u64>().expect("a number"));
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("bench-runner");
    let computing = overhead(&sweep(&folder, rows / 10, &["--stub-busy"]));
    let summary = sweep(&folder, rows, &[]);
    let overhead = overhead(&summary);
    let memory = summary["peak_memory_bytes"].as_u64().unwrap_or(0);
    let open_s = open_with_duckdb(&folder);
    let mut text = String::from(HEAD);
    let _ = writeln!(text, "| rows | {rows} |");
    let _ = writeln!(text, "| overhead | {:.2} % (limit {:.0} %) |", 100.0 * overhead, 100.0 * OVERHEAD_LIMIT);
    let _ = writeln!(text, "| overhead, computing rows | {:.2} % |", 100.0 * computing);
    let _ = writeln!(text, "| peak memory | {} MB (limit {}) |", memory / 1_000_000, MEMORY_LIMIT_BYTES / 1_000_000);
    if let Some(seconds) = open_s {
        let _ = writeln!(text, "| opened by DuckDB in | {seconds:.2} s (limit {OPEN_LIMIT_S} s) |");
    }
    println!("{text}");
    support::write_section("runner", &text);
    assert!(open_s.is_none_or(|seconds| seconds < OPEN_LIMIT_S), "DuckDB took {open_s:?} s");
    assert!(memory < MEMORY_LIMIT_BYTES, "{memory} bytes");
    assert!(overhead < OVERHEAD_LIMIT, "overhead {overhead}");
}

/// Runs a sweep of the test scene; returns its completion file.
fn sweep(folder: &Path, rows: u64, scene: &[&str]) -> serde_json::Value {
    let summary = folder.with_extension("json");
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/placement.toml");
    let status = Command::new(env!("CARGO_BIN_EXE_decore"))
        .args(["run", study, "--replace", "--threads", "2", "--stub-row-ms", "1"])
        .args(scene)
        .args(["--set", &format!("design.rows={rows}"), "--output"])
        .arg(folder)
        .arg("--summary")
        .arg(&summary)
        .status();
    assert!(status.expect("decore runs").code().is_some_and(|code| code == 0 || code == 4));
    serde_json::from_slice(&std::fs::read(&summary).expect("summary")).expect("JSON")
}

/// Wall time of both threads over the rows' own time, less one.
fn overhead(summary: &serde_json::Value) -> f64 {
    let number = |key: &str| summary[key].as_f64().expect("a number");
    2.0 * number("wall_time_s") / number("row_time_s") - 1.0
}

/// Time in which DuckDB opens all parts, counts the rows and averages an output; `None` without DuckDB.
fn open_with_duckdb(folder: &Path) -> Option<f64> {
    const SCRIPT: &str = "import duckdb, sys, time; begin = time.time(); \
        print(duckdb.sql(f\"select count(*), avg(delivered_work_j) from '{sys.argv[1]}/runs/*.parquet'\").fetchall(), \
        file=sys.stderr); print(time.time() - begin)";
    let output = Command::new("python3").args(["-c", SCRIPT]).arg(folder).output().ok()?;
    if !output.status.success() {
        println!("DuckDB               not installed: skipped");
        return None;
    }
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}
