//! Numerical errors that rows state: a row against the same scene with better numerics.

use std::path::Path;

use decore_model::metrics::{HammerMetrics, RunMetrics};
use decore_study::engine::{Engine, RowRunner};

use crate::common::sample::{families, is_calm, judged};

/// Contacts without any loss: the chisel bounces between piston and nose until the first impact, and every error of a bounce stays.
const UNDAMPED: [&str; 4] = [
    "hammer.hammer.parameters.chisel.casting_contact.restitution=1",
    "hammer.hammer.parameters.piston.chisel_contact.restitution=1",
    "hammer.hammer.parameters.chisel.cylinder_contact.restitution=1",
    "duration_s=0.1",
];
/// Converged, on all modes of the structure.
const CONVERGED: [&str; 5] = [
    "solver.fidelity=reference",
    "solver.tolerance=1e-9",
    "structure.fixed_interface_cutoff_hz=20000",
    "structure.mode_tolerance=0",
    "outputs.numerical_twin=none",
];

fn rig(settings: &[&str]) -> RunMetrics {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    Engine::load(&path, &settings).unwrap().outcome(0).metrics.unwrap()
}

/// First impacts of 69.15 J (`draft`), 69.26 J (`standard`) and 69.02 J (`reference`, which keeps the study's 60 modes) where 69.19 J is right,
/// all with energy residuals of 1e-6: the residual is blind to it, the numerical twin is not.
#[test]
fn a_numerical_twin_exposes_what_the_energy_residual_does_not() {
    let energy = |run: &RunMetrics| run.hammers[0].first_impact_energy_j.unwrap();
    let exact = energy(&rig(&[&UNDAMPED[..], &CONVERGED[..]].concat()));
    assert!((exact - 69.194).abs() < 2e-3, "{exact}");
    for preset in ["draft", "standard", "reference"] {
        let fidelity = format!("solver.fidelity={preset}");
        let row = rig(&[&UNDAMPED[..], &[fidelity.as_str(), "outputs.numerical_twin=all"]].concat());
        let numerical = row.numerical.as_ref().unwrap();
        let stated = numerical.hammers[0][HammerMetrics::first_impact_energy_j.name].unwrap();
        let error = (energy(&row) - exact).abs();
        assert!(row.totals.energy_residual.abs() < 1e-5, "{preset}: {:e}", row.totals.energy_residual);
        assert!(error > 0.03 && error < 2.0 * stated, "{preset}: error {error:.3} J, stated {stated:.3} J");
        assert!(numerical.numerical_errors_beyond_promise.unwrap() > 0, "{preset}");
        assert!(numerical.worst_numerical_error_over_promise.unwrap() > 3.0, "{preset}");
    }
}

/// A few of the random scenes of the bench `promises`: 99 % of the promises hold, and the stated errors cover the true
/// ones.
#[test]
fn promises_hold_and_stated_errors_cover_the_true_ones() {
    let (mut pairs, mut uncovered, mut beyond) = (0, 0, 0);
    for family in families(3) {
        let (exact, reference) = (family.exact(), family.stated("reference"));
        let calm: Vec<bool> = reference.iter().map(|row| is_calm(row.as_ref().unwrap())).collect();
        for preset in decore_model::scene::Fidelity::ALL {
            for (row, (own, exact)) in family.stated(preset.name()).iter().zip(&exact).enumerate() {
                let found = judged(own.as_ref().unwrap(), exact.as_ref().unwrap(), calm[row]);
                assert!(found.len() >= 8, "{} row {row}: {} outputs", preset.name(), found.len());
                for one in found {
                    let promised = one.promise.under(preset);
                    if one.error > promised {
                        println!("{} row {row}: {one:?} > {promised:.0e}", preset.name());
                        beyond += 1;
                    }
                    pairs += 1;
                    uncovered += usize::from(!one.is_covered());
                }
            }
        }
    }
    assert!(
        pairs > 300 && 20 * uncovered <= pairs,
        "{uncovered} of {pairs} true errors are beyond what the row states"
    );
    assert!(100 * beyond <= pairs, "{beyond} of {pairs} true errors are beyond the promise");
}

/// With 60 modes 69.0206 J is right. At a preset's own tolerance `reference` gives 68.908 J: where the chisel goes on bouncing presets take
/// a hundredth of it. A study that names a tolerance has it.
#[test]
fn presets_are_tighter_where_the_chisel_goes_on_bouncing() {
    let energy = |settings: &[&str]| rig(&[&UNDAMPED[..], settings].concat()).hammers[0].first_impact_energy_j.unwrap();
    let error = |settings: &[&str]| (energy(settings) - 69.0206).abs();
    assert!(error(&["solver.fidelity=reference"]) < 5e-3);
    assert!(error(&["solver.fidelity=reference", "solver.tolerance=1e-7"]) > 0.1);
    let law = "hammer.hammer.parameters.piston.chisel_contact.law=hunt_crossley";
    let first =
        |more: &[&str]| rig(&[&["duration_s=0.1", law][..], more].concat()).hammers[0].first_impact_energy_j.unwrap();
    let exact = first(&["solver.fidelity=reference"]);
    assert!((first(&[]) / exact - 1.0).abs() < 1e-5, "promised for `standard`");
    assert!((first(&["solver.tolerance=1e-5"]) / exact - 1.0).abs() > 1e-5, "it was not kept before");
}

/// The true errors of an integration that is much too coarse are stated too: nothing here is true of good numerics alone.
#[test]
fn a_coarse_row_states_its_errors() {
    let settings = ["duration_s=0.1", "solver.tolerance=0.001", "outputs.numerical_twin=all"];
    let (coarse, fine) = (rig(&settings), rig(&["duration_s=0.1", "outputs.numerical_twin=all"]));
    let name = HammerMetrics::first_impact_energy_j.name;
    let stated = |run: &RunMetrics| run.numerical.as_ref().unwrap().hammers[0][name].unwrap();
    assert!(stated(&coarse) > 3.0 * stated(&fine), "{} {}", stated(&coarse), stated(&fine));
    assert!(coarse.numerical.unwrap().numerical_errors_beyond_promise.unwrap() > 0);
}
