//! Contacts of a chisel with its casting: a count that converges, and warnings where inputs describe no hammer on a casting.

use crate::common::harness::assert_relative;
use crate::common::studies::rig;
use decore_model::metrics::{HammerMetrics, RunMetrics};

const CONTACT: &str = "hammer.hammer.parameters.chisel.casting_contact";
/// Relative difference of the counts that any two presets may have.
const AGREEMENT: f64 = 0.02;

fn with(settings: &[String]) -> RunMetrics {
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    rig(&settings)
}

/// Counts of a case over 0.25 s with the presets, roughest first, where gaps from `separation_s` on separate two contacts.
fn counts(case: &[String], separation_s: f64) -> [u64; 3] {
    ["draft", "standard", "reference"].map(|preset| {
        let own = ["duration_s=0.25".to_owned(), format!("solver.fidelity={preset}")];
        let separation = format!("outputs.contact_separation_s={separation_s:e}");
        let settings: Vec<String> = own.into_iter().chain([separation]).chain(case.iter().cloned()).collect();
        with(&settings).hammers[0].contact_count
    })
}

/// The number of intervals of positive force does not converge at stiff and dead contacts; that of contacts does.
#[test]
fn counts_of_contacts_agree_between_presets() {
    let default_s = decore_model::scene::OutputSettings::default().contact_separation_s;
    let cases =
        [vec![], vec![format!("{CONTACT}.restitution=1e-3")], vec![format!("{CONTACT}.stiffness_n_per_m=1e11")]];
    for (index, case) in cases.iter().enumerate() {
        let (intervals, contacts) = (counts(case, 0.0), counts(case, default_s));
        println!("{case:?}: intervals {intervals:?}, contacts {contacts:?}");
        let [least, most] = [contacts.iter().min(), contacts.iter().max()].map(|count| *count.expect("three") as f64);
        assert!(most - least <= AGREEMENT * least, "{case:?}: {contacts:?}");
        assert!(contacts.iter().all(|count| *count >= 14) && contacts[2] <= intervals[2], "{contacts:?}");
        // What was counted before: ten times as many with `draft` as with `reference`.
        assert!(index < 2 || intervals[0] > 10 * intervals[2], "{intervals:?}");
    }
}

fn warned(settings: &[&str]) -> (String, HammerMetrics) {
    let own = ["duration_s=0.15".to_owned()].into_iter();
    let settings: Vec<String> = own.chain(settings.iter().map(|setting| format!("{CONTACT}.{setting}"))).collect();
    let metrics = with(&settings);
    (metrics.totals.warnings.clone(), metrics.hammers[0].clone())
}

/// The rows are `done`: their equations are solved. Depths: by the signals where chisel and casting turn round,
/// `(force - damping rate) / stiffness`.
#[test]
fn contacts_without_sense_are_warned_of() {
    let (none, rig) = warned(&[]);
    assert_eq!(none, "");
    assert_relative("depth of the rig's", rig.largest_penetration_m, 2.440e-4, 2e-3);
    // The first touch is at 3.2138 m/s; a bounce closes slightly faster.
    let share = rig.largest_jump_force_n / (500.0 * 3.2138);
    assert!((0.9999..1.01).contains(&share), "{share}");
    for (stiffness, depth_m) in [("1e5", 28.326e-3), ("1e6", 10.203e-3)] {
        let (words, soft) = warned(&[&format!("stiffness_n_per_m={stiffness}")]);
        assert_eq!(words, "deep_contact");
        assert_relative(stiffness, soft.largest_penetration_m, depth_m, 1e-3);
    }
    let (words, dead) = warned(&["restitution=1e-3"]);
    assert_eq!(words, "damper_jump");
    let peak_n = dead.first_impact_peak_force_n.expect("struck");
    assert!(peak_n > 1e6, "{peak_n}");
    assert_relative("the peak is the jump", dead.largest_jump_force_n, peak_n, 1e-3);
    let (words, separating) = warned(&["restitution=1e-3", "law=kelvin_voigt_separating"]);
    assert!(words.is_empty() && separating.largest_jump_force_n < 0.1 * peak_n, "{words}");
    for law in ["hertz", "hunt_crossley"] {
        let (words, smooth) = warned(&["restitution=1e-3", &format!("law={law}")]);
        assert_eq!((words.as_str(), smooth.largest_jump_force_n), ("", 0.0), "{law}");
    }
}
