//! Sideways motion: springs across a fixture's axis, friction of pads in their plane, hammers that do not strike downwards.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::common::harness::{assert_relative, observe, settings};
use crate::common::scenes::castings_only;
use decore_model::metrics::{FixtureMetrics, Recorder};
use decore_model::run::{RowStatus, run_row};
use decore_model::scene::{FixtureId, HammerUnit, PointId, Scene};
use decore_model::system::{Coupled, InterfaceModes, build};
use decore_model::workpiece::{Casting, Fixture};
use decore_study::engine::Engine;

const MASS_KG: f64 = 12.28;
const GRAVITY_M_S2: f64 = 9.80665;
const X: [f64; 3] = [1.0, 0.0, 0.0];

/// Four pads at the corners of a casting, at the height of its centre.
fn pads(pad: &Fixture) -> Vec<Fixture> {
    [[-0.1, -0.1], [0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]].map(|at_m| Fixture { at_m, ..pad.clone() }).to_vec()
}

/// A casting on a rigid machine, measured along x, and no hammer.
fn scene(fixtures: Vec<Fixture>) -> (Scene, InterfaceModes) {
    let held = fixtures.iter().enumerate().flat_map(|(fixture, of)| {
        of.held_axes().map(move |axis| PointId::Support(FixtureId { casting: 0, fixture, axis }))
    });
    let shapes: BTreeMap<PointId, Vec<f64>> = held.map(|point| (point, Vec::new())).collect();
    let casting = Casting {
        name: "part".into(),
        mass_kg: MASS_KG,
        inertia_kg_m2: Some([0.1, 0.2]),
        inertia_z_kg_m2: Some(0.25),
        measuring_axis: Some(X),
        fixtures,
        ..Casting::default()
    };
    let mut scene = castings_only(vec![casting]);
    scene.environment.gravity_m_s2 = GRAVITY_M_S2;
    (scene, InterfaceModes { omega_rad_s: Vec::new(), damping_ratio: Vec::new(), shapes })
}

/// Displacement along x and velocity at the end of a run that begins with a velocity along x, the share of the energy that the books miss,
/// and the outputs of the fixtures.
fn moved(fixtures: Vec<Fixture>, speed_m_s: f64, end_s: f64) -> ([f64; 3], Vec<FixtureMetrics>) {
    let (mut scene, modes) = scene(fixtures);
    scene.outputs.fixture_energy = true;
    assert_eq!(scene.validate(), []);
    let model = build(&scene, &modes).expect("sound");
    let centre = PointId::Centre { casting: 0 };
    let [_, velocity] = model.point_sums(centre).expect("a rigid casting");
    let mut y0 = model.initial_state().to_vec();
    y0[velocity[0].0] = speed_m_s * velocity[0].1;
    let (mut system, mut recorder) = (Coupled::new(&model), Recorder::new(&model, &scene));
    let run = observe(&mut system, &y0, settings(1e-9, 1e-3), end_s, &mut recorder);
    let (displacement, velocity) = system.motion(centre, end_s, &run.y);
    let energy = |y: &[f64]| system.stored_energy(end_s, y) + system.dissipated_energy(end_s, y);
    let missing = (energy(&run.y) - energy(&y0)) / (0.5 * MASS_KG * speed_m_s * speed_m_s);
    ([displacement, velocity, missing], recorder.finish(&system, end_s, &run.y).fixtures)
}

/// Springs across the axes let a casting swing along x with `omega^2 = sum k / m`, and damp it by `sum c / (2 m)`.
#[test]
fn analytic_sideways_oscillation() {
    let (stiffness, damping) = (3e5, 40.0);
    let fixture = Fixture {
        lateral_stiffness_n_per_m: [stiffness, 0.0],
        lateral_damping_n_s_per_m: [damping, 0.0],
        ..Fixture::default()
    };
    let decay = 4.0 * damping / (2.0 * MASS_KG);
    let omega = (4.0 * stiffness / MASS_KG - decay * decay).sqrt();
    let end_s = 2.25 * 2.0 * PI / omega;
    let ([displacement, velocity, missing], _) = moved(pads(&fixture), 1.5, end_s);
    let expected = 1.5 / omega * (-decay * end_s).exp();
    assert_relative("displacement", displacement, expected, 1e-6);
    assert_relative("velocity", velocity, -decay * expected, 1e-5);
    assert!(missing.abs() < 1e-8, "{missing:e}");
}

/// A block on pads slides `v^2 / (2 mu g)` and stops, whatever the stiffness of the pads; without friction it would slide on.
#[test]
fn analytic_sliding_block() {
    for (friction, speed_m_s) in [(0.3, 1.0), (0.05, 0.4), (0.8, 2.0)] {
        let pad = Fixture { one_sided: true, friction, friction_speed_m_s: 1e-4, ..Fixture::default() };
        let distance = speed_m_s * speed_m_s / (2.0 * friction * GRAVITY_M_S2);
        let end_s = 1.5 * speed_m_s / (friction * GRAVITY_M_S2);
        let ([displacement, velocity, missing], of_pads) = moved(pads(&pad), speed_m_s, end_s);
        println!("{friction}: slid {displacement} m, expected {distance} m, still {velocity:.1e} m/s");
        assert_relative("distance", displacement, distance, 1e-4);
        assert!(velocity.abs() < 1e-9 && missing.abs() < 1e-7, "{velocity:e} {missing:e}");
        // Each pad bears a quarter of the weight.
        for pad in of_pads {
            assert_relative("slip", pad.slip_m, distance, 1e-4);
            assert_relative("loss", pad.damper_loss_j, 0.125 * MASS_KG * speed_m_s * speed_m_s, 1e-6);
            assert_eq!(pad.structure_work_j, 0.0);
        }
    }
}

/// Gravity along the pads needs sideways stiffness: friction alone would creep. With it, the pads bear the share along their axes.
#[test]
fn a_tilted_casting_needs_sideways_stiffness() {
    let tilted = |pad: &Fixture| {
        let (mut scene, modes) = scene(pads(pad));
        scene.environment.gravity_axis = [0.6, 0.0, -0.8];
        build(&scene, &modes)
    };
    let pad = Fixture { one_sided: true, friction: 0.9, ..Fixture::default() };
    let reason = tilted(&pad).unwrap_err().to_string();
    assert!(reason.contains("only the friction of its pads"), "{reason}");
    let held = tilted(&Fixture { lateral_stiffness_n_per_m: [1e6; 2], ..pad.clone() }).unwrap();
    let forces: f64 = held.elements().contacts().iter().map(|contact| contact.rest_force_n).sum();
    assert_relative("weight on the pads", forces, 0.8 * MASS_KG * GRAVITY_M_S2, 1e-12);
    // Only pads have friction.
    let (scene, _) = scene(vec![Fixture { friction: 0.5, ..Fixture::default() }]);
    let problems = scene.validate();
    assert!(problems.iter().any(|problem| problem.path.ends_with("friction")), "{problems:?}");
}

/// Energy of the first impact of the paper's hammer against the angle of its strike from straight down.
fn first_impact_j(degrees: f64) -> f64 {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let (sin, cos) = degrees.to_radians().sin_cos();
    let settings = [
        "duration_s=0.1".to_owned(),
        "solver.tolerance=1e-7".to_owned(),
        "geometry=\"as_given\"".to_owned(),
        format!("environment.gravity_axis=[{sin},0.0,{}]", -cos),
    ];
    let engine = Engine::load(&path, &settings).unwrap();
    let scene = engine.scene(0).unwrap().scene;
    let outcome = run_row(&scene, &engine.modes(&scene).unwrap());
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    let metrics = outcome.metrics.unwrap();
    assert!(metrics.totals.energy_residual.abs() < 1e-5, "{:e}", metrics.totals.energy_residual);
    metrics.hammers[0].first_impact_energy_j.unwrap()
}

/// Gravity helps a hammer that strikes downwards in proportion to the cosine of its angle, by no more than the work on all that moves, and
/// hinders one that strikes upwards.
#[test]
fn gravity_counts_along_the_strike() {
    let [down, slanted, level, up] = [0.0, 60.0, 90.0, 180.0].map(first_impact_j);
    println!("{down} J, {slanted} J, {level} J, {up} J");
    let unit = HammerUnit::default();
    let p = &unit.parameters;
    let mass_kg = p.telescope.cylinder_mass_kg + p.valve.mass_kg + p.piston.mass_kg + p.chisel.mass_kg;
    let work = mass_kg * GRAVITY_M_S2 * unit.standoff_m;
    assert!(down - level > 0.5 * work && down - level < work, "{} and {work}", down - level);
    assert_relative("half of it", down - slanted, 0.5 * (down - level), 0.03);
    assert!(up < level, "{up} and {level}");
}

/// A slanted strike pushes a casting off its pad, unless something holds it sideways.
#[test]
fn a_casting_that_slides_away_is_invalid() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let run = |more: &[&str]| {
        let centre = ["hammer.hammer.strike_point_m=[0.0,0.0]", "hammer.hammer.strike_height_m=0.0"];
        let settings = ["duration_s=0.1", "geometry=\"as_given\"", "hammer.hammer.strike_axis=[0.3,0.0,-1.0]"];
        let fixture = ["casting.part.fixture.table.one_sided=true", "casting.part.fixture.table.friction=0.1"];
        let settings = [&settings[..], &centre, &fixture, more].concat();
        let engine = Engine::load(&path, &settings.iter().map(|one| (*one).to_owned()).collect::<Vec<_>>()).unwrap();
        let scene = engine.scene(0).unwrap().scene;
        run_row(&scene, &engine.modes(&scene).unwrap())
    };
    let slid = run(&[]);
    assert!(slid.status == RowStatus::Invalid && slid.reason.contains("slid by"), "{:?}: {}", slid.status, slid.reason);
    let held = run(&["casting.part.fixture.table.lateral_stiffness_n_per_m=[1e6,1e6]"]);
    assert_eq!(held.status, RowStatus::Done, "{}", held.reason);
}
