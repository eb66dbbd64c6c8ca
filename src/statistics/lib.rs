//! Statistics over plain numbers, independent of hammers, studies and files.
//!
//! - [`design`]: designs of experiments, whose rows are addressed by (seed, row).
//! - [`analysis`]: sensitivity indices of tables of numbers.
//! - [`regression`]: models that predict an output from the factors.
//! - [`lifetime`]: laws of doses at failure, from tests of which some ended before the failure.
//! - [`signal`]: spectra, filters, densities, shifts between two signals.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[allow(clippy::disallowed_methods)]
pub mod analysis;
pub mod design;
#[allow(clippy::disallowed_methods)]
pub mod lifetime;
#[allow(clippy::disallowed_methods)]
pub mod regression;
#[allow(clippy::disallowed_methods)]
pub mod signal;
