//! What Windows lets happen to a sweep that runs.
#![cfg(windows)]

use std::fs::{self, File};
use std::thread;
use std::time::Duration;

use crate::synthetic::{ROWS, contract, dataset, info, outcome, record};
use decore_dataset::{DatasetError, DatasetWriter, Existing};
use decore_files::Staged;
use tempfile::TempDir;

#[test]
fn a_folder_in_use_stays_where_it_is() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let mut writer = DatasetWriter::create(&folder, &info(), Existing::Refuse).expect("created");
    (0..10).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    fs::remove_file(folder.join(".lock")).expect_err("the lock is held");
    let error = DatasetWriter::create(&folder, &info(), Existing::Resume).err().expect("refused");
    assert!(matches!(error, DatasetError::InUse { .. }), "{error}");
    (10..ROWS).for_each(|row| writer.write(&record(row, outcome(row))).expect("taken"));
    assert!(writer.finish().expect("finished").complete);
    assert!(!folder.join(".lock").exists());
    let (_scratch, whole) = dataset();
    assert_eq!(contract(&folder), contract(&whole));
}

#[test]
fn a_file_that_is_being_read_is_replaced_once_its_reader_is_through() {
    let scratch = TempDir::new().expect("scratch folder");
    let target = scratch.path().join("rows.csv");
    fs::write(&target, "before").expect("written");
    let held = File::open(&target).expect("opens");
    let reader = thread::spawn(move || {
        thread::sleep(Duration::from_millis(200));
        drop(held);
    });
    let staged = Staged::write(scratch.path(), &target, b"after").expect("written");
    staged.put_in_place().expect("in place");
    reader.join().expect("ends");
    assert_eq!(fs::read(&target).expect("read"), b"after");
    assert_eq!(fs::read_dir(scratch.path()).expect("folder").count(), 1);
}
