//! Core points: spectra against an independent recursion over the signals, doses, probabilities, and what a sweep keeps of them.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use decore_model::metrics::{CoreMetrics, RunMetrics, spectrum_frequencies_hz};
use decore_model::run::RowStatus;
use decore_study::Study;
use decore_study::engine::{Engine, RowRunner};
use tempfile::TempDir;

/// One hammer on a casting of 3 kg that is held off its centre, with two core points; `outputs` are lines of `[outputs]`.
fn study(outputs: &str, more: &str) -> String {
    format!(
        "duration_s = 0.4\ngeometry = \"as_given\"\n[structure]\ncutoff_hz = 500.0\n[hammer.left]\nmount = \"R5\"\nsupply_bar = 5.0\n\
         [solver]\ntolerance = 1e-8\n[casting.part]\nmass_kg = 3.0\ninertia_kg_m2 = [0.01, 0.02]\n\
         [casting.part.core.near]\nat_m = [0.0, 0.0, 0.0]\n[casting.part.core.far]\nat_m = [0.08, 0.02, 0.0]\n\
         [casting.part.core.middle]\nat_m = [0.04, 0.01, 0.0]\n[casting.part.core.back]\nat_m = [-0.06, 0.0, 0.0]\n\
         [casting.part.fixture.a]\npoint = \"T5\"\nat_m = [-0.08, 0.0]\n[casting.part.fixture.b]\npoint = \"T5\"\nat_m = [0.06, 0.03]\n\
         [casting.part.fixture.c]\npoint = \"T5\"\nat_m = [0.06, -0.02]\n[outputs]\n{outputs}\n{more}"
    )
}

fn engine(text: &str, folder: &Path) -> Engine {
    fs::write(folder.join("study.toml"), text).unwrap();
    let study = Study::load(&folder.join("study.toml")).unwrap_or_else(|error| panic!("{error}"));
    Engine::new(study).unwrap_or_else(|error| panic!("{error}"))
}

fn metrics(text: &str) -> RunMetrics {
    let folder = TempDir::new().unwrap();
    let outcome = engine(text, folder.path()).outcome(0);
    assert_eq!(outcome.status, RowStatus::Done, "{}", outcome.reason);
    outcome.metrics.unwrap()
}

/// Largest pseudo-velocity of an oscillator on a point with these velocities: the mean acceleration of each interval acts throughout it.
fn sampled(velocity: &[f64], interval_s: f64, frequency_hz: f64) -> f64 {
    let omega = TAU * frequency_hz;
    let (decay, damped) = (-0.05 * omega, omega * (1.0 - 0.05_f64 * 0.05).sqrt());
    let (size, angle) = ((decay * interval_s).exp(), damped * interval_s);
    let exp = [size * angle.cos(), size * angle.sin()];
    // (exp - 1) / lambda.
    let square = decay * decay + damped * damped;
    let gain =
        [((exp[0] - 1.0) * decay + exp[1] * damped) / square, (exp[1] * decay - (exp[0] - 1.0) * damped) / square];
    let (mut u, mut largest) = ([0.0; 2], 0.0_f64);
    for pair in velocity.windows(2) {
        let acceleration = (pair[1] - pair[0]) / interval_s;
        u = [
            exp[0] * u[0] - exp[1] * u[1] - gain[0] * acceleration,
            exp[0] * u[1] + exp[1] * u[0] - gain[1] * acceleration,
        ];
        largest = largest.max(omega * u[1].abs() / damped);
    }
    largest
}

/// Spectra follow from the velocity signals of the points by a recursion that is written here.
#[test]
fn spectra_follow_from_the_velocity_signals() {
    let folder = TempDir::new().unwrap();
    let text = study("core_spectra = true", "").replace("duration_s = 0.4", "duration_s = 0.1");
    let engine = engine(&text, folder.path());
    let interval_s = 5e-7;
    let (outcome, signals) = engine.outcome_with_signals(0, interval_s).unwrap();
    let signals = signals.unwrap();
    let metrics = outcome.metrics.unwrap();
    for (core, name) in metrics.cores.iter().zip(["near", "far", "middle", "back"]) {
        let column = format!("part_core_{name}_velocity_m_s");
        let signal = signals.iter().find(|signal| signal.name == column).unwrap();
        let spectrum = core.spectrum.as_ref().unwrap();
        let pairs = spectrum_frequencies_hz().into_iter().zip(&spectrum.pseudo_velocity_m_s);
        for (frequency_hz, pseudo_velocity) in pairs {
            let expected = sampled(&signal.values, interval_s, frequency_hz);
            // Samples miss a peak by up to (pi f interval)^2 / 2.
            let tolerance = 4e-6 + (3.2 * frequency_hz * interval_s).powi(2);
            assert!(
                (pseudo_velocity / expected - 1.0).abs() < tolerance,
                "{name}, {frequency_hz}: {pseudo_velocity} {expected}"
            );
        }
        let largest = spectrum.pseudo_velocity_m_s.iter().copied().fold(0.0, f64::max);
        assert_eq!(core.pseudo_velocity_98hz_10khz_m_s, Some(largest));
        let first = core.first_impact_pseudo_velocity_98hz_10khz_m_s.unwrap();
        assert!(first > 0.1 && first <= largest);
    }
    let totals = metrics.core_totals.unwrap();
    let least =
        metrics.cores.iter().filter_map(|core| core.pseudo_velocity_98hz_10khz_m_s).fold(f64::INFINITY, f64::min);
    assert_eq!(totals.least_core_pseudo_velocity_98hz_10khz_m_s, Some(least));
    let place = metrics.cores.iter().position(|core| core.pseudo_velocity_98hz_10khz_m_s == Some(least)).unwrap();
    assert_eq!(totals.least_core, ["part.near", "part.far", "part.middle", "part.back"][place]);
}

/// A dose scales with the power of its reference; the time to a dose within the run is the time at which it is reached, and beyond it the
/// rate of the blows leads there; the probability is Weibull's.
#[test]
fn doses_times_and_probabilities() {
    let run = |lines: &str, duration_s: f64| {
        let text = study(&format!("core_spectra = true\ncore_dose_exponent = 4.0\n{lines}"), "");
        metrics(&text.replace("duration_s = 0.4", &format!("duration_s = {duration_s:?}")))
    };
    let with = |lines: &str| run(lines, 0.6);
    let dose = |of: &CoreMetrics| of.dose_98hz_10khz.unwrap();
    let plain = with("core_dose_reference_m_s = 1.0");
    let halved = with("core_dose_reference_m_s = 0.5");
    for (one, other) in plain.cores.iter().zip(&halved.cores) {
        assert!((dose(other) / dose(one) / 16.0 - 1.0).abs() < 1e-12);
        assert_eq!((one.time_to_dose_s, one.break_probability), (None, None));
    }
    let all = dose(&plain.cores[0]);
    let periodic = plain.cores[0].periodic_pseudo_velocity_98hz_10khz_mean_m_s.unwrap();
    assert!(periodic > 0.1 && periodic < plain.cores[0].first_impact_pseudo_velocity_98hz_10khz_m_s.unwrap());
    let wanted = |share: f64| {
        format!("core_dose_reference_m_s = 1.0\ncore_wanted_dose = {}\ncore_strength_m_s = 3.0", share * all)
    };
    let within = with(&wanted(0.9));
    let reached = within.cores[0].time_to_dose_s.unwrap();
    let first_impact_s = within.hammers[0].first_impact_time_s.unwrap();
    assert!(reached > first_impact_s && reached < 0.6, "{reached}");
    let extrapolated = with(&wanted(1.5)).cores[0].time_to_dose_s.unwrap();
    let true_time = run(&wanted(1.5), 3.0 * extrapolated).cores[0].time_to_dose_s.unwrap();
    assert!(extrapolated > 0.6 && (extrapolated / true_time - 1.0).abs() < 0.3, "{extrapolated} {true_time}");
    // The rate bounds: no oscillator grows by more than its dose, the largest dose grows by what it has beyond the first impact's window.
    let rate = plain.cores[0].dose_rate_98hz_10khz_per_s.unwrap();
    let after_s = first_impact_s + 0.0051;
    let before = dose(&run("core_dose_reference_m_s = 1.0", after_s).cores[0]);
    let grown = rate * (0.6 - first_impact_s - 0.005);
    assert!(before > 0.0 && (all - before) * 0.999 < grown && grown < all, "{before} {grown} {all}");
    // A far dose is reached at that rate.
    let far_s = with(&wanted(1e9)).cores[0].time_to_dose_s.unwrap();
    assert!((1e9 * all / far_s / rate - 1.0).abs() < 1e-6, "{far_s} {rate}");
    let core = &within.cores[0];
    let strength = (core.pseudo_velocity_98hz_10khz_m_s.unwrap() / 3.0).powi(5);
    assert!((core.break_probability.unwrap() - (1.0 - (-strength).exp())).abs() < 1e-12);
    assert!(core.blows_above_threshold.unwrap() >= 1 && core.blow_energy_per_mass_j_per_kg.unwrap() > 0.0);
}

/// Spectra are no part of the motion: all other outputs are the same without them; core points without spectra have a peak only.
#[test]
fn spectra_change_nothing_else() {
    let (with, without) = (metrics(&study("core_spectra = true", "")), metrics(&study("", "")));
    assert_eq!((&with.hammers, &with.castings, &with.totals), (&without.hammers, &without.castings, &without.totals));
    assert_eq!(with.cores.len(), without.cores.len());
    for (one, other) in with.cores.iter().zip(&without.cores) {
        assert_eq!(*other, CoreMetrics { peak_velocity_m_s: one.peak_velocity_m_s, ..CoreMetrics::default() });
    }
    assert!(without.core_totals.is_none());
}

/// Two hammers that strike at the same instant: the window of one does not end that of the other.
#[test]
fn first_impacts_at_the_same_instant_are_seen_whole() {
    let second = "[hammer.right]\nmount = \"R5\"\nsupply_bar = 5.0\nstrike_point_m = [0.01, 0.0]\n";
    let both = metrics(&study("core_spectra = true", second));
    let starts: Vec<f64> = both.hammers.iter().filter_map(|hammer| hammer.first_impact_time_s).collect();
    assert!(starts.len() == 2 && (starts[0] - starts[1]).abs() < 1e-3, "{starts:?}");
    for core in &both.cores {
        let (first, all) = (core.first_impact_pseudo_velocity_98hz_10khz_m_s, core.pseudo_velocity_98hz_10khz_m_s);
        assert!(first.unwrap() > 0.5 * all.unwrap(), "{first:?} {all:?}");
    }
}
