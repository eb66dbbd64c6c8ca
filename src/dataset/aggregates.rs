//! Outputs over all hammers and castings of a run: what a placement is judged by.

use crate::metrics::{HammerMetrics, RunMetrics};

use super::columns::{Cell, ColumnKind};

/// An output over all hammers or castings.
pub struct Aggregate {
    /// Name of the column.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// What it is, in words.
    pub description: &'static str,
    /// Type.
    pub kind: ColumnKind,
    /// Computes it.
    pub value: fn(&RunMetrics) -> Cell<'static>,
}

/// A floating-point aggregate.
const fn real(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    value: fn(&RunMetrics) -> Cell<'static>,
) -> Aggregate {
    Aggregate { name, unit, description, kind: ColumnKind::Real, value }
}

/// All aggregates, in the order of the columns.
pub const AGGREGATES: &[Aggregate] = &[
    Aggregate {
        name: "hammers_striking",
        unit: "1",
        description: "Number of hammers with a first impact whose window lies within the simulation.",
        kind: ColumnKind::Count,
        value: |m| Cell::Count(values(m, |h| h.first_impact_energy_j).count() as u64),
    },
    Aggregate {
        name: "hammers_percussing",
        unit: "1",
        description: "Number of hammers whose percussion strikes to the end (periodic, aperiodic or unsettled). The others count \
                      nothing in sums, and means leave out those without a value.",
        kind: ColumnKind::Count,
        value: |m| Cell::Count(m.hammers.iter().filter(|hammer| hammer.percussion.strikes()).count() as u64),
    },
    Aggregate {
        name: "least_percussion",
        unit: "",
        description: "The least sound percussion of the hammers, in the order none, blank, stalled, unsettled, aperiodic, periodic.",
        kind: ColumnKind::Text,
        value: |m| m.hammers.iter().map(|h| h.percussion).min().map_or(Cell::Null, |least| Cell::Text(least.text())),
    },
    Aggregate {
        name: "total_blow_count",
        unit: "1",
        description: "Number of blows of all hammers, impacts of strokes, settling and blank blows included.",
        kind: ColumnKind::Count,
        value: |m| Cell::Count(m.blows.len() as u64),
    },
    real(
        "delivered_work_in_windows_j",
        "J",
        "Work delivered to the castings within the windows of all blows of all hammers; what lies between blows is missing.",
        |m| Cell::Real(m.blows.iter().map(|blow| blow.work_j).fold(0.0, |sum, x| sum + x)),
    ),
    real(
        "total_first_impact_energy_j",
        "J",
        "Sum of the hammers' first-impact energies (hammers that did not strike count nothing).",
        |m| sum(values(m, |h| h.first_impact_energy_j)),
    ),
    real("mean_first_impact_energy_j", "J", "Mean first-impact energy of the hammers that struck.", |m| {
        mean(values(m, |h| h.first_impact_energy_j))
    }),
    real("min_first_impact_energy_j", "J", "Least first-impact energy of the hammers that struck.", |m| {
        extreme(values(m, |h| h.first_impact_energy_j), f64::min)
    }),
    real("max_first_impact_energy_j", "J", "Largest first-impact energy of the hammers that struck.", |m| {
        extreme(values(m, |h| h.first_impact_energy_j), f64::max)
    }),
    real(
        "total_first_impact_work_j",
        "J",
        "Sum of the work that the hammers' first impacts delivered to the castings.",
        |m| sum(values(m, |h| h.first_impact_work_j)),
    ),
    real(
        "mean_periodic_energy_j",
        "J",
        "Mean over the hammers that have one of their mean energy of a periodic blow.",
        |m| mean(values(m, |h| h.periodic_energy_mean_j)),
    ),
    real("mean_hit_frequency_hz", "Hz", "Mean hit frequency of the hammers that have one.", |m| {
        mean(values(m, |h| h.hit_frequency_hz))
    }),
    real(
        "total_periodic_power_w",
        "W",
        "Sum over the hammers of mean energy of a periodic blow times hit frequency.",
        |m| sum(values(m, |h| Some(h.periodic_energy_mean_j? * h.hit_frequency_hz?))),
    ),
    real(
        "total_periodic_work_rate_w",
        "W",
        "Sum over the hammers of mean work delivered by a periodic blow times hit frequency.",
        |m| sum(values(m, |h| Some(h.periodic_work_mean_j? * h.hit_frequency_hz?))),
    ),
    real("max_first_impact_peak_force_n", "N", "Largest chisel-casting force of all first impacts.", |m| {
        extreme(values(m, |h| h.first_impact_peak_force_n), f64::max)
    }),
    real("max_casting_peak_velocity_m_s", "m/s", "Largest absolute heave velocity of all castings.", |m| {
        extreme(m.castings.iter().map(|c| c.peak_velocity_m_s), f64::max)
    }),
    real(
        "max_casting_point_velocity_m_s",
        "m/s",
        "Largest absolute velocity of the points of all castings that are struck, held or measured, rotations included.",
        |m| extreme(m.castings.iter().map(|c| c.peak_point_velocity_m_s), f64::max),
    ),
    real(
        "max_arm_rms_hammering_m_s",
        "m/s",
        "Largest of the mounts' root-mean-square velocities after the first impacts, their transients included.",
        |m| extreme(values(m, |h| h.arm_rms_hammering_m_s), f64::max),
    ),
    real(
        "max_arm_rms_steady_m_s",
        "m/s",
        "Largest of the mounts' root-mean-square velocities while hammers strike periodically: the lasting load on the machine.",
        |m| extreme(values(m, |h| h.arm_rms_steady_m_s), f64::max),
    ),
    real("total_air_used_nl", "NL", "Air drawn by all hammers over the run, in standard litres.", |m| {
        Cell::Real(air(m))
    }),
    real(
        "work_per_air_j_per_nl",
        "J/NL",
        "Work delivered to the castings over the whole run per standard litre of air drawn.",
        |m| {
            let air = air(m);
            if air > 0.0 { Cell::Real(m.totals.delivered_work_j / air) } else { Cell::Null }
        },
    ),
];

fn air(metrics: &RunMetrics) -> f64 {
    metrics.hammers.iter().map(|hammer| hammer.air_used_nl).fold(0.0, |sum, x| sum + x)
}

/// The hammers' values of a quantity, without those that have none.
fn values(metrics: &RunMetrics, value: fn(&HammerMetrics) -> Option<f64>) -> impl Iterator<Item = f64> {
    metrics.hammers.iter().filter_map(value)
}

/// Zero where no hammer has a value: a hammer that does nothing adds nothing.
fn sum(values: impl Iterator<Item = f64>) -> Cell<'static> {
    // `Iterator::sum` starts from -0.0, which would be the sum of nothing.
    Cell::Real(values.fold(0.0, |sum, x| sum + x))
}

/// Null where no hammer has a value.
fn mean(values: impl Iterator<Item = f64>) -> Cell<'static> {
    let (count, sum) = values.fold((0_u64, 0.0), |(count, sum), x| (count + 1, sum + x));
    if count == 0 { Cell::Null } else { Cell::Real(sum / count as f64) }
}

/// Null where there is no value.
fn extreme(values: impl Iterator<Item = f64>, choose: fn(f64, f64) -> f64) -> Cell<'static> {
    values.reduce(choose).map_or(Cell::Null, Cell::Real)
}
