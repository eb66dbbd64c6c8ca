//! Files that are either whole or not there.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::DatasetError;
#[cfg(test)]
use super::trace::{Event, note};

/// Adds what was tried, and on what, to an error of the system.
pub fn failed_to(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> DatasetError {
    let path = path.to_owned();
    move |source| DatasetError::Io { action, path, source }
}

/// A file that is complete and synced in the staging folder, not yet in place.
pub struct StagedFile {
    staged: PathBuf,
    target: PathBuf,
}

impl StagedFile {
    /// Writes and syncs `bytes` to a file of the staging folder.
    ///
    /// # Errors
    /// The system's, such as a full disk; nothing is in place then.
    pub fn write(staging: &Path, target: &Path, bytes: &[u8]) -> Result<Self, DatasetError> {
        let mut name = target.file_name().unwrap_or_default().to_owned();
        // A suffix that no glob for `*.parquet` matches, should somebody look into the staging folder.
        name.push(".partial");
        let staged = staging.join(name);
        // What lies there under this name was left by a killed process or planted: a link is removed, not followed.
        match fs::remove_file(&staged) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed_to("remove", &staged)(error)),
            _ => {}
        }
        let created = OpenOptions::new().write(true).create_new(true).open(&staged);
        let mut file = created.map_err(failed_to("create", &staged))?;
        let written = file.write_all(bytes).and_then(|()| file.sync_all());
        written.map_err(|error| {
            drop(fs::remove_file(&staged));
            failed_to("write", &staged)(error)
        })?;
        #[cfg(test)]
        {
            note(&staged, || Event::Contents(staged.clone(), bytes.to_vec()));
            note(&staged, || Event::SyncFile(staged.clone()));
        }
        Ok(Self { staged, target: target.to_owned() })
    }

    /// Renames the file into place; the folder must still be synced.
    ///
    /// # Errors
    /// The system's.
    pub fn put_in_place(self) -> Result<(), DatasetError> {
        fs::rename(&self.staged, &self.target).map_err(|error| {
            drop(fs::remove_file(&self.staged));
            failed_to("rename into place", &self.target)(error)
        })?;
        #[cfg(test)]
        note(&self.target, || Event::Rename(self.staged.clone(), self.target.clone()));
        Ok(())
    }
}

/// Makes a folder and those above it, if they are not there.
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
