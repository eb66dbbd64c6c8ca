//! Studies from file to scene: the shipped ones, defaults, placement, factors, overrides, hash, schemas.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::station::{checked, rows};
use decore::cli::output_schemas;
use decore_model::contact::ContactLawName;
use decore_model::hammer::HammerParameters;
use decore_model::scene::{Guide, HammerUnit};
use decore_model::workpiece::Fixture;
use decore_quantity::{Kind, Value};
use decore_study::{InterfaceDemand, Study, hammer_file, hammer_schema, study_schema, template};

fn studies() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies")
}

fn shipped(name: &str) -> Study {
    Study::load(&studies().join(name)).unwrap_or_else(|error| panic!("{error}"))
}

fn parse(text: &str) -> Study {
    Study::parse(text, &studies(), "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn near(hammer: &HammerUnit, strike: [f64; 2]) {
    for (value, wanted) in hammer.strike_point_m.iter().zip(strike) {
        assert!((value - wanted).abs() < 1e-12, "{}: {value} for {wanted}", hammer.name);
    }
}

/// Heave alone.
const HEAVE: [bool; 6] = [false, false, true, false, false, false];

const SMALL: &str = "
[hammer.left]
mount = 'R5'
[casting.part]
mass_kg = 0.517
[casting.part.fixture.f1]
point = 'T5'
";

#[test]
fn every_shipped_study_and_the_template_pass_their_check() {
    let mut count = 0;
    for entry in std::fs::read_dir(studies()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let study = Study::load(&path).unwrap_or_else(|error| panic!("{error}"));
            let study = rows(&study);
            for row in 0..study.row_count() {
                study.scene(row).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            }
            count += 1;
        }
    }
    assert!(count >= 4);
    rows(&parse(&template().unwrap()));
}

#[test]
fn the_template_shows_every_key_of_the_schema_and_the_declared_defaults() {
    let template = template().unwrap();
    let schema = study_schema();
    let mut keys: Vec<String> = Vec::new();
    let mut tables = vec![&schema];
    // A hammer file shows those of a hammer (`hammers/default.toml`).
    let skip = ["Chisel", "Guide", "Hammer", "Housing", "Piston", "Telescope", "Valve"]
        .map(|group| format!("{group}Parameters"));
    let definitions = schema["$defs"].as_object().unwrap();
    let parts = |name: &&String| !skip.contains(name);
    tables.extend(definitions.keys().filter(parts).map(|name| &definitions[name]));
    for table in tables {
        keys.extend(table["properties"].as_object().into_iter().flatten().map(|(key, _)| key.clone()));
    }
    assert!(keys.len() > 40, "{keys:?}");
    for key in keys {
        assert!(template.contains(&key), "the template does not show `{key}`");
    }
    let (hammer, fixture) = (HammerUnit::default(), Fixture::default());
    for (table, key, default) in [
        ("[hammer.left]", "standoff_m", hammer.standoff_m),
        ("[hammer.left]", "start_time_s", hammer.start_time_s),
        ("[hammer.left]", "gate_delay_s", hammer.gate_delay_s),
        ("[casting.part.fixture.front_left]", "stiffness_n_per_m", fixture.stiffness_n_per_m),
        ("[casting.part.fixture.front_left]", "damping_n_s_per_m", fixture.damping_n_s_per_m),
    ] {
        let behind = template.lines().skip_while(|line| *line != table).skip(1);
        let line =
            behind.take_while(|line| !line.starts_with('[')).find_map(|line| line.strip_prefix(&format!("# {key} = ")));
        let shown: f64 = line.and_then(|rest| rest.split_whitespace().next()).unwrap().parse().unwrap();
        assert_eq!(shown, default, "{key}");
    }
    assert!(!template.contains("#!"), "all declared tables are filled in");
}

/// What rows and machines are given in numbers is declared with its range; the rest of the numbers are names of nodes and places on
/// rails, whose range the machine tells.
#[test]
fn every_number_of_scene_and_machine_has_its_range_and_default_in_the_schema() {
    let schema = study_schema();
    let tables = ["StructureEntry", "HammerEntry", "CastingEntry", "FixtureEntry", "SolverEntry", "Environment"];
    let tables = tables.map(|name| (name, &schema["$defs"][name])).into_iter().chain([("the study", &schema)]);
    let mut numbers = 0;
    for (table, (key, property)) in
        tables.flat_map(|(name, table)| table["properties"].as_object().unwrap().iter().map(move |one| (name, one)))
    {
        let kinds = property["type"].to_string();
        if ["dofs_per_node", "rail_position_m"].contains(&key.as_str()) || !kinds.contains("\"number\"") {
            continue;
        }
        let text = property["description"].as_str().unwrap();
        assert!(text.contains("Takes ") && text.contains("; "), "{table}, {key}: {text}");
        numbers += 1;
    }
    assert!(numbers > 20, "{numbers}");
    let at = |pointer: &str| schema.pointer(pointer).unwrap_or_else(|| panic!("{pointer}")).clone();
    assert_eq!(at("/properties/duration_s/exclusiveMinimum"), 0);
    assert_eq!(at("/$defs/HammerEntry/properties/supply_bar/minimum"), 0);
    let structure = "/$defs/StructureEntry/properties";
    assert_eq!(at(&format!("{structure}/mode_tolerance/exclusiveMaximum")), 1);
    assert_eq!(at(&format!("{structure}/damping_ratio/exclusiveMaximum")), 1);
    assert_eq!(at(&format!("{structure}/cutoff_hz/exclusiveMinimum")), 0);
}

#[test]
fn a_study_lists_the_files_that_it_reads() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    for name in ["k.mtx", "m.mtx", "d.mtx", "points.csv", "modes.csv", "unused.toml"] {
        std::fs::write(path(name), "").unwrap();
    }
    for name in ["a.toml", "b.toml"] {
        std::fs::write(path(name), "piston.mass_kg = 0.4").unwrap();
    }
    std::fs::write(path("rows.csv"), "hammer,p\na.toml,5\nb.toml,6\n").unwrap();
    let machine = "source = 'matrices'\nstiffness_file = 'k.mtx'\nmass_file = 'm.mtx'\npoints_file = 'points.csv'";
    let further = "source = 'modal_table'\nmodal_file = 'modes.csv'\npoints_file = 'points.csv'";
    let factors = "hammer = { path = 'hammer.left.file' }\np = { path = 'hammer.left.supply_bar' }";
    let design = format!("[design]\nkind = 'table'\nfile = 'rows.csv'\n[design.factor]\n{factors}");
    let text = format!(
        "[structure]\n{machine}\ndamping_file = 'd.mtx'\n[structures.other]\n{further}\n{SMALL}{design}\n[outputs]\ntwins = 0\n"
    );
    std::fs::write(path("study.toml"), &text).unwrap();
    let mut files = Study::load(&path("study.toml")).unwrap_or_else(|error| panic!("{error}")).files();
    files.sort();
    files.dedup();
    let wanted = ["a.toml", "b.toml", "d.mtx", "k.mtx", "m.mtx", "modes.csv", "points.csv", "rows.csv", "study.toml"];
    assert_eq!(files, wanted.map(path));
    // A text alone has no file of its own.
    assert!(Study::parse(SMALL, directory.path(), "test.toml").unwrap().files().is_empty());
}

#[test]
fn the_hammer_file_is_the_built_in_hammer() {
    is_committed("studies/hammers/default.toml", &hammer_file().unwrap());
    let text = std::fs::read_to_string(studies().join("hammers/default.toml")).unwrap();
    let written: toml::Table = toml::from_str(&text).unwrap();
    assert_eq!(written, toml::Table::try_from(HammerParameters::default()).unwrap());
}

/// Holds a committed file to what the declarations say; with `DECORE_UPDATE_SCHEMAS` set it is written anew.
fn is_committed(file: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    if std::env::var_os("DECORE_UPDATE_SCHEMAS").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap();
    assert!(committed == text, "{} is out of date: run the tests with DECORE_UPDATE_SCHEMAS=1", path.display());
}

#[test]
fn schemas_are_the_committed_ones() {
    let inputs = [("study", study_schema()), ("hammer", hammer_schema())];
    let schemas = inputs.into_iter().chain(output_schemas());
    for (name, schema) in schemas {
        let text = format!("{}\n", serde_json::to_string_pretty(&schema).unwrap());
        is_committed(&format!("schemas/{name}.schema.json"), &text);
    }
}

#[test]
fn studies_hold_to_the_schemas() {
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: studies were not held to the schemas");
        return;
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output =
        Command::new(python).arg(root.join("tests/schemas.py")).arg(root).output().expect("interpreter started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_papers_rig_is_the_default_scene() {
    let study = rows(&shipped("paper_rig.toml"));
    let scene = study.scene(0).unwrap();
    assert_eq!(study.row_count(), 1);
    assert_eq!(scene.duration_s, 1.5);
    let hammer = &scene.hammers[0];
    assert_eq!(hammer.parameters, HammerParameters::default());
    assert_eq!(hammer.supply_pressure_pa, 601_325.0);
    assert_eq!(hammer.standoff_m, 0.085);
    assert_eq!((hammer.start_time_s, hammer.gate_delay_s), (0.002, 0.020));
    assert_eq!(hammer.mount.points, [("R5".to_string(), 1.0)]);
    assert_eq!(hammer.strike_point_m, [0.0, 0.0]);
    let casting = &scene.castings[0];
    assert_eq!(casting.mass_kg, 0.517);
    assert_eq!(casting.fixtures[0].stiffness_n_per_m, 3e7);
    assert_eq!(scene.freedoms(0), HEAVE);
    assert_eq!((scene.solver.tolerance, scene.solver.guide), (1e-5, Guide::Automatic));
    // The same without the file: everything else is a default.
    let small = rows(&parse(SMALL)).scene(0).unwrap();
    assert_eq!(small.hammers[0].supply_pressure_pa, hammer.supply_pressure_pa);
    assert_eq!(small.hammers[0].parameters, hammer.parameters);
}

#[test]
fn overrides_reach_the_other_reference_scenes() {
    let study = shipped("paper_rig.toml");
    let four = study.with_overrides(&["hammer.hammer.supply_bar=4".into()]).unwrap();
    assert_eq!(rows(&four).scene(0).unwrap().hammers[0].supply_pressure_pa, 501_325.0);
    let settings = [
        "hammer.hammer.mount=R3",
        "hammer.hammer.strike_point_m=[0.0, 0.0]",
        "hammer.hammer.standoff_m=0.06",
        "geometry=as_given",
    ];
    let moved = study.with_overrides(&settings.map(String::from)).unwrap();
    let scene = rows(&moved).scene(0).unwrap();
    assert_eq!(scene.hammers[0].mount.points[0].0, "R3");
    assert_eq!(scene.hammers[0].strike_point_m, [0.0, 0.0]);
    assert_eq!(scene.hammers[0].standoff_m, 0.06);
    assert_eq!(InterfaceDemand::of(&moved).mounts, ["R3"]);
    assert_eq!(moved.overrides(), settings);
    assert_ne!(moved.hash(), study.hash());
    let cut = study.with_overrides(&["structure.cutoff_hz=300".into()]).unwrap();
    assert_eq!(cut.structure().cutoff_hz, 300.0);
}

#[test]
fn three_hammers_stand_where_the_reference_puts_them() {
    let study = shipped("three_hammers.toml");
    let scene = rows(&study).scene(0).unwrap();
    assert_eq!(study.hammer_names(), ["one", "two", "three"]);
    assert_eq!(study.casting_names(), ["a", "b"]);
    near(&scene.hammers[0], [0.0, -0.0375]);
    near(&scene.hammers[1], [0.0, 0.0625]);
    near(&scene.hammers[2], [0.0, 0.0]);
    let mount = &scene.hammers[2].mount.points;
    assert_eq!((mount[0].0.as_str(), mount[1].0.as_str()), ("R6", "R7"));
    assert!((mount[0].1 - 0.75).abs() < 1e-12 && (mount[1].1 - 0.25).abs() < 1e-12);
    let bars: Vec<f64> = scene.hammers.iter().map(|hammer| (hammer.supply_pressure_pa - 101_325.0) / 1e5).collect();
    assert!(bars.iter().zip([5.0, 4.5, 5.5]).all(|(bar, wanted)| (bar - wanted).abs() < 1e-12));
    assert_eq!(scene.hammers.iter().map(|hammer| hammer.casting).collect::<Vec<_>>(), [0, 0, 1]);
    let places = [[-0.125, -0.0625], [-0.125, 0.0625], [0.125, -0.0625], [0.125, 0.0625]];
    for (fixture, place) in scene.castings[0].fixtures.iter().zip(places) {
        assert!((fixture.at_m[0] - place[0]).abs() < 1e-12 && (fixture.at_m[1] - place[1]).abs() < 1e-12);
    }
    assert_eq!(scene.freedoms(0), [false, false, true, true, true, false]);
    assert_eq!(scene.freedoms(1), HEAVE);
    let demand = InterfaceDemand::of(&study);
    assert_eq!(demand.mounts, ["R4", "R5", "R1", "R2", "R3", "R6", "R7", "R8", "R9"]);
    assert_eq!(demand.others, ["T1", "T2", "T7", "T8", "T6"]);
}

#[test]
fn the_placement_study_is_a_latin_hypercube_of_scenes() {
    let study = shipped("placement.toml");
    let names: Vec<&str> = study.factors().iter().map(|factor| factor.name.as_str()).collect();
    assert_eq!(names, ["position", "pressure", "standoff", "fixture_stiffness"]);
    assert!(study.factors().iter().all(|factor| factor.kind == Kind::Real));
    assert_eq!(study.factors()[1].unit.as_deref(), Some("bar"));
    assert_eq!(study.seed(), 1);
    let study = rows(&study);
    for row in [0, 17, 239] {
        let scene = study.scene(row).unwrap();
        let values: Vec<f64> = study
            .row_values(row)
            .iter()
            .map(|value| match value {
                Value::Real(value) => *value,
                other => panic!("{other:?}"),
            })
            .collect();
        near(&scene.hammers[0], [0.0, values[0]]);
        assert!((scene.hammers[0].supply_pressure_pa - 101_325.0 - 1e5 * values[1]).abs() < 1e-6);
        assert_eq!(scene.hammers[0].standoff_m, values[2]);
        assert!(scene.castings[0].fixtures.iter().all(|fixture| fixture.stiffness_n_per_m == values[3]));
    }
    assert!(study.scene(240).unwrap_err().reason.contains("rows 0 to 239"));
    assert!(study.row_values(240).is_empty());
}

#[test]
fn the_grid_runs_through_every_combination() {
    let study = shipped("pressure_grid.toml");
    assert_eq!(study.factors()[0].kind, Kind::Text);
    assert_eq!(InterfaceDemand::of(&study).mounts, ["R3", "R5"]);
    let study = rows(&study);
    assert_eq!(study.row_count(), 8);
    let rows: Vec<String> =
        (0..8).map(|row| study.row_values(row).iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")).collect();
    assert_eq!(
        rows,
        ["R3 4 0.06", "R3 4 0.085", "R3 5 0.06", "R3 5 0.085", "R5 4 0.06", "R5 4 0.085", "R5 5 0.06", "R5 5 0.085"]
    );
    assert_eq!(study.scene(0).unwrap().hammers[0].mount.points[0].0, "R3");
    assert_eq!(study.scene(7).unwrap().hammers[0].mount.points[0].0, "R5");
}

#[test]
fn an_overridden_factor_shows_the_override() {
    let study = shipped("placement.toml").with_overrides(&["hammer.hammer.supply_bar=4.25".into()]).unwrap();
    let study = rows(&study);
    assert_eq!(study.row_values(5)[1], Value::Real(4.25));
    let whole = shipped("placement.toml").with_overrides(&["hammer.hammer.supply_bar=4".into()]).unwrap();
    assert_eq!(rows(&whole).row_values(5)[1], Value::Real(4.0));
    let scene = study.scene(5).unwrap();
    assert_eq!(scene.hammers[0].supply_pressure_pa, 101_325.0 + 425_000.0);
}

#[test]
fn parameters_can_be_overridden_and_varied_one_by_one() {
    let text = format!(
        "{SMALL}
[hammer.left.parameters.piston]
mass_kg = 0.5
rear_wall.damping_n_s_per_m = 100.0
[hammer.left.parameters.housing]
centre_of_mass_m = [0.0, 0.0, -0.1]
[design]
kind = 'full_factorial'
[design.factor.bore]
path = 'hammer.left.parameters.piston.bore_m'
values = [0.028, 0.030]
[design.factor.height]
path = 'hammer.left.parameters.housing.centre_of_mass_m.2'
range = [-0.3, -0.1]
levels = 3
[design.factor.steps]
path = 'solver.max_steps'
range = [100, 102]
integer = true
[design.factor.guide]
path = 'solver.guide'
values = ['tied', 'spring']
"
    );
    let study = parse(&text);
    let study = rows(&study);
    assert_eq!(study.row_count(), 2 * 3 * 3 * 2);
    let scene = study.scene(study.row_count() - 2).unwrap();
    let parameters = &scene.hammers[0].parameters;
    assert_eq!(parameters.piston.mass_kg, 0.5);
    assert_eq!(parameters.piston.rear_wall.damping_n_s_per_m, 100.0);
    assert_eq!(parameters.piston.rear_wall.stiffness_n_per_m, 2e7);
    assert_eq!(parameters.piston.bore_m, 0.030);
    assert_eq!(parameters.housing.centre_of_mass_m, [0.0, 0.0, -0.1]);
    assert_eq!((scene.solver.max_steps, scene.solver.guide), (102, Guide::Tied));
}

/// The law of a contact is one key, to set and to vary; a loss stated anew displaces the one of the layer below, and no
/// layer may state it twice.
#[test]
fn contact_laws_are_set_and_varied() {
    let text = |table: &str| {
        format!(
            "{SMALL}
[hammer.left.parameters.chisel.casting_contact]
{table}
[design]
kind = 'full_factorial'
[design.factor.law]
path = 'hammer.left.parameters.chisel.casting_contact.law'
values = ['kelvin_voigt', 'hunt_crossley', 'hertz']
"
        )
    };
    let study = parse(&text("restitution = 0.7\nexponent = 2"));
    let study = rows(&study);
    let contact = |row| study.scene(row).unwrap().hammers[0].parameters.chisel.casting_contact;
    let laws = [0, 1, 2].map(|row| contact(row).law);
    assert_eq!(laws, [ContactLawName::KelvinVoigt, ContactLawName::HuntCrossley, ContactLawName::Hertz]);
    let found = contact(1);
    assert_eq!((found.restitution, found.exponent, found.stiffness_n_per_m), (Some(0.7), Some(2.0), 2.95e8));
    let fails = |table: &str, expected: &str| {
        let study = parse(&text(table));
        let message = checked(&study).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    fails("restitution = 0.7\ndamping_n_s_per_m = 3", "`chisel.casting_contact.restitution`: cannot be combined");
    fails("restitution = 0.0", "above 0 and not above 1");
    fails("restitution = 1.5", "above 0 and not above 1");
    fails("exponent = 0.9", "exponent");
    fails("reference_speed_m_s = 0", "a positive number");
    let unknown = text("law = 'hunt'");
    let message = Study::parse(&unknown, &studies(), "study.toml").unwrap_err().to_string();
    assert!(message.contains("hunt_crossley"), "{message}");
}

/// A supply is switched in ascending order after its start; single times can be varied.
#[test]
fn supplies_are_switched_in_order() {
    let with =
        |times: &str| parse(&SMALL.replace("mount = 'R5'", &format!("mount = 'R5'\nsupply_switch_times_s = {times}")));
    let study = with("[0.5, 0.7]").with_overrides(&["hammer.left.supply_switch_times_s.1=0.9".into()]).unwrap();
    assert_eq!(rows(&study).scene(0).unwrap().hammers[0].supply_switch_times_s, [0.5, 0.9]);
    for times in ["[0.5, 0.5]", "[0.001]", "[0.7, 0.6]"] {
        let message = checked(&with(times)).unwrap_err().to_string();
        assert!(message.contains("expected a time after the switch before"), "{message}");
    }
}

#[test]
fn a_factor_may_give_what_the_file_leaves_out() {
    let text = SMALL.replace("mass_kg = 0.517", "").replace("mount = 'R5'", "")
        + "
[design]
kind = 'latin_hypercube'
rows = 6
[design.factor.mass]
path = 'casting.part.mass_kg'
range = [0.5, 5.0]
scale = 'log'
[design.factor.mount]
path = 'hammer.left.mount'
values = ['R4', 'R5', 'R6']
[design.factor.file]
path = 'hammer.left.file'
values = ['hammers/default.toml']
";
    let study = parse(&text.replace("[casting.part]", "[casting.part]\ninertia_kg_m2 = [0.01, 0.01]"));
    assert_eq!(InterfaceDemand::of(&study).mounts, ["R4", "R5", "R6"]);
    // Off the only fixture the casting would spin.
    let error = checked(&study).unwrap_err().to_string();
    assert!(error.contains("is free to move"), "{error}");
    let study = rows(&parse(&format!("{}[casting.part.fixture.other]\npoint = 'T4'\n", study.text())));
    let mounts: Vec<String> = (0..6).map(|row| study.row_values(row)[1].to_string()).collect();
    for name in ["R4", "R5", "R6"] {
        assert_eq!(mounts.iter().filter(|mount| *mount == name).count(), 2);
    }
    let stands = |row: usize| study.scene(row).unwrap().hammers[0].mount.points[0].0.clone();
    assert_eq!((0..6).map(stands).collect::<Vec<_>>(), mounts);
}

#[test]
fn a_hammer_beside_its_casting_is_an_invalid_row() {
    let text = SMALL.replace("mount = 'R5'", "mount = 'R7'").replace("mass_kg", "size_m = [0.2, 0.3]\nmass_kg");
    let study = parse(&text);
    let study = rows(&study);
    let reason = study.scene(0).unwrap_err().reason;
    assert_eq!(
        reason,
        "`hammer.left.strike_point_m`: hammer `left` would miss casting `part`: it strikes at (0.0000, 0.2000) m from the \
         centre, the casting measures 0.2 m by 0.3 m"
    );
}

/// From above: a hammer along x passes the casting at y = 0.2 m, one along x and -y crosses its corner.
#[test]
fn an_inclined_hammer_beside_its_casting_is_an_invalid_row() {
    let text = SMALL
        .replace("mount = 'R5'", "mount = 'R7'\nstrike_axis = AXIS")
        .replace("mass_kg", "size_m = [0.2, 0.3]\ninertia_kg_m2 = [0.1, 0.1]\ninertia_z_kg_m2 = 0.1\nmass_kg");
    let held = "lateral_stiffness_n_per_m = [1e7, 1e7]\n";
    let text = ["T1", "T3", "T7", "T9"].iter().enumerate().fold(format!("{text}{held}"), |text, (index, point)| {
        format!("{text}[casting.part.fixture.g{index}]\npoint = '{point}'\n{held}")
    });
    let struck = |axis: &str| rows(&parse(&text.replace("AXIS", axis))).scene(0).map_err(|error| error.reason);
    let reason = struck("[1.0, 0.0, -0.5]").unwrap_err();
    let expected = "`hammer.left.strike_point_m`: hammer `left` would miss casting `part`: its axis passes (";
    assert!(reason.starts_with(expected), "{reason}");
    let end = "0.2000) m from the centre, along (0.8944, 0.0000, -0.4472), the casting measures 0.2 m by 0.3 m";
    assert!(reason.ends_with(end), "{reason}");
    for axis in ["[1.0, -1.0, 0.0]", "[0.0, -1.0, -0.5]"] {
        struck(axis).unwrap_or_else(|reason| panic!("{reason}"));
    }
}

#[test]
fn the_hash_follows_values_not_spelling() {
    let hash = |text: &str| parse(text).hash().to_string();
    let base = hash(SMALL);
    assert_eq!(base.len(), 64);
    assert_eq!(base, hash(&format!("# a comment\ntitle = 'other'\n{SMALL}")));
    assert_eq!(base, hash(&SMALL.replace("0.517", "517e-3")));
    assert_ne!(base, hash(&SMALL.replace("0.517", "0.518")));
    assert_ne!(base, hash(&SMALL.replace("left", "right")));
    assert_ne!(base, hash(&SMALL.replace("mount", "file = 'hammers/default.toml'\nmount")));
}

#[test]
fn the_hash_follows_the_hammer_file() {
    let directory = tempfile::tempdir().unwrap();
    let text = SMALL.replace("mount", "file = 'h.toml'\nmount");
    let mut hashes = Vec::new();
    for content in ["[piston]\nmass_kg = 0.5", "# same\n[piston]\nmass_kg = 0.50", "[piston]\nmass_kg = 0.51"] {
        std::fs::write(directory.path().join("h.toml"), content).unwrap();
        let study = Study::parse(&text, directory.path(), "test.toml").unwrap();
        hashes.push(study.hash().to_string());
    }
    assert_eq!(hashes[0], hashes[1]);
    assert_ne!(hashes[0], hashes[2]);
}

#[test]
fn rows_are_resolved_fast_and_without_files() {
    let directory = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(studies().join("placement.toml")).unwrap();
    std::fs::create_dir(directory.path().join("hammers")).unwrap();
    let hammer = directory.path().join("hammers/default.toml");
    std::fs::copy(studies().join("hammers/default.toml"), &hammer).unwrap();
    let study = Study::parse(&text, directory.path(), "test.toml").unwrap();
    std::fs::remove_file(&hammer).unwrap();
    let study = rows(&study);
    let start = std::time::Instant::now();
    for row in 0..study.row_count() {
        study.scene(row).unwrap();
    }
    let each = start.elapsed().as_secs_f64() / study.row_count() as f64;
    println!("{:.1} us per row", 1e6 * each);
    assert!(each < 1e-3, "{each} s per row");
}
