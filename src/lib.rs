//! decore: coupled simulation of pneumatic de-coring hammers, castings and a reduced machine structure.
#![deny(missing_docs)]
pub mod contact;
pub mod dataset;
pub mod hammer;
pub mod metrics;
pub mod report;
pub mod run;
pub mod scene;
pub mod workpiece;
