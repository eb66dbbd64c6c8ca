//! What the fidelity presets promise on the paper's rig: errors against the whole structure, truncation of modes included.

use std::path::Path;

use decore::accuracy::main_differences;
use decore::metrics::RunMetrics;
use decore::run::{Machine, SourceModel, run_row};
use decore::study::Study;

/// The whole structure: all modes of a basis that is complete up to 20 kHz, 525 of them.
const WHOLE: [&str; 2] = ["structure.fixed_interface_cutoff_hz=20000", "structure.mode_tolerance=0"];

fn outputs(settings: &[&str]) -> RunMetrics {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let study = Study::load(&path).and_then(|study| study.with_overrides(&settings)).unwrap();
    let model = SourceModel::read(study.structure()).unwrap();
    let points = model.points();
    let machine = Machine::new(model, study.structure(), &study.interface_demand()).unwrap();
    let scene = study.scene(0, &points).unwrap();
    run_row(&scene, &machine.modes(&scene).unwrap()).metrics.unwrap()
}

#[test]
fn val_presets_keep_their_promise_against_the_whole_structure() {
    let [basis, all] = WHOLE;
    let exact = outputs(&[basis, all, "solver.fidelity=reference"]);
    assert!(exact.energy_residual.abs() < 1e-6, "{:e}", exact.energy_residual);
    // Preset, modes, promised for energies and frequency, promised for the peak velocity.
    let promises: [(&str, &[&str], f64, f64); 6] = [
        ("draft", &[basis, "structure.mode_tolerance=1e-2"], 1e-4, 1e-3),
        ("standard", &[basis, "structure.mode_tolerance=1e-2"], 1e-5, 1e-4),
        ("reference", &[basis, "structure.mode_tolerance=1e-4"], 1e-6, 1e-5),
        // The modes below 1000 Hz, whatever the preset.
        ("draft", &[], 1e-4, 4e-3),
        ("standard", &[], 1e-4, 4e-3),
        ("reference", &[], 1e-4, 4e-3),
    ];
    let mut truncated = Vec::new();
    for (preset, modes, promised, promised_peak) in promises {
        let fidelity = format!("solver.fidelity={preset}");
        let settings: Vec<&str> = modes.iter().copied().chain([fidelity.as_str()]).collect();
        let [first, periodic, frequency, peak] = main_differences(&outputs(&settings), &exact);
        let worst = first.max(periodic).max(frequency);
        assert!(worst < promised, "{settings:?}: {first:.1e} {periodic:.1e} {frequency:.1e} > {promised:.0e}");
        assert!(peak < promised_peak, "{settings:?}: {peak:.1e} > {promised_peak:.0e}");
        truncated.extend(modes.is_empty().then_some(peak));
    }
    assert!(truncated.iter().all(|peak| *peak > 1e-3), "truncation is the larger error: {truncated:?}");
}
