//! The command line as a process: what commands print and write, and how they end.

mod commands;
mod cores;
mod measured;
mod mistakes;
mod options;
mod outputs;
mod paper;
mod printing;
mod readme;
mod scene;
#[path = "../common/solid.rs"]
mod solid;
mod written;
