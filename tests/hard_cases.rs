//! Scenes that break integrators: each must end as stated, with every number finite and every joule accounted for.

use decore::run::{Machine, RowOutcome, RowStatus, SourceModel, run_row};
use decore::scene::Scene;
use decore::study::Study;
use decore::workpiece::Inertia;

/// The energy audit of every hard case.
const RESIDUAL: f64 = 1e-3;

struct Rig {
    machine: Machine,
    scene: Scene,
}

/// The paper's rig with the guide tied to its mount and the given settings.
fn rig(settings: &[&str]) -> Rig {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let mut all = vec!["solver.guide=tied".to_owned(), "duration_s=0.5".to_owned()];
    all.extend(settings.iter().map(|setting| (*setting).to_owned()));
    let study = Study::load(&path).unwrap().with_overrides(&all).unwrap();
    let model = SourceModel::read(study.structure()).unwrap();
    let points = model.points();
    let machine = Machine::new(model, study.structure(), &study.interface_demand()).unwrap();
    let scene = study.scene(0, &points).unwrap();
    Rig { machine, scene }
}

fn run(rig: &Rig) -> RowOutcome {
    run_row(&rig.scene, &rig.machine.modes(&rig.scene).unwrap())
}

/// Runs the rig to its end; holds it to the energy audit and to finite numbers.
fn completes(settings: &[&str]) -> RowOutcome {
    sound(run(&rig(settings)), settings)
}

fn sound(outcome: RowOutcome, case: &[&str]) -> RowOutcome {
    assert_eq!(outcome.status, RowStatus::Done, "{case:?}: {}", outcome.reason);
    let metrics = outcome.metrics.as_ref().unwrap();
    assert!(metrics.energy_residual.abs() < RESIDUAL, "{case:?}: residual {:e}", metrics.energy_residual);
    // JSON has no NaN: it would be null, and no number of a casting or blow may be missing.
    for part in [serde_json::to_string(&metrics.castings), serde_json::to_string(&metrics.blows)] {
        let text = part.unwrap().replace("\"measuring_point_peak_velocity_m_s\":null", "");
        assert!(!text.contains("null"), "{case:?}: {text}");
    }
    outcome
}

fn first_energy(outcome: &RowOutcome) -> Option<f64> {
    outcome.metrics.as_ref().unwrap().hammers[0].first_impact_energy_j
}

const CONTACT: &str = "hammer.hammer.parameters.chisel.casting_contact.stiffness_n_per_m";

#[test]
fn contact_stiffness_over_five_decades() {
    for stiffness in ["1e7", "1e8", "1e9", "1e10"] {
        let setting = format!("{CONTACT}={stiffness}");
        let energy = first_energy(&completes(&[&setting])).unwrap();
        assert!(
            (energy / 69.903 - 1.0).abs() < 1e-4,
            "{setting}: {energy}: the approach does not depend on the contact"
        );
    }
    // A hundred thousand bounces: the casting rattles between chisel and fixture. Long enough for the first blow only.
    let energy = first_energy(&completes(&[&format!("{CONTACT}=1e12"), "duration_s=0.06"])).unwrap();
    assert!((energy / 69.903 - 1.0).abs() < 1e-4);
}

#[test]
fn spool_of_one_gram() {
    completes(&["hammer.hammer.parameters.valve.mass_kg=0.001", "duration_s=0.2"]);
}

#[test]
fn zero_standoff_strikes_at_once_and_without_energy() {
    let outcome = completes(&["hammer.hammer.standoff_m=0"]);
    assert!(first_energy(&outcome).unwrap() < 1e-6);
    assert!(outcome.metrics.unwrap().hammers[0].periodic_blow_count > 5);
}

#[test]
fn grazing_contact_is_found_or_not_but_harmless() {
    // The chisel's reach at 0.5 bar lies between these standoffs: it just touches or just misses.
    for standoff in ["0.030", "0.0301", "0.0302", "0.0303", "0.0304", "0.0305"] {
        completes(&["hammer.hammer.supply_bar=0.5", &format!("hammer.hammer.standoff_m={standoff}")]);
    }
}

#[test]
fn supply_from_nothing_to_twenty_bar() {
    for (bar, strikes) in [("0", false), ("0.1", false), ("1", true), ("10", true), ("20", true)] {
        let outcome = completes(&[&format!("hammer.hammer.supply_bar={bar}")]);
        assert_eq!(first_energy(&outcome).is_some(), strikes, "{bar} bar");
    }
}

#[test]
fn end_of_stroke_without_a_casting_in_reach() {
    let outcome = completes(&["hammer.hammer.standoff_m=0.2"]);
    let hammer = &outcome.metrics.unwrap().hammers[0];
    assert_eq!(hammer.contact_count, 0);
    assert_eq!(hammer.first_impact_time_s, None);
    assert_eq!(hammer.hit_frequency_hz, None);
    assert!(hammer.arm_rms_extension_m_s.unwrap() > 0.0);
}

#[test]
fn rear_chamber_without_clearance_ends_with_a_reason_or_completes() {
    let outcome = run(&rig(&["hammer.hammer.parameters.piston.rear_clearance_m=1e-7"]));
    match outcome.status {
        RowStatus::Done => drop(sound(outcome, &["rear_clearance_m=1e-7"])),
        RowStatus::Diverged => assert!(outcome.reason.contains("chamber"), "{}", outcome.reason),
        status => panic!("{status:?}: {}", outcome.reason),
    }
}

#[test]
fn castings_from_a_tenth_to_ten_times_the_mass() {
    for mass in ["0.0517", "5.17"] {
        completes(&[&format!("casting.part.mass_kg={mass}")]);
    }
}

#[test]
fn undamped_structure_and_all_its_modes() {
    completes(&["structure.damping_ratio=0"]);
    let outcome = completes(&["structure.cutoff_hz=5e4", "duration_s=0.2"]);
    assert!(outcome.modes > 150, "{} modes", outcome.modes);
}

#[test]
fn equal_pressures_and_sticking_for_seconds() {
    // Nothing ever moves: chambers stay at ambient pressure, the seal sticks.
    let outcome = completes(&["hammer.hammer.supply_bar=0", "duration_s=5"]);
    assert_eq!(outcome.metrics.unwrap().hammers[0].contact_count, 0);
}

#[test]
fn many_hammers_firing_at_the_same_instant() {
    for count in [2, 8, 16] {
        let mut rig = rig(&["duration_s=0.12"]);
        let unit = rig.scene.hammers[0].clone();
        rig.scene.hammers = (0..count)
            .map(|index| {
                let mut unit = unit.clone();
                unit.name = format!("hammer{index}");
                unit.strike_point_m = [0.0, 0.02 * (index as f64 - 0.5 * (count - 1) as f64)];
                unit
            })
            .collect();
        let casting = &mut rig.scene.castings[0];
        casting.mass_kg = 5.0 * count as f64;
        casting.inertia = Some(Inertia { x_kg_m2: 0.1 * count as f64, y_kg_m2: 0.1 * count as f64 });
        let fixture = casting.fixtures[0].clone();
        casting.fixtures = [-0.1, 0.1].map(|y| decore::workpiece::Fixture { at_m: [0.0, y], ..fixture.clone() }).into();
        let outcome = sound(run(&rig), &["many hammers"]);
        let metrics = outcome.metrics.unwrap();
        let times: Vec<f64> = metrics.hammers.iter().map(|hammer| hammer.first_impact_time_s.unwrap()).collect();
        // Mirror images across the centre strike at the same instant.
        for (left, right) in times.iter().zip(times.iter().rev()) {
            assert!((left - right).abs() < 1e-6, "{count} hammers: {times:?}");
        }
    }
}

#[test]
fn a_minute_of_hammering_stays_on_its_orbit() {
    let outcome = completes(&["duration_s=20"]);
    let hammer = &outcome.metrics.unwrap().hammers[0];
    assert!((hammer.hit_frequency_hz.unwrap() / 21.954 - 1.0).abs() < 1e-4);
    assert!((hammer.periodic_energy_mean_j.unwrap() / 12.339 - 1.0).abs() < 1e-4);
}

#[test]
fn budgets_end_a_row_with_its_reason() {
    let outcome = run(&rig(&["solver.max_steps=1000"]));
    assert_eq!(outcome.status, RowStatus::BudgetExhausted);
    assert!(outcome.reason.contains("solver.max_steps"), "{}", outcome.reason);
    assert!(outcome.time_reached_s > 0.0 && outcome.metrics.is_none());
    let outcome = run(&rig(&["solver.max_wall_time_s=0.001"]));
    assert_eq!(outcome.status, RowStatus::BudgetExhausted);
    assert!(outcome.reason.contains("wall time"), "{}", outcome.reason);
}
