//! A scene: all data of one row of a study, as plain data in SI units, without files, matrices and hidden defaults. Also the tables of a
//! study whose parameters are declared here: solver, outputs, machine.

mod links;
mod machine;
mod model;
mod overrides;
mod plausibility;
mod solver;
mod strike;
mod validate;

pub use crate::integrate::Method;
pub use links::{FixtureId, HammerLink, Location, Owner, PartId, PointId};
pub(crate) use links::{Freedom, Friction, Link, LinkLaw, Part};
pub use machine::{Housings, SourceName, StructureEntry, StructureParameters};
pub use model::{Environment, HammerEntry, HammerUnit, Mount, OutputSettings, Scene, Supply};
pub use solver::{
    Fidelity, Guide, ModeTreatment, NumericalTwin, PRESETS, Preset, STANDARD, SolverEntry, SolverSettings,
};
pub(crate) use strike::{DEEP_SHARE, JUMP_RATIO};
pub use validate::{SceneProblem, SceneProblemKind};
