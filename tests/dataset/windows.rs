//! What Windows lets happen to a sweep that runs.
#![cfg(windows)]

use std::fs;

use crate::synthetic::{ROWS, contract, dataset, info, outcome, record};
use decore::dataset::{DatasetError, DatasetWriter, Existing};
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
