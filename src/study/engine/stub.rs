//! A built-in scene with a given run time and artificial outputs, for tests of the runner and of clusters.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

use super::info::dataset_info;
use super::prepared::RowRunner;
use crate::CheckedStudy;
use decore_dataset::DatasetInfo;
use decore_model::integrate::Counters;
use decore_model::metrics::{Blow, CastingMetrics, HammerMetrics, RunMetrics, RunTotals};
use decore_model::run::{RowOutcome, RowStatus};

/// One row in this many diverges.
const ROWS_PER_FAILURE: u64 = 1000;
/// Turns of a busy row between two looks at the clock.
const SPINS: u32 = 50;
/// The one among them that does.
const FAILING_ROW: u64 = 613;

/// Keeps the processor busy; returns the processor time that it took.
fn compute(duration: Duration) -> Duration {
    let begin = ThreadTime::now();
    while begin.elapsed() < duration {
        (0..SPINS).for_each(|_| std::hint::spin_loop());
    }
    begin.elapsed()
}

/// Sleeps; returns the wall time that it took.
fn sleep(duration: Duration) -> Duration {
    let begin = Instant::now();
    std::thread::sleep(duration);
    begin.elapsed()
}

/// A study's rows without a simulation. Outcomes are pure functions of the row, as the simulated ones are.
#[derive(Debug, Clone)]
pub struct StubRows {
    /// The study; each of its hammers delivers one blow to casting 0, if there is one.
    pub study: CheckedStudy,
    /// Time that a row takes.
    pub duration: Duration,
    /// Whether a row keeps its thread's processor busy for that time, as a simulation does, or sleeps.
    pub busy: bool,
}

impl RowRunner for StubRows {
    fn checked(&self) -> &CheckedStudy {
        &self.study
    }

    fn info(&self) -> DatasetInfo {
        // Made-up rows never mix with simulated ones.
        let settings = BTreeMap::from([("stub-row-ms".to_owned(), "made-up outcomes".to_owned())]);
        dataset_info(&self.study, BTreeMap::new(), settings, None)
    }

    fn depends_on_factors_alone(&self) -> bool {
        false
    }

    /// Waits, then gives the row's outcome; row 613 of every thousand diverges.
    fn outcome(&self, row: usize) -> RowOutcome {
        let row = row as u64;
        let own_time = if self.busy { compute(self.duration) } else { sleep(self.duration) };
        let diverged = row % ROWS_PER_FAILURE == FAILING_ROW;
        RowOutcome {
            status: if diverged { RowStatus::Diverged } else { RowStatus::Done },
            reason: if diverged { "made up: the built-in test scene fails here".to_owned() } else { String::new() },
            time_reached_s: if diverged { unit(row, 0) } else { 1.0 },
            modes: 60,
            states: 136,
            metrics: (!diverged).then(|| self.metrics(row)),
            counters: Counters {
                steps: 1000 + row % 997,
                rejected_steps: row % 89,
                rhs_evaluations: 7 * (1000 + row % 997),
                located_events: 50,
                retries: u64::from(diverged),
                ..Counters::default()
            },
            wall_time_s: own_time.as_secs_f64(),
            numerical_twin_wall_time_s: None,
        }
    }
}

impl StubRows {
    fn metrics(&self, row: u64) -> RunMetrics {
        let (hammers, castings) = (self.study().hammer_names().len(), self.study().casting_names().len());
        let hammer = |index: usize| HammerMetrics {
            first_impact_time_s: Some(0.1 + 0.01 * unit(row, index)),
            first_impact_energy_j: Some(60.0 + unit(row, index + 1)),
            first_impact_work_j: Some(6.0 + unit(row, index + 2)),
            periodic_blows: 9 + row % 5,
            delivered_work_j: 9.0 + unit(row, index + 2),
            hit_frequency_hz: Some(20.0 + unit(row, index + 3)),
            contact_count: 30,
            air_used_nl: 5.0 + unit(row, index + 4),
            ..HammerMetrics::default()
        };
        let blow = |index: usize| Blow {
            hammer: index,
            start_time_s: 0.1 + 0.01 * unit(row, index),
            energy_j: 60.0 + unit(row, index + 1),
            chisel_velocity_m_s: 4.0,
            work_j: 6.0 + unit(row, index + 2),
            impulse_n_s: 3.0,
            peak_force_n: 1e5 * unit(row, index + 5),
            casting_peak_velocity_m_s: unit(row, index + 6),
            ..Blow::default()
        };
        let casting =
            CastingMetrics { peak_velocity_m_s: unit(row, 7), peak_velocity_time_s: 0.11, ..CastingMetrics::default() };
        let hammers: Vec<HammerMetrics> = (0..hammers).map(hammer).collect();
        let delivered_work_j = hammers.iter().map(|hammer| hammer.delivered_work_j).sum();
        let blows = if castings > 0 { hammers.len() } else { 0 };
        RunMetrics {
            hammers,
            castings: vec![casting; castings],
            blows: (0..blows).map(blow).collect(),
            totals: RunTotals {
                delivered_work_j,
                strike_energy_j: delivered_work_j,
                energy_residual: 1e-5 * unit(row, 8),
                ..RunTotals::default()
            },
            ..RunMetrics::default()
        }
    }
}

/// A number from 0 to 1 that depends on the row and a salt (the finaliser of SplitMix64).
fn unit(row: u64, salt: usize) -> f64 {
    let mut z = row.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(salt as u64 + 1);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
