//! Outputs over all hammers and castings of a run: what a placement is judged by.

use super::outputs::{HammerMetrics, RunMetrics};
use super::percussion::Percussion;
use decore_quantity::quantities;

quantities! {
    /// Outputs over all hammers or castings.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Aggregates {
        /// Number of hammers with a first impact whose window lies within the simulation.
        pub hammers_striking: usize => "1",
        /// Number of hammers whose percussion strikes to the end (periodic, aperiodic or unsettled). The others count
        /// nothing in sums, and means leave out those without a value.
        pub hammers_percussing: usize => "1",
        /// The least sound percussion of the hammers, in the order none, blank, stalled, unsettled, aperiodic, periodic.
        pub least_percussion: Option<Percussion> => "",
        /// Number of blows of all hammers, impacts of strokes, settling and blank blows included.
        pub total_blow_count: usize => "1",
        /// Work delivered to the castings within the windows of all blows of all hammers; what lies between blows is
        /// missing.
        pub delivered_work_in_windows_j: f64 => "J",
        /// Sum of the hammers' first-impact energies (hammers that did not strike count nothing).
        pub total_first_impact_energy_j: f64 => "J",
        /// Mean first-impact energy of the hammers that struck.
        pub mean_first_impact_energy_j: Option<f64> => "J",
        /// Least first-impact energy of the hammers that struck.
        pub min_first_impact_energy_j: Option<f64> => "J",
        /// Largest first-impact energy of the hammers that struck.
        pub max_first_impact_energy_j: Option<f64> => "J",
        /// Sum of the work that the hammers' first impacts delivered to the castings.
        pub total_first_impact_work_j: f64 => "J",
        /// Mean over the hammers that have one of their mean energy of a periodic blow.
        pub mean_periodic_energy_j: Option<f64> => "J",
        /// Mean hit frequency of the hammers that have one.
        pub mean_hit_frequency_hz: Option<f64> => "Hz",
        /// Sum over the hammers of mean energy of a periodic blow times hit frequency.
        pub total_periodic_power_w: f64 => "W",
        /// Sum over the hammers of mean work delivered by a periodic blow times hit frequency.
        pub total_periodic_work_rate_w: f64 => "W",
        /// Sum over the hammers of the mean energy that a periodic strike gives to the casting times hit frequency.
        pub total_strike_energy_rate_w: f64 => "W",
        /// Sum over the hammers of the casting's mean gain of kinetic energy in a periodic strike times hit frequency.
        pub total_strike_kinetic_energy_rate_w: f64 => "W",
        /// Sum over the hammers of the mean momentum that a periodic strike gives to the casting times hit frequency.
        pub total_strike_momentum_rate_n: f64 => "N",
        /// Part of the delivered work that was lost in the dampers of all fixtures.
        pub total_fixture_damper_loss_j: f64 => "J" [less],
        /// Part of the delivered work that went through the fixtures into the machine.
        pub total_structure_work_j: f64 => "J" [less],
        /// Energy lost in the contacts of the chisels with the castings.
        pub total_strike_contact_loss_j: f64 => "J" [less],
        /// Largest chisel-casting force of all first impacts.
        pub max_first_impact_peak_force_n: Option<f64> => "N" [less],
        /// Largest absolute heave velocity of all castings.
        pub max_casting_peak_velocity_m_s: Option<f64> => "m/s" [less],
        /// Largest absolute velocity of the points of all castings that are struck, held or measured, rotations included.
        pub max_casting_point_velocity_m_s: Option<f64> => "m/s" [less],
        /// Largest of the mounts' root-mean-square velocities after the first impacts, their transients included.
        pub max_arm_rms_hammering_m_s: Option<f64> => "m/s" [less],
        /// Largest of the mounts' root-mean-square velocities while hammers strike periodically and their impacts have decayed:
        /// the lasting load on the machine.
        pub max_arm_rms_steady_m_s: Option<f64> => "m/s" [less],
        /// Air drawn by all hammers over the run, in standard litres.
        pub total_air_used_nl: f64 => "NL" [less],
        /// Work delivered to the castings over the whole run per standard litre of air drawn.
        pub work_per_air_j_per_nl: Option<f64> => "J/NL",
    }
}

impl Aggregates {
    /// Those of a run.
    pub fn of(run: &RunMetrics) -> Self {
        let hammers = |value: fn(&HammerMetrics) -> Option<f64>| run.hammers.iter().filter_map(value);
        let castings = || run.castings.iter();
        let rate = |of_blow: fn(&HammerMetrics) -> Option<f64>| {
            sum(run.hammers.iter().filter_map(|h| Some(of_blow(h)? * h.hit_frequency_hz?)))
        };
        let energies = || hammers(|h| h.first_impact_energy_j);
        let air = sum(run.hammers.iter().map(|h| h.air_used_nl));
        Self {
            hammers_striking: energies().count(),
            hammers_percussing: run.hammers.iter().filter(|h| h.percussion.strikes()).count(),
            least_percussion: run.hammers.iter().map(|h| h.percussion).min(),
            total_blow_count: run.blows.len(),
            delivered_work_in_windows_j: sum(run.blows.iter().map(|blow| blow.work_j)),
            total_first_impact_energy_j: sum(energies()),
            mean_first_impact_energy_j: mean(energies()),
            min_first_impact_energy_j: energies().reduce(f64::min),
            max_first_impact_energy_j: energies().reduce(f64::max),
            total_first_impact_work_j: sum(hammers(|h| h.first_impact_work_j)),
            mean_periodic_energy_j: mean(hammers(|h| h.periodic_energy_mean_j)),
            mean_hit_frequency_hz: mean(hammers(|h| h.hit_frequency_hz)),
            total_periodic_power_w: rate(|h| h.periodic_energy_mean_j),
            total_periodic_work_rate_w: rate(|h| h.periodic_work_mean_j),
            total_strike_energy_rate_w: rate(|h| h.periodic_strike_energy_mean_j),
            total_strike_kinetic_energy_rate_w: rate(|h| h.periodic_strike_kinetic_energy_mean_j),
            total_strike_momentum_rate_n: rate(|h| h.periodic_strike_momentum_mean_n_s),
            total_fixture_damper_loss_j: sum(castings().map(|c| c.fixture_damper_loss_j)),
            total_structure_work_j: sum(castings().map(|c| c.structure_work_j)),
            total_strike_contact_loss_j: sum(castings().map(|c| c.strike_contact_loss_j)),
            max_first_impact_peak_force_n: hammers(|h| h.first_impact_peak_force_n).reduce(f64::max),
            max_casting_peak_velocity_m_s: castings().map(|c| c.peak_velocity_m_s).reduce(f64::max),
            max_casting_point_velocity_m_s: castings().map(|c| c.peak_point_velocity_m_s).reduce(f64::max),
            max_arm_rms_hammering_m_s: hammers(|h| h.arm_rms_hammering_m_s).reduce(f64::max),
            max_arm_rms_steady_m_s: hammers(|h| h.arm_rms_steady_m_s).reduce(f64::max),
            total_air_used_nl: air,
            work_per_air_j_per_nl: (air > 0.0).then(|| run.totals.delivered_work_j / air),
        }
    }
}

/// Zero where no hammer has a value: a hammer that does nothing adds nothing.
fn sum(values: impl Iterator<Item = f64>) -> f64 {
    // `Iterator::sum` starts from -0.0, which would be the sum of nothing.
    values.fold(0.0, |sum, x| sum + x)
}

/// `None` where no hammer has a value.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0_u64, 0.0), |(count, sum), x| (count + 1, sum + x));
    (count > 0).then(|| sum / count as f64)
}
