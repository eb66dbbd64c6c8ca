//! A text with the places of its keys and values, paths into it, and values set over it.

pub(super) mod error;
pub(super) mod keys;
pub(super) mod overrides;
pub(super) mod path;
pub(super) mod read;
pub(super) mod tree;
pub(super) mod typed;
