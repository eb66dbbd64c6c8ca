//! Errors for paths that are not a study or a dataset, with a suggestion.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::exit::Failure;
use super::text::shell_word;
use decore_dataset::{MANIFEST_NAME, check_ending};
use decore_quantity::words::nearest;

/// `out/<name of the study file>`.
pub(super) fn default_folder(study: &Path) -> PathBuf {
    Path::new("out").join(study.file_stem().unwrap_or(study.as_os_str()))
}

/// Whether a path is the folder of a dataset.
pub(super) fn is_dataset(path: &Path) -> bool {
    path.join(MANIFEST_NAME).is_file()
}

/// Refuses a path that cannot be a study, before anything is read.
pub(super) fn expect_study(path: &Path) -> Result<(), Failure> {
    let shown = path.display();
    let fault = |message: String| Err(Failure::Argument(message));
    if is_dataset(path) {
        let word = shell_word(path);
        return fault(format!(
            "{shown} is a dataset, where a study (a TOML file) is expected; `decore report {word}`, `decore status {word}` \
             and `decore scene {word}` take datasets"
        ));
    }
    if path.is_dir() {
        let inside = names(path).filter(|name| name.ends_with(".toml")).collect::<Vec<_>>();
        let hint = match inside.as_slice() {
            [] => "it holds none".to_owned(),
            some => format!("it holds {}", some.iter().take(5).cloned().collect::<Vec<_>>().join(", ")),
        };
        return fault(format!("{shown} is a folder, where a study (a TOML file) is expected; {hint}"));
    }
    if !path.exists() {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            return fault(format!("there is no study {shown}: the folder {} does not exist", folder.display()));
        }
        let known: Vec<String> = names(folder).filter(|name| name.ends_with(".toml")).collect();
        let wanted = path.file_name().unwrap_or(OsStr::new("")).to_string_lossy();
        let hint = match nearest(&wanted, known.iter().map(String::as_str)) {
            Some(name) => format!("did you mean {}?", path.with_file_name(name).display()),
            None => format!("`decore init {}` writes one to start from", shell_word(path)),
        };
        return fault(format!("there is no study {shown}; {hint}"));
    }
    if path.extension().is_some_and(|kind| ["json", "parquet", "csv", "svg", "html"].iter().any(|known| kind == *known))
    {
        return fault(format!("{shown} is no study: a TOML file is expected"));
    }
    Ok(())
}

/// Refuses a path that cannot be a dataset, before anything is read.
pub(super) fn expect_dataset(path: &Path) -> Result<(), Failure> {
    let shown = path.display();
    let fault = |message: String| Err(Failure::Argument(message));
    if path.is_file() {
        let inside = path.ancestors().skip(1).take(2).find(|folder| folder.join(MANIFEST_NAME).is_file());
        let hint = match inside {
            Some(folder) => format!("give the folder {}", folder.display()),
            None if default_folder(path).join(MANIFEST_NAME).is_file() => {
                format!("`decore run {}` wrote {}", shell_word(path), default_folder(path).display())
            }
            None => {
                format!("`decore run` writes one, {} unless --output names another", default_folder(path).display())
            }
        };
        return fault(format!("{shown} is a file, where the folder of a dataset is expected; {hint}"));
    }
    let parent = path.parent().filter(|folder| folder.join(MANIFEST_NAME).is_file());
    if let Some(parent) = parent.filter(|_| path.is_dir() && !path.join(MANIFEST_NAME).is_file()) {
        return fault(format!("{shown} is a part of the dataset {0}: give {0}", parent.display()));
    }
    if !path.exists() {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let known: Vec<String> = names(folder).filter(|name| folder.join(name).join(MANIFEST_NAME).is_file()).collect();
        let wanted = path.file_name().unwrap_or(OsStr::new("")).to_string_lossy();
        let hint = nearest(&wanted, known.iter().map(String::as_str)).map_or_else(
            || "give the folder that `decore run` wrote".to_owned(),
            |name| format!("did you mean {}?", path.with_file_name(name).display()),
        );
        return fault(format!("there is no dataset {shown}; {hint}"));
    }
    Ok(())
}

/// Refuses an output file whose name does not end in one of `endings`. `flag`: its option.
pub(super) fn expect_ending(flag: &str, file: &Path, endings: &[&str]) -> Result<(), Failure> {
    check_ending(file, endings).map_err(|error| Failure::Argument(format!("{flag} {error}")))
}

/// Sorted names in a folder; none if it cannot be read.
fn names(folder: &Path) -> impl Iterator<Item = String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names.into_iter()
}
