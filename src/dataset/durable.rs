//! Files that are either complete or absent, and durable.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use super::error::DatasetError;
#[cfg(test)]
use super::trace::{Event, note};
use decore_files::Staged;

/// Adds action and path to a system error.
pub fn failed_to(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> DatasetError {
    let path = path.to_owned();
    move |source| DatasetError::Io { action, path, source }
}

/// Refuses a symbolic link in place of a file that is changed in place: the link's target would be overwritten.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`].
pub fn refuse_link(path: &Path) -> io::Result<()> {
    if fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink()) {
        let message = "it is a symbolic link, which decore never makes here: remove the link";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    Ok(())
}

/// A file that is complete and synced in the staging folder, not yet in place.
pub struct StagedFile(Staged);

impl StagedFile {
    /// Writes and syncs `bytes` to a file of the staging folder.
    ///
    /// # Errors
    /// The system's, such as a full disk; nothing is in place then.
    pub fn write(staging: &Path, target: &Path, bytes: &[u8]) -> Result<Self, DatasetError> {
        let staged = Staged::write(staging, target, bytes).map_err(failed_to("write", target))?;
        staged.sync().map_err(failed_to("sync", target))?;
        #[cfg(test)]
        {
            let path = staged.path().to_owned();
            note(&path, || Event::Contents(path.clone(), bytes.to_vec()));
            note(&path, || Event::SyncFile(path.clone()));
        }
        Ok(Self(staged))
    }

    /// Renames the file into place; the folder must still be synced.
    ///
    /// # Errors
    /// The system's.
    pub fn put_in_place(self) -> Result<(), DatasetError> {
        let target = self.0.target().to_owned();
        #[cfg(test)]
        let from = self.0.path().to_owned();
        self.0.put_in_place().map_err(failed_to("rename into place", &target))?;
        #[cfg(test)]
        note(&target, || Event::Rename(from, target.clone()));
        Ok(())
    }
}

/// [`decore_files::rename`].
///
/// # Errors
/// The system's.
pub fn rename(from: &Path, to: &Path) -> Result<(), DatasetError> {
    decore_files::rename(from, to).map_err(failed_to("rename into place", to))
}

/// Makes a folder and its parents, if they do not exist.
///
/// # Errors
/// The system's.
pub fn make_folder(folder: &Path) -> Result<(), DatasetError> {
    fs::create_dir_all(folder).map_err(failed_to("create", folder))?;
    #[cfg(test)]
    note(folder, || Event::MakeFolder(folder.to_owned()));
    Ok(())
}

/// Makes the names in a folder survive a power failure.
///
/// # Errors
/// The system's.
pub fn sync_folder(folder: &Path) -> Result<(), DatasetError> {
    // Elsewhere folders cannot be opened as files and renames are journalled by the file system.
    if cfg!(unix) {
        let file = File::open(folder).map_err(failed_to("open", folder))?;
        file.sync_all().map_err(failed_to("sync", folder))?;
        #[cfg(test)]
        note(folder, || Event::SyncFolder(folder.to_owned()));
    }
    Ok(())
}
