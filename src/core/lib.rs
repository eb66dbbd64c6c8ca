//! What a study takes to run, over the model of a row: designs, studies, datasets and the engine that joins them. The
//! documentation of the package `decore`, which hands all of this on, shows the flow and who may import whom.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[allow(clippy::disallowed_methods)]
pub mod analysis;
pub mod dataset;
pub mod design;
pub mod engine;
pub mod expression;
pub mod features;
#[allow(clippy::disallowed_methods)]
pub mod regression;
#[allow(clippy::disallowed_methods)]
pub mod signal;
pub mod study;

pub use decore_model::{
    contact, files, hammer, integrate, linalg, metrics, number, parameter, plot, quantity, random, run, scene,
    structure, system, words, workpiece,
};
