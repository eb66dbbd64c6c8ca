//! Whether standard errors hold: 32 runs each of the paper's rig with twelve castings, and how many of their intervals hold the truth.
//!
//! `cargo bench --bench coverage`; `DECORE_BENCH_RUNS` sets the runs per casting (default 32). Fails if the intervals of an output
//! hold the truth in fewer than 90 % of all runs, over the castings of which at least half of the runs have errors.

#[path = "support/mod.rs"]
mod support;

use std::any::Any;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Mutex;

use decore_model::metrics::{ERRING, HammerMetrics};
use decore_model::run::{JobSource, RowJob, RowOutcome, RowStatus, perturbed, run_jobs};
use decore_quantity::Value;
use decore_study::engine::{Engine, RowScene};

/// Castings, kg: from and to, evenly in the logarithm.
const MASSES_KG: [f64; 2] = [0.5, 200.0];
/// See [`MASSES_KG`].
const MASSES: usize = 12;
/// Durations whose errors are judged, s.
const DURATIONS_S: [f64; 3] = [1.5, 3.0, 6.0];
/// Relative deviation from run to run below which runs are the same: errors of the integration.
const SAME: f64 = 1e-4;
/// Least share of the intervals of an output that hold the truth.
const LEAST_COVERAGE: f64 = 0.9;

const HEAD: &str = "# Coverage of standard errors

Written by `cargo bench --bench coverage`: the paper's rig with castings from 0.5 to 200 kg, evenly in the logarithm, each run many
times with pressures and standoffs moved by multiples of 1e-9, as twins are. An interval is the value +- 2 standard errors; the truth is
the mean over all runs of the casting and the duration. Each entry: stated error over true deviation (root mean square of the errors
over the deviation from run to run) and the share of intervals that hold the truth. `same`: the runs differ by less than 1e-4 and all
intervals hold the truth. In brackets the share of runs with an error, where it is not all: the others are too short or their percussion has
not settled. A share of 32 intervals that hold the truth in 95 % is between 88 and 100 % in 95 of 100 cases.
";

/// Jobs by their places, and their outcomes.
struct Jobs {
    left: Vec<(u64, RowJob)>,
    done: Vec<(u64, HammerMetrics)>,
}

struct Shared<'a>(&'a Mutex<Jobs>);

impl JobSource for Shared<'_> {
    fn next(&mut self, _wait: bool) -> Option<(u64, RowJob)> {
        self.0.lock().expect("no panic").left.pop()
    }

    fn ended(&mut self, place: u64, outcome: RowOutcome) {
        assert_eq!(outcome.status, RowStatus::Done, "run {place}: {}", outcome.reason);
        let hammer = outcome.metrics.expect("done").hammers.remove(0);
        self.0.lock().expect("no panic").done.push((place, hammer));
    }

    fn panicked(&mut self, place: u64, _payload: Box<dyn Any + Send>) {
        panic!("run {place} panicked");
    }
}

/// Outputs of many runs of a casting, in their order.
fn runs(mass_kg: f64, duration_s: f64, count: usize) -> Vec<HammerMetrics> {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings = [format!("casting.part.mass_kg={mass_kg}"), format!("duration_s={duration_s}")];
    let RowScene { scene, modes } = Engine::load(&study, &settings).expect("a study").scene(0).expect("a scene");
    let job = |place: usize| {
        let scene = if place == 0 { scene.clone() } else { perturbed(&scene, place - 1) };
        (place as u64, RowJob::new(scene, modes.clone(), 0))
    };
    let jobs = Mutex::new(Jobs { left: (0..count).rev().map(job).collect(), done: Vec::new() });
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        (0..threads).for_each(|_| _ = scope.spawn(|| run_jobs(&mut Shared(&jobs))));
    });
    let mut done = jobs.into_inner().expect("no panic").done;
    done.sort_by_key(|(place, _)| *place);
    done.into_iter().map(|(_, hammer)| hammer).collect()
}

/// A number of a hammer's outputs by its name.
fn number(hammer: &HammerMetrics, name: &str) -> Option<f64> {
    let quantity = HammerMetrics::QUANTITIES.iter().find(|quantity| quantity.name == name)?;
    (quantity.value)(hammer).as_ref().and_then(Value::number)
}

/// How the intervals of an output hold.
#[derive(Clone, Copy, Default)]
struct Held {
    values: usize,
    errors: usize,
    held: usize,
    ratio: f64,
    same: bool,
}

impl Held {
    fn of(runs: &[HammerMetrics], [value, error]: [&str; 2]) -> Self {
        let values: Vec<f64> = runs.iter().filter_map(|hammer| number(hammer, value)).collect();
        let pairs: Vec<(f64, f64)> =
            runs.iter().filter_map(|hammer| number(hammer, value).zip(number(hammer, error))).collect();
        let mean = |values: &mut dyn Iterator<Item = f64>, count: usize| values.sum::<f64>() / count as f64;
        let truth = mean(&mut values.iter().copied(), values.len());
        let deviation = mean(&mut values.iter().map(|value| (value - truth).powi(2)), values.len() - 1).sqrt();
        let stated = mean(&mut pairs.iter().map(|(_, error)| error * error), pairs.len()).sqrt();
        let floor = SAME * truth.abs();
        let held = pairs.iter().filter(|(value, error)| (value - truth).abs() <= 2.0 * error + 0.1 * floor).count();
        Self { values: values.len(), errors: pairs.len(), held, ratio: stated / deviation, same: deviation <= floor }
    }

    fn text(self, runs: usize) -> String {
        if self.errors == 0 {
            return if self.values == 0 { "no value" } else { "no error" }.to_owned();
        }
        let share = 100.0 * self.held as f64 / self.errors as f64;
        let some = if self.errors < runs {
            format!(" ({:.0} %)", 100.0 * self.errors as f64 / runs as f64)
        } else {
            String::new()
        };
        if self.same { format!("same{some}") } else { format!("{:.2}, {share:.0} %{some}", self.ratio) }
    }
}

fn main() {
    let count = std::env::var("DECORE_BENCH_RUNS").map_or(32, |runs| runs.parse::<usize>().expect("a number"));
    let mut text = String::from(HEAD);
    let mut failed = Vec::new();
    for duration_s in DURATIONS_S {
        let mut table: Vec<(f64, Vec<Held>)> = Vec::new();
        for place in 0..MASSES {
            let share = place as f64 / (MASSES - 1) as f64;
            let mass_kg = MASSES_KG[0] * (MASSES_KG[1] / MASSES_KG[0]).powf(share);
            let runs = runs(mass_kg, duration_s, count);
            table.push((mass_kg, ERRING.iter().map(|(value, error)| Held::of(&runs, [value, error])).collect()));
            println!("{duration_s} s, {mass_kg:.2} kg");
        }
        failed.extend(write(&mut text, duration_s, &table, count));
    }
    println!("{text}");
    support::write_section("coverage", &text);
    assert!(failed.is_empty(), "{failed:?}");
}

/// Writes the table of a duration; returns the outputs whose intervals hold the truth too rarely.
fn write(text: &mut String, duration_s: f64, table: &[(f64, Vec<Held>)], runs: usize) -> Vec<String> {
    let names = ERRING.map(|(value, _)| format!("`{value}`"));
    let _ = writeln!(text, "\n{runs} runs of {duration_s} s:\n\n| casting (kg) | {} |", names.join(" | "));
    let _ = writeln!(text, "|---|{}", "---|".repeat(ERRING.len()));
    for (mass_kg, held) in table {
        let cells: Vec<String> = held.iter().map(|held| held.text(runs)).collect();
        let _ = writeln!(text, "| {mass_kg:.2} | {} |", cells.join(" | "));
    }
    let all: Vec<Option<f64>> = (0..ERRING.len())
        .map(|output| {
            let counted =
                table.iter().map(|(_, held)| held[output]).filter(|held| !held.same && 2 * held.errors >= runs);
            let (held, errors) = counted.fold((0, 0), |(a, b), one| (a + one.held, b + one.errors));
            (errors > 0).then(|| held as f64 / errors as f64)
        })
        .collect();
    let cell = |share: &Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    let cells: Vec<String> = all.iter().map(cell).collect();
    let _ = writeln!(text, "| all that scatter | {} |", cells.join(" | "));
    let rare = ERRING.iter().zip(&all).filter(|(_, share)| share.is_some_and(|share| share < LEAST_COVERAGE));
    rare.map(|((value, _), share)| format!("{value} after {duration_s} s: {share:?}")).collect()
}
