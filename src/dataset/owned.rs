//! The dataset's own files in its folder: manifests, tables and hidden files of the writer. The folder may hold other files too, such as a
//! report.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use super::columns::TableName;
use super::journal::{self, JOURNAL};
use super::lock::LOCK_NAME;
use super::manifest::{MANIFEST_NAME, TIMINGS_NAME};
use super::status::{self, STATUS_NAME};
use super::store::{DAMAGED, GROWING, REPLACED, STAGING};

/// Files in the dataset's folder.
const FILES: [&str; 4] = [MANIFEST_NAME, TIMINGS_NAME, STATUS_NAME, LOCK_NAME];
/// Hidden folders in it.
const HIDDEN: [&str; 5] = [STAGING, JOURNAL, GROWING, DAMAGED, REPLACED];

/// Folder of the dataset that would own `path`; `None` if there is none. The links of `path` must be resolved. `coming`: folders that will
/// become datasets, whatever they contain now.
pub fn owner<'a>(path: &'a Path, coming: &[PathBuf]) -> Option<&'a Path> {
    path.ancestors().skip(1).find(|folder| {
        let first = path.strip_prefix(folder).ok().and_then(|inside| inside.iter().next());
        first.is_some_and(is_own) && (coming.iter().any(|one| one == folder) || holds_dataset(folder))
    })
}

/// The files of the dataset in `folder` that a reader opens.
pub fn own_files(folder: &Path) -> Vec<PathBuf> {
    let parts = |table: TableName| fs::read_dir(folder.join(table.folder())).into_iter().flatten();
    let parts = TableName::KNOWN.into_iter().flat_map(parts).filter_map(Result::ok).map(|part| part.path());
    FILES.iter().map(|name| folder.join(name)).chain(parts).collect()
}

fn is_own(name: &OsStr) -> bool {
    let tables = TableName::KNOWN.map(TableName::folder);
    let named = FILES.iter().chain(&HIDDEN).chain(&tables).any(|own| name == *own);
    named || status::is_staged(Path::new(name))
}

/// A dataset that lost its manifest is rebuilt from its parts or its journal: it is still one.
fn holds_dataset(folder: &Path) -> bool {
    [MANIFEST_NAME, TIMINGS_NAME].iter().any(|name| folder.join(name).is_file()) || journal::is_described(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dataset_owns_its_files_and_tables_and_nothing_beside_them() {
        let scratch = tempfile::tempdir().expect("scratch folder");
        let folder = scratch.path();
        let owned =
            ["manifest.json", "timings.json", "status.json", "runs", "runs/a.parquet", "signals/a", ".journal/a/b"];
        let free = ["report.html", "predict.py", "runs.parquet", "plots/runs/a.svg", ".cache/a"];
        let is_owned = |name: &str, coming: &[PathBuf]| owner(&folder.join(name), coming).is_some();
        assert!(!owned.iter().any(|name| is_owned(name, &[])), "no dataset yet");
        let coming = [folder.to_owned()];
        assert!(owned.iter().all(|name| is_owned(name, &coming)) && !free.iter().any(|name| is_owned(name, &coming)));
        for manifest in [TIMINGS_NAME, MANIFEST_NAME] {
            fs::write(folder.join(manifest), "{}").expect("written");
            assert!(owned.iter().all(|name| is_owned(name, &[])) && !free.iter().any(|name| is_owned(name, &[])));
            fs::remove_file(folder.join(manifest)).expect("removed");
        }
    }
}
