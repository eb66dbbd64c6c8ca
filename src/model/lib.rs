//! The model of one row: from a scene and a machine's modes to the row's outputs.
//!
//! - [`parameter`]: parameters declared once, with unit, default, range and source.
//! - [`contact`], [`hammer`], [`workpiece`], [`structure`]: components that know nothing of each other.
//! - [`scene`]: all that one row needs, as plain data.
//! - [`system`]: the coupled model; its builder is the only part that knows scenes.
//! - [`integrate`]: time integration of piecewise smooth systems; never sees a hammer.
//! - [`metrics`]: outputs, computed while a run goes on.
//! - [`run`]: one row, and the parallel batch.
//!
//! Generic code is compiled, and optimised, where it is used: what a step computes has to be used here, not only by the packages
//! above.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[macro_use]
pub mod parameter;

pub mod contact;
pub mod hammer;
pub mod integrate;
pub mod metrics;
pub mod run;
pub mod scene;
pub mod structure;
pub mod system;
pub mod workpiece;
