//! Fixtures that push and never pull: the casting lifts off and lands again.

use crate::common::harness::assert_relative;
use crate::common::scenes::{castings_only, heave_velocity, shapes, simulate};
use std::f64::consts::PI;

use decore_model::metrics::RunMetrics;
use decore_model::run::{RowStatus, run_row};
use decore_model::scene::{FixtureId, Owner};
use decore_model::system::{Coupled, InterfaceModes, build};
use decore_model::workpiece::{Casting, Fixture};
use decore_study::engine::Engine;

const MASS_KG: f64 = 12.28;
const STIFFNESS_N_PER_M: f64 = 1.2e8;
const REST_N: f64 = 4000.0;
const OWNER: Owner = Owner::Fixture(FixtureId { casting: 0, fixture: 0, axis: 0 });

/// A casting on an undamped one-sided support of a rigid machine, given an impulse towards the support. Returns the times at
/// which it lifts off and lands.
fn struck(impulse_n_s: f64, end_s: f64) -> Vec<f64> {
    let pad =
        Fixture { stiffness_n_per_m: STIFFNESS_N_PER_M, damping_n_s_per_m: 0.0, one_sided: true, ..Fixture::default() };
    let clamp = Fixture { clamp_force_n: REST_N, ..Fixture::default() };
    let casting = Casting { name: "part".into(), mass_kg: MASS_KG, fixtures: vec![pad, clamp], ..Casting::default() };
    let modes = InterfaceModes {
        omega_rad_s: Vec::new(),
        damping_ratio: Vec::new(),
        shapes: shapes([], [Vec::new(), Vec::new()]),
    };
    let model = build(&castings_only(vec![casting]), &modes).expect("sound");
    let velocity = heave_velocity(&model, 0);
    let mut y0 = model.initial_state().to_vec();
    y0[velocity] = impulse_n_s / MASS_KG;
    let contact = model.elements().contact_of(OWNER).expect("a contact");
    assert!(Coupled::new(&model).is_closed(contact));
    let run = simulate(&model, &y0, (1e-8, 1e-3), end_s);
    run.events.iter().filter(|event| event.guard == contact).map(|event| event.t).collect()
}

/// It separates above the impulse `P sqrt(m / k)`. Then it leaves with `v^2 = (J/m)^2 - P^2/(k m)` and flies under its load for `2 v m / P`.
#[test]
fn analytic_lift_off() {
    let omega = (STIFFNESS_N_PER_M / MASS_KG).sqrt();
    let least = REST_N / omega;
    assert_relative("impulse", least, 1.280, 5e-4);
    assert!(struck(0.99 * least, 0.05).is_empty());
    for factor in [1.01, 1.5, 4.0_f64] {
        let off_s = (PI + (1.0 / factor).asin()) / omega;
        let speed = (factor * factor - 1.0).sqrt() * least / MASS_KG;
        let on_s = off_s + 2.0 * speed * MASS_KG / REST_N;
        let [off, on] = struck(factor * least, 0.5 * (off_s + on_s) + 0.5 * (on_s - off_s) * 1.01)[..] else {
            panic!("{factor}: not off and on once");
        };
        assert_relative("lift-off", off, off_s, 1e-6);
        assert_relative("landing", on, on_s, 1e-6);
    }
}

/// The paper's rig on its own fixture, or on a pad with a clamp of constant force.
fn rig(clamp_n: Option<f64>) -> RunMetrics {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let engine = Engine::load(&path, &["duration_s=0.3".to_owned()]).unwrap();
    let mut scene = engine.scene(0).unwrap().scene;
    if let Some(clamp_force_n) = clamp_n {
        let fixtures = &mut scene.castings[0].fixtures;
        let clamp = Fixture { clamp_force_n, ..fixtures[0].clone() };
        fixtures[0].one_sided = true;
        fixtures.push(clamp);
    }
    assert_eq!(scene.validate(), []);
    let outcome = run_row(&scene, &engine.modes(&scene).unwrap());
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome.metrics.unwrap()
}

/// A support so loaded that the casting never lifts off does what the spring does, within `bound`; one that it leaves keeps the books.
pub(crate) fn assert_supports([spring, loaded, light]: [RunMetrics; 3], bound: f64) {
    let figures = |metrics: &RunMetrics| {
        let (hammer, casting) = (&metrics.hammers[0], &metrics.castings[0]);
        [
            hammer.first_impact_energy_j.unwrap(),
            hammer.first_impact_work_j.unwrap(),
            casting.peak_velocity_m_s,
            casting.fixture_damper_loss_j,
            casting.structure_work_j,
        ]
    };
    for (found, expected) in figures(&loaded).into_iter().zip(figures(&spring)) {
        assert_relative("loaded", found, expected, bound);
    }
    assert!((figures(&light)[3] / figures(&spring)[3] - 1.0).abs() > 0.01, "it never left its support");
    assert!(light.pads[0].lift_off_count > 0);
    for metrics in [spring, loaded, light] {
        assert!(metrics.totals.energy_residual.abs() < 1e-4, "{:e}", metrics.totals.energy_residual);
    }
}

#[test]
fn a_loaded_support_is_a_spring() {
    assert_supports([None, Some(1e6), Some(50.0)].map(rig), 1e-4);
}

/// Three one-sided supports share a weight by the law of the lever, whatever their stiffness; four share it without pulling. A casting whose centre is not between its supports has no rest.
#[test]
fn analytic_shares_of_weight() {
    let at = |at_m: [f64; 2], stiffness_n_per_m: f64| Fixture {
        at_m,
        stiffness_n_per_m,
        one_sided: true,
        ..Fixture::default()
    };
    let rest = |places: &[[f64; 2]]| {
        let fixtures: Vec<Fixture> =
            places.iter().enumerate().map(|(i, place)| at(*place, 1e7 * (i + 1) as f64)).collect();
        let modes = InterfaceModes {
            omega_rad_s: Vec::new(),
            damping_ratio: Vec::new(),
            shapes: shapes([], vec![Vec::new(); fixtures.len()]),
        };
        let casting = Casting {
            name: "part".into(),
            mass_kg: MASS_KG,
            inertia_kg_m2: Some([0.1, 0.2]),
            fixtures,
            ..Casting::default()
        };
        let mut scene = castings_only(vec![casting]);
        scene.environment.gravity_m_s2 = 9.80665;
        build(&scene, &modes)
    };
    let forces = |places: &[[f64; 2]]| -> Vec<f64> {
        rest(places).expect("at rest").elements().contacts().iter().map(|contact| contact.rest_force_n).collect()
    };
    let weight = MASS_KG * 9.80665;
    // About the line of the first two: the third carries 0.1 / 0.3 of it; these carry the rest by their distances.
    let three = [[-0.1, -0.1], [0.2, -0.1], [0.0, 0.2]];
    let third = weight / 3.0;
    let second = (weight - third) / 3.0;
    for (found, expected) in forces(&three).into_iter().zip([weight - third - second, second, third]) {
        assert_relative("force", found, expected, 1e-12);
    }
    assert!(rest(&[[0.1, -0.1], [0.2, -0.1], [0.15, 0.2]]).unwrap_err().to_string().contains("tip it off"));
    // Two pairs of pads on one side: rounding must not let the casting rest there.
    for y in [0.02, 0.05, 0.08, 0.1, 0.12] {
        let beside = [[-0.06, y], [-0.06, 0.18], [0.06, y], [0.06, 0.18]];
        assert!(rest(&beside).is_err(), "{y}: it rests with its centre beside all pads");
    }
    let four = forces(&[[-0.1, -0.1], [0.2, -0.1], [0.0, 0.2], [-0.1, 0.1]]);
    assert_relative("sum", four.iter().sum(), weight, 1e-12);
    assert!(four.iter().all(|force| *force >= 0.0), "{four:?}");
}
