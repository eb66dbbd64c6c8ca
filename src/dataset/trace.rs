//! Record of disk operations, for tests.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// An operation on the disk, or its completion.
#[derive(Debug, Clone)]
pub enum Event {
    /// A file has these contents now.
    Contents(PathBuf, Vec<u8>),
    SyncFile(PathBuf),
    MakeFolder(PathBuf),
    Rename(PathBuf, PathBuf),
    Remove(PathBuf),
    SyncFolder(PathBuf),
    /// These rows outlive a power cut from here on.
    Durable(Vec<u64>),
}

/// The folder that is recorded, and its events.
pub static RECORD: Mutex<Option<(PathBuf, Vec<Event>)>> = Mutex::new(None);

/// Records an event on `path`, if that is below the folder that is recorded.
pub fn note(path: &Path, event: impl FnOnce() -> Event) {
    if let Some((root, events)) = RECORD.lock().unwrap_or_else(PoisonError::into_inner).as_mut()
        && path.starts_with(&*root)
    {
        events.push(event());
    }
}
