//! Mathematics without statistics or hammers.
//!
//! - [`number`]: one number, or several in the lanes of a vector: the type of a row's arithmetic.
//! - [`linalg`]: dense and sparse factorisations and eigenpairs; the only module that calls faer.
//! - [`random`]: random numbers addressed by position.
//! - [`shock`]: shock spectra and doses of motions.
//! - [`special`]: distribution functions and quantiles.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod linalg;
pub mod number;
pub mod random;
pub mod shock;
pub mod special;
