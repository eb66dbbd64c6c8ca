//! Castings and the fixtures that hold them: plain data, rigid-body kinematics in the plane of the table.

mod casting;
mod restraint;

pub use casting::{Casting, CastingEntry, Fixture, FixtureEntry};
pub(crate) use restraint::{OFFSET_TOLERANCE_M, WorkpieceError};
