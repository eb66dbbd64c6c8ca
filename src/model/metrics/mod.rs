//! Outputs of a run: blows, energies, frequencies, peaks, and how sure they are.
//!
//! - [`Recorder`]: watches an integration and computes them as it goes
//! - `contacts`: contacts of a chisel with its casting: their number, the deepest, the largest jump of the force
//! - [`Warning`]: reasons to doubt a finished run
//! - `hammer`, `casting`, `audit`: what it keeps of each hammer, of each casting, and of the energies
//! - [`Aggregates`]: what follows from them over all hammers and castings
//! - `percussion`, `statistics`: what a series of blows is, and the standard error of its mean
//! - `steady`: figures over the intervals between blows with their errors: frequency, motion of the mount, delivered work
//! - [`Scatter`]: how far a run's main outputs move under inputs that are the same for every purpose
//! - [`NumericalErrors`], [`Promise`]: by how much they move under better numerics, and what presets promise
//! - [`Phase`]: the parts of a hammer's work
//! - [`SignalRecorder`], [`MeanRecorder`]: time signals, and means of chosen ones

mod aggregates;
mod audit;
mod blow;
mod casting;
mod contacts;
mod core;
mod fixture;
mod hammer;
mod instant;
mod numerical;
mod outputs;
mod pad;
mod peak;
mod percussion;
mod phase;
mod promise;
mod recorder;
mod residual;
mod scatter;
mod signal_means;
mod signals;
mod statistics;
mod steady;
mod strain;
mod warning;

pub use aggregates::Aggregates;
pub use blow::{Blow, BlowKind, BlowStrain};
pub use core::{CoreMetrics, CoreSpectrum, CoreTotals, spectrum_frequencies_hz};
pub use fixture::FixtureMetrics;
pub use outputs::{
    CastingMetrics, ERRING, HammerMetrics, NumericalErrors, RunMetrics, RunTotals, Scatter, ScatterOf, duration_for,
};
pub use pad::PadMetrics;
pub use percussion::Percussion;
pub use phase::{Phase, PhaseKind};
pub use promise::{Promise, Span};
pub use recorder::Recorder;
pub use signal_means::{MeanRecorder, MeanSettings};
pub use signals::{
    CastingNames, CastingSignals, FixtureSignals, HammerSignals, Instant, Signal, SignalOf, SignalRecorder, signal_list,
};
pub use strain::ElasticMetrics;
pub use warning::Warning;
