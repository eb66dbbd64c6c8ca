//! What a system lets happen to a sweep that runs: its folder taken away, its files cut short or not allowed to grow.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::synthetic::{ROWS, contract, dataset, info, outcome, record};
use decore_dataset::{DatasetError, DatasetWriter, Existing};
use tempfile::TempDir;

#[test]
fn a_folder_made_anew_belongs_to_its_new_writer() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let mut first = DatasetWriter::create(&folder, &info(), Existing::Refuse).expect("created");
    (0..10).for_each(|row| first.write(&record(row, outcome(row))).expect("taken"));
    fs::remove_dir_all(&folder).expect("removed");
    let mut second = DatasetWriter::create(&folder, &info(), Existing::Refuse).expect("created anew");
    (0..70).for_each(|row| second.write(&record(row, outcome(row))).expect("taken"));
    // The first row of a block would open a file: the second's.
    let error = first.recorder().record(&record(64, outcome(64))).expect_err("refused");
    assert!(matches!(error, DatasetError::Gone { .. }), "{error}");
    let error = first.write(&record(10, outcome(10))).expect_err("refused");
    assert!(matches!(error, DatasetError::Gone { .. }), "{error}");
    assert!(matches!(first.finish(), Err(DatasetError::Gone { .. })));
    // The end of the first takes nothing from the second, not even its lock.
    let error = DatasetWriter::create(&folder, &info(), Existing::Resume).err().expect("refused");
    assert!(matches!(error, DatasetError::InUse { .. }), "{error}");
    (70..ROWS).for_each(|row| second.write(&record(row, outcome(row))).expect("taken"));
    assert!(second.finish().expect("finished").complete);
    let (_scratch, whole) = dataset();
    assert_eq!(contract(&folder), contract(&whole));
}

#[test]
fn a_limit_on_file_sizes_is_an_error_not_the_end() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let sweep = crate::sweeps::sweep(&folder, 300, 0.0);
    let words: Vec<String> = std::iter::once(sweep.get_program())
        .chain(sweep.get_args())
        .map(|word| format!("'{}'", word.to_string_lossy()))
        .collect();
    // In blocks of 512 bytes or 1 kB: below a span of the journal.
    let limited = format!("ulimit -f 100; exec {}", words.join(" "));
    let ended = std::process::Command::new("sh").args(["-c", &limited]).output().expect("sh runs");
    let text = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(3), "{text}");
    assert!(text.contains("too large"), "{text}");
}

#[test]
fn a_journal_cut_short_from_outside_ends_the_sweep_with_words() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let mut sweep = crate::sweeps::sweep(&folder, 500, 5.0);
    let child = sweep.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("decore starts");
    let path = folder.join(".journal/000000000000.rows");
    let begin = Instant::now();
    // Not before it has room for rows: a file that is only just made is filled after the cut.
    let has_room = || fs::metadata(&path).is_ok_and(|file| file.len() > 1000);
    while !has_room() && begin.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    let file = fs::OpenOptions::new().write(true).open(&path).expect("the journal");
    file.set_len(0).expect("cut short");
    let ended = child.wait_with_output().expect("ended");
    let text = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code() == Some(3) && text.contains("cut short by another program"), "{ended:?}");
    crate::sweeps::expect_code(crate::sweeps::sweep(&folder, 500, 0.0), 0);
}

#[test]
fn nothing_is_said_to_be_kept_in_a_folder_that_is_being_removed() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let mut sweep = crate::sweeps::sweep(&folder, 1000, 20.0);
    let child = sweep.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("decore starts");
    let begin = Instant::now();
    while !folder.join(".journal/000000000000.rows").exists() && begin.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    // What a removal of the folder takes first: the folder itself is there still.
    fs::remove_file(folder.join(".lock")).expect("the lock");
    let ended = child.wait_with_output().expect("ended");
    let text = String::from_utf8_lossy(&ended.stderr);
    assert!(
        ended.status.code() == Some(3) && text.contains("was removed, moved or replaced during the sweep"),
        "{text}"
    );
    assert!(!text.contains("is kept in"), "{text}");
}
