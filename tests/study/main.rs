//! Designs, and studies from the file to the scene of a row.

mod design_errors;
mod design_fractions;
mod design_kinds;
mod design_strata;
mod designs;
mod elastic;
mod errors;
mod faults;
mod given;
mod goal;
mod scene;
#[path = "../common/solid.rs"]
mod solid;
mod station;
mod warnings;
