//! Validation against an independent fixed-step program and a second, converged one (`tests/data/reference.json`).

use std::path::Path;

use decore::accuracy::main_differences;
use decore_model::run::{RowOutcome, RowStatus, run_row};
use decore_study::engine::{Engine, RowScene};
use serde_json::Value;

/// Names here, names in the reference, and the bound of the relative difference.
const FIGURES: [(&str, &str, f64); 17] = [
    ("first_impact_time_s", "first_time", 2e-3),
    ("first_impact_energy_j", "first_energy", 2e-3),
    ("first_impact_chisel_velocity_m_s", "first_chisel_v", 2e-3),
    ("first_impact_work_j", "first_work", 1e-2),
    ("first_impact_impulse_n_s", "first_impulse", 1e-2),
    ("first_impact_peak_force_n", "first_peak_force", 1e-2),
    ("first_impact_casting_peak_velocity_m_s", "first_casting_peak", 1e-2),
    ("struck_blow_count", "n_periodic_blows", 0.0),
    ("periodic_energy_mean_j", "periodic_energy_mean", PERIODIC),
    ("hit_frequency_hz", "freq", PERIODIC),
    ("periodic_work_mean_j", "periodic_work", PERIODIC),
    ("periodic_impulse_mean_n_s", "periodic_impulse", PERIODIC),
    ("periodic_peak_force_mean_n", "periodic_peak_force", PERIODIC),
    ("periodic_casting_peak_velocity_mean_m_s", "periodic_casting_peak", PERIODIC),
    ("arm_rms_extension_m_s", "rms_arm_extension", 2e-2),
    ("arm_rms_hammering_m_s", "rms_arm_hammering", 2e-2),
    ("contact_count", "n_contacts", 3e-2),
];
/// Stands for the bound of periodic values, which depends on the scene.
const PERIODIC: f64 = f64::NAN;

fn reference() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn simulate(study: &str, settings: &[&str]) -> RowOutcome {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(study);
    // The reference counts every interval of positive force.
    let settings = settings.iter().chain(&["outputs.contact_separation_s=0.0"]);
    let settings: Vec<String> = settings.map(|setting| (*setting).to_owned()).collect();
    let RowScene { scene, modes } = Engine::load(&path, &settings).unwrap().scene(0).unwrap();
    let outcome = run_row(&scene, &modes);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome
}

fn close(what: &str, value: &Value, expected: &Value, bound: f64) {
    let (value, expected) = (value.as_f64().unwrap_or(f64::NAN), expected.as_f64().unwrap_or(f64::NAN));
    let difference = (value / expected - 1.0).abs();
    assert!(
        difference <= bound,
        "{what}: {value} against {expected}, relative difference {difference:.1e} > {bound:.0e}"
    );
}

/// Holds a scene to the fixed-step program's figures.
fn matches(outcome: &RowOutcome, scene: &str, periodic: f64) {
    let expected = &reference()["scenes"][scene]["metrics"];
    let metrics = outcome.metrics.as_ref().unwrap();
    for (h, hammer) in metrics.hammers.iter().enumerate() {
        let hammer = serde_json::to_value(hammer).unwrap();
        for (name, short, bound) in FIGURES {
            let bound = if bound.is_nan() { periodic } else { bound };
            close(&format!("{scene}, hammer {h}, {name}"), &hammer[name], &expected["hammers"][h][short], bound);
        }
    }
    for (c, casting) in metrics.castings.iter().enumerate() {
        let casting = serde_json::to_value(casting).unwrap();
        let expected = &expected["castings"][c];
        close(&format!("{scene}, casting {c}"), &casting["peak_velocity_m_s"], &expected["peak_velocity"], 1e-2);
        close(&format!("{scene}, casting {c}"), &casting["peak_velocity_time_s"], &expected["peak_time"], 1e-2);
    }
    assert!(metrics.totals.energy_residual.abs() < 1e-3, "{scene}: residual {:e}", metrics.totals.energy_residual);
}

/// Holds a scene to the converged program's figures: first impact, periodic energy, frequency, peak velocity.
fn converges(outcome: &RowOutcome, scene: &str, [first, periodic, frequency, peak]: [f64; 4]) {
    let expected = &reference()["converged"]["scenes"][scene];
    let metrics = outcome.metrics.as_ref().unwrap();
    for (h, hammer) in metrics.hammers.iter().enumerate() {
        let hammer = serde_json::to_value(hammer).unwrap();
        let expected = &expected[h];
        let check = |name: &str, short: &str, bound| {
            close(&format!("{scene}, converged, hammer {h}, {name}"), &hammer[name], &expected[short], bound);
        };
        check("first_impact_energy_j", "first_energy", first);
        check("first_impact_time_s", "first_time", first);
        check("periodic_energy_mean_j", "periodic_energy_mean", periodic);
        check("hit_frequency_hz", "freq", frequency);
    }
    let mut peaks = metrics.castings.iter().map(|casting| serde_json::json!(casting.peak_velocity_m_s));
    let last = expected.as_array().unwrap().last().unwrap();
    close(
        &format!("{scene}, converged, peak"),
        &peaks.next_back().unwrap(),
        &last["casting_of_hammer_peak_velocity"],
        peak,
    );
}

/// The reference strikes the casting's centre from a mount that is not above it.
const R3_60MM: [&str; 4] = [
    "hammer.hammer.mount=R3",
    "hammer.hammer.strike_point_m=[0.0, 0.0]",
    "hammer.hammer.standoff_m=0.060",
    "geometry=as_given",
];

/// A basis whose modes below 1000 Hz are the full model's, as the reference's are.
const BASIS: &str = "structure.fixed_interface_cutoff_hz=20000";
/// Presets, the default also with guides on their springs as the other program has them, with their bounds for first impact,
/// periodic energy, frequency and peak velocity. Measured at worst: 7e-6, 1e-5, 9e-6, 7e-5; 3e-6, 2e-6, 3e-6, 1e-5; 2e-7, 1e-7, 3e-6, 2e-6; 1e-7,
/// 9e-8, 3e-6, 2e-6. All are at most what the preset promises, but for the frequency of `reference`, which promises 1e-6: there the
/// difference to this program stays, whatever the tolerance.
const PRESETS: [(&[&str], [f64; 4]); 4] = [
    (&["solver.fidelity=draft"], [2e-5, 3e-5, 3e-5, 2e-4]),
    (&["solver.fidelity=standard"], [4e-6, 4e-6, 4e-6, 2e-5]),
    (&["solver.fidelity=standard", "solver.guide=spring"], [1e-6, 1e-6, 5e-6, 1e-5]),
    (&["solver.fidelity=reference"], [1e-6, 1e-6, 4e-6, 1e-5]),
];

#[test]
fn val_single_hammer_scenes() {
    let scenes: [(&str, &[&str]); 3] =
        [("paper_rig", &[]), ("paper_rig_4bar", &["hammer.hammer.supply_bar=4.0"]), ("paper_rig_r3_60mm", &R3_60MM)];
    for (scene, settings) in scenes {
        for (preset, bounds) in PRESETS {
            let settings: Vec<&str> = settings.iter().chain(preset).copied().chain([BASIS]).collect();
            let outcome = simulate("paper_rig.toml", &settings);
            matches(&outcome, scene, 1e-2);
            converges(&outcome, scene, bounds);
        }
    }
}

#[test]
fn val_tied_guide_stays_close_to_the_spring() {
    let outcome = simulate("paper_rig.toml", &["solver.guide=tied"]);
    matches(&outcome, "paper_rig", 1e-2);
    converges(&outcome, "paper_rig", [2e-5, 1e-5, 1e-5, 3e-4]);
}

#[test]
fn val_three_hammers_on_two_castings() {
    // The reference's modes and guides; the study leaves them to its preset.
    let outcome = simulate("three_hammers.toml", &["structure.cutoff_hz=1000", "solver.guide=spring"]);
    matches(&outcome, "three_hammers_two_castings", 2e-2);
    // First impacts converge; periodic values of hammers that share a casting scatter between any two methods.
    converges(&outcome, "three_hammers_two_castings", [2e-6, 5e-3, 5e-3, 1e-4]);
}

/// Truncation of modes counts as error: against all modes of the structure, the modes that a scene needs with residual modes
/// for the others keep the promise that as many modes below a cut-off break.
#[test]
fn val_selected_modes_stand_for_the_whole_structure() {
    let outputs = |settings: &[&str]| {
        let basis = ["structure.fixed_interface_cutoff_hz=20000", "solver.guide=tied"];
        let settings: Vec<String> = basis.iter().chain(settings).map(|setting| (*setting).to_owned()).collect();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
        let RowScene { scene, modes } = Engine::load(&path, &settings).unwrap().scene(0).unwrap();
        let metrics = run_row(&scene, &modes).metrics.unwrap();
        (modes.omega_rad_s.len(), metrics)
    };
    let (all, whole) = outputs(&["structure.mode_tolerance=0"]);
    let (few, selected) = outputs(&["structure.mode_tolerance=1e-2"]);
    let (cut, truncated) = outputs(&["structure.cutoff_hz=1000"]);
    assert!(all > 500 && few == 61 && cut == 60, "{all} {few} {cut}");
    // First-impact energy, periodic energy, frequency, peak velocity; measured 1e-7, 2e-7, 3e-6, 9e-6.
    for (error, bound) in main_differences(&selected, &whole).into_iter().zip([1e-5, 1e-5, 1e-5, 1e-4]) {
        assert!(error < bound, "selected modes: {error:.1e} > {bound:.0e}");
    }
    let [.., peak] = main_differences(&truncated, &whole);
    assert!(peak > 2e-3, "the cut-off loses the local flexibility of the fixture point: {peak:.1e}");
}
