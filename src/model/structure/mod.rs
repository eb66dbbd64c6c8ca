//! The machine structure: finite element matrices in, modes of the interface points out.
//!
//! ```text
//! K, M (files of many programs) + points (CSV) -> FeModel -> reduce() -+
//!                                                                      +-> ReducedStructure -> modes_at(housings, points) -> ModesAt
//! modal table (CSV) + points (CSV) -> ModalTable ----------------------+
//! ```
//!
//! 1. [`reduce`] is the Craig-Bampton reduction (Craig and Bampton 1968): interface DOFs b, all others o, constraint modes
//!    `G = -K_oo^-1 K_ob`, fixed-interface modes `Psi` of `(K_oo, M_oo)` below a cut-off,
//!    `T = [Psi G; 0 I]`, `M_zz = T' M T`, `K_zz = T' K T`. Done once per study.
//! 2. [`ReducedStructure::modes_at`] adds the rigid housings to `M_zz` and solves the second eigenproblem
//!    `K_zz phi = omega^2 M_zz phi`, as a change of few columns to the machine's own modes. Done once per placement.
//! 3. [`ModesAt::rows`] are `phi_n = d' R_n T Phi` of a point n and a direction d: force and displacement use the same
//!    row, so receptances are symmetric.
//!
//! SI units, rotations in rad. All results are independent of the number of threads.

mod attached;
mod balance;
mod body_nodes;
mod cache;
mod combined_modes;
mod constraints;
mod csv;
mod digits;
mod elastic;
mod error;
mod fixed_interface;
mod idle;
mod import;
mod label;
mod matrices;
mod means;
mod measured;
mod modal_table;
mod model;
mod modes;
mod motions;
mod nodes;
mod observe;
mod own;
mod partition;
mod place;
mod plausibility;
mod points;
mod quality;
mod reduced;
mod reduction;
mod reference;
mod seeming;
mod selection;
mod suspects;
mod symmetric;
mod truncated_modes;

pub use attached::RigidMass;
pub use body_nodes::BodyNodes;
pub use cache::{CACHE_FOLDER, CacheOutcome, cache_path, reduce_files};
pub use elastic::{BodyModes, BodyPoint, DirectedPoint, ElasticBody, ElasticSettings, LOCAL_HZ, Side};
pub use error::StructureError;
pub use import::{ExportFormat, MatrixFile, MatrixFormat, ModelFiles, Units, write_model};
pub use label::DofLabel;
pub use matrices::ModelMatrices;
pub use measured::{
    MeasuredMode, MeasuredReport, MeasuredSettings, compare as compare_measured, read_damping_ratios, read_measured,
};
pub use modal_table::ModalTable;
pub use model::FeModel;
pub use modes::{DirectedPoints, ModesAt};
pub use nodes::{NodesEntry, WeightedNodes};
pub use observe::{Observer, peak_memory_bytes};
pub use points::{DOF_NAMES, InterfacePoint, InterfacePoints, PointPlace};
pub use quality::{MOBILITY_SHARE, MobilityCurve, ModePair, QualityReport, QualitySettings, assess, assess_telling};
pub use reduced::{Damping, ModalOptions, ReducedStructure};
pub use reduction::{ReductionFacts, ReductionSettings, reduce, reduce_observed};
pub use selection::{ModeSelection, SelectionSettings};
