//! Bad studies: factors, ranges, hammer files, settings from the command line, structures.

use std::path::Path;

use crate::faults::{GOOD, fault, faults, holds};
use crate::station::checked;
use decore_study::Study;

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
    holds(&fault("path = \"hammer.left.supply_bar\"", ""), 16, 16, "design.factor.pressure", "drives no parameter");
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
    holds(&fault("range = [4.0, 6.0]", ""), 16, 16, "design.factor.pressure", "has no range and no values");
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
            Ok(study) => checked(&study).unwrap_err(),
            Err(error) => error,
        }
    };
    let unknown = load("[piston]\nmas_kg = 1.0\n");
    assert_eq!(unknown.problems()[0].nearest.as_deref(), Some("mass_kg"));
    assert!(unknown.to_string().contains("h.toml:2:1: `piston.mas_kg`: unknown key"), "{unknown}");
    let negative = load("[piston]\n\nmass_kg = -1.0\n");
    assert!(negative.to_string().contains("h.toml:3:11: `hammer.left.parameters.piston.mass_kg`: is -1"), "{negative}");
    let broken = load("[piston\n");
    assert!(broken.to_string().contains("h.toml:1:1: the name of a table without its closing bracket"), "{broken}");
}

#[test]
fn settings_from_the_command_line_are_checked_the_same_way() {
    let study = Study::parse(GOOD, Path::new("."), "s.toml").unwrap();
    let set = |setting: &str| match study.with_overrides(&[setting.to_string()]) {
        Ok(study) => checked(&study).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    assert!(set("hammer.left.suply_bar=4").contains("did you mean `hammer.left.supply_bar`?"));
    assert!(set("hammer.left.supply_bar").contains("expected: path=value"));
    assert!(set("hammer.left.supply_bar=high").contains("is the text \"high\"\n  expected: a number"));
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
