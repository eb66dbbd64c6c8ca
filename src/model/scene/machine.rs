//! Source and reduction of a machine.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::solver::STANDARD;
use crate::parameter::parameters;
use crate::structure::Damping::{self, Ratio};
use crate::structure::{MatrixFormat, Units};

parameters! {
    /// Source of the machine, and its reduction.
    #[derive(Serialize)]
    pub struct StructureParameters from StructureEntry {
        typed {
            /// Source of the machine. Default `station`, the built-in one.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub source: Option<SourceName>,
            /// Stiffness matrix, plain or gzip, relative to the study; for `matrices`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub stiffness_file: Option<String>,
            /// Mass matrix without housings, plain or gzip, relative to the study; for `matrices`. If the format stores several matrices in
            /// one file, it may be the stiffness file.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub mass_file: Option<String>,
            /// Matrix of viscous damping, relative to the study; for `matrices`. Its diagonal over the modes replaces `damping_ratio`.
            /// Default: none.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub damping_file: Option<String>,
            /// List of the node and direction of each row of the matrices, one line per row: `12.3` (node 12, direction 3), `12 3` or `5 12
            /// UZ`, relative to the study; for `matrices`. The node's coordinates may follow. CalculiX writes it as `.dof`, ANSYS as
            /// `.mapping`. For a Nastran superelement use the `.pch` (EXTRN entries) or `.asm` file.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub dof_file: Option<String>,
            /// File with the positions of nodes in the unit of the matrices, relative to the study; for `matrices`: an input file with a
            /// `*NODE` block (Abaqus, CalculiX), `GRID` entries (Nastran), or lines of node, x, y, z. They give the centre of mass, and
            /// show wrong labels and units.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub nodes_file: Option<String>,
            /// Format of the matrices. Default: from the ending of the stiffness file's name (`.gz` may follow).
            #[serde(skip_serializing_if = "Option::is_none")]
            pub format: Option<MatrixFormat>,
            /// Units of the matrices and of coordinates in `dof_file` and `nodes_file`: length, mass, time. Default `si`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub units: Option<Units>,
            /// Directions per node, 3 or 6, of matrices whose rows are numbered node by node and have no `dof_file`. Default: not
            /// known.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub dofs_per_node: Option<u32>,
            /// Name of the stiffness in a file of several matrices (`dmig`, `op4`), for instance `KAA`. If an OUTPUT4 file has several of
            /// one name, the second is `KAA#2`. Default `KAAX`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub stiffness_name: Option<String>,
            /// Name of the mass in a file of several matrices. Default `MAAX`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub mass_name: Option<String>,
            /// Name of the damping in a file of several matrices. Default `BAAX`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub damping_name: Option<String>,
            /// Whether to keep reductions next to the stiffness file (folder `.decore-cache`), and to use them again. Default true.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub cache: Option<bool>,
            /// Modal table (CSV), or a universal file with normal modes (data sets 55), relative to the study; for `modal_table`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub modal_file: Option<String>,
            /// Table of named interface points with coordinates (CSV), relative to the study; for `matrices` and `modal_table`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub points_file: Option<String>,
            /// CSV table with the columns `mode` (from 1) and `damping_ratio`, one line per mode up to the cut-off, relative to the study; in
            /// place of `damping_ratio`. `decore structure --measured` proposes one.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub damping_ratio_file: Option<String>,
            /// Whether the hammers' housings are added to the machine or already part of it. Default `add`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub housings: Option<Housings>,
            /// Rails by name: interface points in order along a straight line or polyline. The built-in station has the rail
            /// `rail` with the points R1 to R9.
            #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
            pub rails: IndexMap<String, Vec<String>>,
        }
        /// Keep all modes of the coupled machine up to this frequency, instead of the modes that `mode_tolerance` selects.
        pub cutoff_hz: f64 = 1000.0, "Hz", [> 0], "with a list of damping ratios; without one the preset selects modes";
        /// Keep the modes of the basis that a scene's points need for this error of their receptances up to `mode_band_hz`, relative to
        /// static flexibility. One residual mode per point replaces the others. 0 keeps all modes that move a point. With `cutoff_hz` or a
        /// list of damping ratios, only a value that you give counts, not the preset's.
        pub mode_tolerance: f64 = STANDARD.mode_tolerance, "1", [>= 0, < 1], "the preset's";
        /// Upper edge of the band for `mode_tolerance`: the frequencies that contacts excite (a contact of chisel and casting lasts some
        /// 100 us).
        pub mode_band_hz: f64 = 5000.0, "Hz", [> 0], "assumed";
        /// Fixed-interface modes of the Craig-Bampton basis are kept up to this frequency.
        pub fixed_interface_cutoff_hz: f64 = 3000.0, "Hz", [> 0], "20000 where modes of the built-in station are selected, 6000 in a draft";
        /// Modal damping ratio: one for all modes, a list with one per mode, a table `[[frequency_hz, ratio], ...]`, or Rayleigh damping
        /// `{ mass_per_s = 1.0, stiffness_s = 1e-6 }`.
        pub damping_ratio: Damping = Ratio(0.02), "1", [>= 0, < 1], "assumed";
    }
}

/// Source of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SourceName {
    /// The built-in hammer station.
    #[default]
    Station,
    /// Finite element matrices: `stiffness_file`, `mass_file`, `points_file`.
    Matrices,
    /// A modal table: `modal_file`, `points_file`.
    ModalTable,
}

/// Treatment of the hammers' housings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Housings {
    /// Add rigid masses to the machine at the mounts.
    #[default]
    Add,
    /// The given machine already contains them.
    Included,
}
