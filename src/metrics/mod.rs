//! Outputs of a run: blows, energies, frequencies, peaks.

mod peak;
mod quantity;
mod recorder;
mod signals;

use serde::Serialize;

use quantity::quantities;
pub use quantity::{Quantity, QuantityField, QuantityKind, QuantityValue};
pub use recorder::Recorder;
pub use signals::{Signal, SignalRecorder};

/// What one blow did. Times in s from the start of the simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blow {
    /// Index of the hammer.
    pub hammer: usize,
    /// Index of the casting struck.
    pub casting: usize,
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

quantities! {
    /// Outputs of one hammer. `None`: the event did not happen (or not often enough).
    ///
    /// "Periodic" figures are over the periodic window, the blows after the settling ones.
    pub struct HammerMetrics {
        /// Start of the first impact (the hammer's first contact with its casting).
        pub first_impact_time_s: Option<f64> => "s",
        /// Kinetic energy of cylinder, spool, piston and chisel at the start of the first impact.
        pub first_impact_energy_j: Option<f64> => "J",
        /// Chisel velocity at the start of the first impact.
        pub first_impact_chisel_velocity_m_s: Option<f64> => "m/s",
        /// Work delivered to the casting within the first impact's window.
        pub first_impact_work_j: Option<f64> => "J",
        /// Impulse of the chisel-casting force within the first impact's window.
        pub first_impact_impulse_n_s: Option<f64> => "N s",
        /// Largest chisel-casting force within the first impact's window.
        pub first_impact_peak_force_n: Option<f64> => "N",
        /// Largest absolute velocity of the casting at the strike point within the first impact's window.
        pub first_impact_casting_peak_velocity_m_s: Option<f64> => "m/s",
        /// Number of blows of the percussion, settling ones included.
        pub periodic_blow_count: u64 => "1",
        /// Mean impact energy of the periodic blows.
        pub periodic_energy_mean_j: Option<f64> => "J",
        /// Standard deviation of the impact energy of the periodic blows.
        pub periodic_energy_std_j: Option<f64> => "J",
        /// Blows per second in the periodic window: (n - 1) / (t_n - t_1).
        pub hit_frequency_hz: Option<f64> => "Hz",
        /// Mean work that a periodic blow delivers to the casting within its window.
        pub periodic_work_mean_j: Option<f64> => "J",
        /// Mean impulse of the chisel-casting force within a periodic blow's window.
        pub periodic_impulse_mean_n_s: Option<f64> => "N s",
        /// Mean of the periodic blows' largest chisel-casting force.
        pub periodic_peak_force_mean_n: Option<f64> => "N",
        /// Mean of the periodic blows' largest absolute velocity of the casting at the strike point.
        pub periodic_casting_peak_velocity_mean_m_s: Option<f64> => "m/s",
        /// Root mean square of the mount's velocity along the hammer, before the hammer's first contact.
        pub arm_rms_extension_m_s: Option<f64> => "m/s",
        /// Root mean square of the mount's velocity along the hammer, after the hammer's first contact.
        pub arm_rms_hammering_m_s: Option<f64> => "m/s",
        /// Number of chisel-casting contacts (maximal intervals of positive force).
        pub contact_count: u64 => "1",
        /// Air drawn from the supply over the run, in standard litres.
        pub air_used_nl: f64 => "NL",
    }
}

quantities! {
    /// Outputs of one casting.
    pub struct CastingMetrics {
        /// Largest absolute heave velocity.
        pub peak_velocity_m_s: f64 => "m/s",
        /// Time at which the largest absolute heave velocity occurred.
        pub peak_velocity_time_s: f64 => "s",
        /// Largest absolute velocity at the casting's measuring point, where one is chosen.
        pub measuring_point_peak_velocity_m_s: Option<f64> => "m/s",
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
    /// Audit: (work put in - stored - dissipated) / work put in, the latter taken as at least 0.01 J.
    pub energy_residual: f64,
}
