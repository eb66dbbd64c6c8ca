//! Bad studies: what the messages say about keys, values and names, and where they point.

use std::path::Path;

use crate::faults::{GOOD, fault, faults, holds};
use crate::station::checked;
use decore_study::Study;

#[test]
fn the_study_itself_is_sound() {
    let study = Study::parse(GOOD, Path::new("."), "s.toml").unwrap_or_else(|error| panic!("{error}"));
    checked(&study).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn a_message_shows_the_line_the_key_and_the_nearest_name() {
    let problem = fault("supply_bar = 5.0", "suply_bar = 5.0");
    assert_eq!(
        problem.to_string(),
        [
            "s.toml:7:1: `hammer.left.suply_bar`: unknown key",
            "   |",
            " 7 | suply_bar = 5.0",
            "   | ^^^^^^^^^",
            "  expected: one of casting, file, gate_delay_s, mount, parameters, rail, rail_position_m, standoff_m, \
             start_time_s, strike_axis, strike_height_m, strike_nodes, strike_point_m, supply_bar, supply_switch_times_s",
            "  did you mean `supply_bar`?",
        ]
        .join("\n")
    );
}

#[test]
fn syntax_errors_have_their_place() {
    let problem = fault("mass_kg = 3.0", "mass_kg = = 3.0");
    holds(&problem, 9, 11, "", "");
    let twice = fault("mass_kg = 3.0", "mass_kg = 3.0\nmass_kg = 3.0");
    holds(&twice, 10, 1, "", "the first definition is in line 9");
}

#[test]
fn likely_slips_are_named() {
    holds(&fault("supply_bar = 5.0", "supply_bar = 5,0"), 7, 15, "", "expected: a point in a number, as in 5.0");
    let kind = |text: &str| fault("kind = \"latin_hypercube\"", &format!("kind = \"{text}\""));
    holds(&kind("lhs"), 14, 8, "design.kind", "did you mean `latin_hypercube`?");
    holds(&kind("ccd"), 14, 8, "design.kind", "did you mean `central_composite`?");
    assert_eq!(kind("xyz").nearest, None);
    let constraint = fault("rows = 4", "rows = 4\nconstraints = [\"presure > 4\"]");
    holds(&constraint, 16, 17, "design.constraints.0", "did you mean `pressure`?");
    let fault_in = |text: &str| fault("rows = 4", &format!("rows = 4\nconstraints = [\"{text}\"]"));
    let hammer = fault_in("pressure < 9 and strike_margin(lft) > 0");
    holds(&hammer, 16, 48, "design.constraints.0", "there is no hammer `lft`; there is: left\n");
    assert_eq!(hammer.nearest.as_deref(), Some("left"));
    holds(&fault_in("strike_margn(left) > 0"), 16, 17, "design.constraints.0", "did you mean `strike_margin`?");
    let path = fault_in("pressure < 9 or casting.part.mas_kg > 0");
    holds(&path, 16, 33, "design.constraints.0", "did you mean `casting.part.mass_kg`?");
    let casting = fault("mount = \"R5\"", "mount = \"R5\"\ncasting = \"block\"");
    holds(&casting, 7, 11, "hammer.left.casting", "the study has no casting `block`; it has: part");
}

#[test]
fn unknown_keys_are_found_everywhere_at_once() {
    let text = GOOD.replace("title", "titel").replace("point", "pint").replace("rows", "row");
    let found = faults(&text);
    let keys: Vec<&str> = found.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["titel", "casting.part.fixture.f1.point", "casting.part.fixture.f1.pint", "design.row"]);
    let nearest: Vec<Option<&str>> = found.iter().map(|problem| problem.nearest.as_deref()).collect();
    assert_eq!(nearest, [Some("title"), None, Some("point"), Some("rows")]);
    let problem = fault("mass_kg = 3.0", "mass_kg = 3.0\n[hammer.left.parameters.pistn]\nmass_kg = 1.0");
    holds(&problem, 10, 25, "hammer.left.parameters.pistn", "did you mean `piston`?");
}

#[test]
fn wrong_types_say_what_was_expected() {
    holds(&fault("mass_kg = 3.0", "mass_kg = \"3\""), 9, 11, "casting.part.mass_kg", "is the text \"3\"\n");
    holds(&fault("mass_kg = 3.0", "mass_kg = \"3\""), 9, 11, "casting.part.mass_kg", "expected: a number");
    holds(&fault("rows = 4", "rows = 4.5"), 15, 8, "design.rows", "expected: a whole number of at least 0");
    holds(&fault("rows = 4", "rows = -4"), 15, 8, "design.rows", "is -4");
    holds(&fault("point = \"T5\"", "point = 5"), 11, 9, "casting.part.fixture.f1.point", "expected: a text in quotes");
    holds(
        &fault("mass_kg = 3.0", "mass_kg = 3.0\nsize_m = [0.1]"),
        10,
        10,
        "casting.part.size_m",
        "a list of 2 entries",
    );
    holds(
        &fault("mass_kg = 3.0", "mass_kg = 3.0\nsize_m = [0.1, \"a\"]"),
        10,
        16,
        "casting.part.size_m.1",
        "expected: a number",
    );
    holds(&fault("latin_hypercube", "latin_hypercub"), 14, 8, "design.kind", "did you mean `latin_hypercube`?");
    holds(
        &fault("cutoff_hz = 300.0", "damping_ratio = \"x\""),
        4,
        17,
        "structure.damping_ratio",
        "a number, or a list",
    );
    holds(&fault("[structure]\ncutoff_hz = 300.0", "structure = 3"), 3, 13, "structure", "expected: a table");
    holds(&fault("title = \"test\"", "title = 2026-01-01"), 1, 9, "title", "is a date");
}

#[test]
fn numbers_must_be_finite() {
    for text in ["nan", "inf", "-inf", "+nan"] {
        holds(&fault("mass_kg = 3.0", &format!("mass_kg = {text}")), 9, 11, "casting.part.mass_kg", "no finite number");
    }
    holds(&fault("[4.0, 6.0]", "[4.0, inf]"), 18, 15, "design.factor.pressure.range.1", "no finite number");
    holds(
        &fault("cutoff_hz = 300.0", "damping_ratio = [0.1, nan]"),
        4,
        17,
        "structure.damping_ratio",
        "no finite number",
    );
}

#[test]
fn quantities_must_lie_in_their_range() {
    holds(
        &fault("mass_kg = 3.0", "mass_kg = -3.0"),
        9,
        11,
        "casting.part.mass_kg",
        "is -3, expected a positive number",
    );
    holds(&fault("3e7", "0"), 12, 21, "casting.part.fixture.f1.stiffness_n_per_m", "is 0, expected a positive number");
    holds(
        &fault("3e7", "3e7\ndamping_n_s_per_m = -1"),
        13,
        21,
        "casting.part.fixture.f1.damping_n_s_per_m",
        "zero or a positive",
    );
    holds(&fault("duration_s = 1.0", "duration_s = 0"), 2, 14, "duration_s", "is 0");
    holds(
        &fault("cutoff_hz = 300.0", "cutoff_hz = -1.0"),
        4,
        13,
        "structure.cutoff_hz",
        "is -1, expected a positive number",
    );
    holds(&fault("cutoff_hz = 300.0", "damping_ratio = 1.5"), 4, 17, "structure.damping_ratio", "from 0 to below 1");
    holds(&fault("cutoff_hz = 300.0", "mode_tolerance = 1.0"), 4, 18, "structure.mode_tolerance", "from 0 to below 1");
    let deep = fault("[casting.part]", "parameters.piston.bore_m = 0.0\n[casting.part]");
    holds(&deep, 8, 28, "hammer.left.parameters.piston.bore_m", "is 0, expected a positive number");
    let contact = fault("[casting.part]", "parameters.valve.stop.stiffness_n_per_m = -1\n[casting.part]");
    holds(&contact, 8, 43, "hammer.left.parameters.valve.stop.stiffness_n_per_m", "is -1");
    let tolerance = fault("[design]", "[solver]\ntolerance = 0.0\n[design]");
    holds(&tolerance, 14, 13, "solver.tolerance", "is 0, expected a number above 0 and not above 0.1");
}

#[test]
fn several_bad_quantities_are_reported_together() {
    let text = GOOD.replace("mass_kg = 3.0", "mass_kg = -3.0").replace("3e7", "0.0");
    assert_eq!(faults(&text).len(), 2);
}

#[test]
fn names_must_exist() {
    let mount = fault("\"R5\"", "\"R55\"");
    holds(&mount, 6, 9, "hammer.left.mount", "the machine has no interface point `R55`");
    assert_eq!(mount.nearest.as_deref(), Some("R5"));
    let fixture = fault("\"T5\"", "\"t5\"");
    holds(&fixture, 11, 9, "casting.part.fixture.f1.point", "did you mean `T5`?");
    let rail = fault("mount = \"R5\"", "rail = \"rial\"\nrail_position_m = 0.0");
    holds(&rail, 6, 8, "hammer.left.rail", "did you mean `rail`?");
    let casting = fault("mount = \"R5\"", "mount = \"R5\"\ncasting = \"prt\"");
    holds(&casting, 7, 11, "hammer.left.casting", "did you mean `part`?");
    let point = fault("cutoff_hz = 300.0", "rails.bar = [\"R1\", \"Q5\", \"R9\"]");
    holds(&point, 4, 20, "structure.rails.bar.1", "no interface point `Q5`");
    holds(&fault("cutoff_hz = 300.0", "rails.bar = [\"R1\"]"), 4, 13, "structure.rails.bar", "at least two");
}

/// The fault of a value that a setting gave is the setting's, not that of the line that it replaces.
#[test]
fn faults_of_settings_name_the_setting() {
    let study = |text: &str| Study::parse(text, Path::new("."), "s.toml").unwrap_or_else(|error| panic!("{error}"));
    let good = study(&GOOD.replace("rows = 4", "rows = 4\nconstraints = [\"pressure > 4\"]"));
    for (setting, key) in [
        ("design.rows=0", "design.rows"),
        ("design.trajectories=4", "design.trajectories"),
        ("design.factor.pressure.range=[6.0, 4.0]", "design.factor.pressure.range"),
        ("design.factor.pressure.range.0=9.0", "design.factor.pressure.range"),
        ("design.factor.pressure.path=hammer.left.suply_bar", "design.factor.pressure.path"),
        ("design.constraints=[\"presure > 4\"]", "design.constraints.0"),
        ("design.constraints.0=presure > 4", "design.constraints.0"),
        ("structure.cutoff_hz=-1", "structure.cutoff_hz"),
        ("structure.stiffness_file=K.mtx", "structure.stiffness_file"),
        ("outputs.points=[\"Q5\"]", "outputs.points.0"),
    ] {
        let set = good.with_overrides(&[setting.to_owned()]);
        let found = set.map_or_else(|error| error, |set| checked(&set).expect_err("a fault"));
        let problem = &found.problems()[0];
        assert_eq!((problem.place.file.as_str(), problem.place.line), (format!("--set {setting}").as_str(), None));
        assert_eq!(problem.key, key, "{problem}");
    }
    // Another key than that which is set stands where it is written.
    let holds_elsewhere = good.with_overrides(&["design.kind=morris".to_owned()]).map(|_| ());
    assert!(holds_elsewhere.is_err_and(|error| error.problems()[0].place.file == "s.toml"));
}

#[test]
fn a_hammer_needs_one_place() {
    holds(&fault("mount = \"R5\"", ""), 5, 9, "hammer.left.mount", "the hammer has no place");
    let both = fault("mount = \"R5\"", "mount = \"R5\"\nrail_position_m = 0.0");
    holds(&both, 6, 9, "hammer.left.mount", "two places");
    let off = fault("mount = \"R5\"", "rail_position_m = 0.41");
    holds(
        &off,
        6,
        19,
        "hammer.left.rail_position_m",
        "is 0.41 m, which lies off rail `rail`: its positions run from -0.4 m to 0.4 m",
    );
}

#[test]
fn two_castings_need_a_choice() {
    let second = "[casting.other]\nmass_kg = 1.0\n[casting.other.fixture.f]\npoint = \"T6\"\n[design]";
    let problem = fault("[design]", second);
    holds(&problem, 5, 9, "hammer.left.casting", "The study has: part, other");
}

#[test]
fn hammers_and_castings_are_needed() {
    let bare = faults("title = \"x\"");
    let keys: Vec<&str> = bare.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["hammer", "casting"]);
    assert!(bare[0].to_string().starts_with("s.toml: `hammer`: missing key"), "{}", bare[0]);
    let empty = faults("[hammer]\n[casting]\n");
    assert!(empty[0].message.contains("at least one hammer") && empty[1].message.contains("at least one casting"));
    let unfixed = faults("[hammer.a]\nmount = \"R5\"\n[casting.b]\nmass_kg = 1.0\n[casting.b.fixture]\n");
    holds(&unfixed[0], 5, 12, "casting.b.fixture", "at least one fixture");
    holds(&fault("mass_kg = 3.0", ""), 8, 10, "casting.part.mass_kg", "missing key");
    holds(&fault("hammer.left]", "hammer.\"le ft\"]"), 5, 9, "hammer.le ft", "cannot be a name");
}

#[test]
fn castings_must_be_held() {
    let inertia = fault("mount = \"R5\"", "mount = \"R6\"");
    holds(&inertia, 8, 10, "casting.part.inertia_kg_m2", "its inertia is needed");
    let text = GOOD
        .replace("mount = \"R5\"", "mount = \"R6\"")
        .replace("mass_kg = 3.0", "mass_kg = 3.0\ninertia_kg_m2 = [0.01, 0.02]");
    let found = faults(&text);
    assert_eq!(found.len(), 1);
    holds(&found[0], 11, 15, "casting.part.fixture", "is free to move");
}

#[test]
fn no_text_makes_the_reader_panic() {
    // Every prefix of a study, and the study with each of its bytes replaced.
    for end in 0..GOOD.len() {
        let _ = Study::parse(&GOOD[..end], Path::new("."), "s.toml").map(|study| checked(&study));
    }
    for index in 0..GOOD.len() {
        for byte in ["\u{0}", "\"", "]", "=", ".", "é", "9"] {
            let text = format!("{}{byte}{}", &GOOD[..index], &GOOD[index + 1..]);
            let result = Study::parse(&text, Path::new("."), "s.toml").map(|study| checked(&study));
            if let Err(error) = result {
                assert!(!error.to_string().is_empty());
            }
        }
    }
}
