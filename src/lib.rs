//! decore: coupled simulation of pneumatic de-coring hammers, castings and a reduced machine structure.
#![deny(missing_docs)]
pub mod cli;
pub mod contact;
pub mod dataset;
pub mod design;
pub mod hammer;
pub mod integrate;
pub mod linalg;
pub mod metrics;
pub mod report;
pub mod run;
pub mod scene;
pub mod structure;
pub mod study;
pub mod system;
pub mod workpiece;
