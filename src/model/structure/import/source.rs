//! Sources of a model: files, format, units.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::formats::MatrixFormat;

/// Units of length, mass and time of matrices and their coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Units {
    /// m, kg, s, N.
    #[default]
    Si,
    /// mm, t, s: N, N/mm.
    #[serde(rename = "mm_t_s")]
    MillimetreTonneSecond,
    /// mm, kg, s: mN, mN/mm, as NX has them.
    #[serde(rename = "mm_kg_s")]
    MillimetreKilogramSecond,
    /// mm, kg, ms: kN, kN/mm.
    #[serde(rename = "mm_kg_ms")]
    MillimetreKilogramMillisecond,
    /// mm, g, ms: N, N/mm.
    #[serde(rename = "mm_g_ms")]
    MillimetreGramMillisecond,
    /// m, t, s: kN, kN/m.
    #[serde(rename = "m_t_s")]
    MetreTonneSecond,
    /// cm, g, s: dyn.
    #[serde(rename = "cm_g_s")]
    CentimetreGramSecond,
    /// in, lbf s2/in, s: lbf, lbf/in.
    #[serde(rename = "in_lbf_s")]
    InchPoundForceSecond,
    /// ft, slug, s: lbf, lbf/ft.
    #[serde(rename = "ft_lbf_s")]
    FootPoundForceSecond,
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
    /// Viscous damping, if there is one.
    pub damping: Option<MatrixFile>,
    /// Labels of the rows; required for CalculiX, and useful if points are given by their nodes.
    pub dofs: Option<PathBuf>,
    /// Places of nodes (`*NODE`, `GRID`, or a table), in the unit of the matrices.
    pub nodes: Option<PathBuf>,
    /// DOFs per node (3 or 6) of matrices whose rows are numbered node by node and have no list.
    pub dofs_per_node: Option<usize>,
    /// Table of interface points; empty for a model without any.
    pub points: PathBuf,
}
