//! Files that are either complete or absent.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use tempfile::{Builder, NamedTempFile};

/// Others who share the folder may read the file, as far as the user's mask lets them.
#[cfg(unix)]
const READABLE: u32 = 0o666;

/// A file that is whole under a passing name, not yet in place; removed if it is not put there.
///
/// The name is one that nobody can foresee and that was free (a link planted there is not followed), so that several
/// processes may write the same file at once: the last one to put it in place wins.
#[derive(Debug)]
pub struct Staged {
    file: NamedTempFile,
    target: PathBuf,
}

impl Staged {
    /// Writes `bytes` to a file of the folder `staging`, which must be on the disk of `target`.
    ///
    /// # Errors
    /// The system's, such as a full disk; nothing is left then.
    pub fn write(staging: &Path, target: &Path, bytes: &[u8]) -> io::Result<Self> {
        let prefix = passing_prefix(target);
        let mut builder = Builder::new();
        // A suffix that no glob for `*.parquet` matches.
        builder.prefix(&prefix).suffix(PASSING_SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(READABLE));
        let mut file = builder.tempfile_in(staging)?;
        file.write_all(bytes)?;
        Ok(Self { file, target: target.to_owned() })
    }

    /// Waits until its bytes are on the disk.
    ///
    /// # Errors
    /// The system's.
    pub fn sync(&self) -> io::Result<()> {
        self.file.as_file().sync_all()
    }

    /// Temporary path of the file.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Final path of the file.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Moves the file into place, and replaces an existing one. The name outlives a power cut once the folder is synced.
    ///
    /// # Errors
    /// The system's; on Windows not before [`rename`] has tried again.
    pub fn put_in_place(self) -> io::Result<()> {
        let Self { file, target } = self;
        let mut left = Some(file);
        patiently(|| {
            let Some(file) = left.take() else { return Ok(()) };
            file.persist(&target).map(drop).map_err(|error| {
                left = Some(error.file);
                error.error
            })
        })
    }
}

/// Renames a file or folder; a file replaces an existing one. Windows refuses it as long as another program has the file open, such as a
/// reader or a virus scanner that is through in a moment: it is tried again, for a second in all.
///
/// # Errors
/// The system's.
pub fn rename(from: &Path, to: &Path) -> io::Result<()> {
    patiently(|| fs::rename(from, to))
}

/// Waits before it is tried again.
const WAITS_MS: [u64; 10] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512];

fn patiently(mut attempt: impl FnMut() -> io::Result<()>) -> io::Result<()> {
    for wait_ms in WAITS_MS {
        match attempt() {
            Err(error) if is_held_by_another(&error) => thread::sleep(Duration::from_millis(wait_ms)),
            done => return done,
        }
    }
    attempt()
}

/// Whether another program has the file open, or the system's error does not exclude it.
fn is_held_by_another(error: &io::Error) -> bool {
    /// `ERROR_ACCESS_DENIED`, `ERROR_SHARING_VIOLATION`.
    const HELD: [i32; 2] = [5, 32];
    cfg!(windows) && error.raw_os_error().is_some_and(|code| HELD.contains(&code))
}

const PASSING_SUFFIX: &str = ".partial";

/// Hidden: readers pass over such names.
fn passing_prefix(target: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(target.file_name().unwrap_or_default());
    prefix.push(".");
    prefix
}

/// Whether `name` may be the passing name of the file `target`, left by a process that was killed.
pub fn is_passing_name(name: &Path, target: &Path) -> bool {
    let name = name.as_os_str().as_encoded_bytes();
    name.starts_with(passing_prefix(target).as_encoded_bytes()) && name.ends_with(PASSING_SUFFIX.as_bytes())
}
