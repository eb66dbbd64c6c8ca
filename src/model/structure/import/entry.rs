//! Parts of an exchange format.

use std::io::Write;

use sprs::CsMat;

use super::labelled::LabelledMatrix;
use crate::structure::error::StructureError;
use crate::structure::label::DofLabel;

/// An exchange format.
pub(super) struct Format {
    /// File name endings, in small letters and without `.gz`.
    pub endings: &'static [&'static str],
    /// Reads a matrix.
    pub read: fn(&Given) -> Result<Imported, StructureError>,
    /// Forms in which it is written.
    pub forms: &'static [Form],
}

/// A file to read a matrix from.
pub(super) struct Given<'a> {
    /// Name of the file, for errors.
    pub file: &'a str,
    /// Contents, plain or gzip.
    pub bytes: &'a [u8],
    /// Name of the matrix, where a file holds several.
    pub name: &'a str,
    /// Expected kind of matrix.
    pub kind: MatrixKind,
    /// Number of rows by the list of rows, if there is one.
    pub listed: Option<usize>,
}

/// Kind of a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MatrixKind {
    Stiffness,
    Mass,
    Damping,
}

/// A matrix as its file gives it.
pub(super) enum Imported {
    /// Both triangles over numbered rows.
    Rows(CsMat<f64>),
    /// Entries by node and direction.
    Labels(LabelledMatrix),
}

/// A form in which a format is written.
pub(super) struct Form {
    /// Name on the command line.
    pub name: &'static str,
    /// Files of stiffness, mass and damping; packed where they end in `.gz`.
    pub files: [&'static str; 3],
    /// Requirement on the rows.
    pub rows: RowLabels,
    /// Loss of information, for the user; `None` if every bit is kept.
    pub loss: Option<&'static str>,
    /// Writes a matrix.
    pub write: fn(&mut dyn Write, &Named) -> std::io::Result<()>,
}

/// Requirement of a form on the labels of rows.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum RowLabels {
    /// Nothing: rows are numbered.
    Unused,
    /// Node and direction of every row.
    Needed,
    /// The same, no two alike.
    Distinct,
    /// As `Distinct`, with nodes numbered from 1 on, as Nastran has them.
    NumberedFromOne,
}

/// A matrix to write: name, both triangles, labels of its rows.
pub(super) struct Named<'a> {
    pub name: &'a str,
    pub matrix: &'a CsMat<f64>,
    pub labels: &'a [DofLabel],
}
