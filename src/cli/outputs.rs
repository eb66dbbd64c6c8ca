//! No output is one of the inputs: what a command reads, it does not overwrite.

use std::path::{Path, PathBuf};

use super::exit::Failure;
use crate::files::{self, Limit};

/// Refuses outputs that are the study or a file that it or one of the overrides `path=value` names, by whatever path; a folder
/// for outputs (it ends an `--export`) must not hold one of them.
pub(super) fn refuse_inputs(study: &Path, overrides: &[String], outputs: &[Option<&PathBuf>]) -> Result<(), Failure> {
    // Whoever reads the study says what is wrong with it.
    let text = files::read_text(study, Limit::TOML).unwrap_or_default();
    let mut names = vec![study.to_owned()];
    let folder = study.parent().unwrap_or(Path::new(""));
    let mut words = Vec::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        texts(&toml::Value::Table(table), &mut words);
    }
    words.extend(overrides.iter().filter_map(|one| one.split_once('=')).map(|(_, value)| value.to_owned()));
    names.extend(words.into_iter().map(|word| folder.join(word)));
    let inputs: Vec<PathBuf> =
        names.into_iter().filter_map(|name| name.canonicalize().ok()).filter(|path| path.is_file()).collect();
    for output in outputs.iter().copied().flatten() {
        // What is not there yet is no input.
        let Ok(place) = output.canonicalize() else { continue };
        let clash = inputs.iter().find(|input| **input == place || input.parent() == Some(&place));
        if let Some(input) = clash {
            return Err(Failure::Argument(format!(
                "the output {} would overwrite what the command reads ({}): give another name or folder",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// All texts of a study: those that name files are inputs.
fn texts(value: &toml::Value, found: &mut Vec<String>) {
    match value {
        toml::Value::String(text) => found.push(text.clone()),
        toml::Value::Array(list) => list.iter().for_each(|value| texts(value, found)),
        toml::Value::Table(table) => table.values().for_each(|value| texts(value, found)),
        _ => {}
    }
}
