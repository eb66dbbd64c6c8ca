//! Rows side by side: what a sweep over pressure and standoff takes per simulated second, beside the same rows one by one.

use std::any::Any;
use std::fmt::Write as _;
use std::sync::Arc;

use decore_math::number::Registers;
use decore_model::run::{JobSource, RowJob, RowOutcome, RowStatus, run_jobs_in};
use decore_model::scene::{Guide, SolverSettings};
use decore_model::system::PlacedModes;

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

/// The rows of a setting.
fn rows(rig: &Rig, guide: Guide, tolerance: f64) -> Vec<RowJob> {
    let level = |[from, to]: [f64; 2], i: usize| from + (to - from) * i as f64 / (LEVELS - 1) as f64;
    let modes = Arc::new(PlacedModes::from(rig.modes.clone()));
    let row = |i: usize| {
        let mut scene = rig.scene.clone();
        let ambient_pa = scene.environment.ambient_pressure_pa;
        let unit = &mut scene.hammers[0];
        unit.supply_pressure_pa = ambient_pa + level(PRESSURES_PA, i / LEVELS);
        unit.standoff_m = level(STANDOFFS_M, i % LEVELS);
        scene.duration_s = DURATION_S;
        scene.solver = SolverSettings { guide, tolerance, ..scene.solver };
        RowJob::new(scene, Arc::clone(&modes), 0)
    };
    (0..LEVELS * LEVELS).map(row).collect()
}

/// A way to run rows: one by one, or side by side in some registers.
type Way = Option<Registers>;

fn run(way: Way, source: &mut Rows) {
    match way {
        Some(registers) => run_jobs_in(registers, source),
        None => {
            while let Some((row, job)) = source.next(true) {
                source.ended(row, job.run());
            }
        }
    }
}

/// The section on rows side by side.
pub fn text(text: &mut String, rig: &Rig, repeats: usize) {
    let registers = Registers::ALL.into_iter().filter(|registers| registers.are_available());
    let ways: Vec<Way> = std::iter::once(None).chain(registers.map(Some)).collect();
    let _ = write!(
        text,
        "\n## Rows side by side\n\n{} rows over pressure (4 to 6 bar) and standoff (60 to 100 mm), {DURATION_S} s each: CPU time of one \
         thread per simulated second of a row, ms.\nFour rows with AVX2, eight with AVX-512, as far as this processor has them (`Any` is what runs without them, on \
         x86-64 rows one by one).\n\n| setting | one by one |",
        LEVELS * LEVELS
    );
    ways.iter().flatten().for_each(|registers| text.push_str(&format!(" {registers:?} |")));
    let _ = writeln!(text, " one by one over the last |\n|---|{}---|", "---|".repeat(ways.len()));
    for (name, guide, tolerance) in
        [("tied, 1e-4", Guide::Tied, 1e-4), ("tied, 1e-5", Guide::Tied, 1e-5), ("spring, 1e-5", Guide::Spring, 1e-5)]
    {
        let jobs = rows(rig, guide, tolerance);
        let timed = interleaved(repeats, &ways, |way| {
            let mut rows = Rows { left: jobs.clone(), done: 0 };
            run(*way, &mut rows);
            assert_eq!(rows.done, jobs.len());
        });
        let simulated_s = DURATION_S * jobs.len() as f64;
        let ms: Vec<f64> = timed.iter().map(|timed| 1e3 * timed.cpu_s / simulated_s).collect();
        let cells: String = ms.iter().map(|ms| format!(" {ms:.1} |")).collect();
        let _ = writeln!(text, "| {name} |{cells} {:.2} |", ms[0] / ms[ms.len() - 1]);
    }
}
