//! Lock for one writer per dataset or table of rows. It ends with its process, however the process ends.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::durable::{failed_to, refuse_link};
use super::error::DatasetError;
use decore_files::{Limit, read};

/// Name of the lock's file in the dataset's folder.
pub const LOCK_NAME: &str = ".lock";

/// The right to write to a dataset, or to a file of rows.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    /// Open as long as the lock is held.
    file: Option<File>,
    place: DatasetDir,
}

/// The folder of a dataset and its lock as they were when the lock was taken.
///
/// A folder that is removed and created again during a sweep is another folder: new files there would mix with rows of another writer.
#[derive(Debug, Clone)]
pub struct DatasetDir {
    path: PathBuf,
    /// Nothing on Windows: a folder with an open file cannot be taken away there.
    held: Option<Arc<Held>>,
}

/// Held open: their identities are not given to another folder or file meanwhile.
#[derive(Debug)]
struct Held {
    folder: File,
    _lock: File,
    /// The lock is looked for with every row: its identity and its path are at hand.
    identity: Identity,
    path: PathBuf,
}

impl DatasetDir {
    fn new(folder: &Path, lock: &File, path: &Path) -> io::Result<Self> {
        let held = if cfg!(windows) {
            None
        } else {
            Some(Arc::new(Held {
                folder: File::open(folder)?,
                _lock: lock.try_clone()?,
                identity: identity(&lock.metadata()?),
                path: path.to_owned(),
            }))
        };
        Ok(Self { path: folder.to_owned(), held })
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the path still leads to the folder.
    pub fn is_there(&self) -> bool {
        self.held.as_ref().is_none_or(|held| is_same(&held.folder, &self.path))
    }

    /// The lock in the folder must be the one that was taken: then the folder is that too.
    ///
    /// # Errors
    /// [`DatasetError::Gone`].
    pub fn check(&self) -> Result<(), DatasetError> {
        let is_ours = |held: &Arc<Held>| fs::metadata(&held.path).is_ok_and(|named| identity(&named) == held.identity);
        if self.held.as_ref().is_none_or(is_ours) {
            return Ok(());
        }
        Err(DatasetError::Gone { path: self.path.clone() })
    }
}

impl Lock {
    /// Takes the lock of the dataset in `folder`, which must exist.
    ///
    /// # Errors
    /// [`DatasetError::InUse`] if another process has it, or the system's.
    pub fn take(folder: &Path) -> Result<Self, DatasetError> {
        Self::take_named(folder, folder, folder.join(LOCK_NAME))
    }

    /// Locks a file of rows, which must exist, with `.NAME.lock` in its real folder. The file itself cannot be the lock, because adding
    /// rows replaces it.
    ///
    /// # Errors
    /// As [`Lock::take`].
    pub fn take_beside(file: &Path) -> Result<Self, DatasetError> {
        let own = file.canonicalize().map_err(failed_to("open", file))?;
        let name = own.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let folder = own.parent().unwrap_or(Path::new("."));
        Self::take_named(file, folder, folder.join(format!(".{name}{LOCK_NAME}")))
    }

    /// Takes the lock at `path` in `folder`, for the path to be written.
    fn take_named(written: &Path, folder: &Path, path: PathBuf) -> Result<Self, DatasetError> {
        loop {
            let file = open(&path).map_err(failed_to("open", &path))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    // Windows lets nobody read a file that is locked.
                    let owner = read(&path, Limit::STATUS).unwrap_or_else(|_| b"whose name cannot be read".to_vec());
                    let owner = String::from_utf8_lossy(&owner).trim().to_owned();
                    return Err(DatasetError::InUse { path: written.to_owned(), owner });
                }
                Err(TryLockError::Error(source)) if has_no_locks(&source) => {
                    // Remove all traces of the attempt.
                    let _ = fs::remove_file(&path);
                    return Err(DatasetError::NoLocks { path, source });
                }
                Err(TryLockError::Error(error)) => return Err(failed_to("lock", &path)(error)),
            }
            // The owner before may have removed the file between our opening and locking it.
            if is_same(&file, &path) {
                let place = DatasetDir::new(folder, &file, &path).map_err(failed_to("open", folder))?;
                sign(&file).map_err(failed_to("write", &path))?;
                return Ok(Self { path, file: Some(file), place });
            }
        }
    }

    /// Whether a process writes to the dataset in `folder`.
    pub fn is_taken(folder: &Path) -> bool {
        let file = OpenOptions::new().read(true).write(true).open(folder.join(LOCK_NAME));
        file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
    }

    /// Folder of the dataset, for its writer.
    pub fn place(&self) -> &DatasetDir {
        &self.place
    }
}

/// Whether the file system refuses locks altogether: ENOSYS and EOPNOTSUPP, which are `Unsupported`, or ENOLCK.
fn has_no_locks(error: &io::Error) -> bool {
    const ENOLCK: i32 = if cfg!(target_os = "linux") { 37 } else { 77 };
    error.kind() == ErrorKind::Unsupported || (cfg!(unix) && error.raw_os_error() == Some(ENOLCK))
}

/// Opens the lock's file, or makes it.
fn open(path: &Path) -> io::Result<File> {
    refuse_link(path)?;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    #[cfg(windows)]
    {
        // Others may open it, not remove it: the folder stays where it is as long as it is written to.
        const READ_AND_WRITE: u32 = 3;
        std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, READ_AND_WRITE);
    }
    options.open(path)
}

/// Writes who has the lock, for the message to others.
fn sign(mut file: &File) -> io::Result<()> {
    file.set_len(0)?;
    writeln!(file, "process {} on {}", std::process::id(), host_name())
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Nobody else can have this lock while it is held, so its name can be removed, unless it belongs to another lock in a recreated
        // folder. A remaining file is harmless.
        if self.place.check().is_ok() {
            if cfg!(windows) {
                // A file that is open cannot be removed there; whoever opens it in between keeps it.
                self.file = None;
            }
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Host name of this machine, if the system has one.
pub fn host_name() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").or_else(|_| fs::read_to_string("/etc/hostname"));
    let name = name.ok().or_else(|| std::env::var("COMPUTERNAME").ok()).unwrap_or_default();
    if name.trim().is_empty() { "this machine".to_owned() } else { name.trim().to_owned() }
}

/// Numbers that identify a file among all existing files.
type Identity = (u64, u64);

#[cfg(unix)]
fn identity(metadata: &fs::Metadata) -> Identity {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

/// Elsewhere a file that is open cannot be taken away.
#[cfg(not(unix))]
fn identity(_: &fs::Metadata) -> Identity {
    (0, 0)
}

fn is_same(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::metadata(path)) {
        (Ok(ours), Ok(named)) => identity(&ours) == identity(&named),
        _ => false,
    }
}
