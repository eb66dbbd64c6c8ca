//! What to read: files, format, units.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::formats::MatrixFormat;

/// Units of matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Units {
    /// m, kg, s, N.
    #[default]
    Si,
    /// mm, t, s, N.
    #[serde(rename = "mm_t_s")]
    MillimetreTonneSecond,
}

/// One matrix: its file, and its name where a file holds several (DMIG, OP4).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MatrixFile {
    /// The file, plain or gzip.
    pub path: PathBuf,
    /// Name of the matrix in the file, for instance KAAX.
    pub name: String,
}

/// Files of a finite element model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFiles {
    /// Format of all matrices.
    pub format: MatrixFormat,
    /// Units of all matrices.
    pub units: Units,
    /// Stiffness.
    pub stiffness: MatrixFile,
    /// Mass.
    pub mass: MatrixFile,
    /// Viscous damping, where there is one.
    pub damping: Option<MatrixFile>,
    /// What the rows stand for; needed for CalculiX, of use where points are given by their nodes.
    pub dofs: Option<PathBuf>,
    /// DOFs per node (3 or 6) of matrices whose rows are numbered node by node and have no list.
    pub dofs_per_node: Option<usize>,
    /// Table of interface points.
    pub points: PathBuf,
}
