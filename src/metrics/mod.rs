//! Outputs of a run: blows, energies, frequencies, peaks, and how sure they are.
//!
//! - [`Recorder`]: watches an integration and computes them as it goes
//! - `hammer`, `casting`, `audit`: what it keeps of each hammer, of each casting, and of the energies
//! - `percussion`, `statistics`: what a series of blows is, and the standard error of its mean
//! - [`Scatter`]: how far a run's main outputs move under inputs that are the same for every purpose
//! - [`SignalRecorder`]: time signals

mod audit;
mod casting;
mod hammer;
mod peak;
mod percussion;
mod quantity;
mod recorder;
mod scatter;
mod signals;
mod statistics;

use serde::Serialize;

pub use percussion::Percussion;
use quantity::quantities;
pub use quantity::{Quantity, QuantityField, QuantityKind, QuantityValue};
pub use recorder::Recorder;
pub use scatter::{Scatter, ScatterOf};
pub use signals::{Signal, SignalRecorder};

/// What one blow did. Times in s from the start of the simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blow {
    /// Index of the hammer.
    pub hammer: usize,
    /// Index of the casting struck.
    pub casting: usize,
    /// Counts from 0 for each hammer, blank blows included.
    pub number: usize,
    /// Stroke that it belongs to, from 0: a stroke begins where the supply is switched on.
    pub stroke: usize,
    /// Impact of a stroke, settling, periodic or blank.
    pub kind: BlowKind,
    /// Start of the blow in s.
    pub start_time_s: f64,
    /// Kinetic energy of cylinder, spool, piston and chisel at the start, in J.
    pub energy_j: f64,
    /// Chisel velocity at the start, in m/s.
    pub chisel_velocity_m_s: f64,
    /// Work delivered to the casting within the window, in J.
    pub work_j: f64,
    /// Impulse of the chisel-casting force within the window, in N s.
    pub impulse_n_s: f64,
    /// Largest chisel-casting force within the window, in N.
    pub peak_force_n: f64,
    /// Largest absolute velocity of the casting at the strike point within the window, in m/s.
    pub casting_peak_velocity_m_s: f64,
}

/// Kind of a blow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BlowKind {
    /// The cylinder's single impact of the first stroke.
    FirstImpact,
    /// The same of a later stroke.
    StrokeImpact,
    /// One of the first struck blows of a stroke's percussion.
    Settling,
    /// One of the struck blows after these.
    Periodic,
    /// A blow of the percussion that does not reach the casting.
    Blank,
}

impl BlowKind {
    /// The kind in tables, texts and JSON.
    pub fn text(self) -> &'static str {
        match self {
            Self::FirstImpact => "first_impact",
            Self::StrokeImpact => "stroke_impact",
            Self::Settling => "settling",
            Self::Periodic => "periodic",
            Self::Blank => "blank",
        }
    }

    /// Whether it is a blow of the percussion.
    pub fn is_percussion(self) -> bool {
        !matches!(self, Self::FirstImpact | Self::StrokeImpact)
    }
}

quantities! {
    /// Outputs of one hammer. `None`: the event did not happen (or not often enough).
    ///
    /// "Periodic" figures are over the periodic blows: those that reach the casting, without the first of each stroke.
    pub struct HammerMetrics {
        /// Start of the first impact (the first contact with the casting in the first stroke).
        pub first_impact_time_s: Option<f64> => "s" main,
        /// Kinetic energy of cylinder, spool, piston and chisel at the start of the first impact.
        pub first_impact_energy_j: Option<f64> => "J" main,
        /// Chisel velocity at the start of the first impact.
        pub first_impact_chisel_velocity_m_s: Option<f64> => "m/s" main,
        /// Work delivered to the casting within the first impact's window.
        pub first_impact_work_j: Option<f64> => "J" main,
        /// Impulse of the chisel-casting force within the first impact's window.
        pub first_impact_impulse_n_s: Option<f64> => "N s" main,
        /// Largest chisel-casting force within the first impact's window.
        pub first_impact_peak_force_n: Option<f64> => "N" main,
        /// Largest absolute velocity of the casting at the strike point within the first impact's window.
        pub first_impact_casting_peak_velocity_m_s: Option<f64> => "m/s" main,
        /// Number of strokes: times the supply was switched on.
        pub stroke_count: u64 => "1",
        /// Number of blows of the percussion that reached the casting, settling ones included.
        pub struck_blow_count: u64 => "1",
        /// Number of blows of the percussion that did not reach the casting.
        pub blank_blow_count: u64 => "1",
        /// Number of periodic blows; those that settle do not count.
        pub periodic_blows: u64 => "1",
        /// What the percussion is: periodic, aperiodic, unsettled, stalled, blank or none.
        pub percussion: Percussion => "",
        /// Period of a periodic percussion, in blows.
        pub percussion_period: Option<u64> => "1",
        /// Mean impact energy of the periodic blows.
        pub periodic_energy_mean_j: Option<f64> => "J" main,
        /// Standard error of the mean impact energy, from the series of blows with its autocorrelation.
        pub periodic_energy_mean_error_j: Option<f64> => "J",
        /// Standard deviation of the impact energy of the periodic blows.
        pub periodic_energy_std_j: Option<f64> => "J",
        /// Periodic blows less one over the time from the first to the last, both summed over the strokes.
        pub hit_frequency_hz: Option<f64> => "Hz" main,
        /// Mean work that a periodic blow delivers to the casting within its window.
        pub periodic_work_mean_j: Option<f64> => "J" main,
        /// Standard error of that mean work.
        pub periodic_work_mean_error_j: Option<f64> => "J",
        /// Mean impulse of the chisel-casting force within a periodic blow's window.
        pub periodic_impulse_mean_n_s: Option<f64> => "N s" main,
        /// Standard error of that mean impulse.
        pub periodic_impulse_mean_error_n_s: Option<f64> => "N s",
        /// Mean of the periodic blows' largest chisel-casting force.
        pub periodic_peak_force_mean_n: Option<f64> => "N" main,
        /// Standard error of that mean force.
        pub periodic_peak_force_mean_error_n: Option<f64> => "N",
        /// Mean of the periodic blows' largest absolute velocity of the casting at the strike point.
        pub periodic_casting_peak_velocity_mean_m_s: Option<f64> => "m/s" main,
        /// Standard error of that mean velocity.
        pub periodic_casting_peak_velocity_mean_error_m_s: Option<f64> => "m/s",
        /// Work delivered to the casting over the whole run: the integral of force times the casting's velocity.
        pub delivered_work_j: f64 => "J" main,
        /// Impulse of the chisel-casting force over the whole run.
        pub delivered_impulse_n_s: f64 => "N s" main,
        /// Root mean square of the mount's velocity along the hammer, before the hammer's first impact.
        pub arm_rms_extension_m_s: Option<f64> => "m/s" main,
        /// Root mean square of the mount's velocity along the hammer from the first impact to the end of the run; the
        /// transient of the impact is part of it, so it falls with the duration.
        pub arm_rms_hammering_m_s: Option<f64> => "m/s" main,
        /// Root mean square of the mount's velocity along the hammer from the first to the last periodic blow of each stroke.
        pub arm_rms_steady_m_s: Option<f64> => "m/s" main,
        /// Number of chisel-casting contacts (maximal intervals of positive force).
        pub contact_count: u64 => "1",
        /// Air drawn from the supply over the run, in standard litres (101325 Pa, 293.15 K).
        pub air_used_nl: f64 => "NL",
    }
}

quantities! {
    /// Outputs of one casting.
    pub struct CastingMetrics {
        /// Largest absolute heave velocity.
        pub peak_velocity_m_s: f64 => "m/s" main,
        /// Time at which the largest absolute heave velocity occurred.
        pub peak_velocity_time_s: f64 => "s",
        /// Largest absolute velocity of the points struck, held or measured, along the strike; rotations are part of it.
        pub peak_point_velocity_m_s: f64 => "m/s" main,
        /// Time at which the largest absolute velocity of a point occurred.
        pub peak_point_velocity_time_s: f64 => "s",
        /// Which point that was: hammer.NAME for its strike point, fixture.NAME, or measuring_point.
        pub peak_point: String => "",
        /// Largest absolute velocity at the casting's measuring point, where one is chosen.
        pub measuring_point_peak_velocity_m_s: Option<f64> => "m/s",
    }
}

quantities! {
    /// Outputs of the run as a whole.
    pub struct RunTotals {
        /// Work delivered to the castings over the whole run by all hammers: the integral of force times velocity.
        pub delivered_work_j: f64 => "J" main,
        /// Impulse of the chisel-casting forces over the whole run, all hammers.
        pub delivered_impulse_n_s: f64 => "N s" main,
        /// Audit of the run: (work put in by gas and gravity - stored - dissipated) / work put in, the latter at least 1 J.
        pub energy_residual: f64 => "1",
        /// Audit of the chambers, the largest over them: what the energy of its gas misses by its own equation, over the
        /// expansion work that passed, the latter at least 1 J.
        pub chamber_residual: f64 => "1",
    }
}

/// All outputs of one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunMetrics {
    /// One entry per hammer.
    pub hammers: Vec<HammerMetrics>,
    /// One entry per casting.
    pub castings: Vec<CastingMetrics>,
    /// Every blow whose window lies within the simulation, by time of start, then hammer.
    pub blows: Vec<Blow>,
    /// Of the run as a whole.
    #[serde(flatten)]
    pub totals: RunTotals,
    /// Scatter of the main outputs over the run's twins; `None` without twins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scatter: Option<Scatter>,
}
