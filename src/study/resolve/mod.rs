//! From values to a scene: defaults filled in, names looked up, geometry worked out.

mod geometry;
mod layers;
pub(super) mod library;
pub(super) mod placement;
mod preset;
pub(super) mod rows;
pub(super) mod scene;
pub(super) mod structure;
