//! The outputs of a run: declared here, computed by the recorder and its parts.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::blow::Blow;
use super::core::{CoreMetrics, CoreTotals};
use super::fixture::FixtureMetrics;
use super::pad::PadMetrics;
use super::percussion::Percussion;
use super::strain::ElasticMetrics;
use decore_quantity::quantities;

quantities! {
    /// Outputs of one hammer. `None`: the event did not happen (or not often enough).
    ///
    /// "Periodic" figures are over the periodic blows: those that reach the casting, without the first of each stroke. An
    /// `..._error_...` is a standard error, enlarged by Student's quantile for few or correlated blows: the value +- 2 errors is a
    /// 95 % interval. `None` with fewer than eight values, and where the percussion is unsettled or stalled.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct HammerMetrics {
        /// Start of the first impact (the first contact with the casting in the first stroke).
        pub first_impact_time_s: Option<f64> => "s" main [less],
        /// Kinetic energy of cylinder, spool, piston and chisel at the start of the first impact.
        pub first_impact_energy_j: Option<f64> => "J" main,
        /// Chisel velocity at the start of the first impact.
        pub first_impact_chisel_velocity_m_s: Option<f64> => "m/s" main,
        /// Work delivered to the casting within the first impact's window.
        pub first_impact_work_j: Option<f64> => "J" main,
        /// Impulse of the chisel-casting force within the first impact's window.
        pub first_impact_impulse_n_s: Option<f64> => "N s" main,
        /// Largest chisel-casting force within the first impact's window.
        pub first_impact_peak_force_n: Option<f64> => "N" main [less],
        /// Largest absolute velocity of the casting at the strike point within the first impact's window.
        pub first_impact_casting_peak_velocity_m_s: Option<f64> => "m/s" main [less],
        /// Momentum given to the casting by the first impact's strike: until the casting's kinetic energy is largest.
        pub first_impact_strike_momentum_n_s: Option<f64> => "N s" main,
        /// Energy given to the casting by the first impact's strike.
        pub first_impact_strike_energy_j: Option<f64> => "J" main,
        /// Kinetic energy that the casting gained by the first impact's strike.
        pub first_impact_strike_kinetic_energy_j: Option<f64> => "J" main,
        /// Number of strokes: times the supply was switched on.
        pub stroke_count: u64 => "1",
        /// Number of blows of the percussion that reached the casting, settling ones included.
        pub struck_blow_count: u64 => "1",
        /// Number of blows of the percussion that did not reach the casting.
        pub blank_blow_count: u64 => "1" [less],
        /// Number of periodic blows; those that settle do not count.
        pub periodic_blows: u64 => "1",
        /// What the percussion is: periodic, aperiodic, unsettled, stalled, blank or none; with twins, what the row and
        /// its twins show most often.
        pub percussion: Percussion => "" main,
        /// Period of a periodic percussion, in blows.
        pub percussion_period: Option<u64> => "1",
        /// Mean impact energy of the periodic blows.
        pub periodic_energy_mean_j: Option<f64> => "J" main,
        /// Standard error of the mean impact energy; mean +- 2 errors is a 95 % interval. None with fewer than eight blows or
        /// an unsettled or stalled percussion.
        pub periodic_energy_mean_error_j: Option<f64> => "J" [less],
        /// Standard deviation of the impact energy of the periodic blows.
        pub periodic_energy_std_j: Option<f64> => "J" [less],
        /// Periodic blows less one over the time from the first to the last, both summed over the strokes.
        pub hit_frequency_hz: Option<f64> => "Hz" main,
        /// Standard error of the hit frequency.
        pub hit_frequency_error_hz: Option<f64> => "Hz" [less],
        /// Mean work that a periodic blow delivers to the casting within its window.
        pub periodic_work_mean_j: Option<f64> => "J" main,
        /// Standard error of that mean work.
        pub periodic_work_mean_error_j: Option<f64> => "J" [less],
        /// Mean impulse of the chisel-casting force within a periodic blow's window.
        pub periodic_impulse_mean_n_s: Option<f64> => "N s" main,
        /// Standard error of that mean impulse.
        pub periodic_impulse_mean_error_n_s: Option<f64> => "N s" [less],
        /// Mean of the periodic blows' largest chisel-casting force.
        pub periodic_peak_force_mean_n: Option<f64> => "N" main [less],
        /// Standard error of that mean force.
        pub periodic_peak_force_mean_error_n: Option<f64> => "N" [less],
        /// Mean of the periodic blows' largest absolute velocity of the casting at the strike point.
        pub periodic_casting_peak_velocity_mean_m_s: Option<f64> => "m/s" main [less],
        /// Standard error of that mean velocity.
        pub periodic_casting_peak_velocity_mean_error_m_s: Option<f64> => "m/s" [less],
        /// Mean momentum that the strike of a periodic blow gives to the casting.
        pub periodic_strike_momentum_mean_n_s: Option<f64> => "N s" main,
        /// Standard error of that mean momentum.
        pub periodic_strike_momentum_mean_error_n_s: Option<f64> => "N s" [less],
        /// Mean energy that the strike of a periodic blow gives to the casting.
        pub periodic_strike_energy_mean_j: Option<f64> => "J" main,
        /// Standard error of that mean energy.
        pub periodic_strike_energy_mean_error_j: Option<f64> => "J" [less],
        /// Mean kinetic energy that the casting gains in the strike of a periodic blow.
        pub periodic_strike_kinetic_energy_mean_j: Option<f64> => "J" main,
        /// Standard error of that mean kinetic energy.
        pub periodic_strike_kinetic_energy_mean_error_j: Option<f64> => "J" [less],
        /// Momentum given to the casting by the strikes of all blows.
        pub strike_momentum_n_s: f64 => "N s" main,
        /// Energy given to the casting by the strikes of all blows.
        pub strike_energy_j: f64 => "J" main,
        /// Kinetic energy that the casting gained in the strikes of all blows.
        pub strike_kinetic_energy_j: f64 => "J" main,
        /// Work delivered to the casting over the whole run: the integral of force times the casting's velocity.
        pub delivered_work_j: f64 => "J" main,
        /// Standard error of the delivered work: its deviation from run to run, where runs differ by chance.
        pub delivered_work_error_j: Option<f64> => "J" [less],
        /// Impulse of the chisel-casting force over the whole run.
        pub delivered_impulse_n_s: f64 => "N s" main,
        /// Root mean square of the mount's velocity along the hammer, before the hammer's first impact.
        pub arm_rms_extension_m_s: Option<f64> => "m/s" main [less],
        /// Root mean square of the mount's velocity along the hammer from the first impact to the end of the run; the
        /// transient of the impact is part of it, so it falls with the duration.
        pub arm_rms_hammering_m_s: Option<f64> => "m/s" main [less],
        /// Root mean square of the mount's velocity along the hammer between periodic blows, from the time on at which the
        /// stroke's impact has decayed: five time constants of the energy of the slowest mode that moves the mount. None where
        /// fewer than eight blows follow.
        pub arm_rms_steady_m_s: Option<f64> => "m/s" main [less],
        /// Standard error of the steady velocity of the mount. None over less than three of those time constants.
        pub arm_rms_steady_error_m_s: Option<f64> => "m/s" [less],
        /// Number of chisel-casting contacts: intervals of positive force, of which those separated by less than
        /// `outputs.contact_separation_s` (50 us) are one.
        pub contact_count: u64 => "1",
        /// Deepest penetration of the chisel into the casting.
        pub largest_penetration_m: f64 => "m" [less],
        /// Largest force with which a chisel-casting contact began: damping times closing speed; 0 for laws without such a jump.
        pub largest_jump_force_n: f64 => "N" [less],
        /// Air drawn from the supply over the run, in standard litres (101325 Pa, 293.15 K).
        pub air_used_nl: f64 => "NL" [less],
    }
}

/// Outputs of a hammer that have a standard error, with the name of that error.
pub const ERRING: [(&str, &str); 11] = [
    (HammerMetrics::periodic_energy_mean_j.name, HammerMetrics::periodic_energy_mean_error_j.name),
    (HammerMetrics::hit_frequency_hz.name, HammerMetrics::hit_frequency_error_hz.name),
    (HammerMetrics::periodic_work_mean_j.name, HammerMetrics::periodic_work_mean_error_j.name),
    (HammerMetrics::periodic_impulse_mean_n_s.name, HammerMetrics::periodic_impulse_mean_error_n_s.name),
    (HammerMetrics::periodic_peak_force_mean_n.name, HammerMetrics::periodic_peak_force_mean_error_n.name),
    (
        HammerMetrics::periodic_casting_peak_velocity_mean_m_s.name,
        HammerMetrics::periodic_casting_peak_velocity_mean_error_m_s.name,
    ),
    (
        HammerMetrics::periodic_strike_momentum_mean_n_s.name,
        HammerMetrics::periodic_strike_momentum_mean_error_n_s.name,
    ),
    (HammerMetrics::periodic_strike_energy_mean_j.name, HammerMetrics::periodic_strike_energy_mean_error_j.name),
    (
        HammerMetrics::periodic_strike_kinetic_energy_mean_j.name,
        HammerMetrics::periodic_strike_kinetic_energy_mean_error_j.name,
    ),
    (HammerMetrics::delivered_work_j.name, HammerMetrics::delivered_work_error_j.name),
    (HammerMetrics::arm_rms_steady_m_s.name, HammerMetrics::arm_rms_steady_error_m_s.name),
];

impl HammerMetrics {
    /// Value and standard error of each of [`ERRING`], with its name, where there are both.
    pub fn erring(&self) -> impl Iterator<Item = (&'static str, f64, f64)> {
        let number = |name: &str| {
            let quantity = Self::QUANTITIES.iter().find(|quantity| quantity.name == name)?;
            (quantity.value)(self)?.number()
        };
        ERRING.iter().filter_map(move |(name, error)| Some((*name, number(name)?, number(error)?)))
    }
}

/// Duration in s at which a standard error would be `wanted` of its value, where a run of `duration_s` has `error`: errors fall
/// with the root of the duration.
pub fn duration_for(wanted: f64, duration_s: f64, (value, error): (f64, f64)) -> f64 {
    duration_s * (error / (wanted * value)).powi(2)
}

quantities! {
    /// Outputs of one casting.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct CastingMetrics {
        /// Largest absolute heave velocity.
        pub peak_velocity_m_s: f64 => "m/s" main [less],
        /// Time at which the largest absolute heave velocity occurred.
        pub peak_velocity_time_s: f64 => "s",
        /// Largest absolute velocity of the points struck, held or measured, along the strike; rotations are part of it.
        pub peak_point_velocity_m_s: f64 => "m/s" main [less],
        /// Time at which the largest absolute velocity of a point occurred.
        pub peak_point_velocity_time_s: f64 => "s",
        /// Which point that was: hammer.NAME for its strike point, fixture.NAME, or measuring_point.
        pub peak_point: String => "",
        /// Largest absolute velocity at the casting's measuring point, where one is chosen.
        pub measuring_point_peak_velocity_m_s: Option<f64> => "m/s" [less],
        /// Energy given to the casting by the strikes of all blows on it.
        pub strike_energy_j: f64 => "J" main,
        /// Work of all hammers on this casting over the run. On a rigid casting it is the sum of `fixture_damper_loss_j`,
        /// `fixture_spring_energy_j`, `structure_work_j` and `kinetic_energy_j`.
        pub delivered_work_j: f64 => "J",
        /// Part of the delivered work lost in the dampers of the casting's fixtures.
        pub fixture_damper_loss_j: f64 => "J" main [less],
        /// Part of the delivered work stored in the springs of the casting's fixtures at the end of the run.
        pub fixture_spring_energy_j: f64 => "J" [less],
        /// Part of the delivered work passed on to the machine through the casting's fixtures.
        pub structure_work_j: f64 => "J" [less],
        /// Part of the delivered work that is kinetic energy of the casting at the end of the run.
        pub kinetic_energy_j: f64 => "J",
        /// Energy lost in the contacts of the chisels with this casting; the hammers supply it on top of the delivered work.
        pub strike_contact_loss_j: f64 => "J" [less],
    }
}

quantities! {
    /// Outputs of the run as a whole.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct RunTotals {
        /// Work delivered to the castings over the whole run by all hammers: the integral of force times velocity.
        pub delivered_work_j: f64 => "J" main,
        /// Standard error of the delivered work: its deviation from run to run, where runs differ by chance. None where a
        /// hammer's percussion is unsettled or stalled.
        pub delivered_work_error_j: Option<f64> => "J" [less],
        /// Impulse of the chisel-casting forces over the whole run, all hammers.
        pub delivered_impulse_n_s: f64 => "N s" main,
        /// Energy given to all castings by the strikes of all blows: the default ranking.
        pub strike_energy_j: f64 => "J" main,
        /// Audit of the run: (work put in by gas and gravity - stored - dissipated) / work put in, the latter at least 1 J.
        pub energy_residual: f64 => "1" [less],
        /// Audit of the chambers, the largest over them: what the energy of its gas misses by its own equation, over the
        /// expansion work that passed, the latter at least 1 J.
        pub chamber_residual: f64 => "1" [less],
        /// Reasons to doubt a finished run, separated by commas: deep_contact, damper_jump (`decore help outputs`); empty: none.
        pub warnings: String => "",
    }
}

/// All outputs of one run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct RunMetrics {
    /// One entry per hammer.
    pub hammers: Vec<HammerMetrics>,
    /// One entry per casting.
    pub castings: Vec<CastingMetrics>,
    /// One entry per elastic casting.
    pub elastic: Vec<ElasticMetrics>,
    /// One entry per core point, casting by casting.
    pub cores: Vec<CoreMetrics>,
    /// Over all core points; `None` unless the study asks for their spectra.
    pub core_totals: Option<CoreTotals>,
    /// One entry per one-sided fixture, casting by casting.
    pub pads: Vec<PadMetrics>,
    /// One entry per fixture, casting by casting; empty unless the study asks for their energies.
    pub fixtures: Vec<FixtureMetrics>,
    /// Longest time in s for which each casting was off all its fixtures. Decides whether the row is valid; no output.
    #[serde(skip)]
    pub flights_s: Vec<f64>,
    /// Distance in m by which each casting has slid on its pads at the end of the run. Decides whether the row is valid; no output.
    #[serde(skip)]
    pub slides_m: Vec<f64>,
    /// Every blow whose window lies within the simulation, by time of start, then hammer.
    pub blows: Vec<Blow>,
    /// Of the run as a whole.
    #[serde(flatten)]
    pub totals: RunTotals,
    /// Scatter of the main outputs over the run's twins; `None` without twins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scatter: Option<Scatter>,
    /// Numerical errors of the main outputs; `None` without a numerical twin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numerical: Option<NumericalErrors>,
    /// Means of the signals that the study keeps of the row, instant by instant, time in s first; empty where it keeps none. They
    /// have a table of their own.
    #[serde(skip)]
    pub signals: Vec<Vec<f64>>,
}

/// Scatter of the main outputs of one hammer, of one casting or of the run, by name; `None` where one of the runs lacks the
/// output.
pub type ScatterOf = BTreeMap<&'static str, Option<f64>>;

quantities! {
    /// Scatter of the main outputs over a run and its twins: half the range, scaled to the range of eleven runs; of the percussion,
    /// the share of another kind.
    #[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
    pub struct Scatter {
        /// Twins of the row that were simulated to their end; the scatter is over these and the row itself.
        pub twins_done: u64 => "1",
        /// One entry per hammer.
        pub hammers: Vec<ScatterOf>,
        /// One entry per casting.
        pub castings: Vec<ScatterOf>,
        /// Of the run as a whole.
        pub totals: ScatterOf,
    }
}

quantities! {
    /// Numerical errors of the main outputs: by how much a row differs from its numerical twin, the same scene at a hundredth of the
    /// tolerance, with housing guides on their springs and all modes of the structure. Of the percussion: 1 if the twin has another.
    #[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
    pub struct NumericalErrors {
        /// 1 if the row's numerical twin was simulated to its end; 0 if it was not, so that the errors are unknown.
        pub numerical_twin_done: u64 => "1",
        /// Number of main outputs whose numerical error exceeds the promise of the row's preset. Outputs of the first impact count
        /// in every row, the others where every hammer is periodic or strikes nothing, in the row and in its numerical twin.
        pub numerical_errors_beyond_promise: Option<u64> => "1" [less],
        /// Largest numerical error of those outputs over its promise.
        pub worst_numerical_error_over_promise: Option<f64> => "1" [less],
        /// One entry per hammer.
        pub hammers: Vec<ScatterOf>,
        /// One entry per casting.
        pub castings: Vec<ScatterOf>,
        /// Of the run as a whole.
        pub totals: ScatterOf,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_quantity::{Kind, Value};

    #[test]
    fn getters_read_their_own_field() {
        let metrics = HammerMetrics { hit_frequency_hz: Some(22.0), contact_count: 7, ..HammerMetrics::default() };
        for quantity in HammerMetrics::QUANTITIES {
            let value = (quantity.value)(&metrics);
            match (quantity.name, quantity.kind) {
                ("hit_frequency_hz", _) => assert_eq!(value, Some(Value::Real(22.0))),
                ("contact_count", _) => assert_eq!(value, Some(Value::Count(7))),
                ("percussion", _) => assert_eq!(value, Some(Value::Text("none"))),
                (
                    "air_used_nl"
                    | "delivered_work_j"
                    | "delivered_impulse_n_s"
                    | "largest_penetration_m"
                    | "largest_jump_force_n",
                    _,
                ) => {
                    assert_eq!(value, Some(Value::Real(0.0)));
                }
                (name, Kind::Real) if name.starts_with("strike_") => {
                    assert_eq!(value, Some(Value::Real(0.0)), "{name}")
                }
                ("percussion_period", _) => assert_eq!(value, None),
                (_, Kind::Count) => assert_eq!(value, Some(Value::Count(0))),
                _ => assert_eq!((value, quantity.kind), (None, Kind::Real), "{}", quantity.name),
            }
            assert!(quantity.description().ends_with('.'), "{}", quantity.name);
        }
        let main: Vec<&str> = CastingMetrics::QUANTITIES.iter().filter(|q| q.main).map(|q| q.name).collect();
        assert_eq!(main, ["peak_velocity_m_s", "peak_point_velocity_m_s", "strike_energy_j", "fixture_damper_loss_j"]);
    }
}
