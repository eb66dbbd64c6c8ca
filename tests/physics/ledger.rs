//! Ledger of the hammers' work, strikes on a casting, and a ranking of placements that does not depend on the fixtures.

use std::path::Path;

use crate::common::harness::assert_relative;
use crate::common::studies::{outcome, rig};
use decore_model::metrics::{Aggregates, BlowKind, CastingMetrics, RunMetrics};
use decore_model::run::{RowJob, RowStatus};
use decore_study::engine::{Engine, RowScene};

/// The parts of a casting's delivered work.
fn parts(casting: &CastingMetrics) -> f64 {
    casting.fixture_damper_loss_j
        + casting.fixture_spring_energy_j
        + casting.structure_work_j
        + casting.kinetic_energy_j
}

/// Each part is computed by itself, and the parts sum to the work: one and three hammers, one and two castings, rigid and tilting,
/// fixtures without and with damping, modes condensed and integrated, guides tied and sprung.
#[test]
fn the_parts_sum_to_the_delivered_work() {
    let damped = |damping: &str| format!("casting.part.fixture.table.damping_n_s_per_m={damping}");
    let cases: [(&str, Vec<String>); 6] = [
        ("paper_rig.toml", vec![]),
        ("paper_rig.toml", vec![damped("0")]),
        ("paper_rig.toml", vec![damped("40"), "solver.modes=integrated".into()]),
        ("paper_rig.toml", vec![damped("400"), "solver.guide=spring".into()]),
        ("placement.toml", vec!["hammer.hammer.rail_position_m=0.11".into()]),
        ("three_hammers.toml", vec![]),
    ];
    for (study, mut settings) in cases {
        settings.push("duration_s=0.4".into());
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let metrics = outcome(study, 0, &settings).metrics.unwrap();
        for casting in &metrics.castings {
            println!("{study} {settings:?}: {casting:?}");
            assert!(
                (parts(casting) - casting.delivered_work_j).abs() < 1e-4 * casting.strike_energy_j,
                "{study} {settings:?}"
            );
            assert!(casting.strike_contact_loss_j > 0.0);
        }
        let delivered: f64 = metrics.castings.iter().map(|casting| casting.delivered_work_j).sum();
        let strikes: f64 = metrics.castings.iter().map(|casting| casting.strike_energy_j).sum();
        assert_relative("strikes", strikes, metrics.totals.strike_energy_j, 1e-12);
        assert_relative("castings", delivered, metrics.totals.delivered_work_j, 1e-12);
    }
}

/// Largest differences between the energies of a casting and the sums over its fixtures, relative to its delivered work.
pub(crate) fn missing_in_fixtures(metrics: &RunMetrics, fixtures_of: &[usize]) -> f64 {
    let mut fixtures = metrics.fixtures.iter();
    let mut worst = 0.0_f64;
    for (casting, count) in metrics.castings.iter().zip(fixtures_of) {
        let own: Vec<_> = fixtures.by_ref().take(*count).collect();
        let loss: f64 = own.iter().map(|fixture| fixture.damper_loss_j).sum();
        let work: f64 = own.iter().map(|fixture| fixture.structure_work_j).sum();
        let off = (loss - casting.fixture_damper_loss_j).abs().max((work - casting.structure_work_j).abs());
        worst = worst.max(off / casting.delivered_work_j);
    }
    assert!(fixtures.next().is_none());
    worst
}

/// Energies through single fixtures are read off the steps; over the fixtures of a casting they sum to its own integrals. Asking for them
/// changes nothing else.
#[test]
fn energies_through_fixtures_sum_to_those_of_their_castings() {
    let cases: [(&str, &[usize], &[&str]); 4] = [
        ("paper_rig.toml", &[1], &[]),
        ("paper_rig.toml", &[1], &["solver.modes=integrated", "solver.guide=spring"]),
        ("placement.toml", &[4], &["hammer.hammer.rail_position_m=0.11"]),
        ("three_hammers.toml", &[4, 1], &[]),
    ];
    for (study, fixtures_of, settings) in cases {
        let settings = [settings, &["duration_s=0.4"]].concat();
        let without = outcome(study, 0, &settings).metrics.unwrap();
        let with = outcome(study, 0, &[&settings[..], &["outputs.fixture_energy=true"]].concat()).metrics.unwrap();
        let missing = missing_in_fixtures(&with, fixtures_of);
        println!("{study} {settings:?}: {missing:.1e} of the delivered work is missing");
        assert!(missing < 1e-10, "{study} {settings:?}: {missing:e}");
        assert!(without.fixtures.is_empty());
        assert!(with.fixtures.iter().all(|fixture| fixture.damper_loss_j > 0.0), "{:?}", with.fixtures);
        assert!(RunMetrics { fixtures: Vec::new(), ..with } == without, "{study}");
    }
}

/// Nearly all work on the rig's casting ends in the fixture's damper, and none where there is no damping: the delivered work falls
/// by a factor of 30, the energy of the strikes hardly changes.
#[test]
fn delivered_work_is_mostly_the_loss_of_the_fixture() {
    let run = |damping: &str| {
        let damping = format!("casting.part.fixture.table.damping_n_s_per_m={damping}");
        rig(&["duration_s=1", &damping]).castings.remove(0)
    };
    let (damped, undamped) = (run("4000"), run("0"));
    println!("{damped:?}\n{undamped:?}");
    assert!(damped.fixture_damper_loss_j > 0.9 * damped.delivered_work_j);
    assert_eq!(undamped.fixture_damper_loss_j, 0.0);
    assert!(undamped.delivered_work_j < 0.05 * damped.delivered_work_j);
    assert_relative("strikes", undamped.strike_energy_j, damped.strike_energy_j, 0.1);
}

/// A casting that only heaves on a soft fixture keeps the strike's energy as kinetic energy, and its momentum follows from both.
/// Integrals of forces are not under error control: they hold to 1e-5.
#[test]
fn analytic_strike_on_a_free_casting() {
    for mass_kg in [0.5, 2.0, 8.0] {
        let mass = format!("casting.part.mass_kg={mass_kg}");
        let fixture = "casting.part.fixture.table";
        let soft = [
            format!("{fixture}.stiffness_n_per_m=1"),
            format!("{fixture}.damping_n_s_per_m=0"),
            "duration_s=0.06".to_owned(),
        ];
        let metrics = rig(&[&mass, &soft[0], &soft[1], &soft[2]]);
        let hammer = &metrics.hammers[0];
        let kinetic = hammer.first_impact_strike_kinetic_energy_j.unwrap();
        let momentum = hammer.first_impact_strike_momentum_n_s.unwrap();
        println!("{mass_kg} kg: {kinetic} J, {momentum} N s");
        assert_relative("energy", hammer.first_impact_strike_energy_j.unwrap(), kinetic, 1e-5);
        assert_relative("momentum", momentum, (2.0 * mass_kg * kinetic).sqrt(), 1e-5);
        let peak = hammer.first_impact_casting_peak_velocity_m_s.unwrap();
        assert_relative("peak", peak, momentum / mass_kg, 1e-5);
    }
}

/// Blows, hammers and aggregates hold the same strikes.
#[test]
fn strikes_add_up() {
    let metrics = rig(&["duration_s=1"]);
    let hammer = &metrics.hammers[0];
    let sum = |value: fn(&decore_model::metrics::Blow) -> f64| metrics.blows.iter().map(value).sum::<f64>();
    assert_relative("momentum", hammer.strike_momentum_n_s, sum(|blow| blow.strike_momentum_n_s), 1e-12);
    assert_relative("energy", hammer.strike_energy_j, sum(|blow| blow.strike_energy_j), 1e-12);
    assert_relative("kinetic", hammer.strike_kinetic_energy_j, sum(|blow| blow.strike_kinetic_energy_j), 1e-12);
    let periodic = metrics.blows.iter().filter(|blow| blow.kind == BlowKind::Periodic);
    let energies: Vec<f64> = periodic.map(|blow| blow.strike_energy_j).collect();
    let mean = energies.iter().sum::<f64>() / energies.len() as f64;
    assert_relative("mean", hammer.periodic_strike_energy_mean_j.unwrap(), mean, 1e-12);
    let rate = Aggregates::of(&metrics).total_strike_energy_rate_w;
    assert_relative("rate", rate, mean * hammer.hit_frequency_hz.unwrap(), 1e-12);
    assert!(metrics.blows.iter().all(|blow| blow.strike_kinetic_energy_j <= blow.strike_energy_j));
}

/// Placements of the shipped study with one damping of all fixtures.
fn placements(damping: &str) -> Vec<RunMetrics> {
    let fixtures = ["front_left", "front_right", "back_left", "back_right"];
    let mut settings: Vec<String> =
        fixtures.map(|name| format!("casting.part.fixture.{name}.damping_n_s_per_m={damping}")).to_vec();
    settings.push("design.rows=50".to_owned());
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    let engine = Engine::load(&study, &settings).unwrap();
    let run = |row: usize| {
        let RowScene { scene, modes } = engine.scene(row).unwrap();
        let outcome = RowJob::new(scene, modes, 0).run();
        assert_eq!(outcome.status, RowStatus::Done, "row {row}: {}", outcome.reason);
        outcome.metrics.unwrap()
    };
    (0..50).map(run).collect()
}

/// Spearman's rank correlation of two series without ties.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let ranks = |values: &[f64]| -> Vec<f64> {
        values.iter().map(|value| values.iter().filter(|other| *other < value).count() as f64).collect()
    };
    let n = a.len() as f64;
    let squares = ranks(a).iter().zip(ranks(b)).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

/// The damping of the fixtures does not set the order of placements by the default ranking; it does set that by delivered work.
#[test]
fn the_default_ranking_keeps_its_order_over_fixture_damping() {
    let (light, heavy) = (placements("40"), placements("4000"));
    let order = |value: fn(&RunMetrics) -> f64| {
        let of = |runs: &[RunMetrics]| runs.iter().map(value).collect::<Vec<_>>();
        rank_correlation(&of(&light), &of(&heavy))
    };
    let (given, delivered) = (order(|run| run.totals.strike_energy_j), order(|run| run.totals.delivered_work_j));
    println!("rank correlation over damping: strikes {given:.3}, delivered work {delivered:.3}");
    assert_eq!(decore_lab::report::DEFAULT_RANKING, "strike_energy_j");
    assert!(given >= 0.9 && delivered < 0.9, "{given} {delivered}");
}
