//! The methods at a fixed step on the paper's rig: how far they are from the default method.

use decore::run::{Machine, RowOutcome, RowStatus, SourceModel, run_row};
use decore::study::Study;

fn simulate(settings: &[&str]) -> RowOutcome {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let study = Study::load(&path).unwrap().with_overrides(&settings).unwrap();
    let model = SourceModel::read(study.structure()).unwrap();
    let points = model.points();
    let machine = Machine::new(model, study.structure(), &study.interface_demand()).unwrap();
    let scene = study.scene(0, &points).unwrap();
    run_row(&scene, &machine.modes(&scene).unwrap())
}

/// First-impact energy, peak velocity of the casting, mean periodic energy, hit frequency.
fn figures(outcome: &RowOutcome) -> [f64; 4] {
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    let metrics = outcome.metrics.as_ref().unwrap();
    let hammer = &metrics.hammers[0];
    [
        hammer.first_impact_energy_j.unwrap(),
        metrics.castings[0].peak_velocity_m_s,
        hammer.periodic_energy_mean_j.unwrap(),
        hammer.hit_frequency_hz.unwrap(),
    ]
}

/// Bounds: three times what was measured. With contacts located, the rule of order 4 is as good as the default method;
/// without, first order shows.
#[test]
fn fixed_steps_come_close_to_the_default() {
    let expected = figures(&simulate(&["solver.tolerance=1e-7"]));
    for (settings, bounds) in [
        (vec!["solver.method=rk4", "solver.step_s=5e-6", "solver.located=true"], [1e-6, 1e-5, 1e-6, 1e-6]),
        (vec!["solver.method=rk4"], [1e-3, 1e-2, 1e-2, 1e-2]),
        (vec!["solver.method=trapezoid"], [1e-2, 0.15, 6e-3, 6e-2]),
    ] {
        let outcome = simulate(&settings);
        let found = figures(&outcome);
        let errors: Vec<f64> =
            found.iter().zip(expected).map(|(found, expected)| (found / expected - 1.0).abs()).collect();
        println!(
            "{settings:?}: {errors:?}, residual {:.1e}, {:?}",
            outcome.metrics.as_ref().unwrap().energy_residual,
            outcome.counters
        );
        for (error, bound) in errors.iter().zip(bounds) {
            assert!(*error < bound, "{settings:?}: {errors:?}");
        }
    }
}

/// Modes at a fixed step are integrated like all else; a study that asks for anything else is told so.
#[test]
fn modes_are_integrated_at_a_fixed_step() {
    let outcome = simulate(&["solver.method=rk4", "duration_s=0.01"]);
    assert!(outcome.states >= 2 * outcome.modes);
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings = ["solver.method=trapezoid".to_owned(), "solver.modes=condensed".to_owned()];
    let study = Study::load(&path).unwrap().with_overrides(&settings).unwrap();
    let points = SourceModel::read(study.structure()).unwrap().points();
    let message = study.scene(0, &points).unwrap_err().to_string();
    assert!(message.contains("must be \"integrated\""), "{message}");
}
