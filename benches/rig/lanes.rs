//! Rows side by side: what a sweep over pressure and standoff takes per simulated second, beside the same rows one by one.

use std::any::Any;
use std::fmt::Write as _;

use decore::number::Four;
use decore::run::{JobSource, RowJob, RowOutcome, RowStatus, run_jobs, run_jobs_in};
use decore::scene::{Guide, SolverSettings};

use crate::scene::Rig;
use crate::timing::interleaved;

/// Levels of pressure and of standoff.
const LEVELS: usize = 8;
/// Simulated time of a row, s.
const DURATION_S: f64 = 1.2;
/// Gauge pressures in Pa and standoffs in m, from and to.
const PRESSURES_PA: [f64; 2] = [4e5, 6e5];
/// See [`PRESSURES_PA`].
const STANDOFFS_M: [f64; 2] = [0.06, 0.1];

/// How rows are run.
type Way = fn(&mut dyn JobSource);

/// Rows to be run, and how many have ended well.
struct Rows {
    left: Vec<RowJob>,
    done: usize,
}

impl JobSource for Rows {
    fn next(&mut self, _wait: bool) -> Option<(u64, RowJob)> {
        Some((self.left.len() as u64, self.left.pop()?))
    }

    fn ended(&mut self, row: u64, outcome: RowOutcome) {
        assert_eq!(outcome.status, RowStatus::Done, "row {row}: {}", outcome.reason);
        self.done += 1;
    }

    fn panicked(&mut self, row: u64, _payload: Box<dyn Any + Send>) {
        panic!("row {row} panicked");
    }
}

fn one_by_one(source: &mut dyn JobSource) {
    while let Some((row, job)) = source.next(true) {
        source.ended(row, job.run());
    }
}

/// The rows of a setting.
fn rows(rig: &Rig, guide: Guide, tolerance: f64) -> Vec<RowJob> {
    let level = |[from, to]: [f64; 2], i: usize| from + (to - from) * i as f64 / (LEVELS - 1) as f64;
    let row = |i: usize| {
        let mut scene = rig.scene.clone();
        let ambient_pa = scene.environment.ambient_pressure_pa;
        let unit = &mut scene.hammers[0];
        unit.supply_pressure_pa = ambient_pa + level(PRESSURES_PA, i / LEVELS);
        unit.standoff_m = level(STANDOFFS_M, i % LEVELS);
        scene.duration_s = DURATION_S;
        scene.solver = SolverSettings { guide, tolerance, ..scene.solver };
        RowJob::new(scene, rig.modes.clone(), 0)
    };
    (0..LEVELS * LEVELS).map(row).collect()
}

/// The section on rows side by side.
pub fn text(text: &mut String, rig: &Rig, repeats: usize) {
    let _ = writeln!(
        text,
        "\n## Rows side by side\n\n{} rows over pressure (4 to 6 bar) and standoff (60 to 100 mm), {DURATION_S} s each: CPU time of one \
         thread per simulated second of a row. `registers`: four\nrows in the vector registers of this processor; `arrays`: four as on \
         any other processor.\n\n| setting | one by one, ms | registers, ms | arrays, ms | one by one over registers |\n|---|---|---|---|---|",
        LEVELS * LEVELS
    );
    let ways: [Way; 3] = [one_by_one, run_jobs, run_jobs_in::<Four>];
    for (name, guide, tolerance) in
        [("tied, 1e-4", Guide::Tied, 1e-4), ("tied, 1e-5", Guide::Tied, 1e-5), ("spring, 1e-5", Guide::Spring, 1e-5)]
    {
        let jobs = rows(rig, guide, tolerance);
        let timed = interleaved(repeats, &ways, |way| {
            let mut rows = Rows { left: jobs.clone(), done: 0 };
            way(&mut rows);
            assert_eq!(rows.done, jobs.len());
        });
        let simulated_s = DURATION_S * jobs.len() as f64;
        let ms: Vec<f64> = timed.iter().map(|timed| 1e3 * timed.cpu_s / simulated_s).collect();
        let _ = writeln!(text, "| {name} | {:.1} | {:.1} | {:.1} | {:.2} |", ms[0], ms[1], ms[2], ms[0] / ms[1]);
    }
}
