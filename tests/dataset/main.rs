//! Datasets: tables and their readers, and sweeps that are killed, grown, or spread over machines.

#[cfg(unix)]
mod cluster;
#[cfg(unix)]
mod durable;
#[cfg(unix)]
mod growth;
mod loss;
mod report;
#[cfg(unix)]
mod rerun;
#[cfg(unix)]
mod sweeps;
mod synthetic;
mod tables;
