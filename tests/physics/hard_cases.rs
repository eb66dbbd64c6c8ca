//! Scenes that break integrators: each must end as stated, with every number finite and every joule accounted for.

use decore_model::hammer::body;
use decore_model::integrate::{Observer, Step};
use decore_model::run::{RowOutcome, RowStatus, run_row, run_row_observed};
use decore_model::scene::{PointId, Scene};
use decore_model::system::{Coupled, InterfaceModes};
use decore_study::engine::Engine;

/// The energy audit of every hard case.
const RESIDUAL: f64 = 1e-3;

struct Rig {
    engine: Engine,
    scene: Scene,
}

/// The paper's rig with the guide tied to its mount and the given settings.
fn rig(settings: &[&str]) -> Rig {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/paper_rig.toml");
    let mut all = vec!["solver.guide=tied".to_owned(), "duration_s=0.5".to_owned()];
    all.extend(settings.iter().map(|setting| (*setting).to_owned()));
    let engine = Engine::load(&path, &all).unwrap();
    let scene = engine.scene(0).unwrap().scene;
    Rig { engine, scene }
}

fn run(rig: &Rig) -> RowOutcome {
    run_row(&rig.scene, &rig.engine.modes(&rig.scene).unwrap())
}

/// Runs the rig to its end; holds it to the energy audit and to finite numbers.
fn completes(settings: &[&str]) -> RowOutcome {
    sound(run(&rig(settings)), settings)
}

fn sound(outcome: RowOutcome, case: &[&str]) -> RowOutcome {
    assert_eq!(outcome.status, RowStatus::Done, "{case:?}: {}", outcome.reason);
    let metrics = outcome.metrics.as_ref().unwrap();
    assert!(metrics.totals.energy_residual.abs() < RESIDUAL, "{case:?}: residual {:e}", metrics.totals.energy_residual);
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
    // The stroke begins with the supply at 2 ms; the chisel hangs a few hundredths of a micrometre off the casting then.
    let hammer = &outcome.metrics.as_ref().unwrap().hammers[0];
    assert!(first_energy(&outcome).unwrap() < 1e-2 && hammer.first_impact_time_s.unwrap() < 0.004);
    assert!(outcome.metrics.unwrap().hammers[0].struck_blow_count > 5);
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

/// Off: the telescope retracts and the percussion dies down. On again: the hammer starts anew and strikes as before.
#[test]
fn supply_that_switches_off_and_on() {
    let outcome = completes(&["hammer.hammer.supply_switch_times_s=[0.5, 0.8]", "duration_s=1.5"]);
    let metrics = outcome.metrics.unwrap();
    let energies = |from: f64, to: f64| -> Vec<f64> {
        let within = metrics.blows.iter().filter(|blow| blow.start_time_s > from && blow.start_time_s < to);
        within.map(|blow| blow.energy_j).collect()
    };
    // Steady before; at most the blow that was under way and bounces of the piston while the supply is off.
    let (before, off, after) = (energies(0.35, 0.5), energies(0.6, 0.8), energies(1.1, 1.5));
    println!("{before:?} {off:?} {after:?}");
    assert!(before.len() >= 3 && before.iter().all(|energy| (energy / 12.34 - 1.0).abs() < 0.01), "{before:?}");
    assert!(off.iter().all(|energy| *energy < 1.0), "{off:?}");
    assert!(after.len() >= 5 && after.iter().all(|energy| (energy / 12.34 - 1.0).abs() < 0.02), "{after:?}");
    // Switched faster than anything moves, before the first contact and after the end.
    completes(&["hammer.hammer.supply_switch_times_s=[0.0030, 0.0031, 0.1, 0.2, 7.0]"]);
}

/// Switched off here, the hammer meets its soft top stop faster than that can hold it, as the model has it; the reason says what would.
#[test]
fn a_hammer_that_its_top_stop_does_not_hold_says_what_would() {
    let off = ["hammer.hammer.supply_switch_times_s=[0.8]", "duration_s=1.5"];
    let outcome = run(&rig(&off));
    assert_eq!(outcome.status, RowStatus::Diverged);
    assert!(outcome.reason.contains("a larger `telescope.top_stop.stiffness_n_per_m`"), "{}", outcome.reason);
    completes(&[off[0], off[1], "hammer.hammer.parameters.telescope.top_stop.stiffness_n_per_m=1e5"]);
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

/// The chisel rests on the casting for seconds, the gate shut: the top chamber fills until its pressure is the supply's and
/// stays there, on the square-root singularity of the flow.
#[test]
fn equal_pressures_for_seconds() {
    let outcome = completes(&["hammer.hammer.gate_delay_s=100", "duration_s=5"]);
    let hammer = &outcome.metrics.as_ref().unwrap().hammers[0];
    assert!((hammer.first_impact_energy_j.unwrap() / 69.903 - 1.0).abs() < 1e-4);
    assert_eq!((hammer.struck_blow_count, hammer.blank_blow_count), (0, 0));
    // Twice the time costs no second singularity: what remains are steps of the chisel at rest between nose and casting.
    let longer = completes(&["hammer.hammer.gate_delay_s=100", "duration_s=10"]);
    println!("{} and {} steps", outcome.counters.steps, longer.counters.steps);
    assert!(longer.counters.steps < 3 * outcome.counters.steps);
    let air = |outcome: &RowOutcome| outcome.metrics.as_ref().unwrap().hammers[0].air_used_nl;
    println!("{} {}", air(&longer), air(&outcome));
    assert!((air(&longer) / air(&outcome) - 1.0).abs() < 1e-4, "no flow between equal pressures");
}

/// A seal that holds more than the gas can push. The friction is a smooth function of the speed, so what ought to stick
/// creeps: the model is not valid for holding, and the speed at which it creeps says how far off it is, `v_s artanh(F / f_s)`.
#[test]
fn sticking_for_seconds_creeps_at_the_speed_of_the_regularisation() {
    let friction = "hammer.hammer.parameters.telescope.friction_static_n=2000";
    for velocity in [1e-2, 1e-3] {
        let setting = format!("hammer.hammer.parameters.telescope.friction_velocity_m_s={velocity}");
        let rig = rig(&[friction, &setting, "duration_s=4", "hammer.hammer.standoff_m=0.1"]);
        let (outcome, log) =
            run_row_observed(&rig.scene, &rig.engine.modes(&rig.scene).unwrap(), |_| Extension::default());
        let (outcome, log) = (sound(outcome, &["stick"]), log.unwrap());
        let speed = (log.last.1 - log.middle.1) / (log.last.0 - log.middle.0);
        println!("{velocity}: {speed} m/s, {} steps", outcome.counters.steps);
        // Gas on the bore against spring, weight and what the annulus holds back: between 40 and 70 % of the friction.
        assert!(speed > 0.4 * velocity && speed < 0.9 * velocity, "{speed} m/s at v_s = {velocity}");
        assert_eq!(outcome.metrics.unwrap().hammers[0].contact_count, 0);
    }
}

/// Extension of the telescope at half the time and at the end.
#[derive(Default)]
struct Extension {
    middle: (f64, f64),
    last: (f64, f64),
}

impl Observer<Coupled> for Extension {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let mut y = vec![0.0; step.dimension()];
        step.write_end(&mut y);
        let state = system.hammer_state(0, step.t1(), &y);
        self.last = (step.t1(), state.position[body::CYLINDER] - state.position[body::GUIDE]);
        if self.middle.0 < 2.0 {
            self.middle = self.last;
        }
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

/// A machine that floats: one rigid motion of two tonnes, modes and all. Forces within the rig cancel, so the machine swings
/// about where it is and does not drift away: what moves up as a whole is what the hammer moves down.
#[test]
fn a_free_floating_structure_hammers_and_keeps_its_momentum() {
    for treatment in ["integrated", "condensed"] {
        floating_structure(treatment);
    }
}

fn floating_structure(treatment: &str) {
    let rig = rig(&["duration_s=1.5", &format!("solver.modes={treatment}")]);
    let held = rig.engine.modes(&rig.scene).unwrap();
    let shape: f64 = 1.0 / 2000.0_f64.sqrt();
    let mut modes = InterfaceModes::clone(&held);
    modes.omega_rad_s.insert(0, 0.0);
    modes.damping_ratio.insert(0, 0.0);
    modes.shapes.values_mut().for_each(|row| row.insert(0, shape));
    sound(run_row(&rig.scene, &modes), &["floating, flexible"]);
    // The rigid motion alone: momentum of hammer, casting and machine together is nothing at all times.
    modes.omega_rad_s.truncate(1);
    modes.damping_ratio.truncate(1);
    modes.shapes.values_mut().for_each(|row| row.truncate(1));
    let (outcome, log) = run_row_observed(&rig.scene, &modes, |_| Momentum { largest: 0.0, shape });
    sound(outcome, &["floating, rigid"]);
    let largest = log.unwrap().largest;
    println!("{treatment}: largest momentum {largest:e} N s; the first blow's impulse is 52");
    assert!(largest < 1e-6, "{largest:e}");
}

/// Largest momentum of a hammer with its guide tied, its casting and a machine of one rigid mode.
struct Momentum {
    largest: f64,
    shape: f64,
}

impl Observer<Coupled> for Momentum {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let (model, mut y) = (system.model(), vec![0.0; step.dimension()]);
        step.write_end(&mut y);
        let y = &y;
        let state = system.hammer_state(0, step.t1(), y);
        let hammer: f64 = model.hammers()[0].model.mass().iter().zip(state.velocity).map(|(m, v)| m * v).sum();
        let casting = 0.517 * y[crate::common::scenes::heave_velocity(model, 0)];
        let machine = system.motion(PointId::Mount { hammer: 0 }, step.t1(), y).1 / (self.shape * self.shape);
        self.largest = self.largest.max((hammer + casting + machine).abs());
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

/// One mode at 50 kHz as strong at all points as the strongest mode of the machine: hammering goes on as without it.
#[test]
fn a_mode_at_fifty_kilohertz() {
    for treatment in ["integrated", "condensed"] {
        let rig = rig(&[&format!("solver.modes={treatment}"), "duration_s=0.3"]);
        let plain = rig.engine.modes(&rig.scene).unwrap();
        let expected = first_energy(&sound(run_row(&rig.scene, &plain), &["plain"])).unwrap();
        let mut modes = InterfaceModes::clone(&plain);
        modes.omega_rad_s.push(2.0 * std::f64::consts::PI * 5e4);
        modes.damping_ratio.push(0.02);
        let strongest = plain.shapes.values().flatten().fold(0.0_f64, |largest, share| largest.max(share.abs()));
        modes.shapes.values_mut().for_each(|row| row.push(strongest));
        let outcome = sound(run_row(&rig.scene, &modes), &["50 kHz", treatment]);
        println!("{treatment}: {} steps", outcome.counters.steps);
        assert!((first_energy(&outcome).unwrap() / expected - 1.0).abs() < 1e-4);
    }
}

#[test]
fn nothing_moves_without_a_supply() {
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
        casting.inertia_kg_m2 = Some([0.1 * count as f64; 2]);
        let fixture = casting.fixtures[0].clone();
        casting.fixtures =
            [-0.1, 0.1].map(|y| decore_model::workpiece::Fixture { at_m: [0.0, y], ..fixture.clone() }).into();
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
    let outcome = completes(&["duration_s=60"]);
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

/// All modes of a basis up to 20 kHz, most of which hardly move a point of the scene: integrated like the others, they must
/// not gain energy that nothing put in.
#[test]
fn modes_that_no_point_sees_gain_no_energy() {
    let all = ["structure.fixed_interface_cutoff_hz=20000", "structure.mode_tolerance=0", "duration_s=0.06"];
    for modes in ["integrated", "condensed"] {
        for tolerance in [1e-4, 1e-5] {
            let settings =
                [format!("solver.modes={modes}"), format!("solver.tolerance={tolerance}"), "solver.guide=tied".into()];
            let settings: Vec<&str> = all.into_iter().chain(settings.iter().map(String::as_str)).collect();
            let metrics = completes(&settings).metrics.unwrap();
            assert!(
                metrics.totals.energy_residual.abs() < RESIDUAL,
                "{modes}, {tolerance:.0e}: {:.1e}",
                metrics.totals.energy_residual
            );
        }
    }
}

/// A study of hammers at the mounts of the built-in station that are counted from the first, over a casting on four fixtures.
fn hammers_at_mounts(count: usize) -> String {
    let hammer = |mount: usize| {
        let y_m = -0.5 + 0.1 * mount as f64;
        format!("[hammer.h{mount}]\nmount = \"R{mount}\"\nstrike_point_m = [0.0, {y_m:.1}]\n")
    };
    let fixture = |point: &str| format!("[casting.part.fixture.{point}]\npoint = \"{point}\"\n");
    let hammers: String = (1..=count).map(hammer).collect();
    let fixtures: String = ["T1", "T3", "T7", "T9"].map(fixture).concat();
    format!(
        "duration_s = 0.002\n{hammers}[casting.part]\nmass_kg = 20.0\nsize_m = [0.5, 1.0]\ncentre_m = [0.36, 0.0]\n\
         inertia_kg_m2 = [1.7, 0.5]\n{fixtures}"
    )
}

#[test]
fn hammers_at_many_mounts_are_carried() {
    // Their rows are combinations of which some have mass in the fast modes, and no flexibility there but rounding.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mounts.toml");
    for count in [1, 3, 8, 9] {
        std::fs::write(&path, hammers_at_mounts(count)).unwrap();
        let engine = Engine::load(&path, &[]).unwrap();
        let scene = engine.scene(0).unwrap();
        sound(run_row(&scene.scene, &scene.modes), &[&format!("{count} hammers")]);
    }
}
