//! The methods at a fixed step on the paper's rig: how far their outputs are from those of the default method at 1e-7.

use decore_model::run::{RowOutcome, RowStatus, run_row};
use decore_study::engine::{Engine, RowScene};

fn simulate(settings: &[&str]) -> RowOutcome {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let RowScene { scene, modes } = Engine::load(&path, &settings).unwrap().scene(0).unwrap();
    run_row(&scene, &modes)
}

/// First-impact energy, peak velocity of the casting, mean periodic energy, hit frequency.
fn figures(outcome: &RowOutcome) -> [f64; 4] {
    // At a fixed step that locates nothing the audit fails: what it says is that step's error.
    let ended = matches!(outcome.status, RowStatus::Done | RowStatus::AuditFailed);
    assert!(ended, "{}", outcome.reason);
    let metrics = outcome.metrics.as_ref().unwrap();
    let hammer = &metrics.hammers[0];
    [
        hammer.first_impact_energy_j.unwrap(),
        metrics.castings[0].peak_velocity_m_s,
        hammer.periodic_energy_mean_j.unwrap(),
        hammer.hit_frequency_hz.unwrap(),
    ]
}

/// Relative errors of the four figures of a run at a fixed step, printed with the audit and the work.
fn errors(settings: &[&str], expected: &[f64; 4]) -> [f64; 4] {
    let outcome = simulate(settings);
    let found = figures(&outcome);
    let errors = std::array::from_fn(|i| (found[i] / expected[i] - 1.0).abs());
    let residual = outcome.metrics.as_ref().unwrap().totals.energy_residual;
    println!("{settings:?}: {errors:?}, residual {residual:.1e}, {:?}", outcome.counters);
    errors
}

/// Each error is at most what was measured and a margin of about a third. The bounds hold for these steps only: where contacts
/// are noticed at the ends of steps, errors depend on where in a step they happen to fall and do not follow an order. For
/// the periodic figures that is a matter of the last digit: a damping ratio changed by 5e-14 moves the frequency's error of
/// the plain rule between -1.3e-3 and 4.6e-4, that of the trapezoid between 6.8e-3 and 1.7e-2, other last bits of the set-up to
/// 2.3e-2; their bounds are a third above the largest of five such runs.
///
/// What the figures say: located, the rule of order 4 at 5 us is as good as the default method at 1e-6; not located, the same rule at
/// 10 us is worse by a factor of 100 at least in every figure; the trapezoid, which notices contacts as late and damps nothing
/// but follows stiff contacts to second order only, is worse still.
#[test]
fn errors_at_a_fixed_step_are_what_was_measured() {
    let expected = figures(&simulate(&["solver.tolerance=1e-7", "solver.guide=spring"]));
    let located = errors(&["solver.method=rk4", "solver.step_s=5e-6", "solver.located=true"], &expected);
    let plain = errors(&["solver.method=rk4", "solver.step_s=1e-5"], &expected);
    let trapezoid = errors(&["solver.method=trapezoid", "solver.step_s=1e-5"], &expected);
    for (name, errors, bounds) in [
        // The third was 8e-9, below what the default method is known to at 1e-7.
        ("located", located, [1.6e-7, 3.4e-6, 3e-8, 3.4e-7]),
        ("plain", plain, [4.7e-4, 2.9e-3, 1.1e-3, 1.7e-3]),
        ("trapezoid", trapezoid, [4.2e-3, 7.3e-2, 3.7e-3, 3.1e-2]),
    ] {
        assert!(errors.iter().zip(bounds).all(|(error, bound)| *error < bound), "{name}: {errors:?} and {bounds:?}");
    }
    for figure in 0..4 {
        assert!(plain[figure] > 100.0 * located[figure], "figure {figure}: {plain:?} and {located:?}");
        assert!(trapezoid[figure] > plain[figure], "figure {figure}: {trapezoid:?} and {plain:?}");
    }
}

/// Modes at a fixed step are integrated like all else; a study that asks for anything else is told so.
#[test]
fn modes_are_integrated_at_a_fixed_step() {
    let outcome = simulate(&["solver.method=rk4", "duration_s=0.01"]);
    assert!(outcome.states >= 2 * outcome.modes);
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings = ["solver.method=trapezoid".to_owned(), "solver.modes=condensed".to_owned()];
    let message = Engine::load(&path, &settings).unwrap_err().to_string();
    assert!(message.contains("must be \"integrated\""), "{message}");
}
