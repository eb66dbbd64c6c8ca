//! What a study takes to run: the coupled model and its integration, structures, designs, studies, datasets and the engine that
//! joins them. The documentation of the package `decore`, which hands all of this on, shows the flow and who may import whom.
//!
//! Code that is generic is compiled, and optimised, where it is used: what a step or a row calls has to be used here, not only
//! by the package above.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[macro_use]
pub mod parameter;

#[allow(clippy::disallowed_methods)]
pub mod analysis;
pub mod contact;
pub mod dataset;
pub mod design;
pub mod engine;
pub mod expression;
pub mod features;
pub mod files;
pub mod hammer;
pub mod integrate;
pub mod linalg;
pub mod metrics;
pub mod number;
#[allow(clippy::disallowed_methods)]
pub mod plot;
pub mod quantity;
pub mod random;
#[allow(clippy::disallowed_methods)]
pub mod regression;
pub mod run;
pub mod scene;
#[allow(clippy::disallowed_methods)]
pub mod signal;
pub mod structure;
pub mod study;
pub mod system;
pub mod words;
pub mod workpiece;
