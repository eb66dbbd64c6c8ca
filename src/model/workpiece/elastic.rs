//! Settings of an elastic casting's finite element model in a study.

use serde::Serialize;

use crate::parameter::parameters;
use crate::structure::Damping::{self, Ratio};
use crate::structure::{MatrixFormat, Units};

parameters! {
    /// Finite element model of an elastic casting: matrices without supports, z up, and the settings of its reduction.
    ///
    /// Hammers strike the upper surface at their strike points, fixtures hold the lower surface at `at_m`; each of these points is an area,
    /// all nodes within `point_radius_m`, unless the study names the point's nodes.
    #[derive(Serialize)]
    pub struct CastingStructure from CastingStructureEntry {
        typed {
            /// Stiffness matrix, plain or gzip, relative to the study.
            pub stiffness_file: String,
            /// Mass matrix, plain or gzip, relative to the study. If the format stores several matrices in one file, it may be the
            /// stiffness file.
            pub mass_file: String,
            /// List of the node and direction of each row of the matrices, as for the machine. Required unless the matrices or
            /// `dofs_per_node` give them.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub dof_file: Option<String>,
            /// Coordinates of nodes in the unit of the matrices, as for the machine. Required unless another file has them.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub nodes_file: Option<String>,
            /// Format of the matrices. Default: as for the machine.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub format: Option<MatrixFormat>,
            /// Units of matrices and coordinates: length, mass, time. Default `si`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub units: Option<Units>,
            /// Directions per node, 3 or 6, of matrices whose rows are numbered node by node and have no `dof_file`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub dofs_per_node: Option<u32>,
            /// Name of the stiffness in a file of several matrices. Default `KAAX`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub stiffness_name: Option<String>,
            /// Name of the mass in a file of several matrices. Default `MAAX`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub mass_name: Option<String>,
            /// Whether the stiffness of the contact between chisel and casting includes the local flexibility of the casting, as in the
            /// paper. Otherwise the flexibility is added to the contact. Default true.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub contact_includes_casting: Option<bool>,
        }
        /// Modes below this frequency are kept. The static flexibility of the others is kept without their mass.
        pub cutoff_hz: f64 = 10_000.0, "Hz", [> 0] usual [500, 50_000], "what contacts of 100 us excite";
        /// Modal damping ratio of the elastic modes: one for all, a list, a table `[[frequency_hz, ratio], ...]`, or Rayleigh damping
        /// `{ mass_per_s = 10.0, stiffness_s = 1e-7 }`.
        pub damping_ratio: Damping = Ratio(0.005), "1", [>= 0, < 1], "assumed";
        /// Radius of the areas of strike points, fixtures and core points.
        pub point_radius_m: f64 = 0.01, "m", [> 0] usual [0.001, 0.1], "assumed: the tip of a chisel";
    }
}
