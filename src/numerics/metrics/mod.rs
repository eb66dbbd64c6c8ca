//! Outputs of a run: blows, energies, frequencies, peaks, and how sure they are.
//!
//! - [`Recorder`]: watches an integration and computes them as it goes
//! - `hammer`, `casting`, `audit`: what it keeps of each hammer, of each casting, and of the energies
//! - [`Aggregates`]: what follows from them over all hammers and castings
//! - `percussion`, `statistics`: what a series of blows is, and the standard error of its mean
//! - `steady`: figures over the intervals between blows with their errors: frequency, motion of the mount, delivered work
//! - [`Scatter`]: how far a run's main outputs move under inputs that are the same for every purpose
//! - [`Phase`]: the parts of a hammer's work
//! - [`SignalRecorder`], [`MeanRecorder`]: time signals, and means of chosen ones

mod aggregates;
mod at;
mod audit;
mod blow;
mod casting;
mod hammer;
mod outputs;
mod peak;
mod percussion;
mod phase;
mod recorder;
mod scatter;
mod signal_means;
mod signals;
mod statistics;
mod steady;

pub use aggregates::Aggregates;
pub use blow::{Blow, BlowKind};
pub use outputs::{CastingMetrics, ERRING, HammerMetrics, RunMetrics, RunTotals, Scatter, ScatterOf, duration_for};
pub use percussion::Percussion;
pub use phase::{Phase, PhaseKind};
pub use recorder::Recorder;
pub use signal_means::{MeanRecorder, MeanSettings};
pub use signals::{
    CastingSignals, EnergySignals, FixtureSignals, HammerSignals, Instant, PointSignals, Signal, SignalOf,
    SignalRecorder, signal_list,
};
