//! Castings and the fixtures that hold them: plain data, rigid-body kinematics.

mod casting;
mod elastic;
mod pad;
mod restraint;

pub use casting::{Casting, CastingEntry, CorePoint, CorePointEntry, Elastic, Fixture, FixtureEntry};
pub use elastic::{CastingStructure, CastingStructureEntry};
pub use pad::{Pad, PadFigures, PadMaterial};
pub use restraint::{FREEDOMS, Motion};
pub(crate) use restraint::{OFFSET_TOLERANCE_M, WorkpieceError};
