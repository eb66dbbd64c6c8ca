//! What is possible but unlikely: values in another unit, a fixture on a mount.

use std::path::Path;

use crate::faults::{GOOD, fault, holds};
use crate::station::rows;
use decore_study::{Problem, Study};

/// Warnings of the sound study with one part replaced.
fn warnings(from: &str, to: &str) -> Vec<Problem> {
    assert!(GOOD.contains(from), "{from}");
    let text = GOOD.replacen(from, to, 1);
    let study = Study::parse(&text, Path::new("."), "s.toml").unwrap_or_else(|error| panic!("{error}"));
    rows(&study).warnings().to_vec()
}

#[track_caller]
fn warns(from: &str, to: &str, (line, column, key): (usize, usize, &str), words: &str) {
    let mut found = warnings(from, to);
    // A value that is a thousand times too large also makes contacts senseless: other tests hold that.
    found.retain(|problem| problem.key == key);
    assert_eq!(found.len(), 1, "{found:#?}");
    holds(&found[0], line, column, key, words);
}

#[test]
fn values_in_another_unit_are_told_with_their_likely_unit() {
    assert_eq!(warnings("title", "title"), []);
    warns(
        "range = [4.0, 6.0]",
        "range = [400000, 600000]",
        (18, 9, "hammer.left.supply_bar"),
        "400000 bar is unusual, expected 0.5 to 16 bar: is it in Pa (4 bar)?",
    );
    let hammer = |line: &str| format!("mount = \"R5\"\n{line}");
    let standoff = "60 m is unusual, expected 0 to 0.5 m: is it in mm (0.06 m)?";
    warns("mount = \"R5\"", &hammer("standoff_m = 60"), (7, 14, "hammer.left.standoff_m"), standoff);
    warns(
        "mass_kg = 3.0",
        "mass_kg = 3000",
        (9, 11, "casting.part.mass_kg"),
        "3000 kg is unusual, expected 0.05 to 1000 kg: is it in g (3 kg)?",
    );
    warns("mass_kg = 3.0", "mass_kg = 3e6", (9, 11, "casting.part.mass_kg"), "3000000 kg is unusual");
    let duration = "duration_s = 1.0";
    warns(duration, "duration_s = 1500", (2, 14, "duration_s"), "is it in ms (1.5 s)?");
    warns(duration, "duration_s = 1e308", (2, 14, "duration_s"), "1e308 s is unusual, expected 0.001 to 100 s\n");
    let gas = |text: &str| format!("[environment]\ntemperature_k = {text}\n[design]");
    let kelvin = (14, 17, "environment.temperature_k");
    warns("[design]", &gas("20"), kelvin, "is it in degrees Celsius (293.1 K)?");
    warns("[design]", &gas("1e-30"), kelvin, "1e-30 K is unusual, expected 200 to 450 K");
    let valve = "supply_bar = 5.0\nparameters.valve.mass_kg = 74.0";
    warns("supply_bar = 5.0", valve, (8, 28, "hammer.left.parameters.valve.mass_kg"), "is it in g (0.074 kg)?");
}

/// A contact that is too soft or too damped is told before a row is run; the rig's own, and another law, are not.
#[test]
fn contacts_without_sense_are_told() {
    let contact = |text: &str| format!("supply_bar = 5.0\nparameters.chisel.casting_contact.{text}");
    let key = |name: &str| format!("hammer.left.parameters.chisel.casting_contact.{name}");
    let soft = key("stiffness_n_per_m");
    warns(
        "supply_bar = 5.0",
        &contact("stiffness_n_per_m = 1e5"),
        (8, 55, &soft),
        "the contact is too soft: by its energy alone the chisel goes",
    );
    let dead = key("restitution");
    let jump = "the contact begins with a jump of the damper's force";
    warns("supply_bar = 5.0", &contact("restitution = 1e-3"), (8, 49, &dead), jump);
    let damped = key("damping_n_s_per_m");
    warns("supply_bar = 5.0", &contact("damping_n_s_per_m = 1e5"), (8, 55, &damped), jump);
    for sound in ["restitution = 0.5", "stiffness_n_per_m = 1e7", "law = \"kelvin_voigt_separating\""] {
        assert_eq!(warnings("supply_bar = 5.0", &contact(sound)), [], "{sound}");
    }
    let law = "restitution = 1e-3\nparameters.chisel.casting_contact.law = \"hunt_crossley\"";
    assert_eq!(warnings("supply_bar = 5.0", &contact(law)), []);
}

/// A method may be set over a study, or differ between rows.
#[test]
fn keys_that_no_method_makes_use_of_are_told() {
    let solver = |text: &str| format!("[solver]\n{text}\n[design]");
    let of = |text: &str, key: &str, words: &str| {
        warns("[design]", &solver(text), (14, key.len() + 4, &format!("solver.{key}")), words);
    };
    of("step_s = 1e-5", "step_s", "has no effect with `tsit5`: it needs a method with a fixed step");
    of("located = true\nmethod = \"tsit5\"", "located", "here `solver.tolerance` counts");
    of("tolerance = 1e-6\nmethod = \"rk4\"", "tolerance", "has no effect with `rk4`: it needs a method under error");
    // Rows of either kind have use of both.
    let factor = "[design.factor.method]\npath = \"solver.method\"\nvalues = [\"tsit5\", \"rk4\"]\n";
    for quiet in [
        "tolerance = 1e-6",
        "step_s = 1e-5\nlocated = true\nmethod = \"trapezoid\"",
        "fidelity = \"reference\"\nmethod = \"rk4\"",
        &format!("step_s = 1e-5\ntolerance = 1e-5\n{factor}"),
    ] {
        assert_eq!(warnings("[design]", &solver(quiet)), [], "{quiet}");
    }
    let study = Study::parse(GOOD, Path::new("."), "s.toml").unwrap_or_else(|error| panic!("{error}"));
    let study = study.with_overrides(&["solver.step_s=1e-5".to_owned()]).unwrap_or_else(|error| panic!("{error}"));
    let found = rows(&study).warnings().to_vec();
    assert!(found.len() == 1, "{found:?}");
    assert!(found[0].to_string().starts_with("--set solver.step_s=1e-5: `solver.step_s`: "), "{found:?}");
}

#[test]
fn a_fixture_on_a_mount_is_told() {
    let text = "point = \"R5\"\nat_m = [0.0, 0.0]";
    let words = "`R5` carries hammer `left`";
    warns("point = \"T5\"", text, (11, 9, "casting.part.fixture.f1.point"), words);
}

/// Not that the casting spins: beside 1e25 N/m the stiffness of the others is lost in rounding.
#[test]
fn a_fixture_that_is_too_stiff_is_named_with_its_frequency() {
    let more = "stiffness_n_per_m = 1e25\n[casting.part.fixture.f2]\npoint = \"T1\"\n[casting.part.fixture.f3]\npoint = \"T3\"";
    let text = GOOD.replacen("mass_kg = 3.0", "mass_kg = 3.0\ninertia_kg_m2 = [0.1, 0.1]\ncentre_m = [0.36, 0.0]", 1);
    let found = crate::faults::faults(&text.replacen("stiffness_n_per_m = 3e7", more, 1));
    assert_eq!(found.len(), 1, "{found:#?}");
    holds(&found[0], 14, 21, "casting.part.fixture.f1.stiffness_n_per_m", "is 1e25, which is too stiff");
    assert!(found[0].message.contains("would swing on fixture `f1` at 2.9e11 Hz"), "{}", found[0]);
    let alone = fault("stiffness_n_per_m = 3e7", "stiffness_n_per_m = 1e25");
    assert!(alone.message.contains("too stiff"), "{alone}");
    let light = fault("mass_kg = 3.0", "mass_kg = 1e-300");
    assert!(light.message.contains("casting `part` (1e-300 kg) would swing"), "{light}");
}

/// The declared defaults are usual.
#[test]
fn the_template_has_no_warnings() {
    let text = decore_study::template().expect("a template");
    let study = Study::parse(&text, Path::new("."), "s.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(rows(&study).warnings(), []);
}
