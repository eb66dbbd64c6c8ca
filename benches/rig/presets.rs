//! The fidelity presets against what they promise: an independent program's converged figures, and the whole structure.

use std::fmt::Write as _;
use std::path::Path;

use decore_model::run::{RowOutcome, run_row};
use decore_study::Study;
use serde_json::Value;

use crate::methods::cells;
use crate::scene::{FIGURES, Rig, errors, figures, of_study};
use crate::study_path;
use crate::timing::interleaved;

/// Presets and what they promise for energies and frequency, and for the casting's peak velocity.
const PRESETS: [(&str, f64, f64); 3] = [("draft", 1e-4, 1e-3), ("standard", 1e-5, 1e-4), ("reference", 1e-6, 1e-5)];
/// The converged program's scenes of one hammer, as settings of the shipped study.
const SCENES: [(&str, &[&str]); 3] = [
    ("paper_rig", &[]),
    ("paper_rig_4bar", &["hammer.hammer.supply_bar=4.0"]),
    (
        "paper_rig_r3_60mm",
        &[
            "hammer.hammer.mount=R3",
            "hammer.hammer.strike_point_m=[0.0, 0.0]",
            "hammer.hammer.standoff_m=0.060",
            "geometry=as_given",
        ],
    ),
];
/// Its names of the figures.
const NAMES: [&str; 4] = ["first_energy", "periodic_energy_mean", "freq", "casting_of_hammer_peak_velocity"];
/// All fixed-interface modes that matter: those of the machine below 1000 Hz are the full model's.
const BASIS: &str = "structure.fixed_interface_cutoff_hz=20000";
/// The line of the study that says itself which modes count.
const CUTOFF: &str = "cutoff_hz = 1000.0\n";

/// The section on presets.
pub fn text(text: &mut String, repeats: usize) {
    let _ = writeln!(
        text,
        "\n## Presets against their promises\n\nAgainst the converged figures of an independent program (`tests/data/reference.json`, good to about \
         1e-6, peak velocity 1e-5),\non its modes, those of the full model below 1000 Hz.\n\n| scene | preset | promised | {} | |\n|---|---|---|---|---|---|---|---|",
        FIGURES.join(" | ")
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference.json");
    let reference: Value = serde_json::from_slice(&std::fs::read(path).expect("the shipped reference")).expect("JSON");
    for (scene, settings) in SCENES {
        let expected = &reference["converged"]["scenes"][scene][0];
        let exact = NAMES.map(|name| expected[name].as_f64().unwrap_or(f64::NAN));
        for promise in PRESETS {
            let fidelity = format!("solver.fidelity={}", promise.0);
            let settings: Vec<&str> = settings.iter().copied().chain([BASIS, &fidelity]).collect();
            let found = run(&of_study(&rig(true), &settings));
            let row = row(promise, &found, &exact);
            let _ = writeln!(text, "| {scene} | {row}");
        }
    }
    whole(text, repeats);
}

/// The table of presets with the modes that they select, against all modes.
fn whole(text: &mut String, repeats: usize) {
    let study = rig(false);
    let all = of_study(&study, &[BASIS, "structure.mode_tolerance=0", "solver.fidelity=reference"]);
    let _ = writeln!(
        text,
        "\nAgainst the whole structure of the paper's rig ({} modes, guide on its spring, 1e-7), each with the modes that it selects (the study \
         without\nits `cutoff_hz`).\n\n| modes, ms per s | preset | promised | {} | |\n|---|---|---|---|---|---|---|---|",
        all.modes.omega_rad_s.len(),
        FIGURES.join(" | ")
    );
    let exact = figures(run(&all).metrics.as_ref().expect("the run with all modes"));
    let rigs = PRESETS.map(|(preset, ..)| of_study(&study, &[&format!("solver.fidelity={preset}")]));
    for ((promise, rig), timed) in PRESETS.iter().zip(&rigs).zip(interleaved(repeats, &rigs, run)) {
        let ms = 1e3 * timed.cpu_s / rig.scene.duration_s;
        let row = row(*promise, &timed.value, &exact);
        let _ = writeln!(text, "| {}, {ms:.0} | {row}", rig.modes.omega_rad_s.len());
    }
}

/// The paper's rig, with its cut-off or with the modes left to the preset.
fn rig(cutoff: bool) -> Study {
    let path = study_path();
    let text = std::fs::read_to_string(&path).expect("the shipped study");
    let text = if cutoff { text } else { text.replace(CUTOFF, "") };
    let directory = path.parent().unwrap_or(Path::new(""));
    Study::parse(&text, directory, "paper_rig.toml").expect("the shipped study")
}

fn run(rig: &Rig) -> RowOutcome {
    run_row(&rig.scene, &rig.modes)
}

/// The cells of a preset: name, promise, errors, verdict.
fn row((preset, promised, promised_peak): (&str, f64, f64), found: &RowOutcome, exact: &[f64; 4]) -> String {
    let found = found.metrics.as_ref().map_or([f64::NAN; 4], figures);
    let errors = errors(&found, exact);
    let bounds = [promised, promised, promised, promised_peak];
    let beyond = |i: &usize| errors[*i].is_nan() || errors[*i] > bounds[*i];
    let names: Vec<&str> = (0..4).filter(beyond).map(|i| FIGURES[i]).collect();
    let verdict = if names.is_empty() { "kept".to_owned() } else { format!("**beyond**: {}", names.join(", ")) };
    format!("{preset} | {promised:.0e}, {promised_peak:.0e} | {} | {verdict} |", cells(&errors))
}
