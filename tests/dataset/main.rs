//! Datasets: tables and their readers, and sweeps that are killed, grown, or spread over machines.

mod batches;
mod best;
#[cfg(unix)]
mod cluster;
mod compare;
mod durable;
mod features;
mod flips;
mod formats;
mod groups;
mod growth;
mod kills;
mod linux;
mod loss;
mod page;
mod refine;
mod repeats;
mod report;
mod rerun;
mod sensitivity;
mod signals;
mod surrogate;
mod sweeps;
mod synthetic;
mod tables;
mod truth;
mod windows;
