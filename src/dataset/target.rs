//! Places where files and datasets may be written. The command line and the Python package check these rules before they start work;
//! writers check them again.

use std::path::{Path, PathBuf};

use super::error::DatasetError;
use super::owned::owner;

/// Returns an error if a file's name does not end in one of `endings`.
///
/// # Errors
/// [`DatasetError::Target`].
pub fn check_ending(file: &Path, endings: &[&str]) -> Result<(), DatasetError> {
    let shown = file.display();
    let dotted = endings.iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(" or ");
    if file.is_dir() {
        return Err(DatasetError::Target(format!(
            "{shown} is a folder: give the name of a file that ends in {dotted}"
        )));
    }
    let is = |ending: &&str| file.extension().is_some_and(|kind| kind.eq_ignore_ascii_case(ending));
    if endings.iter().any(is) {
        return Ok(());
    }
    // Usual names of the file formats.
    let kind = |ending: &&str| match *ending {
        "parquet" => "Parquet".to_owned(),
        other => other.to_uppercase(),
    };
    let kinds = endings.iter().map(kind).collect::<Vec<_>>().join(" or ");
    let dotted = endings.iter().map(|ending| format!("`.{ending}`")).collect::<Vec<_>>().join(" or ");
    Err(DatasetError::Target(format!("{shown}: the output format is {kinds}: use a file name that ends in {dotted}")))
}

/// Returns an error for a path among a dataset's own files, also through links. `coming`: folders that will become datasets, as returned by
/// [`place`].
///
/// # Errors
/// [`DatasetError::Target`].
pub fn check_free(path: &Path, coming: &[PathBuf]) -> Result<(), DatasetError> {
    match owner(&place(path), coming) {
        None => Ok(()),
        Some(dataset) => Err(DatasetError::Target(format!(
            "{}: this is a place where the dataset {} keeps its own files: give another name or folder (directly in the dataset's \
             folder any other name will do)",
            path.display(),
            dataset.display()
        ))),
    }
}

/// Refuses a folder for a dataset where another one keeps its own, or whose own places hold one of the `inputs` that its rows are
/// computed from.
///
/// # Errors
/// [`DatasetError::Target`].
pub fn check_folder(folder: &Path, inputs: &[PathBuf]) -> Result<(), DatasetError> {
    check_free(folder, &[])?;
    let own = place(folder);
    match inputs.iter().find(|input| is_part_of(&place(input), &own)) {
        None => Ok(()),
        Some(input) => Err(DatasetError::Target(format!(
            "the dataset {} would overwrite what its rows are computed from ({}): give another folder",
            folder.display(),
            input.display()
        ))),
    }
}

/// Whether a file lies where the dataset in `folder` would keep its own; both as [`place`] gives them.
pub fn is_part_of(file: &Path, folder: &PathBuf) -> bool {
    owner(file, std::slice::from_ref(folder)).is_some_and(|owner| owner == folder)
}

/// Resolves a path: follows links, and places a missing name in the last existing folder above it.
pub fn place(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let found = path.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
    let Some((above, mut place)) = found else { return path };
    for part in path.strip_prefix(above).into_iter().flat_map(Path::iter) {
        if part == ".." {
            place.pop();
        } else {
            place.push(part);
        }
    }
    place
}
