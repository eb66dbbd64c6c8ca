//! One blow of a hammer, and what is remembered of it while its run goes on.

use schemars::JsonSchema;
use serde::Serialize;

use decore_quantity::{named, quantities};

quantities! {
    /// Energy that one blow left in an elastic casting.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct BlowStrain {
        /// Strain energy of an elastic casting at the end of the blow's window, beyond rest.
        pub casting_strain_energy_j: f64 => "J",
    }
}

quantities! {
    /// What one blow did.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct Blow {
        /// Index of the hammer.
        pub hammer: usize,
        /// Index of the casting struck.
        pub casting: usize,
        /// Number of the blow for this hammer, from 0 (the first impact), blank ones included.
        pub number: usize => "1",
        /// Stroke of the hammer that the blow belongs to, from 0; a stroke begins where the supply is switched on.
        pub stroke: usize => "1",
        /// Kind of blow: first_impact, stroke_impact, settling, periodic or blank.
        pub kind: BlowKind => "",
        /// Start of the blow, from the start of the simulation.
        pub start_time_s: f64 => "s" ("start"),
        /// Kinetic energy of cylinder, spool, piston and chisel at the start.
        pub energy_j: f64 => "J" ("energy"),
        /// Chisel velocity at the start.
        pub chisel_velocity_m_s: f64 => "m/s",
        /// Work delivered to the casting within the blow's window.
        pub work_j: f64 => "J" ("work"),
        /// Impulse of the chisel-casting force within the blow's window.
        pub impulse_n_s: f64 => "N s" ("impulse"),
        /// Largest chisel-casting force within the blow's window.
        pub peak_force_n: f64 => "N" ("peak force"),
        /// Largest absolute velocity of the casting at the strike point within the blow's window.
        pub casting_peak_velocity_m_s: f64 => "m/s" ("casting"),
        /// Kinetic energy that the casting gained by the strike: from the blow's start to where the casting's kinetic energy is
        /// largest within the window.
        pub strike_kinetic_energy_j: f64 => "J",
        /// Energy given to the casting by the strike: the work of the chisel-casting force over that time.
        pub strike_energy_j: f64 => "J",
        /// Momentum given to the casting by the strike: the impulse of the chisel-casting force over that time.
        pub strike_momentum_n_s: f64 => "N s",
        /// Strain of an elastic casting; absent for a rigid one.
        #[serde(flatten, skip_serializing_if = "Option::is_none")]
        pub strain: Option<BlowStrain>,
    }
}

named! {
    /// Kind of a blow.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
    pub enum BlowKind {
        /// The cylinder's single impact of the first stroke.
        #[default]
        FirstImpact = "first_impact",
        /// The same of a later stroke.
        StrokeImpact = "stroke_impact",
        /// One of the first struck blows of a stroke's percussion.
        Settling = "settling",
        /// One of the struck blows after these.
        Periodic = "periodic",
        /// A blow of the percussion that does not reach the casting.
        Blank = "blank",
    }
}

impl BlowKind {
    /// Whether it is a blow of the percussion.
    pub fn is_percussion(self) -> bool {
        !matches!(self, Self::FirstImpact | Self::StrokeImpact)
    }
}

/// A blow whose window lies within the simulation, with what its hammer had done when it began.
#[derive(Debug, Clone, Default)]
pub(super) struct Recorded {
    pub blow: Blow,
    /// Time in s that the gate had been open.
    pub gated_s: f64,
    /// Integral of the mount's squared velocity, m2/s.
    pub arm_integral: f64,
    /// Work that the hammer had delivered, J.
    pub work_before_j: f64,
    /// Work that all hammers had delivered, J.
    pub run_work_before_j: f64,
}
