//! A measurement beside a calculated signal: read from a file, brought onto its time, filtered alike, compared by what the field
//! compares by.
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
