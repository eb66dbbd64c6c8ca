//! Sweeps of the built-in test scene, run as separate processes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Output};

/// A study of this repository whose number of rows can be set.
pub const STUDY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/placement.toml");

/// The program.
pub fn decore() -> Command {
    Command::new(env!("CARGO_BIN_EXE_decore"))
}

/// A sweep of `rows` rows of `row_ms` each into `folder`, on two threads.
pub fn sweep(folder: &Path, rows: u64, row_ms: f64) -> Command {
    sweep_on(2, folder, rows, row_ms)
}

/// A sweep on a number of threads.
pub fn sweep_on(threads: u32, folder: &Path, rows: u64, row_ms: f64) -> Command {
    let mut command = decore();
    command.arg("run").arg(STUDY).arg("--output").arg(folder).args(["--threads", &threads.to_string()]);
    command.args(["--set", &format!("design.rows={rows}"), "--stub-row-ms", &row_ms.to_string()]);
    command
}

/// Runs to the end, whatever it is.
pub fn output(mut command: Command) -> Output {
    command.output().expect("decore runs")
}

/// Standard error as text.
pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs to the end and holds it to an exit code.
pub fn expect_code(command: Command, code: i32) -> Output {
    let output = output(command);
    assert_eq!(output.status.code(), Some(code), "{}", errors(&output));
    output
}

/// The files that must not depend on how the dataset came about: `runs/`, `blows/` and the manifest.
pub fn contract(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for table in ["runs", "blows"] {
        for entry in fs::read_dir(folder.join(table)).expect("table") {
            let path = entry.expect("entry").path();
            let name = path.strip_prefix(folder).expect("below").to_owned();
            found.insert(name, fs::read(&path).expect("part"));
        }
    }
    found.insert("manifest.json".into(), fs::read(folder.join("manifest.json")).expect("manifest"));
    found
}

/// Holds two datasets to the same bytes.
pub fn assert_same(one: &Path, other: &Path) {
    let (one, other) = (contract(one), contract(other));
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    assert!(one.len() > 2);
    for (name, bytes) in &one {
        assert!(*bytes == other[name], "{} differs", name.display());
    }
}

/// Whether a process was ended by [`std::process::Child::kill`]: by a signal, or on Windows with a code that decore never has.
pub fn was_killed(ended: ExitStatus) -> bool {
    ended.code() == if cfg!(windows) { Some(1) } else { None }
}

/// What `decore status --json` says of a dataset.
pub fn status(folder: &Path) -> serde_json::Value {
    let mut command = decore();
    command.arg("status").arg("--json").arg(folder);
    let output = expect_code(command, 0);
    let list: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    list[0]["status"].clone()
}

/// Sends a signal to a process.
#[cfg(unix)]
pub fn signal(name: &str, process: u32) {
    let sent = Command::new("kill").arg(format!("-{name}")).arg(process.to_string()).status();
    assert!(sent.expect("kill runs").success());
}
