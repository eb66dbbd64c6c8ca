//! Bad studies: what the messages say, and where they point.

mod support;

use std::path::Path;

use decore::study::{Problem, Study, StudyError};
use support::station_points;

/// A sound study; tests replace parts of it.
const GOOD: &str = r#"title = "test"
duration_s = 1.0
[structure]
cutoff_hz = 300.0
[hammer.left]
mount = "R5"
supply_bar = 5.0
[casting.part]
mass_kg = 3.0
[casting.part.fixture.f1]
point = "T5"
stiffness_n_per_m = 3e7
[design]
kind = "latin_hypercube"
rows = 4
[design.factor.pressure]
path = "hammer.left.supply_bar"
range = [4.0, 6.0]
"#;

/// Faults of a text, from loading or checking.
fn faults(text: &str) -> Vec<Problem> {
    let error = match Study::parse(text, Path::new(env!("CARGO_MANIFEST_DIR")), "s.toml") {
        Ok(study) => study.check(&station_points()).expect_err("the study has no fault"),
        Err(error) => error,
    };
    assert!(matches!(error, StudyError::Invalid { .. }));
    assert!(!error.problems().is_empty());
    error.problems().to_vec()
}

/// The only fault of the sound study with `from` replaced by `to`.
fn fault(from: &str, to: &str) -> Problem {
    assert!(GOOD.contains(from), "{from}");
    let found = faults(&GOOD.replacen(from, to, 1));
    assert_eq!(found.len(), 1, "{found:#?}");
    found.into_iter().next().unwrap()
}

#[track_caller]
fn holds(problem: &Problem, line: usize, column: usize, key: &str, words: &str) {
    assert_eq!((problem.place.line, problem.place.column), (Some(line), Some(column)), "{problem}");
    assert_eq!(problem.key, key, "{problem}");
    let text = problem.to_string();
    assert!(text.contains(words), "{text}");
    assert!(text.starts_with(&format!("s.toml:{line}:{column}: ")), "{text}");
}

#[test]
fn the_study_itself_is_sound() {
    let study = Study::parse(GOOD, Path::new("."), "s.toml").unwrap_or_else(|error| panic!("{error}"));
    study.check(&station_points()).unwrap_or_else(|error| panic!("{error}"));
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
             start_time_s, strike_point_m, supply_bar",
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
    holds(&twice, 10, 1, "", "duplicate");
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
    holds(&fault("mass_kg = 3.0", "mass_kg = \"3\""), 9, 11, "casting.part.mass_kg", "is a text\n");
    holds(&fault("mass_kg = 3.0", "mass_kg = \"3\""), 9, 11, "casting.part.mass_kg", "expected: a number");
    holds(&fault("rows = 4", "rows = 4.5"), 15, 8, "design.rows", "expected: a whole number not below 0");
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
    holds(&fault("cutoff_hz = 300.0", "damping_ratio = 1.5"), 4, 17, "structure.damping_ratio", "below 1");
    let deep = fault("[casting.part]", "parameters.piston.bore_m = 0.0\n[casting.part]");
    holds(&deep, 8, 28, "hammer.left.parameters.piston.bore_m", "is 0, expected a positive number");
    let contact = fault("[casting.part]", "parameters.valve.stop.stiffness_n_per_m = -1\n[casting.part]");
    holds(&contact, 8, 43, "hammer.left.parameters.valve.stop.stiffness_n_per_m", "is -1");
    let tolerance = fault("[design]", "[solver]\ntolerance = 0.0\n[design]");
    holds(&tolerance, 14, 13, "solver.tolerance", "must lie above 0");
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
    holds(&found[0], 11, 15, "casting.part.fixture", "could spin freely");
}

#[test]
fn factors_must_drive_something() {
    let unknown = fault("hammer.left.supply_bar", "hammer.left.suply_bar");
    holds(&unknown, 17, 8, "design.factor.pressure.path", "did you mean `hammer.left.supply_bar`?");
    let other = fault("hammer.left.supply_bar", "hammer.lft.supply_bar");
    holds(&other, 17, 8, "design.factor.pressure.path", "did you mean `hammer.left.supply_bar`?");
    let short = fault("hammer.left.supply_bar", "supply_bar");
    holds(&short, 17, 8, "design.factor.pressure.path", "did you mean `hammer.left.supply_bar`?");
    holds(&fault("hammer.left.supply_bar", "hammer.left"), 17, 8, "design.factor.pressure.path", "no single value");
    holds(
        &fault("hammer.left.supply_bar", "structure.cutoff_hz"),
        17,
        8,
        "design.factor.pressure.path",
        "shared by all rows",
    );
    holds(
        &fault("hammer.left.supply_bar", "hammer.left.mount"),
        18,
        9,
        "design.factor.pressure.range",
        "expected: a text in quotes",
    );
    let list = fault("hammer.left.supply_bar", "casting.part.centre_m.0");
    holds(&list, 17, 8, "design.factor.pressure.path", "write the list there first");
    let twice = fault(
        "range = [4.0, 6.0]",
        "range = [4.0, 6.0]\n[design.factor.again]\npath = \"hammer.left.supply_bar\"\nvalues = [1.0]",
    );
    holds(&twice, 20, 8, "design.factor.again.path", "driven twice");
    holds(&fault("path = \"hammer.left.supply_bar\"", ""), 16, 16, "design.factor.pressure", "what it drives");
    holds(&fault("path = \"hammer", "path = \"hammer..left"), 17, 8, "design.factor.pressure.path", "empty part");
}

#[test]
fn ranges_and_values_must_be_sound() {
    holds(&fault("[4.0, 6.0]", "[6.0, 4.0]"), 18, 9, "design.factor.pressure.range", "is empty");
    holds(&fault("[4.0, 6.0]", "[4.0, 4.0]"), 18, 9, "design.factor.pressure.range", "is empty");
    holds(&fault("[4.0, 6.0]", "[-1.0, 4.0]"), 18, 9, "hammer.left.supply_bar", "zero or a positive number");
    holds(
        &fault("range = [4.0, 6.0]", "range = [0.0, 6.0]\nscale = \"log\""),
        18,
        9,
        "design.factor.pressure.range",
        "positive ends",
    );
    holds(
        &fault("range = [4.0, 6.0]", "range = [4.5, 6.0]\ninteger = true"),
        18,
        9,
        "design.factor.pressure.range",
        "whole numbers",
    );
    holds(&fault("range = [4.0, 6.0]", "values = []"), 18, 10, "design.factor.pressure.values", "no values");
    holds(
        &fault("range = [4.0, 6.0]", "values = [\"a\"]"),
        18,
        11,
        "design.factor.pressure.values.0",
        "expected: a number",
    );
    let mixed = faults(&GOOD.replace("range = [4.0, 6.0]", "values = [4, \"a\"]"));
    holds(&mixed[0], 18, 10, "design.factor.pressure.values", "mixes texts and numbers");
    holds(&fault("range = [4.0, 6.0]", "values = [4, 4.0]"), 18, 14, "design.factor.pressure.values.1", "given twice");
    holds(&fault("range = [4.0, 6.0]", ""), 16, 16, "design.factor.pressure", "what it varies over");
    holds(
        &fault("range = [4.0, 6.0]", "values = [1.0]\nlevels = 2"),
        19,
        10,
        "design.factor.pressure.levels",
        "belongs to a `range`",
    );
    holds(&fault("\nrows = 4", ""), 13, 2, "design.rows", "missing key");
    holds(&fault("rows = 4", "rows = 0"), 15, 8, "design.rows", "at least one row");
    holds(
        &fault("kind = \"latin_hypercube\"\nrows = 4", "kind = \"full_factorial\""),
        15,
        16,
        "design.factor.pressure.levels",
        "needs `levels`",
    );
    holds(&fault("kind = \"latin_hypercube\"\nrows = 4", ""), 13, 2, "design.kind", "no kind of design");
    holds(&fault("latin_hypercube\"", "full_factorial\""), 15, 8, "design.rows", "belongs to");
}

#[test]
fn categories_that_name_nothing_are_found_before_any_row() {
    let text = GOOD
        .replace("hammer.left.supply_bar", "hammer.left.mount")
        .replace("range = [4.0, 6.0]", "values = [\"R5\", \"R50\"]");
    let found = faults(&text);
    assert!(found.iter().any(|problem| problem.key == "design.factor.pressure.values.1"), "{found:#?}");
    let text = GOOD
        .replace("hammer.left.supply_bar", "hammer.left.file")
        .replace("range = [4.0, 6.0]", "values = [\"studies/hammers/default.toml\", \"none.toml\"]");
    let found = faults(&text);
    assert_eq!(found.len(), 1);
    holds(&found[0], 18, 43, "design.factor.pressure.values.1", "cannot read the hammer file");
}

#[test]
fn hammer_files_are_checked_with_places_of_their_own() {
    let missing = fault("mount", "file = \"no.toml\"\nmount");
    holds(&missing, 6, 8, "hammer.left.file", "cannot read the hammer file");
    let directory = tempfile::tempdir().unwrap();
    let load = |content: &str| {
        std::fs::write(directory.path().join("h.toml"), content).unwrap();
        let text = GOOD.replace("mount", "file = \"h.toml\"\nmount");
        match Study::parse(&text, directory.path(), "s.toml") {
            Ok(study) => study.check(&station_points()).unwrap_err(),
            Err(error) => error,
        }
    };
    let unknown = load("[piston]\nmas_kg = 1.0\n");
    assert_eq!(unknown.problems()[0].nearest.as_deref(), Some("mass_kg"));
    assert!(unknown.to_string().contains("h.toml:2:1: `piston.mas_kg`: unknown key"), "{unknown}");
    let negative = load("[piston]\n\nmass_kg = -1.0\n");
    assert!(negative.to_string().contains("h.toml:3:11: `hammer.left.parameters.piston.mass_kg`: is -1"), "{negative}");
    let broken = load("[piston\n");
    assert!(broken.to_string().contains("h.toml:1:8"), "{broken}");
}

#[test]
fn settings_from_the_command_line_are_checked_the_same_way() {
    let study = Study::parse(GOOD, Path::new("."), "s.toml").unwrap();
    let set = |setting: &str| match study.with_overrides(&[setting.to_string()]) {
        Ok(study) => study.check(&station_points()).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    assert!(set("hammer.left.suply_bar=4").contains("did you mean `hammer.left.supply_bar`?"));
    assert!(set("hammer.left.supply_bar").contains("expected: path=value"));
    assert!(set("hammer.left.supply_bar=high").contains("is a text\n  expected: a number"));
    assert!(set("casting.part.mass_kg=-1").starts_with("--set casting.part.mass_kg=-1: `casting.part.mass_kg`: is -1"));
    assert!(set("hammer.left.mount=R55").contains("no interface point `R55`\n  did you mean `R5`?"));
    assert!(set("casting.part.mass_kg=nan").contains("no finite number"));
    assert!(set("=1").contains("empty part"));
}

#[test]
fn structures_need_their_files() {
    let problem = fault("cutoff_hz = 300.0", "source = \"modal_table\"\npoints_file = \"Cargo.toml\"");
    holds(&problem, 3, 2, "structure.modal_file", "needs this file");
    let text = "source = \"matrices\"\npoints_file = \"Cargo.toml\"\nmass_file = \"Cargo.toml\"\nstiffness_file = \"none.mtx\"";
    holds(&fault("cutoff_hz = 300.0", text), 7, 18, "structure.stiffness_file", "there is no file");
    holds(&fault("cutoff_hz = 300.0", "mass_file = \"Cargo.toml\""), 4, 13, "structure.mass_file", "does not belong");
}

#[test]
fn no_text_makes_the_reader_panic() {
    // Every prefix of a study, and the study with each of its bytes replaced.
    for end in 0..GOOD.len() {
        let _ = Study::parse(&GOOD[..end], Path::new("."), "s.toml").map(|study| study.check(&station_points()));
    }
    for index in 0..GOOD.len() {
        for byte in ["\u{0}", "\"", "]", "=", ".", "é", "9"] {
            let text = format!("{}{byte}{}", &GOOD[..index], &GOOD[index + 1..]);
            let result = Study::parse(&text, Path::new("."), "s.toml").map(|study| study.check(&station_points()));
            if let Err(error) = result {
                assert!(!error.to_string().is_empty());
            }
        }
    }
}
