//! Typed input: a text, the folder for relative file names, and the overrides.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::error::{FileLocation, Problem, StudyError};
use super::keys::{self, Shape};
use super::overrides::{Override, driven_paths};
use super::path;
use super::tree::{Content, Document, TextSpan};

/// A study as typed.
#[derive(Debug, Clone)]
pub(crate) struct Typed {
    pub document: Document,
    /// The file that it was read from; `None` for a text alone.
    pub file: Option<PathBuf>,
    /// Folder for relative file names.
    pub directory: PathBuf,
    /// Folder of the file with the design's rows, where it is another one.
    pub row_directory: Option<PathBuf>,
    /// Texts of hammer files by the name that the study gives them; these files are not opened.
    pub hammers: BTreeMap<String, String>,
    /// Overrides of the text, in order.
    pub overrides: Vec<Override>,
}

impl Typed {
    /// Folder in which the name of the file with the design's rows starts.
    pub fn row_directory(&self) -> &Path {
        self.row_directory.as_ref().unwrap_or(&self.directory)
    }

    /// The values, overrides applied.
    pub fn tree(&self) -> toml::Table {
        let mut tree = self.document.root.table();
        for one in &self.overrides {
            // Accepted when it was read: cannot fail.
            let _ = path::set(&mut tree, &one.path, one.value.clone());
        }
        tree
    }

    /// Place of the value at a path: the setting that gave it or an entry of it, else as [`Document::locate`].
    pub fn locate(&self, at: &[String]) -> FileLocation {
        self.given(at).unwrap_or_else(|| self.document.locate(at))
    }

    /// Place of a part of the text at a path: as [`Document::locate_part`], unless a setting gave the text.
    pub fn locate_part(&self, at: &[String], text: &str, part: &TextSpan<'_>) -> FileLocation {
        self.given(at).unwrap_or_else(|| self.document.locate_part(at, text, part))
    }

    /// Place of the setting that gave the value at a path. One inside of a table gave that table's key, not the table.
    fn given(&self, at: &[String]) -> Option<FileLocation> {
        let (node, depth) = self.document.nearest(at);
        let is_list = depth == at.len() && matches!(node.content, Content::Array(_));
        let one = self.overridden(|path| at.starts_with(path) || (is_list && path.starts_with(at)));
        one.map(Override::place)
    }

    /// The last override of a path that the function accepts.
    pub fn overridden(&self, accepts: impl Fn(&[String]) -> bool) -> Option<&Override> {
        self.overrides.iter().rev().find(|one| accepts(&one.path))
    }
}

/// Holds the document to its shape and returns its values, overrides applied.
pub(crate) fn check_keys(
    document: &Document,
    shape: &Shape,
    overrides: &[Override],
) -> Result<toml::Table, StudyError> {
    let mut tree = document.root.table();
    let driven = driven_paths(&tree);
    let provided = |at: &[String]| {
        // A value inside a missing table provides the table too.
        let set = overrides.iter().map(|one| &one.path);
        driven.iter().chain(set).any(|path| path.starts_with(at))
    };
    StudyError::from_problems(keys::check(document, shape, &provided))?;
    for one in overrides {
        path::set(&mut tree, &one.path, one.value.clone())
            .map_err(|message| StudyError::one(Problem::new(one.place(), path::join(&one.path), message)))?;
    }
    Ok(tree)
}
