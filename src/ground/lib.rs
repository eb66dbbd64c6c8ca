//! What knows nothing of hammers and machines: designs, indices of plain numbers, signals, random numbers, values and their units, words and
//! files. The documentation of the package `decore`, which hands all of this on, shows the flow and who may import whom.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[allow(clippy::disallowed_methods)]
pub mod analysis;
pub mod design;
pub mod files;
pub mod quantity;
pub mod random;
#[allow(clippy::disallowed_methods)]
pub mod signal;
pub mod words;
