//! Checksums of the structure's files, because the rows depend on them as on the study.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;

use super::error::EngineError;

/// BLAKE3 of every file of a structure by its key in the study and the file's name. Folders do not count: a sweep may be
/// continued elsewhere.
///
/// `table`: where the structure stands in the study.
pub(super) fn input_hashes(table: &str, files: &[(&str, &Path)]) -> Result<BTreeMap<String, String>, EngineError> {
    let mut hashes = BTreeMap::new();
    // Of a built-in one there are none: the program's version stands for it.
    for (key, path) in files {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        hashes.insert(format!("{table}.{key} ({name})"), hash(path)?);
    }
    Ok(hashes)
}

fn hash(path: &Path) -> Result<String, EngineError> {
    let mut hasher = blake3::Hasher::new();
    let read = File::open(path).and_then(|file| hasher.update_reader(file).map(|_| ()));
    read.map_err(|source| EngineError::Read { path: path.to_path_buf(), source })?;
    Ok(hasher.finalize().to_hex().to_string())
}
