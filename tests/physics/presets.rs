//! What the fidelity presets promise on the paper's rig: errors against the whole structure, truncation of modes included.

use std::path::Path;

use decore::accuracy::main_differences;
use decore::engine::{Engine, RowScene};
use decore::metrics::RunMetrics;
use decore::run::run_row;
use decore::study::Study;

/// The whole structure: all modes of a basis that is complete up to 20 kHz, 525 of them.
const WHOLE: [&str; 2] = ["structure.fixed_interface_cutoff_hz=20000", "structure.mode_tolerance=0"];
/// The line of the study that says itself which modes count.
const CUTOFF: &str = "cutoff_hz = 1000.0\n";

/// The paper's rig, its modes left to the preset.
fn rig() -> Study {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let text = std::fs::read_to_string(directory.join("paper_rig.toml")).unwrap();
    assert!(text.contains(CUTOFF));
    Study::parse(&text.replace(CUTOFF, ""), &directory, "paper_rig.toml").unwrap()
}

fn with(settings: &[&str]) -> Study {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    rig().with_overrides(&settings).unwrap()
}

fn outputs(settings: &[&str]) -> RunMetrics {
    let RowScene { scene, modes } = Engine::new(with(settings)).unwrap().scene(0).unwrap();
    run_row(&scene, &modes).metrics.unwrap()
}

#[test]
fn val_presets_keep_their_promise_against_the_whole_structure() {
    let [basis, all] = WHOLE;
    let exact = outputs(&[basis, all, "solver.fidelity=reference"]);
    assert!(exact.totals.energy_residual.abs() < 1e-6, "{:e}", exact.totals.energy_residual);
    // Preset, cut-off, promised for energies and frequency, promised for the peak velocity.
    let cutoff: &[&str] = &["structure.cutoff_hz=1000"];
    let promises: [(&str, &[&str], f64, f64); 6] = [
        ("draft", &[], 1e-4, 1e-3),
        ("standard", &[], 1e-5, 1e-4),
        ("reference", &[], 1e-6, 1e-5),
        ("draft", cutoff, 1e-4, 4e-3),
        ("standard", cutoff, 1e-4, 4e-3),
        ("reference", cutoff, 1e-4, 4e-3),
    ];
    let mut truncated = Vec::new();
    for (preset, cutoff, promised, promised_peak) in promises {
        let fidelity = format!("solver.fidelity={preset}");
        let settings: Vec<&str> = cutoff.iter().copied().chain([fidelity.as_str()]).collect();
        let [first, periodic, frequency, peak] = main_differences(&outputs(&settings), &exact);
        let worst = first.max(periodic).max(frequency);
        assert!(worst < promised, "{settings:?}: {first:.1e} {periodic:.1e} {frequency:.1e} > {promised:.0e}");
        assert!(peak < promised_peak, "{settings:?}: {peak:.1e} > {promised_peak:.0e}");
        truncated.extend((!cutoff.is_empty()).then_some(peak));
    }
    assert!(truncated.iter().all(|peak| *peak > 1e-3), "truncation is the larger error: {truncated:?}");
}

/// A preset selects modes only where the study does not say itself which count.
#[test]
fn a_study_overrides_its_presets_modes() {
    let settings = |given: &[&str]| {
        let study = with(given);
        (study.structure().mode_tolerance, study.structure().fixed_interface_cutoff_hz)
    };
    assert_eq!(settings(&[]), (Some(1e-2), 20_000.0));
    assert_eq!(settings(&["solver.fidelity=draft"]), (Some(1e-2), 6000.0));
    assert_eq!(settings(&["solver.fidelity=reference"]), (Some(1e-4), 20_000.0));
    assert_eq!(settings(&["structure.cutoff_hz=500"]), (None, 3000.0));
    assert_eq!(settings(&["structure.cutoff_hz=500", "structure.mode_tolerance=0.1"]), (Some(0.1), 20_000.0));
    assert_eq!(settings(&["structure.damping_ratio=[0.02, 0.03]"]), (None, 3000.0));
    assert_eq!(settings(&["structure.fixed_interface_cutoff_hz=4000"]), (Some(1e-2), 4000.0));
}
