//! The model of one row: from a scene and a machine's modes to the row's outputs.
//!
//! - [`parameter`]: parameters declared once, with unit, default, range and source.
//! - [`direction`]: directions in world axes.
//! - [`contact`], [`hammer`], [`workpiece`], [`structure`]: components, independent of each other.
//! - [`scene`]: all data of one row, as plain data.
//! - [`system`]: the coupled model; only its builder uses scenes.
//! - [`integrate`]: time integration of piecewise smooth systems, independent of hammers.
//! - [`metrics`]: outputs, computed during a run.
//! - [`run`]: one row, and the parallel batch.
//!
//! The compiler compiles and optimises generic code where it is used. So this package must use the code of a step itself, not only the
//! packages above.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[macro_use]
pub mod parameter;

pub mod contact;
pub mod direction;
pub mod hammer;
pub mod integrate;
pub mod metrics;
pub mod run;
pub mod scene;
pub mod structure;
pub mod system;
pub mod workpiece;
