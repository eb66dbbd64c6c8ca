//! Castings that lie on pads under clamps: forces, lift-offs, castings that cannot rest or are thrown off.

use std::fs;
use std::path::Path;

use decore_dataset::{Columns, TableName};
use decore_model::metrics::RunMetrics;
use decore_model::run::{RowOutcome, RowStatus};
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};
use tempfile::TempDir;

/// One hammer on a casting of 12 kg on four pads, with a clamp on each side.
fn study(clamp: &str) -> String {
    let pad = |name: &str, [x, y]: [f64; 2]| {
        format!(
            "[casting.part.fixture.{name}]\npoint = \"T5\"\nat_m = [{x}, {y}]\nstiffness_n_per_m = 3e7\none_sided = true\n"
        )
    };
    let pads = [("a", [-0.08, -0.04]), ("b", [0.08, -0.04]), ("c", [-0.08, 0.04]), ("d", [0.08, 0.04])];
    let pads: String = pads.into_iter().map(|(name, at)| pad(name, at)).collect();
    format!(
        "duration_s = 0.4\ngeometry = \"as_given\"\n[structure]\ncutoff_hz = 300.0\n[solver]\ntolerance = 1e-7\n[hammer.left]\nmount = \"R5\"\nsupply_bar = 5.0\n\
         [casting.part]\nmass_kg = 12.0\ninertia_kg_m2 = [0.02, 0.05]\n{pads}{clamp}"
    )
}

fn clamps(force_n: f64) -> String {
    let clamp = |name: &str, x: f64| {
        format!("[casting.part.fixture.{name}]\npoint = \"T5\"\nat_m = [{x}, 0.0]\nclamp_force_n = {force_n:?}\n")
    };
    [clamp("left", -0.08), clamp("right", 0.08)].concat()
}

fn engine(text: &str, folder: &Path) -> Result<Engine, String> {
    fs::write(folder.join("study.toml"), text).unwrap();
    let study = Study::load(&folder.join("study.toml")).map_err(|error| error.to_string())?;
    Engine::new(study).map_err(|error| error.to_string())
}

fn outcome(text: &str) -> RowOutcome {
    let folder = TempDir::new().unwrap();
    engine(text, folder.path()).unwrap_or_else(|error| panic!("{error}")).outcome(0)
}

fn metrics(text: &str) -> RunMetrics {
    let outcome = outcome(text);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    let metrics = outcome.metrics.unwrap();
    assert!(metrics.totals.energy_residual.abs() < 1e-4, "{:e}", metrics.totals.energy_residual);
    metrics
}

/// Each pad has energies if the study asks for them; they sum to those of the casting, lift-offs included.
#[test]
fn energies_through_pads() {
    let text = format!("{}\n[outputs]\nfixture_energy = true\n", study(&clamps(1000.0)));
    let folder = TempDir::new().unwrap();
    let columns = Columns::new(&engine(&text, folder.path()).unwrap().info()).unwrap().describe(TableName::Runs);
    assert!(columns.iter().any(|column| column.name == "part_fixture_left_structure_work_j" && column.unit == "J"));
    assert!(columns.iter().any(|column| column.name == "part_fixture_a_damper_loss_j" && column.less));
    let metrics = metrics(&text);
    assert!(metrics.pads.iter().any(|pad| pad.lift_off_count > 0) && metrics.fixtures.len() == 6);
    let casting = &metrics.castings[0];
    let loss: f64 = metrics.fixtures.iter().map(|fixture| fixture.damper_loss_j).sum();
    let work: f64 = metrics.fixtures.iter().map(|fixture| fixture.structure_work_j).sum();
    let off = (loss - casting.fixture_damper_loss_j).abs().max((work - casting.structure_work_j).abs());
    println!("{:.1e} of the delivered work is missing", off / casting.delivered_work_j);
    assert!(off < 1e-10 * casting.delivered_work_j, "{off:e}");
    // A clamp of constant force has no damper.
    assert!(metrics.fixtures[..4].iter().all(|fixture| fixture.damper_loss_j > 0.0));
    assert!(metrics.fixtures[4..].iter().all(|fixture| fixture.damper_loss_j == 0.0));
}

/// Pads carry weight and clamps by the law of the lever; their least and largest forces are those of the signals; more clamping force
/// leaves less time off the pads.
#[test]
fn forces_and_lift_offs() {
    let folder = TempDir::new().unwrap();
    let engine = engine(&study(&clamps(1000.0)), folder.path()).unwrap();
    let (outcome, signals) = engine.outcome_with_signals(0, 2e-6).unwrap();
    let (metrics, signals) = (outcome.metrics.unwrap(), signals.unwrap());
    let rest = (12.0 * 9.80665 + 2000.0) / 4.0;
    for (pad, name) in metrics.pads.iter().zip(["a", "b", "c", "d"]) {
        assert!((pad.rest_force_n / rest - 1.0).abs() < 1e-4, "{pad:?}");
        let column = format!("part_fixture_{name}_force_n");
        let signal = &signals.iter().find(|signal| signal.name == column).unwrap().values;
        let largest = signal.iter().copied().fold(f64::MIN, f64::max) + rest;
        assert!((pad.largest_force_n / largest - 1.0).abs() < 1e-4, "{pad:?} {largest}");
        let off = signal.iter().filter(|force| **force + rest < 1e-6 * rest).count() as f64 / signal.len() as f64;
        assert!((pad.lifted_off_share - off).abs() < 1e-4, "{pad:?} {off}");
        assert!(pad.lift_off_count > 0 && pad.least_force_n == 0.0 && pad.longest_lift_off_s > 0.0, "{pad:?}");
    }
    let share = |force_n: f64| metrics_share(&study(&clamps(force_n)));
    let (light, heavy, held) = (share(1000.0), share(5000.0), share(3e5));
    assert!(light > heavy && heavy > 0.0 && held == 0.0, "{light} {heavy} {held}");
}

fn metrics_share(text: &str) -> f64 {
    metrics(text).pads.iter().map(|pad| pad.lifted_off_share).fold(0.0, f64::max)
}

/// A casting that never lifts off moves as on two-sided fixtures: the least force is the one above which it does.
#[test]
fn held_down_it_moves_as_on_springs() {
    // Until shortly after the first impact: what follows depends on the last digits.
    let short = |text: String| metrics(&text.replace("duration_s = 0.4", "duration_s = 0.07"));
    let (pressed, spring) = (short(study(&clamps(3e5))), short(study("").replace("one_sided = true\n", "")));
    for pad in &pressed.pads {
        assert!(pad.least_force_n > 0.0 && pad.least_force_n < pad.rest_force_n && pad.lift_off_count == 0, "{pad:?}");
    }
    let figures = |of: &RunMetrics| {
        [of.castings[0].peak_velocity_m_s, of.castings[0].fixture_damper_loss_j, of.totals.strike_energy_j]
    };
    for (one, other) in figures(&pressed).into_iter().zip(figures(&spring)) {
        assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
    }
}

/// What cannot rest or stay is invalid, with its reason and a way out; what makes no sense is refused with its key.
#[test]
fn castings_that_cannot_stay() {
    let loose = study("").replace("supply_bar = 5.0", "supply_bar = 8.0\nsupply_switch_times_s = [0.07]");
    let soft = loose.replace("stiffness_n_per_m = 3e7", "stiffness_n_per_m = 3e6\ndamping_n_s_per_m = 10.0");
    let thrown =
        outcome(&soft.replace("mass_kg = 12.0", "mass_kg = 3.0").replace("duration_s = 0.4", "duration_s = 1.0"));
    assert_eq!(thrown.status, RowStatus::Invalid, "{:?}", thrown.metrics.map(|metrics| metrics.flights_s));
    assert!(thrown.reason.contains("`part`") && thrown.reason.contains("clamp_force_n"), "{}", thrown.reason);
    let tips = outcome(&study("").replace("at_m = [-0.08", "at_m = [0.02"));
    assert_eq!(tips.status, RowStatus::Invalid);
    assert!(tips.reason.contains("tip it off"), "{}", tips.reason);
    let reason = |text: &str| match engine(text, TempDir::new().unwrap().path()) {
        Err(error) => error,
        Ok(engine) => engine.outcome(0).reason,
    };
    let loose = reason(&study(&clamps(1000.0)).replace("one_sided = true\n", ""));
    assert!(loose.contains("casting.part.fixture.left.clamp_force_n") && loose.contains("one_sided = true"), "{loose}");
    let nothing = reason(&study("").replacen("one_sided", "clamp_stiffness_n_per_m = 1e6\none_sided", 1));
    assert!(nothing.contains("casting.part.fixture.a.clamp_stiffness_n_per_m"), "{nothing}");
    let design = "[design]\nkind = \"full_factorial\"\n[design.factor.c]\npath = \"casting.part.fixture.a.one_sided\"\nvalues = [1.0]\n";
    let driven = reason(&format!("{}{design}", study("")));
    assert!(driven.contains("shared by all rows"), "{driven}");
}

/// Stiffness and damping of a material by hand: PU of 22 MPa (the paper, Table 1), steel of 210 GPa behind a surface of 1e11 N/m3.
#[test]
fn materials_of_pads() {
    let folder = TempDir::new().unwrap();
    let pads = |material: &str| {
        study(&clamps(2000.0)).replace(
            "stiffness_n_per_m = 3e7\n",
            &format!("material = \"{material}\"\npad_area_m2 = 1.5e-3\npad_thickness_m = 0.02\n"),
        )
    };
    let spring = |material: &str| {
        let text = pads(material);
        fs::write(folder.path().join("study.toml"), text).unwrap();
        let study = Study::load(&folder.path().join("study.toml")).unwrap_or_else(|error| panic!("{error}"));
        Engine::new(study).unwrap().scene(0).unwrap().scene.castings[0].fixtures[0].spring()
    };
    let steel_n_per_m = 1.5e-3 / (0.02 / 2.1e11 + 1e-11);
    for (material, stiffness_n_per_m, loss, hz) in [
        ("polyurethane", 1.5e-3 * 22e6 / 0.02, 0.2, 100.0),
        ("rubber", 1.5e-3 * 3.6e6 / 0.02, 0.1, 100.0),
        ("steel", steel_n_per_m, 0.04, 1000.0),
        ("aluminium", 1.5e-3 / (0.02 / 7e10 + 1e-11), 0.04, 1000.0),
    ] {
        let [stiffness, damping] = spring(material);
        assert!((stiffness / stiffness_n_per_m - 1.0).abs() < 1e-12, "{material}: {stiffness}");
        let damping_n_s_per_m = stiffness_n_per_m * loss / (std::f64::consts::TAU * hz);
        assert!((damping / damping_n_s_per_m - 1.0).abs() < 1e-12, "{material}: {damping}");
    }
    // The material as a factor: rows are those of the same stiffness and damping stated as numbers.
    let design = |key: &str, values: &str| {
        let paths: Vec<String> =
            ["a", "b", "c", "d"].iter().map(|pad| format!("\"casting.part.fixture.{pad}.{key}\"")).collect();
        format!(
            "[design]\nkind = \"full_factorial\"\n[design.factor.f]\npaths = [{}]\nvalues = {values}\n",
            paths.join(", ")
        )
    };
    let short = |text: String| text.replace("duration_s = 0.4", "duration_s = 0.1");
    let rows =
        engine(&short(pads("rubber") + &design("material", "[\"steel\", \"polyurethane\"]")), folder.path()).unwrap();
    let [steel, soft] = [0, 1].map(|row| rows.outcome(row).metrics.unwrap().pads[0].largest_force_n);
    assert!(steel > 2.0 * soft, "{steel} {soft}");
    let [stiffness, damping] = spring("steel");
    let stated = study(&clamps(2000.0)).replace(
        "stiffness_n_per_m = 3e7\n",
        &format!("stiffness_n_per_m = {stiffness:?}\ndamping_n_s_per_m = {damping:?}\n"),
    );
    assert_eq!(metrics(&short(stated)).pads[0].largest_force_n, steel);
    let areas = engine(&(pads("rubber") + &design("pad_area_m2", "[1e-3, 2e-3]")), folder.path()).unwrap();
    let stiffness = [0, 1].map(|row| areas.scene(row).unwrap().scene.castings[0].fixtures[3].spring()[0]);
    assert_eq!(stiffness[1], 2.0 * stiffness[0]);
}

/// A material that contradicts another key is an error at its key.
#[test]
fn materials_of_pads_are_not_half_stated() {
    let pads = study("")
        .replace("stiffness_n_per_m = 3e7\n", "material = \"rubber\"\npad_area_m2 = 1e-3\npad_thickness_m = 0.02\n");
    let error = |old: &str, new: &str| {
        assert!(pads.contains(old));
        let folder = TempDir::new().unwrap();
        engine(&pads.replacen(old, new, 1), folder.path()).err().unwrap_or_default()
    };
    let at = "casting.part.fixture.a";
    for (old, new, key, text) in [
        (
            "one_sided",
            "stiffness_n_per_m = 1e6\none_sided",
            "stiffness_n_per_m",
            "remove either `stiffness_n_per_m` or `material`",
        ),
        (
            "one_sided",
            "damping_n_s_per_m = 10.0\none_sided",
            "damping_n_s_per_m",
            "follows from `material = \"rubber\"`",
        ),
        ("pad_area_m2 = 1e-3\n", "", "material", "needs `pad_area_m2` and `pad_thickness_m`"),
        ("material = \"rubber\"\n", "", "pad_area_m2", "needs the `material`"),
        ("rubber", "wood", "material", "expected: one of \"steel\", \"aluminium\", \"polyurethane\", \"rubber\""),
        ("pad_thickness_m = 0.02", "pad_thickness_m = 0.0", "pad_thickness_m", "expected a positive number"),
        ("one_sided = true", "clamp_force_n = 100.0", "material", "needs no `clamp_force_n`"),
        ("pad_area_m2 = 1e-3", "pad_area_m2 = 1e15", "pad_area_m2", "too stiff"),
    ] {
        let found = error(old, new);
        assert!(found.contains(&format!("{at}.{key}")) && found.contains(text), "{found}");
    }
}
