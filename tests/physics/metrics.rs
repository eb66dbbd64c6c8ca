//! Outputs of a run against their definitions, worked out a second time from the bare trajectory.

use crate::common::harness::{assert_close, assert_relative};
use crate::common::scenes::{heave_velocity, rig};
use decore_model::hammer::body;
use decore_model::integrate::{Observer, Step, System};
use decore_model::metrics::{BlowKind, RunMetrics};
use decore_model::run::{run_row, run_row_observed};
use decore_model::scene::{HammerLink, OutputSettings, Owner, PointId, Scene};
use decore_model::system::{Coupled, InterfaceModes};

/// Everything that the definitions need, kept as it comes.
#[derive(Default)]
struct Trace {
    /// Onsets of chisel-casting contacts: hammer, time.
    contacts: Vec<(usize, f64)>,
    /// Their ends.
    releases: Vec<(usize, f64)>,
    /// Deepest penetration of each chisel at an instant with its contact closed, m; sampled as below.
    depths_m: Vec<f64>,
    /// Largest force at an onset, N.
    largest_onset_n: f64,
    /// Onsets of piston-chisel contacts: hammer, time, closing speed, whether the gate is open, kinetic energy.
    strikes: Vec<(usize, f64, f64, bool, f64)>,
    /// Parts of a step at whose ends samples are taken; 0: none.
    parts: usize,
    /// Per hammer: time, chisel-casting force, casting's velocity, mount's velocity.
    samples: Vec<Vec<[f64; 4]>>,
}

/// Samples of a step, dense enough for integrals by the trapezoidal rule to 1e-4.
const PARTS: usize = 24;

impl Observer<Coupled> for Trace {
    fn step(&mut self, system: &Coupled, step: &Step<'_>) {
        if self.parts == 0 {
            return;
        }
        let model = system.model();
        self.samples.resize(model.hammers().len(), Vec::new());
        self.depths_m.resize(model.hammers().len(), 0.0);
        let mut y = vec![0.0; system.dimension()];
        for part in 0..=self.parts {
            let theta = step.theta_end * part as f64 / self.parts as f64;
            step.state(theta, &mut y);
            for (h, slot) in model.hammers().iter().enumerate() {
                let force = system.contact_force(slot.strike, step.time(theta), &y);
                let heave = y[heave_velocity(model, slot.casting)];
                let arm = system.motion(PointId::Mount { hammer: h }, step.time(theta), &y).1;
                self.samples[h].push([step.time(theta), force, heave, arm]);
                if system.is_closed(slot.strike) {
                    let (depth_m, _) = system.penetration(slot.strike, step.time(theta), &y);
                    self.depths_m[h] = self.depths_m[h].max(depth_m);
                }
            }
        }
    }

    fn event(&mut self, system: &Coupled, guard: usize, t: f64, y: &[f64]) {
        let model = system.model();
        let contact = &model.elements().contacts()[guard];
        let Owner::Hammer { hammer: h, link } = contact.owner else { return };
        match link {
            HammerLink::ChiselCasting if system.is_closed(guard) => {
                self.contacts.push((h, t));
                self.largest_onset_n = self.largest_onset_n.max(system.contact_force(guard, t, y));
            }
            HammerLink::ChiselCasting => self.releases.push((h, t)),
            HammerLink::PistonChisel if system.is_closed(guard) => {
                let state = system.hammer_state(h, t, y);
                let closing = state.velocity[body::PISTON] - state.velocity[body::CHISEL];
                let masses = model.hammers()[h].model.mass();
                let energy = (1..body::COUNT).map(|i| 0.5 * masses[i] * state.velocity[i].powi(2)).sum();
                self.strikes.push((h, t, closing, system.gate_open(h), energy));
            }
            _ => {}
        }
    }
}

fn traced(scene: &Scene, modes: &InterfaceModes, parts: usize) -> (RunMetrics, Trace) {
    let (outcome, trace) = run_row_observed(scene, modes, |_| Trace { parts, ..Trace::default() });
    (outcome.metrics.expect("done"), trace.expect("built"))
}

fn long_rig(hammers: usize) -> (Scene, InterfaceModes) {
    let (mut scene, modes) = rig(hammers);
    scene.duration_s = 0.6;
    (scene, modes)
}

/// Contacts of a hammer by the definition: onsets that come late enough after the release before them.
fn contact_count(h: usize, trace: &Trace, settings: &OutputSettings) -> u64 {
    let onsets = trace.contacts.iter().filter(|contact| contact.0 == h);
    let separate = onsets.filter(|(_, t)| {
        let before = trace.releases.iter().rev().find(|release| release.0 == h && release.1 <= *t);
        before.is_none_or(|release| t - release.1 >= settings.contact_separation_s)
    });
    separate.count() as u64
}

/// Starts of a hammer's blows by the definitions: the first contact, then strikes that close fast enough, late enough after
/// the one before, with the gate open; without those whose window passes the end.
fn blow_starts(h: usize, trace: &Trace, settings: &OutputSettings, end: f64) -> Vec<f64> {
    let mut starts: Vec<f64> =
        trace.contacts.iter().filter(|contact| contact.0 == h).map(|contact| contact.1).take(1).collect();
    for &(hammer, t, closing, gate_open, _) in &trace.strikes {
        let separate = starts.last().is_none_or(|last| t - last >= settings.blow_separation_s);
        if hammer == h && gate_open && closing >= settings.blow_closing_speed_m_s && separate {
            starts.push(t);
        }
    }
    // A window ends where the next blow starts at the latest.
    let whole = |pair: &[f64]| pair[0] + settings.blow_window_s <= end || pair.len() > 1;
    (0..starts.len()).filter(|&n| whole(&starts[n..starts.len().min(n + 2)])).map(|n| starts[n]).collect()
}

/// Blows are counted as defined, for the default thresholds and for altered ones, one hammer and two.
#[test]
fn blows_follow_their_definition() {
    let default = OutputSettings::default();
    let altered = [
        default.clone(),
        OutputSettings { blow_closing_speed_m_s: 0.0, blow_separation_s: 0.0, ..default.clone() },
        OutputSettings { blow_closing_speed_m_s: 8.0, ..default.clone() },
        OutputSettings { blow_separation_s: 0.1, ..default.clone() },
        OutputSettings { blow_window_s: 0.1, ..default.clone() },
        OutputSettings { contact_separation_s: 0.0, ..default.clone() },
        OutputSettings { contact_separation_s: 1e-3, ..default.clone() },
    ];
    let (mut counts, mut contacts) = (Vec::new(), Vec::new());
    for hammers in [1, 2] {
        for settings in altered.clone() {
            let (mut scene, modes) = long_rig(hammers);
            scene.outputs = settings.clone();
            let (metrics, trace) = traced(&scene, &modes, 0);
            for h in 0..hammers {
                let own = || metrics.blows.iter().filter(|blow| blow.hammer == h);
                let found: Vec<f64> = own().map(|blow| blow.start_time_s).collect();
                let expected = blow_starts(h, &trace, &settings, scene.duration_s);
                assert_eq!(found, expected, "{settings:?}");
                assert!(own().map(|blow| blow.number).eq(0..found.len()));
                let mut struck = 0;
                for (n, blow) in own().enumerate() {
                    let blank = blow.peak_force_n <= 0.0;
                    struck += usize::from(n > 0 && !blank);
                    let kind = match n {
                        0 => BlowKind::FirstImpact,
                        _ if blank => BlowKind::Blank,
                        _ if struck <= settings.settling_blows => BlowKind::Settling,
                        _ => BlowKind::Periodic,
                    };
                    assert_eq!((blow.kind, blow.stroke), (kind, 0));
                }
                assert_eq!(metrics.hammers[h].contact_count, contact_count(h, &trace, &settings));
                contacts.push(metrics.hammers[h].contact_count);
                counts.push(found.len());
            }
        }
    }
    println!("blows {counts:?}, contacts {contacts:?}");
    // The alterations do alter the count.
    assert!(counts[2] < counts[0] && counts[3] < counts[0]);
    assert!(contacts[6] < contacts[0] && contacts[0] < contacts[5]);
}

/// Energy, work, impulse, peaks of every blow, and the sums over blows, from the sampled trajectory. 1e-3: the trapezoidal
/// rule and the sampled maximum, 24 parts a step.
#[test]
fn quantities_follow_their_definition() {
    let (scene, modes) = long_rig(1);
    let (metrics, trace) = traced(&scene, &modes, PARTS);
    let samples = &trace.samples[0];
    let integral = |from: f64, to: f64, f: &dyn Fn(&[f64; 4]) -> f64| -> f64 {
        let inside = samples.windows(2).filter(|pair| pair[0][0] >= from - 1e-12 && pair[1][0] <= to);
        inside.map(|pair| 0.5 * (pair[1][0] - pair[0][0]) * (f(&pair[0]) + f(&pair[1]))).sum()
    };
    let largest = |from: f64, to: f64, column: usize| -> f64 {
        let inside = samples.iter().filter(|sample| sample[0] >= from - 1e-12 && sample[0] <= to);
        inside.fold(0.0, |largest, sample| largest.max(sample[column].abs()))
    };
    let mut worst = [0.0f64; 4];
    for blow in &metrics.blows {
        let (from, to) = (blow.start_time_s, blow.start_time_s + scene.outputs.blow_window_s);
        let expected = [
            integral(from, to, &|sample| sample[1] * sample[2]),
            integral(from, to, &|sample| sample[1]),
            largest(from, to, 1),
            largest(from, to, 2),
        ];
        let found = [blow.work_j, blow.impulse_n_s, blow.peak_force_n, blow.casting_peak_velocity_m_s];
        for i in 0..4 {
            let scale = [1.0, 1.0, 0.0, 0.0][i];
            worst[i] = worst[i].max((found[i] - expected[i]).abs() / expected[i].abs().max(scale));
        }
        let strike = trace.strikes.iter().find(|strike| strike.1 == from);
        if let Some(strike) = strike {
            assert_relative("energy", blow.energy_j, strike.4, 1e-12);
        }
    }
    println!("work, impulse, force, velocity off by {worst:?}");
    assert!(worst.iter().all(|error| *error < 1e-3), "{worst:?}");
    check_sums(&metrics, &scene);
    let hammer = &metrics.hammers[0];
    assert_relative("deepest penetration", hammer.largest_penetration_m, trace.depths_m[0], 1e-3);
    assert_relative("largest jump", hammer.largest_jump_force_n, trace.largest_onset_n, 1e-6);
    let first = trace.contacts[0].1;
    let rms = |from: f64, to: f64| (integral(from, to, &|sample| sample[3] * sample[3]) / (to - from)).sqrt();
    assert_relative("arm, extension", hammer.arm_rms_extension_m_s.expect("moved"), rms(0.0, first), 1e-3);
    let hammering = hammer.arm_rms_hammering_m_s.expect("hammered");
    assert_relative("arm, hammering", hammering, rms(first, scene.duration_s), 1e-3);
    let peak = largest(0.0, scene.duration_s, 2);
    assert_relative("peak of the run", metrics.castings[0].peak_velocity_m_s, peak, 1e-3);
    let at = metrics.castings[0].peak_velocity_time_s;
    assert!(samples.iter().any(|sample| (sample[0] - at).abs() < 1e-5 && sample[2].abs() > 0.999 * peak));
}

/// Means, standard deviation and frequency over the periodic window.
fn check_sums(metrics: &RunMetrics, scene: &Scene) {
    let hammer = &metrics.hammers[0];
    let periodic: Vec<_> = metrics.blows.iter().filter(|blow| blow.kind == BlowKind::Periodic).collect();
    assert_eq!(hammer.periodic_blows as usize, periodic.len());
    assert_eq!(hammer.struck_blow_count as usize, periodic.len() + scene.outputs.settling_blows);
    let n = periodic.len() as f64;
    let mean = periodic.iter().map(|blow| blow.energy_j).sum::<f64>() / n;
    let variance = periodic.iter().map(|blow| (blow.energy_j - mean).powi(2)).sum::<f64>() / n;
    assert_relative("mean", hammer.periodic_energy_mean_j.expect("periodic"), mean, 1e-12);
    assert_close("deviation", hammer.periodic_energy_std_j.expect("periodic"), variance.sqrt(), 1e-12);
    let span = periodic[periodic.len() - 1].start_time_s - periodic[0].start_time_s;
    assert_relative("frequency", hammer.hit_frequency_hz.expect("periodic"), (n - 1.0) / span, 1e-12);
    let first = &metrics.blows[0];
    assert_eq!(hammer.first_impact_time_s, Some(first.start_time_s));
    assert_eq!(hammer.first_impact_energy_j, Some(first.energy_j));
    assert_eq!(hammer.first_impact_work_j, Some(first.work_j));
}

/// A blow counts only with its whole window: the first impact's outputs appear when the run lasts to the window's end.
#[test]
fn a_window_beyond_the_end_does_not_count() {
    let (mut scene, modes) = rig(1);
    scene.duration_s = 0.1;
    let start = run_row(&scene, &modes).metrics.expect("done").hammers[0].first_impact_time_s.expect("an impact");
    for (duration, counts) in [(start + 0.0049, false), (start + 0.0051, true)] {
        scene.duration_s = duration;
        let metrics = run_row(&scene, &modes).metrics.expect("done");
        assert_eq!(metrics.blows.len(), usize::from(counts));
        assert_eq!(metrics.hammers[0].first_impact_time_s.is_some(), counts);
        assert!(metrics.hammers[0].contact_count > 0);
    }
    // Without any contact: nothing, and the arm's figure covers the whole run.
    scene.duration_s = 0.5 * start;
    let metrics = run_row(&scene, &modes).metrics.expect("done");
    assert_eq!(metrics.hammers[0].contact_count, 0);
    assert_eq!(metrics.hammers[0].arm_rms_hammering_m_s, None);
    assert!(metrics.hammers[0].arm_rms_extension_m_s.expect("moved") > 0.0);
}

/// A hammer never switched on draws no air; one that is draws more with more pressure.
#[test]
fn air_follows_the_supply() {
    let air = |bar: f64| {
        let (mut scene, modes) = rig(1);
        scene.duration_s = 0.2;
        scene.hammers[0].supply_pressure_pa = 101_325.0 + 1e5 * bar;
        run_row(&scene, &modes).metrics.expect("done").hammers[0].air_used_nl
    };
    let used = [0.0, 3.0, 5.0, 7.0].map(air);
    println!("{used:?} standard litres");
    assert!(used[0].abs() < 1e-3 && used.windows(2).all(|pair| pair[1] > pair[0]));
}
