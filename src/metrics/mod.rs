//! Outputs of a run: blows, energies, frequencies, peaks.

mod peak;
mod recorder;
mod signals;

use serde::Serialize;

pub use recorder::Recorder;
pub use signals::{Signal, SignalRecorder};

/// What one blow did. Times in s from the start of the simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blow {
    /// Index of the hammer.
    pub hammer: usize,
    /// Counts from 0 (the first impact) for each hammer.
    pub number: usize,
    /// First impact, settling or periodic.
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
    /// The cylinder's single impact.
    FirstImpact,
    /// One of the first blows of the percussion.
    Settling,
    /// A blow of the periodic window.
    Periodic,
}

/// Outputs of one hammer. `None`: the event did not happen (or not often enough).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct HammerMetrics {
    pub first_impact_time_s: Option<f64>,
    pub first_impact_energy_j: Option<f64>,
    pub first_impact_chisel_velocity_m_s: Option<f64>,
    pub first_impact_work_j: Option<f64>,
    pub first_impact_impulse_n_s: Option<f64>,
    pub first_impact_peak_force_n: Option<f64>,
    pub first_impact_casting_peak_velocity_m_s: Option<f64>,
    pub periodic_blow_count: u64,
    pub periodic_energy_mean_j: Option<f64>,
    pub periodic_energy_std_j: Option<f64>,
    pub hit_frequency_hz: Option<f64>,
    pub periodic_work_mean_j: Option<f64>,
    pub periodic_impulse_mean_n_s: Option<f64>,
    pub periodic_peak_force_mean_n: Option<f64>,
    pub periodic_casting_peak_velocity_mean_m_s: Option<f64>,
    pub arm_rms_extension_m_s: Option<f64>,
    pub arm_rms_hammering_m_s: Option<f64>,
    pub contact_count: u64,
    pub air_used_nl: f64,
}

/// Outputs of one casting.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CastingMetrics {
    /// Largest absolute heave velocity in m/s.
    pub peak_velocity_m_s: f64,
    /// When it occurred, in s.
    pub peak_velocity_time_s: f64,
    /// Largest absolute velocity at the measuring point in m/s, where one is chosen.
    pub measuring_point_peak_velocity_m_s: Option<f64>,
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
    /// Audit: (work put in - stored - dissipated) / work put in.
    pub energy_residual: f64,
}
