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
mod written;
