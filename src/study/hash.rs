//! Hash that identifies a study.

use super::document::overrides::Override;
use super::document::path;
use super::plan::kinds::RowFile;
use super::resolve::library::Library;

/// BLAKE3 over a study's values, overrides, the contents of the design's files, and the hammer files.
pub(super) fn hash<'a>(
    values: &str,
    overrides: impl Iterator<Item = &'a Override>,
    (files, library): (&[RowFile], &Library),
) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |label: &str, content: &str| {
        for part in [label.as_bytes(), content.as_bytes()] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
    };
    add("study", values);
    for one in overrides {
        add(&path::join(&one.path), &one.value.to_string());
    }
    for file in files {
        add(&file.name, &file.content);
    }
    for (name, table) in library.contents() {
        add(name, &serde_json::to_string(&table).unwrap_or_default());
    }
    hasher.finalize().to_hex().to_string()
}
