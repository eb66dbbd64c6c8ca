//! Answers from a dataset.
//!
//! - [`best`]: best values of the factors within limits, and their confidence.
//! - [`report`]: summary of a dataset.
//! - [`cores`]: when cores are out, from tests of cores.
//! - [`comparison`]: differences between two datasets.
//! - [`sensitivity`]: influence of each factor on each output.
//! - [`surrogate`]: models that predict rows without running them.
//! - [`refinement`]: rows to run next.
//! - [`features`]: flat table for training predictors, its dictionary, groups and splits.
//! - [`measurement`]: comparison of a measured channel with a calculated signal.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[allow(clippy::disallowed_methods)]
pub mod best;
pub mod comparison;
#[allow(clippy::disallowed_methods)]
pub mod cores;
pub mod features;
#[allow(clippy::disallowed_methods)]
pub mod measurement;
#[allow(clippy::disallowed_methods)]
pub mod refinement;
#[allow(clippy::disallowed_methods)]
pub mod report;
#[allow(clippy::disallowed_methods)]
pub mod sensitivity;
#[allow(clippy::disallowed_methods)]
pub mod surrogate;
