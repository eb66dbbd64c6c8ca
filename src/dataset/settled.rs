//! Checks whether a dataset has all its rows, and completes an interrupted growth.

use std::path::Path;

use super::columns::TableName;
use super::durable::{rename, sync_folder};
use super::error::DatasetError;
use super::journal::{self, JOURNAL};
use super::lock::Lock;
use super::manifest::{MANIFEST_NAME, Manifest, TIMINGS_NAME};
use super::store::{GROWING, remove};

/// Marker file in the grown dataset: it is whole and replaces the dataset around it.
pub const READY: &str = "ready";

/// Completes an interrupted growth of the dataset in `folder`, or undoes it if it was incomplete. Without such a growth it does nothing,
/// and needs no lock.
///
/// # Errors
/// [`DatasetError::InUse`] or the system's.
pub fn settle(folder: &Path) -> Result<(), DatasetError> {
    if !folder.join(GROWING).exists() {
        return Ok(());
    }
    let _lock = Lock::take(folder)?;
    settle_locked(folder)
}

/// As [`settle`], for whoever has the lock.
///
/// # Errors
/// The system's.
pub fn settle_locked(folder: &Path) -> Result<(), DatasetError> {
    let growing = folder.join(GROWING);
    if growing.join(READY).exists() {
        remove(&folder.join(JOURNAL))?;
        // The manifest goes last: until then the dataset is the old one with parts that its manifest calls damaged.
        let tables = TableName::KNOWN.map(TableName::folder);
        for name in tables.into_iter().chain([TIMINGS_NAME, MANIFEST_NAME]) {
            let (from, to) = (growing.join(name), folder.join(name));
            if from.exists() {
                // A file is replaced in one step, a folder is not.
                if to.is_dir() {
                    remove(&to)?;
                }
                rename(&from, &to)?;
            }
        }
        sync_folder(folder)?;
    }
    remove(&growing)
}

/// Whether a dataset has all rows that it is to hold in parts: none is missing, and none waits in the journal.
///
/// # Errors
/// Any error of [`Manifest::read`], or a system error.
pub fn is_settled(folder: &Path) -> Result<bool, DatasetError> {
    let waits = folder.join(GROWING).exists() || journal::count(folder, &|_| true)?.0 > 0;
    Ok(!waits && Manifest::read(folder)?.complete)
}
