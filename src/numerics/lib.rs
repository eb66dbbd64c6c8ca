//! What computes: machines and their reduction, hammers, castings, contacts, the coupled model of a scene, its integration and its
//! outputs; and regressions of plain numbers. The documentation of the package `decore`, which hands all of this on, shows the flow and
//! who may import whom.
//!
//! Code that is generic is compiled, and optimised, where it is used: what a step computes has to be used here, not only by the packages
//! above.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[macro_use]
pub mod parameter;

pub mod contact;
pub mod hammer;
pub mod integrate;
pub mod linalg;
pub mod metrics;
pub mod number;
#[allow(clippy::disallowed_methods)]
pub mod regression;
pub mod run;
pub mod scene;
pub mod structure;
pub mod system;
pub mod workpiece;

pub use decore_ground::{analysis, design, files, quantity, random, signal, words};
