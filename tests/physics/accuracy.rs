//! Speed against error on a scene: what the figures must have in common whatever the machine.

use crate::common::scenes::{MOUNT, rig, support};
use decore::accuracy::{Accuracy, Experiment, MAIN_OUTPUTS, fixed_steps, ladder, measure, plot, text};
use decore_model::run::RowStatus;
use decore_model::scene::{Method, ModeTreatment, SolverSettings};
use decore_model::system::PlacedModes;

/// The first impact and some blows of the default hammer.
fn short_rig() -> Accuracy {
    let (mut scene, modes) = rig(1);
    scene.duration_s = 0.2;
    scene.solver.modes = ModeTreatment::Automatic;
    // What the scene itself asks for has no say: neither the reference nor the ladder is at a fixed step.
    scene.solver = SolverSettings { method: Method::Trapezoid, step_s: 1e-3, located: true, ..scene.solver };
    let mut all = modes.clone();
    // One more mode that the fixture feels.
    all.omega_rad_s.push(3000.0);
    all.damping_ratio.push(0.02);
    all.shapes.insert(MOUNT, [&modes.shapes[&MOUNT][..], &[0.03]].concat());
    all.shapes.insert(support(0, 0), [&modes.shapes[&support(0, 0)][..], &[0.08]].concat());
    let mut settings = ladder(&scene);
    settings.extend(fixed_steps(&scene.solver, true));
    let [modes, all] = [modes, all].map(PlacedModes::from);
    let experiment = Experiment { scene: &scene, modes: &modes, all_modes: Some(&all), settings, repeats: 1 };
    let (mut told, mut counts) = (Vec::new(), Vec::new());
    let accuracy = measure(&experiment, &mut |begun| {
        counts.push((begun.number, begun.of));
        told.push(begun.what.to_owned());
    })
    .expect("measured");
    // Every setting is run once: what is told first is kept to.
    let all = counts.len();
    assert!(counts.iter().enumerate().all(|(index, count)| *count == (index + 1, all)), "{counts:?}");
    assert!(told.iter().any(|what| what == "reference") && told.len() > accuracy.measurements.len());
    accuracy
}

#[test]
fn errors_fall_with_the_tolerance_down_to_the_floors() {
    let accuracy = short_rig();
    print!("{}", text(&accuracy));
    let worst = |family: &str| -> Vec<f64> {
        let of_family = accuracy.measurements.iter().filter(|measurement| measurement.setting.family == family);
        of_family.map(|measurement| accuracy.worst(&measurement.errors)).collect()
    };
    for measurement in &accuracy.measurements {
        // All reach their end; what is coarse may miss its audit.
        let fine = measurement.setting.solver.method == Method::Tsit5 && measurement.setting.solver.tolerance < 5e-5;
        let sound = measurement.status == RowStatus::Done;
        assert!(sound || !fine && measurement.status == RowStatus::AuditFailed, "{:?}", measurement.setting);
    }
    for family in ["guide on its spring", "guide on its spring, modes integrated"] {
        let errors = worst(family);
        assert!(errors[2] < 1e-4 && errors[5] < 1e-7, "{family}: {errors:?}");
    }
    // Tying the guide has an error of its own, which no tolerance takes away.
    let tied = worst("guide tied");
    assert!(tied[5] > 1e-8 && tied[5] < 1e-4, "{tied:?}");
    // At a fixed step, contacts that are not located leave an error of first order.
    let [plain, located, trapezoid] = ["rk4", "rk4, contacts located", "implicit trapezoid"].map(worst);
    assert!(plain[0] > 1e-4 && plain[1] < 0.5 * plain[0], "{plain:?}");
    assert!(located[1] < 1e-2 * plain[0], "{located:?}");
    assert!(trapezoid[0] > plain[0], "{trapezoid:?}");
    for measurement in &accuracy.measurements {
        let implicit = measurement.setting.solver.method == Method::Trapezoid;
        assert_eq!(measurement.counters.factorisations > 0, implicit, "{:?}", measurement.setting);
    }
    assert!(accuracy.worst(&accuracy.reference_error) < 1e-6);
    let sensitivity = accuracy.worst(&accuracy.sensitivity);
    assert!(sensitivity > 0.0 && sensitivity < 1e-5, "{sensitivity}");
    let (modes, truncation) = accuracy.truncation.as_ref().expect("all modes were given");
    assert_eq!(*modes, 7);
    assert!(accuracy.worst(truncation) > 100.0 * sensitivity, "{}", accuracy.worst(truncation));
}

#[test]
fn presets_are_marked_once_and_texts_name_what_is_measured() {
    let accuracy = short_rig();
    for preset in ["draft", "standard", "reference"] {
        let marked = accuracy.measurements.iter().filter(|measurement| measurement.setting.preset == Some(preset));
        assert_eq!(marked.count(), 1, "{preset}");
    }
    let words = text(&accuracy);
    assert!(words.contains("modes left out (6 of 7 kept)") && words.contains("sensitivity"), "{words}");
    let rows = words
        .lines()
        .filter(|line| ["guide ", "rk4 ", "rk4, ", "implicit "].iter().any(|family| line.starts_with(family)));
    assert_eq!(rows.count(), accuracy.measurements.len());
    assert!(words.contains("on the same 6 modes") && words.contains(" 5 us "), "{words}");
    assert!(MAIN_OUTPUTS.iter().all(|name| accuracy.outputs.iter().any(|output| output.name == *name)));
    let svg = plot(&accuracy).expect("a plot");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    for words in
        ["guide tied", "implicit trapezoid", "modes left out", "sensitivity of the scene", "ms per simulated second"]
    {
        assert!(svg.contains(words), "{words}");
    }
}

#[test]
fn the_slowest_methods_can_be_left_out() {
    let (scene, _) = rig(1);
    let [all, quick] = [true, false].map(|slow| fixed_steps(&scene.solver, slow));
    assert!(quick.iter().all(|setting| all.contains(setting)));
    let left_out: Vec<String> = all.iter().filter(|setting| !quick.contains(setting)).map(|s| s.grade()).collect();
    assert_eq!(left_out, ["1 us", "10 us"]);
}
