//! Hosts with limits: little address space, many threads on few cores, file systems without locks, signals of batch systems.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

const DECORE: &str = env!("CARGO_BIN_EXE_decore");
const STUDY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/placement.toml");
/// Settings that make a row quick.
const QUICK: [&str; 4] = ["--set", "solver.fidelity=draft", "--set", "duration_s=0.06"];

/// Rows of the shipped study under a limit of the shell.
fn limited(limit: &str, rows: u32, threads: &str, folder: &Path) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("{limit}; exec \"$0\" \"$@\""), DECORE, "run", STUDY, "--output"]).arg(folder);
    command.args(["--set", &format!("design.rows={rows}"), "--threads", threads]).args(QUICK).output().expect("sh runs")
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn the_main_job_needs_little_address_space() {
    let scratch = TempDir::new().expect("scratch folder");
    for (limit, threads) in [("ulimit -v 300000", "2"), ("ulimit -v 1000000", "8"), ("ulimit -v 1000000", "64")] {
        let ended = limited(limit, 96, threads, &scratch.path().join(threads));
        assert_eq!(ended.status.code(), Some(0), "{limit}, {threads} threads: {}", words(&ended));
    }
}

#[test]
fn memory_that_runs_out_is_told_with_words() {
    let scratch = TempDir::new().expect("scratch folder");
    for limit in [60_000, 80_000, 100_000] {
        let ended = limited(&format!("ulimit -v {limit}"), 24, "8", &scratch.path().join(limit.to_string()));
        let said = words(&ended);
        let code = ended.status.code();
        // Where two threads run out at the same moment, the second ends the program while the first prints its message.
        let aborted = std::os::unix::process::ExitStatusExt::signal(&ended.status) == Some(6);
        assert!(aborted || matches!(code, Some(0 | 2 | 3)), "{limit}: {:?}: {said}", ended.status);
        assert!(code == Some(0) || said.contains("error: ") && said.contains("ulimit -v"), "{limit}: {said}");
    }
}

#[test]
fn absurd_numbers_of_threads_in_the_environment_are_refused() {
    for (value, name) in [("100000", "RAYON_NUM_THREADS"), ("many", "RAYON_NUM_THREADS"), ("5000", "RAYON_RS_NUM_CPUS")]
    {
        let scratch = TempDir::new().expect("scratch folder");
        let mut command = Command::new(DECORE);
        command.env_remove("RAYON_NUM_THREADS").env(name, value).current_dir(scratch.path());
        let ended = command.args(["run", STUDY]).args(QUICK).output().expect("decore runs");
        assert_eq!(ended.status.code(), Some(2), "{}", words(&ended));
        let expected = format!("{name} is `{value}`, expected a whole number from 0 (one thread per core) to 1024");
        assert!(words(&ended).contains(&expected), "{}", words(&ended));
        assert!(!scratch.path().join("out").exists());
    }
}

#[test]
fn a_file_system_without_locks_is_named() {
    let scratch = TempDir::new().expect("scratch folder");
    let (source, library) = (scratch.path().join("shim.c"), scratch.path().join("shim.so"));
    let text = "#include <errno.h>\n#include <stdlib.h>\nint flock(int f, int o) { errno = atoi(getenv(\"NO_LOCKS\")); return -1; }\n";
    fs::write(&source, text).expect("written");
    let built = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&source).status();
    assert!(built.expect("a C compiler, as the dependencies need one").success());
    // ENOLCK, ENOSYS, EOPNOTSUPP.
    for number in ["37", "38", "95"] {
        let folder = scratch.path().join(number);
        let mut command = Command::new(DECORE);
        command.env("LD_PRELOAD", &library).env("NO_LOCKS", number);
        let ended = command.args(["run", STUDY, "--stub-row-ms", "0", "--output"]).arg(&folder).output().expect("runs");
        let said = words(&ended);
        assert_eq!(ended.status.code(), Some(3), "{said}");
        assert!(said.contains("has no file locks") && said.contains("write to another file system"), "{said}");
        assert!(!said.contains("free space") && !folder.join(".lock").exists(), "{said}");
        // Nothing is in the way of a later run.
        let mut command = Command::new(DECORE);
        let ended = command.args(["run", STUDY, "--stub-row-ms", "0", "--output"]).arg(&folder).output().expect("runs");
        assert_eq!(ended.status.code(), Some(0), "{}", words(&ended));
    }
}

/// A sweep of the test scene that has begun, with this handling of hangups from its parent.
fn begun(hangup: libc::sighandler_t, folder: &Path) -> Child {
    let mut command = Command::new(DECORE);
    // SAFETY: between fork and exec; the call is allowed there. The tests themselves may run under `nohup`.
    unsafe {
        command.pre_exec(move || {
            libc::signal(libc::SIGHUP, hangup);
            Ok(())
        })
    };
    command.args(["run", STUDY, "--stub-row-ms", "30", "--output"]);
    command.arg(folder).args(["--threads", "2", "--set", "design.rows=200"]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("sh runs");
    let begin = Instant::now();
    while !folder.join(".journal").exists() && begin.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    child
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
}

#[test]
fn usr1_prints_the_progress_and_ends_nothing() {
    let scratch = TempDir::new().expect("scratch folder");
    let child = begun(libc::SIG_DFL, &scratch.path().join("sweep"));
    send("-USR1", &child);
    let ended = child.wait_with_output().expect("ended");
    let said = words(&ended);
    assert_eq!(ended.status.code(), Some(0), "{said}");
    let lines: Vec<&str> = said.lines().filter(|line| line.contains(" of 200 rows")).collect();
    assert!(lines.len() == 2 && !lines[0].contains("in all") && lines[1].contains("in all"), "{said}");
}

#[test]
fn a_hangup_ends_a_sweep_in_order_but_under_nohup() {
    let scratch = TempDir::new().expect("scratch folder");
    for (hangup, code) in [(libc::SIG_DFL, 5), (libc::SIG_IGN, 0)] {
        let child = begun(hangup, &scratch.path().join(code.to_string()));
        send("-HUP", &child);
        let ended = child.wait_with_output().expect("ended");
        assert_eq!(ended.status.code(), Some(code), "{}", words(&ended));
    }
}

#[test]
fn a_check_of_a_study_without_a_row_that_runs_fails() {
    let check = |further: &[&str]| {
        let mut command = Command::new(DECORE);
        command.args(["check", STUDY]).args(QUICK).args(further).output().expect("decore runs")
    };
    let ended = check(&["--set", "casting.part.size_m=[0.001, 0.001]"]);
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(4), "{said}");
    assert!(said.contains("240 of 240 rows cannot be simulated"), "{said}");
    assert_eq!(check(&[]).status.code(), Some(0));
}

#[test]
fn a_key_that_is_nested_too_deep_has_its_line() {
    let scratch = TempDir::new().expect("scratch folder");
    let path = scratch.path().join("study.toml");
    let deep = vec!["a"; 300].join(".");
    for (text, line) in [
        (format!("title = \"x\"\n[a]\n{deep} = 1\n"), "study.toml:3:1: "),
        (format!("title = \"x\"\n\n\n[{deep}]\nb = 1\n"), "study.toml:4:2: "),
        (format!("b = {{ {deep} = 1 }}\n"), "study.toml:1:7: "),
    ] {
        fs::File::create(&path).and_then(|mut file| file.write_all(text.as_bytes())).expect("written");
        let ended = Command::new(DECORE).arg("check").arg(&path).output().expect("decore runs");
        let said = words(&ended);
        assert_eq!(ended.status.code(), Some(2), "{said}");
        assert!(said.contains(line) && said.contains("at most 80 parts"), "{said}");
    }
}
