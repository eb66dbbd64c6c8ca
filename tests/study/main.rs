//! Designs, and studies from the file to the scene of a row.

mod core;
mod design_errors;
mod design_fractions;
mod design_kinds;
mod design_strata;
mod designs;
mod directions;
mod elastic;
mod errors;
mod faults;
mod given;
mod goal;
mod machine_nodes;
mod merged;
mod pads;
mod scene;
#[path = "../common/solid.rs"]
mod solid;
mod station;
mod warnings;
