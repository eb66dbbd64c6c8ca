//! Compares a measurement with a calculated signal: reads it from a file, aligns it in time, filters both alike and compares the usual
//! figures.
//!
//! ```text
//! CSV, Parquet --read--> Measured --+
//!                                   +--beside--> Beside: offset, spikes, differences, the curve to lay over
//!                                   |                +--phases--> Phases: the same phase by phase, densities
//! Signal of a run ------------------+
//! ```

mod beside;
mod error;
mod phases;
mod read;

pub use beside::{Compared, LOW_PASS_HZ, LOW_PASS_ORDER, MeasuredBeside, Treatment, beside};
pub use phases::{LineBeside, PhaseBeside, Phases, phases};
pub use read::{Measured, UNITS, Unit, read, unit};
