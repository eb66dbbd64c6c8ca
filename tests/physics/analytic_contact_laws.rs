//! The choice of contact laws against closed forms: restitution, duration, peaks, chains of impacts, energy.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::harness::{assert_close, assert_relative, observe, settings, switches};
use crate::common::scenes::{
    NO_CONTACT, PeakForce, bench, clear, contact_index, heave_velocity, place, rig, shapes, simulate,
};
use decore_model::contact::{ContactLaw, ContactLawName, ContactParameters, restitution};
use decore_model::hammer::{HammerParameters, body};
use decore_model::integrate::{Integrator, Stopped, Tsit5};
use decore_model::metrics::Recorder;
use decore_model::scene::{HammerLink, Scene};
use decore_model::system::{Coupled, CoupledModel, build};

/// Chisel and casting of the bench.
const MASSES: [f64; 2] = [1.8157, 0.517];
const MU: f64 = MASSES[0] * MASSES[1] / (MASSES[0] + MASSES[1]);

fn with_law(law: ContactLawName) -> ContactParameters {
    ContactParameters { law, ..HammerParameters::default().chisel.casting_contact }
}

/// Moves the whole hammer on by a distance.
fn shift(model: &Arc<CoupledModel>, y: &mut [f64], distance: f64) {
    let at = Coupled::new(model).hammer_state(0, 0.0, y).position;
    for (index, position) in at.into_iter().enumerate().skip(body::CYLINDER) {
        place(model, y, index, (position + distance, 0.0));
    }
}

/// What a collision of chisel and casting gave.
struct Collision {
    restitution: f64,
    duration: f64,
    peak_force: f64,
}

/// Lets the chisel meet the free casting at `speed`, nothing else around.
fn collide(parameters: ContactParameters, speed: f64) -> Collision {
    let (mut scene, modes) = bench();
    scene.hammers[0].standoff_m = 0.0;
    scene.hammers[0].parameters.chisel.casting_contact = parameters;
    let model = build(&scene, &modes).expect("the bench is sound");
    let mut y0 = clear(&model);
    shift(&model, &mut y0, 0.005);
    // The casting's face stands where the resting chisel's tip does, at 0.012.
    place(&model, &mut y0, body::CHISEL, (0.0119, speed));
    let contact = contact_index(&model, HammerLink::ChiselCasting);
    let mut peak = PeakForce { contact, newton: 0.0 };
    let end = (0.0001 + 0.0006) / speed + 0.0003;
    let run = observe(&mut Coupled::new(&model), &y0, settings(1e-8, 1e-4), end, &mut peak);
    let [onset, release] = switches(&run, contact);
    let row = model.elements().contact_row(contact);
    Collision {
        restitution: -Coupled::new(&model).relative_motion(row, end, &run.y).1 / speed,
        duration: release - onset,
        peak_force: peak.newton,
    }
}

/// The restitution asked for is the restitution found, at every speed for the laws whose restitution does not depend on it,
/// at the reference speed for Hunt-Crossley.
#[test]
fn analytic_restitution_as_stated() {
    for &law in ContactLawName::ALL {
        for e in [0.1, 0.5, 0.9, 1.0] {
            for speed in [0.3, 1.0, 8.0] {
                let reference_speed_m_s = (law == ContactLawName::HuntCrossley).then_some(speed);
                let stated = ContactParameters { restitution: Some(e), reference_speed_m_s, ..with_law(law) };
                let found = collide(stated, speed);
                println!("{law:?} at {speed} m/s: {e} off by {:.1e}", found.restitution - e);
                // Some ten to a hundred steps of 1e-8 m/s each, over 0.3 m/s.
                assert_close("restitution", found.restitution, e, 3e-6);
            }
        }
    }
}

/// Hunt-Crossley: `a v0` gives the restitution of the closed form whatever the exponent, published for three values.
#[test]
fn analytic_hunt_crossley_restitution() {
    for (product, published) in [(0.5, 0.748_435), (1.0, 0.593_624), (2.0, 0.410_720)] {
        assert_close("closed form", restitution::hunt_crossley(product), published, 1e-6);
        let speed = 2.0;
        for exponent in [1.0, 1.5, 2.5] {
            let stated = ContactParameters {
                exponent: Some(exponent),
                damping_s_per_m: Some(product / speed),
                ..with_law(ContactLawName::HuntCrossley)
            };
            let found = collide(stated, speed);
            println!("a v0 = {product}, n = {exponent}: off by {:.1e}", found.restitution - published);
            assert_close("restitution", found.restitution, published, 2e-6);
        }
    }
}

/// Separation at zero penetration: `e = exp(-pi z / sqrt(1 - z^2))`, duration `pi / w_d`.
#[test]
fn analytic_separation_at_zero_penetration() {
    let (k, omega) = (2.95e8_f64, (2.95e8_f64 / MU).sqrt());
    for z in [0.0, 0.1, 0.5, 0.9] {
        let damping_n_s_per_m = 2.0 * z * (k * MU).sqrt();
        let stated = ContactParameters { damping_n_s_per_m, ..with_law(ContactLawName::KelvinVoigtSeparating) };
        let found = collide(stated, 1.0);
        let damped = (1.0 - z * z).sqrt();
        let e = (-PI * z / damped).exp();
        println!(
            "z = {z}: e off by {:.1e}, duration {:.1e}",
            found.restitution - e,
            found.duration * omega * damped / PI - 1.0
        );
        assert_close("restitution", found.restitution, e, 1e-6);
        assert_relative("duration", found.duration, PI / (omega * damped), 1e-5);
        assert_close("function", restitution::separating(z), e, 1e-14);
    }
}

/// Undamped Hertz: `d_max = (5 mu v^2 / (4 K))^0.4`, duration `2.9433 d_max / v`.
#[test]
fn analytic_hertz_peak_and_duration() {
    let stiffness = 3e10;
    for speed in [0.2, 1.0, 5.0] {
        let stated = ContactParameters {
            damping_n_s_per_m: 0.0,
            power_stiffness_n_per_m_n: Some(stiffness),
            ..with_law(ContactLawName::Hertz)
        };
        let found = collide(stated, speed);
        let deepest = (1.25 * MU * speed * speed / stiffness).powf(0.4);
        println!(
            "{speed} m/s: peak off by {:.1e}, duration by {:.1e}",
            found.peak_force / (stiffness * deepest.powf(1.5)) - 1.0,
            found.duration * speed / (2.943_275 * deepest) - 1.0
        );
        assert_relative("peak force", found.peak_force, stiffness * deepest.powf(1.5), 1e-5);
        // The constant is published to five digits: 2.9433.
        assert_relative("duration", found.duration, 2.9433 * deepest / speed, 2e-5);
        assert_close("restitution", found.restitution, 1.0, 1e-6);
    }
}

/// Laws without figures of their own compress as deep as the linear one at the reference speed: `F_max` follows.
#[test]
fn analytic_laws_are_matched_at_the_reference_speed() {
    for law in [ContactLawName::HuntCrossley, ContactLawName::Hertz] {
        for speed in [0.5, 4.0] {
            let linear = ContactParameters { damping_n_s_per_m: 0.0, ..with_law(law) };
            let stated = ContactParameters { reference_speed_m_s: Some(speed), ..linear };
            let found = collide(stated, speed);
            // K d^1.5 at d = v sqrt(mu/k): 5/4 of the linear law's peak.
            let expected = 1.25 * speed * (linear.stiffness_n_per_m * MU).sqrt();
            assert_relative("peak force", found.peak_force, expected, 1e-5);
        }
    }
}

/// The closed forms and their inverses, from almost no loss to almost no rebound.
#[test]
fn analytic_inverses_of_the_closed_forms() {
    for e in [1e-3, 0.05, 0.135_335_283, 0.3, 0.9, 0.999_999, 1.0] {
        assert_close("linear", restitution::kelvin_voigt(restitution::kelvin_voigt_damping(e)), e, 1e-12);
        assert_close("separating", restitution::separating(restitution::separating_damping(e)), e, 1e-12);
        // Near e = 1 the two terms of the closed form cancel: what is left is known to the root of the precision.
        let bound = if e > 0.999 { 1e-8 } else { 1e-10 };
        assert_close("Hunt-Crossley", restitution::hunt_crossley(restitution::hunt_crossley_damping(e)), e, bound);
    }
    assert_eq!(restitution::kelvin_voigt(0.0), 1.0);
    // Critical damping: exp(-2), from either side.
    for z in [1.0 - 1e-5, 1.0, 1.0 + 1e-5] {
        assert_close(
            "critical damping",
            restitution::kelvin_voigt(z),
            (-2.0_f64 * (1.0 + (z - 1.0) * 2.0 / 3.0)).exp(),
            1e-9,
        );
    }
}

/// The mass of the casting's side counts as at the strike point: off its centre a casting that can rotate is lighter.
#[test]
fn analytic_reduced_mass_of_the_strike() {
    let (mut scene, modes) = bench();
    let contact = ContactParameters { restitution: Some(0.5), ..with_law(ContactLawName::KelvinVoigt) };
    scene.hammers[0].parameters.chisel.casting_contact = contact;
    scene.hammers[0].strike_point_m = [0.03, -0.04];
    let casting = &mut scene.castings[0];
    casting.inertia_kg_m2 = Some([0.002, 0.004]);
    let fixture = casting.fixtures[0].clone();
    let corners = [[0.1, 0.1], [0.1, -0.1], [-0.1, 0.1], [-0.1, -0.1]];
    casting.fixtures = corners.map(|at_m| decore_model::workpiece::Fixture { at_m, ..fixture.clone() }).into();
    let modes = decore_model::system::InterfaceModes { shapes: shapes([Vec::new()], vec![Vec::new(); 4]), ..modes };
    let model = build(&scene, &modes).expect("sound");
    let inverse = 1.0 / MASSES[0] + 1.0 / MASSES[1] + 0.04 * 0.04 / 0.002 + 0.03 * 0.03 / 0.004;
    let found = model.elements().contacts()[contact_index(&model, HammerLink::ChiselCasting)].law;
    assert_eq!(found, contact.law(1.0 / inverse));
}

/// Three equal masses in a row, the last two touching, undamped Hertz contacts.
#[test]
fn analytic_three_ball_cradle_of_hertz() {
    let (mut scene, modes) = bench();
    let unit = &mut scene.hammers[0];
    unit.standoff_m = 0.0;
    let law = ContactParameters {
        power_stiffness_n_per_m_n: Some(1e10),
        restitution: Some(1.0),
        ..with_law(ContactLawName::Hertz)
    };
    (unit.parameters.piston.mass_kg, unit.parameters.chisel.mass_kg) = (1.0, 1.0);
    (unit.parameters.piston.chisel_contact, unit.parameters.chisel.casting_contact) = (law, law);
    scene.castings[0].mass_kg = 1.0;
    let model = build(&scene, &modes).expect("sound");
    let mut y0 = clear(&model);
    shift(&model, &mut y0, 0.006);
    place(&model, &mut y0, body::PISTON, (0.012 + 0.126 - 0.001, 1.0));
    let run = simulate(&model, &y0, (1e-8, 1e-3), 0.004);
    assert_eq!(run.stopped, Stopped::AtEnd);
    let hammer = Coupled::new(&model).hammer_state(0, 0.0, &run.y);
    let casting = run.y[heave_velocity(&model, 0)];
    println!("{} {} {casting}", hammer.velocity[body::PISTON], hammer.velocity[body::CHISEL]);
    // Published to five digits.
    assert_close("first", hammer.velocity[body::PISTON], -0.07095, 1e-5);
    assert_close("second", hammer.velocity[body::CHISEL], 0.07640, 1e-5);
    assert_close("third", casting, 0.99455, 1e-5);
}

/// A chisel that bounces on a casting too heavy to move, under gravity: each flight is `e` times as long as the one before,
/// down to flights a hundredth as long as the first; their limit lies at `sqrt(2h/g) (1+e)/(1-e)`. All else falls freely.
#[test]
fn analytic_bouncing_ball() {
    for law in [ContactLawName::KelvinVoigt, ContactLawName::KelvinVoigtSeparating, ContactLawName::Hertz] {
        let (e, gravity, height) = (0.8, 9.80665, 1e-4);
        let (mut scene, modes) = bench();
        scene.environment.gravity_m_s2 = gravity;
        scene.hammers[0].standoff_m = 0.0;
        everywhere(&mut scene, |contact| *contact = NO_CONTACT);
        // Only for a start at a finite place: nothing but this stop carries what hangs.
        scene.hammers[0].parameters.telescope.end_stop.stiffness_n_per_m = 1e14;
        let stated = ContactParameters {
            stiffness_n_per_m: 1e12,
            restitution: Some(e),
            reference_speed_m_s: Some(0.01),
            ..with_law(law)
        };
        scene.hammers[0].parameters.chisel.casting_contact = stated;
        scene.castings[0].mass_kg = 1e12;
        let model = build(&scene, &modes).expect("sound");
        let contact = contact_index(&model, HammerLink::ChiselCasting);
        let mut y0 = clear(&model);
        let face = model.elements().contacts()[contact].offset_m;
        shift(&model, &mut y0, 0.006);
        place(&model, &mut y0, body::CHISEL, (face - height, 0.0));
        // 20 flights: the last one has 0.8^20 = 1.2 % of the first one's length.
        let mut bounces = Bounces { contact, times: Vec::new() };
        let fall = (2.0 * height / gravity).sqrt();
        let end = fall * (1.0 + 2.0 * e * (1.0 - e.powi(20)) / (1.0 - e));
        let run = observe(&mut Coupled::new(&model), &y0, settings(1e-8, 1e-3), end, &mut bounces);
        assert_eq!(run.stopped, Stopped::AtEnd);
        let times = &bounces.times;
        println!("{law:?}: {} bounces up to {end} s, {} events", times.len(), run.counters.located_events);
        assert!(times.len() >= 20);
        for (n, onset) in (1..).zip(times) {
            // What the n contacts before take (4 to 10 us each) delays the bounce.
            let expected = fall * (1.0 + 2.0 * (e - e.powi(n)) / (1.0 - e));
            assert!(
                (onset - expected).abs() < 2e-5 * f64::from(n),
                "{law:?}, bounce {n}: {onset} instead of {expected}"
            );
        }
    }
}

/// Times at which a contact closes.
struct Bounces {
    contact: usize,
    times: Vec<f64>,
}

impl decore_model::integrate::Observer<Coupled> for Bounces {
    fn step(&mut self, _system: &Coupled, _step: &decore_model::integrate::Step<'_>) {}

    fn event(&mut self, system: &Coupled, guard: usize, t: f64, _y: &[f64]) {
        if guard == self.contact && system.is_closed(guard) {
            self.times.push(t);
        }
    }
}

/// Changes all contacts of all hammers.
fn everywhere(scene: &mut Scene, change: impl Fn(&mut ContactParameters)) {
    for unit in &mut scene.hammers {
        let p = &mut unit.parameters;
        let contacts = [
            &mut p.telescope.top_stop,
            &mut p.telescope.end_stop,
            &mut p.piston.rear_wall,
            &mut p.piston.chisel_contact,
            &mut p.valve.stop,
            &mut p.chisel.cylinder_contact,
            &mut p.chisel.casting_contact,
        ];
        contacts.into_iter().for_each(&change);
    }
}

/// A whole hammer hammers under every law with every joule accounted for. The first blow depends on the law by where the
/// cylinder rests on its top stop only: 1.3 % at most.
#[test]
fn analytic_energy_under_every_law() {
    for &law in ContactLawName::ALL {
        let (mut scene, modes) = rig(1);
        everywhere(&mut scene, |contact| contact.law = law);
        let model = build(&scene, &modes).expect("sound");
        let mut system = Coupled::new(&model);
        let mut recorder = Recorder::new(&model, &scene);
        let mut integrator = Integrator::<_, Tsit5>::new(&system, 0.0, model.initial_state(), &settings(1e-6, 1e-3));
        assert_eq!(integrator.run(&mut system, &mut recorder, 0.4), Stopped::AtEnd);
        let metrics = recorder.finish(&system, integrator.time(), integrator.state());
        let counters = integrator.counters();
        println!(
            "{law:?}: residual {:.1e}, {} steps, {} events, {:?} J, {} blows",
            metrics.totals.energy_residual,
            counters.steps,
            counters.located_events,
            metrics.hammers[0].first_impact_energy_j,
            metrics.blows.len()
        );
        assert!(metrics.totals.energy_residual.abs() < 1e-5, "{law:?}: {:e}", metrics.totals.energy_residual);
        assert!(metrics.blows.len() > 4);
        assert_relative("first blow", metrics.hammers[0].first_impact_energy_j.unwrap(), 70.31, 2e-2);
    }
}

/// A hammer that rests, its supply off, under every law: no contact chatters. Under Hunt-Crossley slow impacts lose next to
/// nothing, so chisel and piston go on bouncing from their drop of some micrometres, some 3000 events a second.
#[test]
fn regress_resting_contacts_do_not_chatter() {
    for &law in ContactLawName::ALL {
        let (mut scene, modes) = rig(1);
        everywhere(&mut scene, |contact| contact.law = law);
        scene.hammers[0].start_time_s = 10.0;
        let model = build(&scene, &modes).expect("sound");
        let run = simulate(&model, model.initial_state(), (1e-5, 1e-3), 0.5);
        println!("{law:?}: {} events, {} steps", run.counters.located_events, run.counters.steps);
        assert_eq!(run.stopped, Stopped::AtEnd);
        assert!(run.counters.located_events < 3000 && run.counters.steps < 200_000, "{law:?}: {:?}", run.counters);
    }
}

/// At rest the top stop carries what spring and weight leave to it, under every law.
#[test]
fn analytic_rest_under_every_law() {
    for &law in ContactLawName::ALL {
        let (mut scene, modes) = rig(1);
        everywhere(&mut scene, |contact| contact.law = law);
        let model = build(&scene, &modes).expect("sound");
        let mut system = Coupled::new(&model);
        let stop = contact_index(&model, HammerLink::TopStop);
        let weight = 9.80665 * (6.5 + 0.074 + 0.4546 + 1.8157);
        assert_relative(
            "stop force",
            system.contact_force(stop, 0.0, model.initial_state()),
            {
                let extension =
                    model.initial_state()[model.layout().position(model.hammers()[0].points[body::CYLINDER])];
                140.0 + 1.633e3 * extension - weight
            },
            1e-9,
        );
        let mut rate = vec![0.0; model.layout().dimension()];
        decore_model::integrate::System::rhs(&mut system, 0.0, model.initial_state(), &mut rate);
        // The cylinder carries no chisel, piston and spool yet: they fall until they touch.
        let cylinder = rate[model.layout().velocity(model.hammers()[0].points[body::CYLINDER])];
        let hanging = 9.80665 * (0.074 + 0.4546 + 1.8157) / 6.5;
        assert_close("acceleration of the cylinder", cylinder, -hanging, 1e-9);
    }
}

/// The law's split at its switching surfaces: where an indicator is zero the force is, and force, store and loss agree.
#[test]
fn analytic_split_of_the_laws() {
    let laws =
        ContactLawName::ALL.iter().map(|&law| ContactParameters { restitution: Some(0.6), ..with_law(law) }.law(MU));
    for law in laws {
        for (d, v) in [(1e-5, 0.7), (1e-5, -0.2), (4e-5, -3.0), (2e-5, 0.0)] {
            // Power of the force = growth of the store + loss.
            let h = 1e-5 * d;
            let growth = (law.stored_energy(d + h) - law.stored_energy(d - h)) / (2.0 * h) * v;
            let power = law.closed_force(d, v) * v;
            assert_close("power", growth + law.dissipated_power(d, v), power, 1e-7);
            assert!(law.dissipated_power(d, v) >= 0.0);
            // Open where it pushes, closed where it pulls (or, for separation at zero, where the bodies part).
            let pushes = match law {
                ContactLaw::KelvinVoigtSeparating { .. } => d > 0.0,
                _ => law.closed_force(d, v) > 0.0,
            };
            assert_eq!(law.onset_indicator(d, v) > 0.0, pushes, "{law:?} at {d}, {v}");
            assert_eq!(law.release_indicator(d, v) < 0.0, pushes, "{law:?} at {d}, {v}");
        }
        assert!(law.onset_indicator(-1e-6, 1.0) < 0.0 && law.onset_indicator(-1e-6, -1.0) < 0.0);
        let (d, v, a) = (2e-5, -0.1, 3e3);
        let (value, rate) = law.smooth_release(d, v, a);
        let ahead = law.smooth_release(d + 1e-9 * v, v + 1e-9 * a, a).0;
        assert_relative("rate of the release", (ahead - value) / 1e-9, rate, 1e-3);
    }
}
