//! What a study takes to run, over what computes a row and what keeps it: study files and the engine that joins them. The
//! documentation of the package `decore`, which hands all of this on, shows the flow and who may import whom.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod engine;
pub mod expression;
pub mod features;
pub mod study;

pub use decore_numerics::{
    analysis, contact, design, files, hammer, integrate, linalg, metrics, number, parameter, quantity, random,
    regression, run, scene, signal, structure, system, words, workpiece,
};
pub use decore_tables::dataset;
