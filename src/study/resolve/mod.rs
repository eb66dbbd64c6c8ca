//! Converts values to a scene: fills in defaults, looks up names, computes the geometry.

mod geometry;
pub(super) mod issue;
mod layers;
pub(super) mod library;
pub(super) mod nodes;
pub(super) mod placement;
pub(super) mod rows;
pub(super) mod scene;
pub(super) mod structure;
