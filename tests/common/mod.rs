//! Named reference problems and what the tests share. Every problem is a value that any test can reuse.
//!
//! - `changed`: the coupled system with a change of what an integrator sees of it
//! - `harness`: piecewise smooth problems as an integrator sees them, logs of a run, observed orders
//! - `smooth`: problems with a known smooth solution
//! - `impact`: problems with an impact law
//! - `sample`: random scenes of one hammer, their stated and their true errors
//! - `studies`: rows of shipped studies
//! - `scenes`: scenes for the coupled system, from a bare bench of rigid bodies to a whole rig

// Every test binary uses a part of this.
#![allow(dead_code)]

pub mod changed;
pub mod harness;
pub mod impact;
pub mod sample;
pub mod scenes;
pub mod smooth;
pub mod studies;
