//! Structures: their files, their reduction, and what is said about its quality.

mod containers;
mod elastic;
mod foreign;
mod hard;
mod import;
mod means;
mod measured;
mod mistaken;
mod op4_files;
mod outside;
mod quality;
mod reduction;
mod right;
mod road;
mod selection;
#[path = "../common/solid.rs"]
mod solid;
