//! decore: coupled simulation of pneumatic de-coring hammers, castings and a reduced machine structure.
#![deny(missing_docs)]
pub mod contact;
pub mod design;
pub mod hammer;
#[allow(missing_docs)]
pub mod metrics;
pub mod run;
pub mod scene;
pub mod study;
pub mod workpiece;
