//! Designs, and studies from the file to the scene of a row.

mod design_errors;
mod design_fractions;
mod design_kinds;
mod design_strata;
mod designs;
mod errors;
mod faults;
mod given;
mod goal;
mod scene;
mod station;
mod warnings;
