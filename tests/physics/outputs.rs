//! Outputs mean what their names say, in the scenes in which they once did not: rest states, strokes, blank blows, whole-run
//! integrals, points of a rotating casting, stalls, geometry, air of another gas, scatter over twins.

use std::cell::RefCell;

use crate::common::harness::{assert_close, assert_relative, bisect};
use crate::common::studies::{outcome, rig, scene};
use decore_model::hammer::{HammerParameters, body};
use decore_model::integrate::{Observer, Step};
use decore_model::metrics::{BlowKind, ERRING, HammerMetrics, Percussion, RunMetrics};
use decore_model::run::{RowJob, RowStatus, perturbed, run_row, run_row_observed};
use decore_model::scene::{Environment, HammerLink, Owner};
use decore_model::system::{Coupled, HammerQuadrature, build};

const TELESCOPE: &str = "hammer.hammer.parameters.telescope";

/// At rest the telescope is where its forces balance: against the top stop, hanging on the return spring, or on the end stop; for
/// every contact law over preload, mass and gravity. No stop pulls.
#[test]
fn analytic_rest_states_of_every_law() {
    let mut kinds = [0; 3];
    for law in decore_model::contact::ContactLawName::ALL.iter().copied() {
        for preload_n in [0.0, 20.0, 86.0, 87.5, 140.0, 500.0] {
            for (chisel_kg, gravity_m_s2) in [(1.8157, 9.80665), (1.8157, 0.0), (1.8157, 3.7), (60.0, 9.80665)] {
                let (mut scene, modes) = crate::common::scenes::rig(1);
                scene.environment = Environment { gravity_m_s2, ..scene.environment };
                let parameters = &mut scene.hammers[0].parameters;
                parameters.chisel.mass_kg = chisel_kg;
                parameters.telescope.spring_preload_n = preload_n;
                (parameters.telescope.top_stop.law, parameters.telescope.end_stop.law) = (law, law);
                let found = rest_extension(parameters, gravity_m_s2);
                let model = build(&scene, &modes).unwrap();
                let slot = &model.hammers()[0];
                let place = |body: usize| model.initial_state()[model.layout().position(slot.points[body])];
                assert_close("extension", place(body::CYLINDER), found, 1e-12);
                let stroke_m = parameters_of(&scene).telescope.stroke_m;
                kinds[usize::from(found > 0.0) + usize::from(found > stroke_m)] += 1;
            }
        }
    }
    println!("held, hanging, on the end stop: {kinds:?}");
    assert!(kinds.iter().all(|count| *count >= 8), "{kinds:?}");
}

fn parameters_of(scene: &decore_model::scene::Scene) -> &HammerParameters {
    &scene.hammers[0].parameters
}

/// Where `N_u(-e) - N_end(e - L) - F0 - k e + W` changes sign, forces of stops none where they do not touch.
fn rest_extension(parameters: &HammerParameters, gravity_m_s2: f64) -> f64 {
    let t = &parameters.telescope;
    let mass = t.cylinder_mass_kg + parameters.valve.mass_kg + parameters.piston.mass_kg + parameters.chisel.mass_kg;
    let stop = |contact: &decore_model::contact::ContactParameters, d: f64| {
        if d > 0.0 { contact.law(t.cylinder_mass_kg).closed_force(d, 0.0) } else { 0.0 }
    };
    bisect(-0.5, 0.5, |e| {
        stop(&t.top_stop, -e) - stop(&t.end_stop, e - t.stroke_m) - t.spring_preload_n - t.spring_stiffness_n_per_m * e
            + mass * gravity_m_s2
    })
}

/// A hammer that hangs on its return spring: an independent program gives 27.49 J; with the hole in the rest state it was 79 J.
#[test]
fn val_a_hanging_hammer() {
    let preload = format!("{TELESCOPE}.spring_preload_n=20");
    for law in ["kelvin_voigt", "hertz"] {
        let law = format!("{TELESCOPE}.top_stop.law={law}");
        let metrics = rig(&[&preload, &law, "duration_s=0.2"]);
        assert_relative(&law, metrics.hammers[0].first_impact_energy_j.unwrap(), 27.49, 3e-3);
    }
    // Unsupplied it stays where it is.
    let (scene, modes) =
        scene("paper_rig.toml", 0, &[&preload, "hammer.hammer.start_time_s=9", "duration_s=0.5"]).unwrap();
    let (_, moved) = run_row_observed(&scene, &modes, |_| Cylinder::default());
    let moved = moved.unwrap();
    assert!(moved.largest - moved.least < 1e-5, "moves by {} m", moved.largest - moved.least);
}

/// Range of a cylinder's position.
#[derive(Default)]
struct Cylinder {
    least: f64,
    largest: f64,
    seen: bool,
}

impl Observer<Coupled> for Cylinder {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let model = system.model();
        let at = step.end(model.layout().position(model.hammers()[0].points[body::CYLINDER]));
        self.least = if self.seen { self.least.min(at) } else { at };
        self.largest = if self.seen { self.largest.max(at) } else { at };
        self.seen = true;
    }

    fn event(&mut self, _system: &Coupled, _guard: usize, _t: f64, _y: &[f64]) {}
}

/// Supply off and on again: the second extension's impact is a blow of its own, its percussion settles anew, and the pause is no
/// part of the frequency.
#[test]
fn a_second_stroke_has_its_impact_and_settles() {
    let once = rig(&["duration_s=1.0"]);
    let twice = rig(&["duration_s=2.5", "hammer.hammer.supply_switch_times_s=[1.0, 2.0]"]);
    let hammer = &twice.hammers[0];
    assert_eq!((once.hammers[0].stroke_count, hammer.stroke_count), (1, 2));
    assert_relative("frequency", hammer.hit_frequency_hz.unwrap(), 21.95, 1e-3);
    let of = |stroke: usize, kind: BlowKind| {
        twice.blows.iter().filter(move |blow| (blow.stroke, blow.kind) == (stroke, kind)).collect::<Vec<_>>()
    };
    for (stroke, kind) in [(0, BlowKind::FirstImpact), (1, BlowKind::StrokeImpact)] {
        assert_eq!((of(stroke, kind).len(), of(stroke, BlowKind::Settling).len()), (1, 5));
    }
    let second = of(1, BlowKind::StrokeImpact)[0];
    // Measured 69.0 J and 47 J; the machine still moves, so it is not the first impact again.
    assert_relative("impact", second.energy_j, 69.0, 2e-2);
    assert!(second.work_j > 40.0 && second.start_time_s > 2.0, "{second:?}");
    let periodic = of(0, BlowKind::Periodic).len() + of(1, BlowKind::Periodic).len();
    assert_eq!(hammer.periodic_blows as usize, periodic);
    assert!(twice.blows.iter().enumerate().all(|(n, blow)| blow.number == n));
}

/// Quadratures at every blow's start and at the end, from outside.
#[derive(Default)]
struct Books {
    /// Time, work and impulse at each contact of piston and chisel and of chisel and casting.
    events: Vec<(f64, f64, f64)>,
    end: (f64, f64),
}

impl Observer<Coupled> for Books {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        let at = |q| step.end(system.model().layout().quadrature(0, q));
        self.end = (at(HammerQuadrature::Work), at(HammerQuadrature::Impulse));
    }

    fn event(&mut self, system: &Coupled, guard: usize, t: f64, y: &[f64]) {
        let model = system.model();
        use HammerLink::{ChiselCasting, PistonChisel};
        let owner = model.elements().contacts()[guard].owner;
        if matches!(owner, Owner::Hammer { link: PistonChisel | ChiselCasting, .. }) {
            let at = |q| y[model.layout().quadrature(0, q)];
            self.events.push((t, at(HammerQuadrature::Work), at(HammerQuadrature::Impulse)));
        }
    }
}

/// Windows that reach from each blow to the next add up to the integral over the whole run, to rounding; the delivered work
/// does not depend on the windows at all.
#[test]
fn windows_and_the_whole_integral() {
    let (mut scene, modes) = scene("paper_rig.toml", 0, &["duration_s=1.0"]).unwrap();
    let default = run_row(&scene, &modes).metrics.unwrap();
    scene.outputs.blow_window_s = 100.0;
    let (outcome, books) = run_row_observed(&scene, &modes, |_| Books::default());
    let (metrics, books) = (outcome.metrics.unwrap(), books.unwrap());
    let last = metrics.blows.last().unwrap();
    // The last blow's window is open at the end: it does not count, and its own start is where the sum ends.
    let starts = |t: f64| books.events.iter().find(|event| event.0 == t).copied().unwrap();
    let after = books.events.iter().filter(|event| event.0 > last.start_time_s).collect::<Vec<_>>();
    let sum = |value: fn(&decore_model::metrics::Blow) -> f64| metrics.blows.iter().map(value).sum::<f64>();
    let (first, work, impulse) = (starts(metrics.blows[0].start_time_s), sum(|b| b.work_j), sum(|b| b.impulse_n_s));
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12 * b.abs();
    assert!(after.iter().any(|event| close(work, event.1 - first.1) && close(impulse, event.2 - first.2)));
    assert_eq!((metrics.totals.delivered_work_j, metrics.totals.delivered_impulse_n_s), books.end);
    assert_eq!(metrics.totals.delivered_impulse_n_s, metrics.hammers[0].delivered_impulse_n_s);
    assert_eq!(metrics.totals.delivered_work_j, default.totals.delivered_work_j);
    assert_relative("work of the run", default.totals.delivered_work_j, 172.0, 5e-3);
    assert_relative("work in windows", default.blows.iter().map(|blow| blow.work_j).sum(), 149.0, 5e-3);
}

/// A hammer that never reaches its casting again hits nothing: no frequency, no energy, no power; its blows are blank.
#[test]
fn blank_blows_do_not_count_as_hits() {
    let metrics = rig(&["hammer.hammer.standoff_m=0.135"]);
    let hammer = &metrics.hammers[0];
    assert_eq!((hammer.percussion, hammer.contact_count, hammer.struck_blow_count), (Percussion::Blank, 1, 0));
    assert!(hammer.blank_blow_count > 20, "{}", hammer.blank_blow_count);
    assert_eq!((hammer.hit_frequency_hz, hammer.periodic_energy_mean_j, hammer.arm_rms_steady_m_s), (None, None, None));
    assert!(metrics.blows.iter().skip(1).all(|blow| blow.kind == BlowKind::Blank && blow.work_j == 0.0));
}

/// Four fixtures, struck off the centre: the strike point is faster than the heave, and the outputs say so.
#[test]
fn the_fastest_point_of_a_rotating_casting() {
    // At the end of the positions the casting tilts most.
    let outcome = outcome("placement.toml", 0, &["duration_s=0.2", "hammer.hammer.rail_position_m=0.12"]);
    let metrics = outcome.metrics.unwrap();
    let casting = &metrics.castings[0];
    let struck = metrics.hammers[0].first_impact_casting_peak_velocity_m_s.unwrap();
    println!("heave {}, {} {}", casting.peak_velocity_m_s, casting.peak_point, casting.peak_point_velocity_m_s);
    assert!(casting.peak_point_velocity_m_s >= struck * (1.0 - 1e-12));
    assert!(casting.peak_point_velocity_m_s > 1.5 * casting.peak_velocity_m_s);
    assert_eq!(casting.peak_point, "fixture.front_right");
    // A casting that only heaves is as fast everywhere.
    let plain = rig(&["duration_s=0.1", "casting.part.measuring_point_m=[0.0, 0.0]"]).castings.remove(0);
    assert_eq!(plain.peak_point_velocity_m_s, plain.peak_velocity_m_s);
    assert_eq!(plain.peak_point_velocity_time_s, plain.peak_velocity_time_s);
    assert_eq!(plain.measuring_point_peak_velocity_m_s, Some(plain.peak_velocity_m_s));
}

/// The steady figure of the arm starts when the first impact has decayed: it does not fall with the duration, as the figure of the
/// whole hammering does, and as it did when it started at the first periodic blow (0.00478, 0.00344 and 0.00332 m/s after 1.5, 10 and
/// 20 s; 0.003195 in the last second). 0.5 % of it is left at most. A run that is too short
/// has none.
#[test]
fn the_steady_arm_forgets_the_first_impact() {
    let [short, long, longer] =
        ["duration_s=1.5", "duration_s=6", "duration_s=12"].map(|duration| rig(&[duration]).hammers.remove(0));
    assert_eq!((short.arm_rms_steady_m_s, short.arm_rms_steady_error_m_s), (None, None));
    let whole = [&long, &longer].map(|hammer| hammer.arm_rms_hammering_m_s.unwrap());
    let of = |hammer: &HammerMetrics| (hammer.arm_rms_steady_m_s.unwrap(), hammer.arm_rms_steady_error_m_s.unwrap());
    let steady = [of(&long), of(&longer)];
    println!("steady {steady:?}, hammering {whole:?}");
    assert!(whole[0] / whole[1] > 1.15);
    for (value, error) in steady {
        assert!((value / 0.003195 - 1.0).abs() < 0.005, "{value}");
        assert!(error > 0.0 && error < 0.02 * value, "{value} {error}");
    }
}

/// A percussion whose works scatter by 6 % from blow to blow is not periodic, though its energies (to 0.4 %) and intervals repeat;
/// its twins agree.
#[test]
fn works_that_scatter_are_not_periodic() {
    let soft = [
        "casting.part.fixture.table.stiffness_n_per_m=1e6",
        "casting.part.fixture.table.damping_n_s_per_m=400",
        "casting.part.mass_kg=1.5",
        "outputs.twins=4",
    ];
    let metrics = rig(&soft);
    let works = metrics.blows.iter().filter(|blow| blow.kind == BlowKind::Periodic).map(|blow| blow.work_j);
    let works: Vec<f64> = works.collect();
    let mean = works.iter().sum::<f64>() / works.len() as f64;
    let spread = (works.iter().map(|work| (work - mean).powi(2)).sum::<f64>() / works.len() as f64).sqrt() / mean;
    let kinds = metrics.scatter.as_ref().unwrap().hammers[0]["percussion"];
    println!(
        "works scatter by {:.1} %, {:?}, others among twins {kinds:?}",
        100.0 * spread,
        metrics.hammers[0].percussion
    );
    assert!(spread > 0.03, "{spread}");
    assert_ne!(metrics.hammers[0].percussion, Percussion::Periodic);
    assert_eq!(kinds, Some(0.0));
}

/// Number of a hammer's outputs by its name.
fn number(hammer: &HammerMetrics, name: &str) -> Option<f64> {
    let quantity = HammerMetrics::QUANTITIES.iter().find(|quantity| quantity.name == name).unwrap();
    (quantity.value)(hammer).and_then(|value| value.number())
}

/// Two standard errors hold the truth, the mean over 24 runs that differ by chance, in most runs: of every output that has an error,
/// with a casting whose intervals once held it in 84 % (3.5 kg), one in 62 % of runs (60 kg), and of runs that are short (1.5 s). The
/// bound is what 3 x 24 intervals of 95 % meet in 999 of 1000 cases.
#[test]
fn val_intervals_hold_the_truth() {
    let mut held = [(0, 0); ERRING.len()];
    for mass in ["3.5", "20", "60"] {
        let mass = format!("casting.part.mass_kg={mass}");
        let (scene, modes) = scene("paper_rig.toml", 0, &[&mass]).unwrap();
        let hammer =
            |run: usize| RowJob::new(perturbed(&scene, run), modes.clone(), 0).run().metrics.unwrap().hammers.remove(0);
        let runs: Vec<HammerMetrics> = (0..24).map(hammer).collect();
        for ((value, error), (held, all)) in ERRING.iter().zip(&mut held) {
            let values: Vec<f64> = runs.iter().filter_map(|run| number(run, value)).collect();
            let truth = values.iter().sum::<f64>() / values.len() as f64;
            let pairs = || runs.iter().filter_map(|run| number(run, value).zip(number(run, error)));
            *held += pairs().filter(|(value, error)| (value - truth).abs() <= 2.0 * error).count();
            *all += pairs().count();
        }
    }
    for ((name, _), (held, all)) in ERRING.iter().zip(held) {
        println!("{name}: {held} of {all}");
        // The steady velocity of the mount needs a longer run.
        assert!(*name == "arm_rms_steady_m_s" || all >= 40, "{name}: {all}");
        assert!(held as f64 >= 0.86 * all as f64, "{name}: {held} of {all}");
    }
}

/// A casting of 116 kg switches between two motions every few hundred blows: most short runs have no standard error, and say why.
#[test]
fn errors_are_null_where_the_percussion_is_unsettled() {
    let (scene, modes) = scene("paper_rig.toml", 0, &["casting.part.mass_kg=116", "duration_s=3"]).unwrap();
    let mut unsettled = 0;
    for run in 0..6 {
        let metrics = RowJob::new(perturbed(&scene, run), modes.clone(), 0).run().metrics.unwrap();
        let hammer = &metrics.hammers[0];
        let sure = matches!(hammer.percussion, Percussion::Aperiodic | Percussion::Periodic);
        unsettled += usize::from(!sure);
        assert_eq!(hammer.periodic_energy_mean_error_j.is_some(), sure, "{hammer:?}");
        assert_eq!(
            (hammer.delivered_work_error_j.is_some(), metrics.totals.delivered_work_error_j.is_some()),
            (sure, sure)
        );
    }
    println!("{unsettled} of 6 unsettled");
    assert!(unsettled >= 3);
}

/// Supplies too low or too high for the percussion: rows that are done, and whose outputs say what the hammer does.
#[test]
fn stalls_have_a_name() {
    for bar in [0.8, 1.3, 18.0] {
        let hammer = rig(&[&format!("hammer.hammer.supply_bar={bar}")]).hammers.remove(0);
        assert!(!hammer.percussion.strikes(), "{bar} bar: {:?}", hammer.percussion);
        assert_eq!((hammer.hit_frequency_hz, hammer.periodic_energy_mean_j, hammer.periodic_blows), (None, None, 0));
    }
    let usual = rig(&[]).hammers.remove(0);
    assert_eq!((usual.percussion, usual.percussion_period), (Percussion::Periodic, Some(1)));
}

/// A hammer that never starts is sound; a row whose books do not close is none of the done ones, and is run again more strictly.
#[test]
fn audits_decide_the_status() {
    let idle = outcome("paper_rig.toml", 0, &["hammer.hammer.start_time_s=9", "duration_s=0.5"]);
    assert_eq!((idle.status, idle.reason.as_str()), (RowStatus::Done, ""));
    let loose = outcome("paper_rig.toml", 0, &["solver.tolerance=0.1", "duration_s=0.5"]);
    assert_eq!(loose.status, RowStatus::AuditFailed);
    assert!(loose.reason.contains("energy residual") && loose.metrics.is_some(), "{}", loose.reason);
    let (scene, modes) = scene("paper_rig.toml", 0, &["solver.tolerance=0.1", "duration_s=0.5"]).unwrap();
    let again = RowJob::new(scene, modes, 3).run();
    assert_eq!(again.status, RowStatus::Done, "{}", again.reason);
    assert!(again.counters.retries > 0);
}

/// Places that contradict the machine's coordinates make a row invalid, with what contradicts what; unless the study says that
/// they are as given.
#[test]
fn geometry_is_held_to_the_machine() {
    let faults: [(&[&str], &str); 4] = [
        (
            &["hammer.hammer.strike_point_m=[0.05, 0.0]"],
            "strikes downwards from (0.3600, 0.0000) m, but its strike point",
        ),
        (&["hammer.hammer.mount=R4", "hammer.hammer.strike_point_m=[0.0, 0.0]"], "`hammer.hammer.strike_point_m`"),
        (&["casting.part.fixture.table.at_m=[0.0, 0.1]"], "fixture `table` holds casting `part` at (0.3600, 0.1000) m"),
        (&["casting.part.centre_m=[0.36, 0.05]", "casting.part.fixture.table.at_m=[0.0, 0.0]"], "interface point `T5`"),
    ];
    for (settings, words) in faults {
        let reason = scene("paper_rig.toml", 0, settings).unwrap_err();
        assert!(reason.contains(words), "{settings:?}: {reason}");
        assert!(reason.contains("geometry"), "{reason}");
    }
    let reason = scene("three_hammers.toml", 0, &["hammer.two.mount=R4"]).unwrap_err();
    assert!(reason.contains("hammer `two` stands where hammer `one` does"), "{reason}");
    // Two bores of 56.4 mm.
    let beside = |apart_m: f64| {
        let place = format!("hammer.three.rail_position_m={apart_m}");
        scene("three_hammers.toml", 0, &["hammer.three.casting=a", "casting.a.size_m=[0.3, 0.4]", &place])
    };
    let reason = beside(0.008).unwrap_err();
    let words = "hammer `three` stands at (0.3600, 0.0080) m, 0.0080 m from hammer `two`: the bores of their telescopes alone need \
                 0.0564 m";
    assert!(reason.contains(words) && reason.contains("geometry"), "{reason}");
    assert!(beside(0.056).is_err() && beside(0.057).is_ok(), "{:?}", beside(0.057).err());
    let given: Vec<&str> = faults[1].0.iter().copied().chain(["geometry=as_given"]).collect();
    assert!(scene("paper_rig.toml", 0, &given).is_ok());
}

/// A gas of twice the constant at half the temperature moves the hammer alike and has twice the volume at standard conditions.
#[test]
fn analytic_air_of_another_gas() {
    let of = |settings: &[&str]| {
        let settings: Vec<&str> = settings.iter().copied().chain(["duration_s=0.2"]).collect();
        let metrics = rig(&settings);
        (metrics.hammers[0].first_impact_energy_j.unwrap(), metrics.hammers[0].air_used_nl)
    };
    let air = of(&[]);
    let other = of(&["environment.gas_constant_j_per_kg_k=574.1", "environment.temperature_k=146.575"]);
    assert_relative("energy", other.0, air.0, 1e-9);
    assert_relative("air", other.1, 2.0 * air.1, 1e-9);
}

/// The largest scatter over its output, and that output's name.
fn largest_relative(metrics: &RunMetrics) -> (f64, String) {
    let scatter = metrics.scatter.as_ref().expect("twins");
    let worst = RefCell::new((0.0, String::new()));
    let check = |name: &str, moved: Option<f64>, value: Option<f64>| {
        let (Some(moved), Some(value)) = (moved, value) else { return };
        let mut worst = worst.borrow_mut();
        if moved > worst.0 * value.abs() {
            *worst = (moved / value.abs(), name.to_owned());
        }
    };
    for quantity in decore_model::metrics::HammerMetrics::QUANTITIES.iter().filter(|quantity| quantity.main) {
        let value = (quantity.value)(&metrics.hammers[0]).and_then(|value| value.number());
        check(quantity.name, scatter.hammers[0][quantity.name], value);
    }
    for quantity in decore_model::metrics::CastingMetrics::QUANTITIES.iter().filter(|quantity| quantity.main) {
        let value = (quantity.value)(&metrics.castings[0]).and_then(|value| value.number());
        check(quantity.name, scatter.castings[0][quantity.name], value);
    }
    check("delivered_work_j", scatter.totals["delivered_work_j"], Some(metrics.totals.delivered_work_j));
    worst.into_inner()
}

/// The rig's outputs do not move with its twins; over heavy castings they do, by what the standard error says of their mean. The
/// standard error of a single aperiodic run is a matter of chance itself: the middle one of three castings counts.
#[test]
fn twins_show_the_scatter() {
    let rig_metrics = rig(&["outputs.twins=4"]);
    let (worst, name) = largest_relative(&rig_metrics);
    println!("rig: {worst:.1e} ({name})");
    // Half the range of five runs is below 1e-5; scaled to the range of eleven runs it is 1.36 times as large.
    assert!(worst > 0.0 && worst < 1.4e-5, "{name}: {worst:e}");
    assert_eq!(rig_metrics.scatter.as_ref().unwrap().twins_done, 4);
    let mut ratios = [18, 20, 22].map(|mass_kg| {
        let heavy = rig(&["outputs.twins=6", &format!("casting.part.mass_kg={mass_kg}")]);
        let hammer = &heavy.hammers[0];
        let scatter = heavy.scatter.as_ref().unwrap().hammers[0]["periodic_energy_mean_j"].unwrap();
        let (mean, error) = (hammer.periodic_energy_mean_j.unwrap(), hammer.periodic_energy_mean_error_j.unwrap());
        println!("{mass_kg} kg: scatter {:.2} %, standard error {:.2} %", 100.0 * scatter / mean, 100.0 * error / mean);
        assert!(scatter / mean > 0.005 && scatter / mean < 0.05, "{}", scatter / mean);
        assert_eq!(hammer.percussion, Percussion::Aperiodic);
        error / scatter
    });
    ratios.sort_by(f64::total_cmp);
    assert!(ratios[1] > 0.2 && ratios[1] < 5.0, "{ratios:?}");
    assert!(rig(&["duration_s=0.1"]).scatter.is_none());
}

/// What `--signals` records is what the tables say: peaks, work and impulse of a blow, read off the signals.
#[test]
fn signals_agree_with_the_tables() {
    let (scene, modes) = scene("paper_rig.toml", 0, &["duration_s=0.18"]).unwrap();
    let interval_s = 1e-6;
    let (outcome, recorder) =
        run_row_observed(&scene, &modes, |model| decore_model::metrics::SignalRecorder::new(model, &scene, interval_s));
    let (metrics, signals) = (outcome.metrics.unwrap(), recorder.unwrap().into_signals());
    let values = |name: &str| {
        let signal = signals.iter().find(|signal| signal.name == name);
        signal.unwrap_or_else(|| panic!("no signal {name}")).values.as_slice()
    };
    let (force, work) = (values("hammer_casting_force_n"), values("hammer_delivered_work_j"));
    let (impulse, speed) = (values("hammer_delivered_impulse_n_s"), values("hammer_casting_velocity_m_s"));
    assert_eq!(metrics.blows.len(), 2, "the first impact and a blow");
    for blow in &metrics.blows {
        let (from, to) = (blow.start_time_s, blow.start_time_s + scene.outputs.blow_window_s);
        let before = (from / interval_s) as usize;
        // An integral has a kink where the force jumps; before that it stands still.
        let begin = |integral: &[f64]| {
            if force[before] == 0.0 { integral[before] } else { at(integral, from / interval_s) }
        };
        let change = |integral: &[f64]| at(integral, to / interval_s) - begin(integral);
        assert_relative("work", change(work), blow.work_j, 1e-6);
        assert_relative("impulse", change(impulse), blow.impulse_n_s, 1e-6);
        let inside = (from / interval_s).ceil() as usize..(to / interval_s) as usize;
        assert_relative("force", top(&force[inside.clone()]), blow.peak_force_n, 1e-6);
        assert_relative("velocity", top(&speed[inside]), blow.casting_peak_velocity_m_s, 1e-6);
    }
    let last = |integral: &[f64]| integral[integral.len() - 1];
    assert_relative("work of the run", last(work), metrics.totals.delivered_work_j, 1e-9);
    assert_relative("impulse of the run", last(impulse), metrics.hammers[0].delivered_impulse_n_s, 1e-9);
}

/// The end of the run is an instant of signals whose interval fits into it, also where their product lies beyond it by rounding, as
/// `1500 * 2e-5` does.
#[test]
fn signals_end_with_the_run() {
    for (interval_s, instants) in [(2e-5, 1501), (1e-4, 301), (7e-5, 429)] {
        let (scene, modes) = scene("paper_rig.toml", 0, &["duration_s=0.03"]).unwrap();
        let recorder = run_row_observed(&scene, &modes, |model| {
            decore_model::metrics::SignalRecorder::new(model, &scene, interval_s)
        });
        let signals = recorder.1.unwrap().into_signals();
        assert!(
            signals.iter().all(|signal| signal.values.len() == instants),
            "{interval_s}: {}",
            signals[0].values.len()
        );
        let last_s = signals[0].values[instants - 1];
        assert_eq!(last_s, if instants == 429 { 428.0 * interval_s } else { 0.03 });
    }
}

/// Forces of mount and fixture are what Newton's law leaves: of the hammer's bodies together and of a casting that only heaves,
/// momentum is the integral of the forces. At the end the energy balance is the audit's, and it holds at any time.
#[test]
fn signals_of_forces_and_energies_balance() {
    let (scene, modes) = scene("paper_rig.toml", 0, &["duration_s=0.12"]).unwrap();
    let interval_s = 1e-6;
    let (outcome, recorder) =
        run_row_observed(&scene, &modes, |model| decore_model::metrics::SignalRecorder::new(model, &scene, interval_s));
    let (metrics, signals) = (outcome.metrics.unwrap(), recorder.unwrap().into_signals());
    let values = |name: &str| {
        let signal = signals.iter().find(|signal| signal.name == name);
        signal.unwrap_or_else(|| panic!("no signal {name}")).values.as_slice()
    };
    let integral = |values: &[f64], to: usize| {
        let ends = 0.5 * (values[0] + values[to]);
        interval_s * (values[..=to].iter().sum::<f64>() - ends)
    };
    // The impulse of blows is integrated with the state: a sum over samples misses where their forces jump.
    let (strike, mount) = (values("hammer_delivered_impulse_n_s"), values("hammer_mount_force_n"));
    let fixture = scene.castings[0].fixtures[0].name.as_str();
    let table = values(&format!("part_fixture_{fixture}_force_n")).to_vec();
    assert!(mount[0].abs() < 1e-6 && table[0].abs() < 1e-6, "at rest {} and {}", mount[0], table[0]);
    let parameters = &scene.hammers[0].parameters;
    let bodies = [
        (parameters.telescope.cylinder_mass_kg, values("hammer_cylinder_velocity_m_s")),
        (parameters.valve.mass_kg, values("hammer_spool_velocity_m_s")),
        (parameters.piston.mass_kg, values("hammer_piston_velocity_m_s")),
        (parameters.chisel.mass_kg, values("hammer_chisel_velocity_m_s")),
    ];
    for to in [40_000, 60_000, strike.len() - 1] {
        let momentum: f64 = bodies.iter().map(|(mass, velocity)| mass * velocity[to]).sum();
        let given = -integral(mount, to) - strike[to];
        assert!((momentum - given).abs() < 1e-3, "hammer: {momentum} and {given} N s");
        let momentum = scene.castings[0].mass_kg * values("part_heave_velocity_m_s")[to];
        let given = strike[to] - integral(&table, to);
        assert!((momentum - given).abs() < 1e-3, "casting: {momentum} and {given} N s");
    }
    // Newton's law at every instant: between the ends of a step an acceleration is the slope of the interpolated velocity.
    let (force, accelerations) = (values("hammer_casting_force_n"), values("part_heave_acceleration_m_s2"));
    let newton = force.iter().zip(&table).zip(accelerations);
    let off = newton.map(|((force, table), given)| scene.castings[0].mass_kg * given - (force - table));
    let off: Vec<f64> = off.collect();
    let rms = |values: &[f64]| (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt();
    assert!(rms(&off) < 2e-3 * rms(force), "casting: {} of {} N", rms(&off), rms(force));
    for body in ["cylinder", "piston", "chisel"] {
        let (velocity, acceleration) =
            (values(&format!("hammer_{body}_velocity_m_s")), values(&format!("hammer_{body}_acceleration_m_s2")));
        let to = velocity.len() - 1;
        assert!((integral(acceleration, to) - velocity[to]).abs() < 1e-2, "{body}: {}", integral(acceleration, to));
    }
    assert_eq!(values("part_measuring_point_velocity_m_s"), values("part_heave_velocity_m_s"));
    assert_eq!(values("part_measuring_point_acceleration_m_s2"), accelerations);
    let (put_in, unaccounted) = (values("work_put_in_j"), values("energy_unaccounted_j"));
    let last = put_in.len() - 1;
    let residual = unaccounted[last] / put_in[last];
    assert!((residual - metrics.totals.energy_residual).abs() < 1e-7, "{residual}");
    let worst = unaccounted.iter().map(|residual| residual.abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3 * put_in[last], "{worst} J of {}", put_in[last]);
}

/// Watched points move as the structure does: one that is the mount as the mount, one that carries the
/// fixture as the fixture, another one alike whether modes are integrated or condensed. Seeing them changes no more than tolerances.
#[test]
fn signals_of_points_are_those_of_the_structure() {
    let run = |modes: &str, points: &[&str]| {
        let points = format!("outputs.points={points:?}");
        let settings = ["duration_s=0.1", "solver.tolerance=1e-7", modes, &points];
        let (scene, modes) = scene("paper_rig.toml", 0, &settings).unwrap();
        let (outcome, recorder) =
            run_row_observed(&scene, &modes, |model| decore_model::metrics::SignalRecorder::new(model, &scene, 1e-4));
        (outcome.metrics.unwrap(), recorder.unwrap().into_signals())
    };
    let values = |signals: &[decore_model::metrics::Signal], name: &str| {
        let signal = signals.iter().find(|signal| signal.name == name);
        signal.unwrap_or_else(|| panic!("no signal {name}")).values.clone()
    };
    let (metrics, signals) = run("solver.modes=\"integrated\"", &["R3", "T5", "R5"]);
    for quantity in ["displacement_m", "velocity_m_s"] {
        let of = |of: &str| values(&signals, &format!("{of}_{quantity}"));
        assert_eq!(of("point_R5"), of("hammer_arm"));
        assert_eq!(of("point_T5"), of("part_fixture_table_point"));
    }
    let (_, condensed) = run("solver.modes=\"condensed\"", &["R3"]);
    let [integrated, condensed] = [&signals, &condensed].map(|signals| values(signals, "point_R3_velocity_m_s"));
    let largest = integrated.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let apart = integrated.iter().zip(&condensed).fold(0.0_f64, |apart, (a, b)| apart.max((a - b).abs()));
    assert!(largest > 0.01 && apart < 1e-4 * largest, "{apart} of {largest} m/s");
    let (unseen, _) = run("solver.modes=\"integrated\"", &[]);
    let [seen, unseen] = [metrics, unseen].map(|metrics| metrics.hammers[0].first_impact_energy_j.unwrap());
    assert_relative("first impact", seen, unseen, 1e-5);
}

/// The point (x, y) of a rigid casting moves by `z + y tx - x ty`, and by the integral of its velocity.
#[test]
fn castings_move_where_they_are_struck_and_held() {
    let interval_s = 5e-6;
    let (scene, modes) = scene("three_hammers.toml", 0, &["duration_s=0.06"]).unwrap();
    let (_, recorder) =
        run_row_observed(&scene, &modes, |model| decore_model::metrics::SignalRecorder::new(model, &scene, interval_s));
    let signals = recorder.unwrap().into_signals();
    let values = |name: &str| {
        let signal = signals.iter().find(|signal| signal.name == name);
        signal.unwrap_or_else(|| panic!("no signal {name}")).values.as_slice()
    };
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let [heave, tx, ty] = ["a_heave_m", "a_rotation_x_rad", "a_rotation_y_rad"].map(values);
    let apart = |found: &[f64], expected: &dyn Fn(usize) -> f64| {
        let differences = found.iter().enumerate().map(|(at, value)| (value - expected(at)).abs());
        differences.fold(0.0, f64::max)
    };
    let mut points: Vec<(String, [f64; 2])> = scene.castings[0]
        .fixtures
        .iter()
        .map(|fixture| (format!("a_fixture_{}", fixture.name), fixture.at_m))
        .collect();
    points.extend(scene.hammers.iter().take(2).map(|unit| (unit.name.clone(), unit.strike_point_m)));
    for (name, [x, y]) in points {
        let found = values(&format!("{name}_casting_displacement_m"));
        assert!(largest(found) > 1e-4, "{name} moves by at most {} m", largest(found));
        let off = apart(found, &|at| heave[at] + y * tx[at] - x * ty[at]);
        assert!(off < 1e-12, "{name}: {off} m");
    }
    assert_eq!(values("b_measuring_point_displacement_m"), values("b_heave_m"), "the centre, where no point is chosen");
    let velocity = values("one_casting_velocity_m_s");
    let mut integral = vec![0.0];
    for pair in velocity.windows(2) {
        integral.push(integral[integral.len() - 1] + 0.5 * interval_s * (pair[0] + pair[1]));
    }
    let struck = values("one_casting_displacement_m");
    let off = apart(struck, &|at| integral[at]);
    assert!(off < 1e-3 * largest(struck), "{off} of {} m", largest(struck));
}

/// Points that are only to be seen cost no state, however many there are, and modes stay condensed. Other outputs change by less than the
/// tolerances of the preset.
#[test]
fn watched_points_cost_no_state() {
    let names = ["R1", "R2", "R3", "R4", "R6", "R7", "R8", "R9"];
    let run = |points: &[&str]| {
        let points = format!("outputs.points={points:?}");
        let (scene, modes) = scene("paper_rig.toml", 0, &["duration_s=0.1", &points]).unwrap();
        let outcome = run_row(&scene, &modes);
        (outcome.states, outcome.metrics.unwrap().hammers[0].first_impact_energy_j.unwrap())
    };
    let (states, energy_j) = run(&[]);
    for count in [1, 4, 8] {
        let (seen, seen_energy_j) = run(&names[..count]);
        assert_eq!(seen, states, "{count} points");
        assert_relative("first impact", seen_energy_j, energy_j, 1e-4);
    }
}

/// A sampled function between its samples, by the cubic through four of them.
fn at(values: &[f64], place: f64) -> f64 {
    let first = (place as usize).saturating_sub(1);
    let x = place - first as f64;
    (0..4_usize)
        .map(|i| {
            let others = (0..4).filter(|j| *j != i);
            values[first + i] * others.map(|j| (x - j as f64) / (i as f64 - j as f64)).product::<f64>()
        })
        .sum()
}

/// The largest absolute value, by the parabola through the largest sample and its neighbours.
fn top(values: &[f64]) -> f64 {
    let largest = (1..values.len() - 1).max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs())).unwrap();
    let [a, b, c] = [0, 1, 2].map(|i| values[largest + i - 1].abs());
    b - 0.125 * (c - a) * (c - a) / (a - 2.0 * b + c)
}
