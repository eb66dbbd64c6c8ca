//! `decore best` on the shipped study beside a brute force, and beside runs that it has not seen. Writes its section of
//! `benches/RESULTS.md`. `DECORE_BRUTE`: dataset of the brute force, from an earlier run; made in `target/answer/brute` otherwise.
//! `DECORE_RUNS`: unseen runs of each proposal, 2,000 otherwise.

mod support;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use decore_dataset::{DatasetReader, TableName};
use decore_math::random::uniform;
use decore_model::metrics::{Aggregates, RunTotals};
use decore_quantity::Cell;
use decore_statistics::design::{Coordinate, Level};
use decore_study::engine::{Engine, RowRunner};
use serde_json::Value;

/// Decisions of the brute force, and draws of the stiffness for each.
const BRUTE: [usize; 2] = [1000, 20];
/// Runs of the independent check; `DECORE_RUNS` gives another number.
const CHECKED: usize = 2000;
/// Limits of the velocity in m/s.
const LIMITS: [f64; 3] = [3.5, 4.5, 5.5];
/// Factors of the study: three decisions, then the stiffness.
const FACTORS: [&str; 4] = ["position", "pressure", "standoff", "fixture_stiffness"];
/// Seed of the check.
const SEED: u64 = 20_000;

const GOAL: &str = RunTotals::strike_energy_j.name;
const LIMITED: &str = Aggregates::max_casting_point_velocity_m_s.name;

fn study() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml")
}

fn decore(arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_decore")).args(arguments).output().expect("decore starts");
    assert!(matches!(output.status.code(), Some(0 | 4)), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// The dataset of the brute force: decisions at random, each with the middles of the strata of the stiffness' logarithm.
fn brute(folder: &Path) -> PathBuf {
    if let Some(found) = std::env::var_os("DECORE_BRUTE") {
        return found.into();
    }
    let engine = Engine::load(&study(), &[]).expect("the study");
    let factors = engine.checked().design().factors().to_vec();
    let mut table = FACTORS.join(",") + "\n";
    for decision in 0..BRUTE[0] {
        for draw in 0..BRUTE[1] {
            let share = |factor: usize| match factor {
                3 => (draw as f64 + 0.5) / BRUTE[1] as f64,
                _ => uniform(SEED, decision as u64, factor as u64),
            };
            let value = |factor: usize| number(factors[factor].distribution.quantile(share(factor)));
            let row: Vec<String> = (0..FACTORS.len()).map(|factor| value(factor).to_string()).collect();
            table += &(row.join(",") + "\n");
        }
    }
    std::fs::create_dir_all(folder).expect("a folder");
    let (rows, file, dataset) = (folder.join("brute.csv"), folder.join("brute.toml"), folder.join("brute"));
    std::fs::write(&rows, table).expect("rows");
    let text = std::fs::read_to_string(study()).expect("the study");
    let hammer = study().with_file_name("hammers/default.toml");
    let text = text.replace("\"hammers/default.toml\"", &format!("{:?}", hammer.display().to_string()));
    let text = text.replace("kind = \"latin_hypercube\"\nrows = 240", "kind = \"table\"\nfile = \"brute.csv\"");
    std::fs::write(&file, text).expect("a study");
    decore(&["run", &file.to_string_lossy(), "--output", &dataset.to_string_lossy(), "--threads", "1"]);
    dataset
}

fn runs() -> usize {
    std::env::var("DECORE_RUNS").ok().and_then(|text| text.parse().ok()).unwrap_or(CHECKED)
}

fn number(level: Level) -> f64 {
    if let Level::Real(value) = level { value } else { f64::NAN }
}

/// Mean energy and velocities of a decision of the brute force.
#[derive(Default)]
struct Decision {
    energies: Vec<f64>,
    velocities: Vec<f64>,
}

/// The best mean energy among decisions of which a share of 0.95 of the draws hold the limit, and that share's decision.
fn best_of(decisions: &BTreeMap<[u64; 3], Decision>, limit: f64) -> (f64, [f64; 3]) {
    let holds = |of: &Decision| {
        let held = of.velocities.iter().filter(|velocity| **velocity <= limit).count();
        held as f64 >= 0.95 * BRUTE[1] as f64 - 1e-9
    };
    let mean = |of: &Decision| of.energies.iter().sum::<f64>() / of.energies.len() as f64;
    let found = decisions.iter().filter(|(_, of)| holds(of)).map(|(at, of)| (mean(of), at.map(f64::from_bits)));
    found.fold((f64::NAN, [f64::NAN; 3]), |best, next| if next.0 > best.0 || best.0.is_nan() { next } else { best })
}

fn decisions(dataset: &Path) -> BTreeMap<[u64; 3], Decision> {
    let reader = DatasetReader::open(dataset).expect("the dataset of the brute force");
    let names: Vec<String> = FACTORS.iter().map(|name| format!("factor_{name}")).collect();
    let columns: Vec<&str> = names.iter().map(String::as_str).chain([GOAL, LIMITED]).collect();
    let mut decisions: BTreeMap<[u64; 3], Decision> = BTreeMap::new();
    let number = |cell: &Cell<'_>| cell.and_then(|value| value.number()).unwrap_or(f64::NAN);
    let read = |cells: &[Cell<'_>]| {
        let at = [0, 1, 2].map(|factor| number(&cells[factor]).to_bits());
        let own = decisions.entry(at).or_default();
        own.energies.push(number(&cells[4]));
        own.velocities.push(number(&cells[5]));
    };
    reader.visit(TableName::Runs, &columns, read).expect("rows");
    decisions
}

/// Mean energy and share of the limit in runs of a decision that nothing has seen.
fn checked(engine: &Engine, decision: &[f64], limit: f64) -> (f64, f64) {
    let stiffness = &engine.checked().design().factors()[3].distribution;
    let point = |run: usize| {
        let draw = Coordinate::Probability(uniform(SEED, 1, run as u64)).level(stiffness);
        decision.iter().map(|value| Level::Real(*value)).chain([draw]).collect::<Vec<Level>>()
    };
    let points: Vec<Vec<Level>> = (0..runs()).map(point).collect();
    let outcomes = engine.outcomes_at(&points, 1, &AtomicBool::new(false)).expect("runs").expect("all of them");
    let metrics: Vec<_> = outcomes.iter().filter_map(|outcome| outcome.metrics.as_ref()).collect();
    let energy = metrics.iter().map(|of| of.totals.strike_energy_j).sum::<f64>() / metrics.len() as f64;
    let held =
        metrics.iter().filter(|of| Aggregates::of(of).max_casting_point_velocity_m_s.is_some_and(|v| v <= limit));
    (energy, held.count() as f64 / points.len() as f64)
}

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/answer");
    let decisions = decisions(&brute(&folder));
    let engine = Engine::load(&study(), &[]).expect("the study");
    let mut text = format!(
        "# The answer beside a brute force\n\nWritten by `cargo bench --bench answer`: `decore best studies/placement.toml` with three limits of \
         the casting's velocity, beside the best of {} decisions at random with {} draws of the stiffness each, and in {} runs that it has \
         not seen. Wanted: the limit holds in 95 % of these, and the mean energy is at least 0.99 of the brute force's, with at most 400 runs.\n\n\
         | limit (m/s) | runs | position (m), pressure (bar), standoff (m) | checks held | energy (J) | limit held in | brute force (J) | at | share |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        decisions.len(),
        BRUTE[1],
        runs()
    );
    for limit in LIMITS {
        let output = folder.join(format!("placement-{limit}"));
        let goal = format!("goal.limits=[\"{LIMITED} <= {limit}\"]");
        let answer = decore(&[
            "best",
            &study().to_string_lossy(),
            "--output",
            &output.to_string_lossy(),
            "--set",
            &goal,
            "--json",
        ]);
        let answer: Value = serde_json::from_slice(&answer).expect("JSON");
        eprintln!("{}", answer["sentence"]);
        let values = answer["settings"].as_array().expect("settings").iter().map(|one| one["value"].as_f64());
        let values: Vec<f64> = values.map(|value| value.unwrap_or(f64::NAN)).collect();
        let added = std::fs::read_to_string(folder.join(format!("placement-{limit}.best.csv"))).unwrap_or_default();
        let runs = 240 + added.lines().count().saturating_sub(1);
        let (energy, held) = checked(&engine, &values, limit);
        let (brute, at) = best_of(&decisions, limit);
        let _ = writeln!(
            text,
            "| {limit} | {runs} | {values:?} | {} of {} | {energy:.2} | {:.2} % | {brute:.2} | {at:.4?} | {:.4} |",
            answer["proof"]["held"],
            answer["proof"]["runs"],
            100.0 * held,
            energy / brute
        );
    }
    print!("{text}");
    support::write_section("answer", &text);
}
