//! Studies with an elastic casting, from files of matrices to a row.

use std::fs;
use std::path::Path;

use decore_dataset::{Columns, TableName};
use decore_model::direction::DOWN;
use decore_model::run::{RowOutcome, RowStatus};
use decore_model::structure::{BodyPoint, Damping, ElasticBody, ElasticSettings, Side};
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};
use tempfile::TempDir;

use crate::solid::{block, write_block};

/// The part of a study that makes its casting elastic.
const STRUCTURE: &str = "[casting.part.structure]\nstiffness_file = \"K.mtx\"\nmass_file = \"M.mtx\"\ndof_file = \"rows.dof\"\n\
     nodes_file = \"nodes.csv\"\npoint_radius_m = 0.025\ncutoff_hz = 5000.0\n";

/// A study of one hammer on the block of bricks on four pads; `structure` makes it elastic.
fn study(structure: &str) -> String {
    let pad = |name: &str, x: f64, y: f64| {
        format!(
            "[casting.part.fixture.{name}]\npoint = \"T5\"\nat_m = [{x}, {y}]\nstiffness_n_per_m = 8e6\ndamping_n_s_per_m = 1500.0\n"
        )
    };
    let pads = [pad("a", -0.06, -0.02), pad("b", 0.06, -0.02), pad("c", -0.06, 0.02), pad("d", 0.06, 0.02)].concat();
    format!(
        "duration_s = 0.2\ngeometry = \"as_given\"\n[structure]\ncutoff_hz = 300.0\n[hammer.left]\nmount = \"R5\"\nsupply_bar = 5.0\n\
         [solver]\ntolerance = 1e-7\n[casting.part]\nmass_kg = 1.0368\ninertia_kg_m2 = [4.49280e-4, 2.350080e-3]\n\
         [casting.part.core.top]\nat_m = [0.03, 0.01, 0.01]\n{pads}{structure}"
    )
}

fn engine(text: &str, folder: &Path) -> Result<Engine, String> {
    fs::write(folder.join("study.toml"), text).unwrap();
    let study = Study::load(&folder.join("study.toml")).map_err(|error| error.to_string())?;
    Engine::new(study).map_err(|error| error.to_string())
}

/// A row of a study in a folder, which must be done.
pub fn outcome(text: &str, folder: &Path) -> RowOutcome {
    let outcome = engine(text, folder).unwrap_or_else(|error| panic!("{error}")).outcome(0);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome
}

/// Energy, work and casting velocities; the audit must hold.
pub fn figures(outcome: &RowOutcome) -> [f64; 5] {
    let metrics = outcome.metrics.as_ref().unwrap();
    assert!(metrics.totals.energy_residual.abs() < 1e-5, "{:e}", metrics.totals.energy_residual);
    let (hammer, casting) = (&metrics.hammers[0], &metrics.castings[0]);
    [
        hammer.first_impact_energy_j.unwrap(),
        hammer.first_impact_work_j.unwrap(),
        hammer.first_impact_casting_peak_velocity_m_s.unwrap(),
        casting.peak_velocity_m_s,
        casting.peak_point_velocity_m_s,
    ]
}

/// A casting 1e5 and 1e8 times stiffer than aluminium gives the outputs of the rigid one, and takes no more steps for it. Aluminium does not.
#[test]
fn a_stiff_casting_is_the_rigid_one() {
    let folder = TempDir::new().unwrap();
    let rigid = outcome(&study(""), folder.path());
    let steps = |outcome: &RowOutcome| outcome.counters.steps as f64;
    for stiffer in [1e5, 1e8] {
        write_block(70e9 * stiffer, folder.path());
        let stiff = outcome(&study(STRUCTURE), folder.path());
        for (found, expected) in figures(&stiff).into_iter().zip(figures(&rigid)) {
            println!("{stiffer:e}: {found} instead of {expected}: {:.1e}", found / expected - 1.0);
            assert!((found / expected - 1.0).abs() < 1e-6, "{stiffer:e}: {found} instead of {expected}");
        }
        assert!(steps(&stiff) < 1.2 * steps(&rigid), "{} and {}", steps(&stiff), steps(&rigid));
    }
    write_block(70e9, folder.path());
    let soft = figures(&outcome(&study(STRUCTURE), folder.path()));
    assert!((soft[0] / figures(&rigid)[0] - 1.0).abs() < 1e-4 && (soft[2] / figures(&rigid)[2] - 1.0).abs() > 1e-3);
}

/// Strain energy is an output of elastic castings alone; a stiff casting hardly strains.
#[test]
fn strain_energy_of_elastic_castings_alone() {
    let folder = TempDir::new().unwrap();
    let columns = |text: &str| {
        let columns = Columns::new(&engine(text, folder.path()).unwrap().info()).unwrap();
        let named = |table| columns.describe(table).into_iter().map(|column| column.name);
        let strain = named(TableName::Runs).chain(named(TableName::Blows)).filter(|name| name.contains("strain"));
        strain.collect::<Vec<_>>()
    };
    let peak = |young: f64| {
        write_block(young, folder.path());
        let outcome = outcome(&study(STRUCTURE), folder.path());
        let metrics = outcome.metrics.unwrap();
        let blows_j = metrics.blows.iter().map(|blow| blow.strain.as_ref().unwrap().casting_strain_energy_j);
        let [peak_j, last_j] = [metrics.elastic[0].peak_strain_energy_j, blows_j.fold(0.0, f64::max)];
        assert!(metrics.castings.len() == 1 && 0.0 < last_j && last_j < peak_j, "{last_j} {peak_j}");
        peak_j
    };
    let (soft, stiff) = (peak(70e9), peak(70e9 * 1e4));
    assert!(soft > 1e-3 && stiff < 1e-3 * soft, "{soft} {stiff}");
    assert_eq!(
        columns(&study(STRUCTURE)),
        [
            "part_peak_strain_energy_j",
            "part_peak_strain_energy_time_s",
            "part_first_impact_strain_energy_j",
            "part_periodic_strain_energy_mean_j",
            "casting_strain_energy_j"
        ]
    );
    assert!(columns(&study("")).is_empty());
    let rigid = outcome(&study(""), folder.path()).metrics.unwrap();
    assert!(rigid.elastic.is_empty() && rigid.blows.iter().all(|blow| blow.strain.is_none()));
}

/// Faults name the casting and the way out.
#[test]
fn faults_of_an_elastic_casting() {
    let folder = TempDir::new().unwrap();
    write_block(70e9, folder.path());
    let text = study(STRUCTURE);
    let reason = |text: &str| match engine(text, folder.path()) {
        Err(error) => error,
        Ok(engine) => engine.outcome(0).reason,
    };
    let heavy = reason(&text.replace("mass_kg = 1.0368", "mass_kg = 2.0"));
    assert!(heavy.contains("casting.part.mass_kg") && heavy.contains("1.0368 kg"), "{heavy}");
    let missing = reason(&text.replace("\"M.mtx\"", "\"N.mtx\""));
    assert!(missing.contains("there is no file") && missing.contains("N.mtx"), "{missing}");
    let bare = reason(&text.replace("nodes_file = \"nodes.csv\"\n", ""));
    assert!(bare.contains("casting.part.structure") && bare.contains("nodes_file"), "{bare}");
    let beside = reason(&text.replace("at_m = [0.03, 0.01, 0.01]", "at_m = [0.3, 0.0, 0.0]"));
    assert!(beside.contains("casting.part.structure") && beside.contains("larger radius"), "{beside}");
    let design = "[design]\nkind = \"full_factorial\"\n[design.factor.c]\npath = \"casting.part.structure.cutoff_hz\"\nvalues = [1000.0, 2000.0]\n";
    let driven = reason(&format!("{text}{design}"));
    assert!(driven.contains("shared by all rows"), "{driven}");
    let powers = text.replace(
        "supply_bar = 5.0\n",
        "supply_bar = 5.0\nparameters = { chisel = { casting_contact = { law = \"hertz\" } } }\n",
    );
    let hertz =
        reason(&powers.replace("cutoff_hz = 5000.0\n", "cutoff_hz = 5000.0\ncontact_includes_casting = false\n"));
    assert!(hertz.contains("contact_includes_casting = true"), "{hertz}");
}

/// The nodes of the area around a point with their weights, as a study has them.
fn area(point: BodyPoint) -> String {
    let settings = ElasticSettings { cutoff_hz: 5000.0, damping: Damping::Ratio(0.005), point_radius_m: 0.025 };
    let model = block(70e9);
    let nodes = model.order() / 3;
    let body = ElasticBody::new(model, settings).unwrap();
    let point = (point, DOWN);
    // Down is against z.
    let weights = (0..nodes).map(|node| (node + 1, -body.weight(&point, 3 * node + 2).unwrap()));
    let (nodes, weights): (Vec<usize>, Vec<f64>) = weights.filter(|(_, weight)| *weight != 0.0).unzip();
    format!("{{ nodes = {nodes:?}, weights = {weights:?} }}")
}

/// The study with strike point, fixtures, core and measuring point by locations, or by the nodes of their areas.
fn point_study(by_nodes: bool) -> String {
    let place = |keys: [&str; 2], location: &str, point: BodyPoint| match by_nodes {
        true => format!("{} = {}\n", keys[1], area(point)),
        false => format!("{} = {location}\n", keys[0]),
    };
    let surface = |x: f64, y: f64, side: Side| BodyPoint::Surface { at_m: [x, y, 0.0], axis: DOWN, side };
    let mut text = study(STRUCTURE);
    let strike = place(["strike_point_m", "strike_nodes"], "[0.01, 0.005]", surface(0.01, 0.005, Side::Struck));
    text = text.replace("supply_bar = 5.0\n", &format!("supply_bar = 5.0\n{strike}"));
    let measured = place(["measuring_point_m", "measuring_nodes"], "[0.03, -0.01]", surface(0.03, -0.01, Side::Held));
    text = text.replace("mass_kg = 1.0368\n", &format!("mass_kg = 1.0368\n{measured}"));
    let core = place(["at_m", "at_nodes"], "[0.03, 0.01, 0.01]", BodyPoint::Place([0.03, 0.01, 0.01]));
    text = text.replace("at_m = [0.03, 0.01, 0.01]\n", &core);
    let held = place(["at_m", "at_nodes"], "[0.06, 0.02]", surface(0.06, 0.02, Side::Held));
    text.replace("at_m = [0.06, 0.02]\n", &held)
}

/// A study whose points are the nodes of areas with the weights of these has the outputs of the study with the areas, bit by bit.
#[test]
fn nodes_with_the_weights_of_areas_give_the_same_outputs() {
    let folder = TempDir::new().unwrap();
    write_block(70e9, folder.path());
    let [areas, nodes] = [false, true].map(|by_nodes| outcome(&point_study(by_nodes), folder.path()).metrics.unwrap());
    assert_eq!(areas.castings, nodes.castings);
    assert_eq!(areas.hammers, nodes.hammers);
    assert!(areas.castings[0].peak_point_velocity_m_s > 0.0);
    // The places are the means of the nodes.
    let scene = engine(&point_study(true), folder.path()).unwrap().scene(0).unwrap().scene;
    let near = |found: &[f64], expected: &[f64]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14);
    let casting = &scene.castings[0];
    assert!(near(&scene.hammers[0].strike_point_m, &[0.01, 0.005]) && near(&casting.fixtures[3].at_m, &[0.06, 0.02]));
    assert!(
        near(&casting.cores[0].at_m[..2], &[0.03, 0.01]) && near(&casting.measuring_point_m.unwrap(), &[0.03, -0.01])
    );
    assert!((scene.hammers[0].strike_height_m - 0.02).abs() < 0.01, "{}", scene.hammers[0].strike_height_m);
}

/// Node 54 of 9 x 4 x 3 stands at (4, 1, 2): on the upper surface at x = 0, y = -0.01.
#[test]
fn points_that_are_nodes_and_their_faults() {
    let folder = TempDir::new().unwrap();
    write_block(70e9, folder.path());
    let strike = |keys: &str| study(STRUCTURE).replace("supply_bar = 5.0\n", &format!("supply_bar = 5.0\n{keys}\n"));
    let part = |keys: &str| study(STRUCTURE).replace("mass_kg = 1.0368\n", &format!("mass_kg = 1.0368\n{keys}\n"));
    let core = |keys: &str| study(STRUCTURE).replace("at_m = [0.03, 0.01, 0.01]", keys);
    let held = |keys: &str| study(STRUCTURE).replace("at_m = [0.06, 0.02]", keys);
    let engine = |text: &str| engine(text, folder.path());

    // One node of a solid mesh is a warning, more are none.
    let one = engine(&strike("strike_nodes = 54")).unwrap();
    let warnings: Vec<String> = one.checked().warnings().iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("study.toml:8:16") && warnings[0].contains("node 54 alone"), "{warnings:?}");
    let scene = one.scene(0).unwrap().scene;
    let [x, y] = scene.hammers[0].strike_point_m;
    assert!(x.abs() < 1e-12 && (y + 0.01).abs() < 1e-12 && (scene.hammers[0].strike_height_m - 0.02).abs() < 1e-12);
    for sound in [
        strike("strike_nodes = [54, 57]"),
        strike("strike_nodes = { nodes = [54, 57], weights = [1, 2.5] }"),
        core("at_nodes = 54"),
        held("at_nodes = [52]"),
        part("measuring_nodes = 52"),
    ] {
        let engine = engine(&sound).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(engine.checked().warnings(), []);
        assert!(engine.scene(0).is_ok());
    }

    for (text, words) in [
        (strike("strike_nodes = 999"), "`hammer.left.strike_nodes`: names node 999, which the model does not have"),
        (strike("strike_nodes = []"), "`hammer.left.strike_nodes`: needs at least one node"),
        (strike("strike_nodes = [54, 57, 54]"), "`hammer.left.strike_nodes`: has node 54 twice"),
        (strike("strike_nodes = { nodes = [54, 57], weights = [1] }"), "has 2 nodes but 1 weights"),
        (strike("strike_nodes = { nodes = [54, 57], weights = [1, 0] }"), "has the weight 0 of node 57"),
        (strike("strike_nodes = { nodes = [54, 57], weights = [1, -2] }"), "has the weight -2 of node 57"),
        (strike("strike_nodes = { nodes = [54] }"), "expected a node, a list of nodes, or `{ nodes ="),
        (strike("strike_nodes = \"54\""), "`hammer.left.strike_nodes`: is the text \"54\""),
        (strike("strike_nodes = 54\nstrike_point_m = [0.0, 0.0]"), "remove either `strike_nodes` or `strike_point_m`"),
        (strike("strike_nodes = 54\nstrike_height_m = 0.0"), "remove either `strike_nodes` or `strike_height_m`"),
        (core("at_nodes = 54\nat_m = [0.0, 0.0, 0.0]"), "`casting.part.core.top.at_nodes`: the nodes are the location"),
        (core("at_nodes = 0"), "`casting.part.core.top.at_nodes`: names node 0"),
        (held("at_nodes = 54\nheight_m = 0.1"), "`casting.part.fixture.d.at_nodes`: the nodes are the location"),
        (held("at_nodes = [54, 999]"), "`casting.part.fixture.d.at_nodes`: names node 999"),
        (part("measuring_nodes = 999"), "`casting.part.measuring_nodes`: names node 999"),
        (part("measuring_nodes = 54\nmeasuring_point_m = [0.0, 0.0]"), "remove either `measuring_nodes` or"),
        (strike("strike_nodes = 54").replace(STRUCTURE, ""), "`hammer.left.strike_nodes`: casting `part` is rigid"),
        (core("at_nodes = 54").replace(STRUCTURE, ""), "`casting.part.core.top.at_nodes`: casting `part` is rigid"),
        (
            strike("strike_nodes = 54").replace("geometry = \"as_given\"\n", ""),
            "`hammer.left.strike_nodes`: hammer `left` strikes downwards from",
        ),
    ] {
        let found = match engine(&text) {
            Err(error) => error,
            Ok(engine) => engine.scene(0).err().unwrap_or_else(|| panic!("a scene, but expected: {words}")).reason,
        };
        assert!(found.contains(words), "{found}\nexpected: {words}");
    }
}

/// A factor chooses among nodes.
#[test]
fn a_factor_drives_the_struck_node() {
    let folder = TempDir::new().unwrap();
    write_block(70e9, folder.path());
    let design = "[design]\nkind = \"full_factorial\"\n[design.factor.node]\npath = \"hammer.left.strike_nodes\"\nvalues = [54, 57]\n";
    let engine =
        engine(&format!("{}{design}", study(STRUCTURE)), folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let y = [0, 1].map(|row| engine.scene(row).unwrap().scene.hammers[0].strike_point_m[1]);
    assert!((y[0] + 0.01).abs() < 1e-12 && (y[1] - 0.01).abs() < 1e-12, "{y:?}");
}
