//! From values to a scene: defaults filled in, names looked up, geometry worked out.

mod geometry;
pub(super) mod issue;
mod layers;
pub(super) mod library;
pub(super) mod placement;
pub(super) mod rows;
pub(super) mod scene;
pub(super) mod structure;
