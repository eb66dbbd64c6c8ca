//! The tables of a study, which every row goes through. The documentation of the package `decore`, which hands all of this on, shows
//! the flow and who may import whom.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod dataset;

use decore_numerics::{design, files, integrate, metrics, quantity, run, words};
