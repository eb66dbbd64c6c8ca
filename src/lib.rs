//! decore: coupled simulation of pneumatic de-coring hammers, castings and a reduced machine structure.
#![deny(missing_docs)]
pub mod contact;
pub mod hammer;
pub mod linalg;
#[allow(missing_docs)]
pub mod metrics;
pub mod run;
pub mod scene;
pub mod structure;
pub mod workpiece;
