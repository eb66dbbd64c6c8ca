//! Speed against error on the paper's rig, all figures from one run on one core.
//!
//! `cargo bench --bench rig` prints the table and writes its section of `benches/RESULTS.md`. Errors are relative to a run at tolerance
//! 1e-9 of the full model (guide on its spring); times are thread CPU times as ratios to the standard setting, medians of
//! [`REPEATS`] interleaved runs, because absolute times on shared machines mean little.

mod support;

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use decore::metrics::RunMetrics;
use decore::run::{Machine, RowOutcome, SourceModel, run_row};
use decore::scene::{Guide, Scene};
use decore::study::Study;
use decore::system::InterfaceModes;

const REPEATS: usize = 5;
/// Index of the setting that the others are compared with.
const STANDARD: usize = 1;

struct Case {
    name: &'static str,
    guide: Guide,
    tolerance: f64,
    cutoff_hz: f64,
}

const fn case(name: &'static str, guide: Guide, tolerance: f64, cutoff_hz: f64) -> Case {
    Case { name, guide, tolerance, cutoff_hz }
}

const CASES: [Case; 9] = [
    case("spring guide, 1e-4", Guide::Spring, 1e-4, 1000.0),
    case("spring guide, 1e-5 (standard)", Guide::Spring, 1e-5, 1000.0),
    case("spring guide, 1e-7 (reference)", Guide::Spring, 1e-7, 1000.0),
    case("tied guide, 1e-4 (draft)", Guide::Tied, 1e-4, 1000.0),
    case("tied guide, 1e-5", Guide::Tied, 1e-5, 1000.0),
    case("tied guide, 1e-7", Guide::Tied, 1e-7, 1000.0),
    case("tied guide, 1e-5, modes below 300 Hz", Guide::Tied, 1e-5, 300.0),
    case("tied guide, 1e-5, modes below 3000 Hz", Guide::Tied, 1e-5, 3000.0),
    case("spring guide, 1e-5, modes below 3000 Hz", Guide::Spring, 1e-5, 3000.0),
];

fn prepare(cutoff_hz: f64) -> (Scene, InterfaceModes) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings = [format!("structure.cutoff_hz={cutoff_hz}"), "structure.fixed_interface_cutoff_hz=6000".to_owned()];
    let study = Study::load(&path).and_then(|study| study.with_overrides(&settings)).expect("the shipped study");
    let model = SourceModel::read(study.structure()).expect("the built-in station");
    let points = model.points();
    let machine = Machine::new(model, study.structure(), &study.interface_demand()).expect("its reduction");
    let scene = study.scene(0, &points).expect("its scene");
    let modes = machine.modes(&scene).expect("its modes");
    (scene, modes)
}

fn run(case: &Case, (scene, modes): &(Scene, InterfaceModes)) -> (RowOutcome, f64) {
    let mut scene = scene.clone();
    scene.solver.guide = case.guide;
    scene.solver.tolerance = case.tolerance;
    let begin = Instant::now();
    let outcome = run_row(&scene, modes);
    (outcome, begin.elapsed().as_secs_f64())
}

/// First-impact energy, periodic energy, hit frequency, casting peak velocity.
fn figures(metrics: &RunMetrics) -> [f64; 4] {
    let hammer = &metrics.hammers[0];
    let value = |value: Option<f64>| value.unwrap_or(f64::NAN);
    [
        value(hammer.first_impact_energy_j),
        value(hammer.periodic_energy_mean_j),
        value(hammer.hit_frequency_hz),
        metrics.castings[0].peak_velocity_m_s,
    ]
}

fn main() {
    let prepared: Vec<_> = CASES.iter().map(|case| prepare(case.cutoff_hz)).collect();
    let exact_case = case("", Guide::Spring, 1e-9, 1000.0);
    let exact = run(&exact_case, &prepared[STANDARD]).0.metrics.expect("the reference run");
    let mut times = vec![Vec::new(); CASES.len()];
    let mut outcomes: Vec<Option<RowOutcome>> = vec![None; CASES.len()];
    for _ in 0..REPEATS {
        for (index, case) in CASES.iter().enumerate() {
            let (outcome, time) = run(case, &prepared[index]);
            times[index].push(time);
            outcomes[index] = Some(outcome);
        }
    }
    for list in &mut times {
        list.sort_by(f64::total_cmp);
    }
    let mut text = String::from(
        "# Speed against error on the paper's rig\n\nWritten by `cargo bench --bench rig`: 1.5 s, one hammer, one core. Time is relative to the standard\nsetting in the same run; errors are relative to the full model at tolerance 1e-9 with modes below 1000 Hz (so the rows with\nother cut-offs show what truncation of modes does).\n\n| setting | modes | time | steps | right-hand sides | first-impact energy | periodic energy | frequency | peak velocity | energy residual |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let median = |index: usize| times[index][REPEATS / 2];
    for (index, case) in CASES.iter().enumerate() {
        let Some(RowOutcome { metrics: Some(metrics), modes, counters, .. }) = &outcomes[index] else { continue };
        let errors =
            figures(metrics).into_iter().zip(figures(&exact)).map(|(a, b)| format!("{:.0e}", (a / b - 1.0).abs()));
        let _ = writeln!(
            text,
            "| {} | {modes} | {:.2} | {} | {} | {} | {:.0e} |",
            case.name,
            median(index) / median(STANDARD),
            counters.steps,
            counters.rhs_evaluations,
            errors.collect::<Vec<_>>().join(" | "),
            metrics.energy_residual.abs()
        );
    }
    let _ = writeln!(
        text,
        "\nThe standard setting took {:.0} ms per simulated second on the machine of this run.",
        median(STANDARD) / 1.5 * 1e3
    );
    print!("{text}");
    support::write_section("rig", &text);
}
