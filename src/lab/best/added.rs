//! Table of the rows that a search has added, next to the dataset.

use std::path::{Path, PathBuf};

use super::task::{Added, Purpose};
use decore_files::{Limit, read_text};
use decore_study::{Study, column_rows};

/// Columns of the table after the factors: purpose and question of a row.
pub const ADDED_COLUMNS: [&str; 2] = ["purpose", "question"];

/// Folder of the dataset of rows that were added to the dataset in `folder`.
pub fn added_folder(folder: &Path) -> PathBuf {
    beside(folder, ".best")
}

/// Table of the rows that were added to the dataset in `folder`.
pub fn added_file(folder: &Path) -> PathBuf {
    beside(folder, ".best.csv")
}

/// A path with something behind its name.
fn beside(folder: &Path, ending: &str) -> PathBuf {
    // `results/` and `results` are one folder.
    let folder: PathBuf = folder.components().collect();
    let mut name = folder.file_name().map_or_else(|| "dataset".into(), std::ffi::OsStr::to_os_string);
    name.push(ending);
    folder.with_file_name(name)
}

/// Reads the table of added rows, in their order.
///
/// # Errors
/// File not found, a line with missing cells, or an unknown purpose, as a message.
pub fn read_added(file: &Path, study: &Study) -> Result<Vec<Added>, String> {
    let text = read_text(file, Limit::ROWS).map_err(|source| format!("failed to read {}: {source}", file.display()))?;
    if text.lines().count() <= 1 {
        return Ok(Vec::new());
    }
    let names = study.factors().iter().map(|factor| factor.name.as_str());
    let names: Vec<&str> = names.chain(ADDED_COLUMNS).collect();
    let read = |mut cells: Vec<String>| {
        let (question, purpose) = (cells.pop().unwrap_or_default(), cells.pop().unwrap_or_default());
        let known = Purpose::read(&purpose);
        known.map(|purpose| Added { purpose, question, cells }).ok_or_else(|| {
            format!("{}: `{purpose}` in column `purpose` is none of `learn`, `compare`, `check`", file.display())
        })
    };
    column_rows(file, &names)?.into_iter().map(|row| read(row.cells)).collect()
}
