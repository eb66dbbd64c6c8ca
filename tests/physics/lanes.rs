//! Rows side by side: what a row gives does not depend on its neighbours, on its lane, or on whether it has any.

use std::any::Any;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::common::studies::scene;
use crate::fragile::Fragile;
use decore_math::number::Registers;
use decore_model::contact::ContactLawName;
use decore_model::run::{JobSource, RowJob, RowOutcome, RowStatus, run_jobs_in, run_jobs_over};
use decore_model::scene::Scene;
use decore_study::engine::{Engine, RowScene};

/// Rows in an order; what came of them.
struct Rows {
    left: VecDeque<(u64, RowJob)>,
    ended: BTreeMap<u64, RowOutcome>,
    panicked: Vec<u64>,
}

impl JobSource for Rows {
    fn next(&mut self, _wait: bool) -> Option<(u64, RowJob)> {
        self.left.pop_front()
    }

    fn ended(&mut self, row: u64, outcome: RowOutcome) {
        assert!(self.ended.insert(row, without_time(outcome)).is_none());
    }

    fn panicked(&mut self, row: u64, _payload: Box<dyn Any + Send>) {
        self.panicked.push(row);
    }
}

fn without_time(outcome: RowOutcome) -> RowOutcome {
    RowOutcome { wall_time_s: 0.0, numerical_twin_wall_time_s: None, ..outcome }
}

fn side_by_side(
    run: impl FnOnce(&mut dyn JobSource),
    jobs: impl Iterator<Item = (u64, RowJob)>,
) -> BTreeMap<u64, RowOutcome> {
    let mut rows = Rows { left: jobs.collect(), ended: BTreeMap::new(), panicked: Vec::new() };
    run(&mut rows);
    assert!(rows.panicked.is_empty());
    rows.ended
}

/// The registers that this processor has, and code for those that have none.
fn available() -> impl Iterator<Item = Registers> + Clone {
    Registers::ALL.into_iter().filter(|registers| registers.are_available())
}

/// Rows that differ in pressure, standoff and duration, the fifth with a budget of steps that it exceeds, the sixth with twins, the seventh
/// with a numerical twin.
fn rows(settings: &[&str], mut change: impl FnMut(&mut Scene)) -> Vec<RowJob> {
    let (first, modes) = scene("paper_rig.toml", 0, settings).unwrap();
    let mut row = |i: usize| {
        let mut scene = first.clone();
        let unit = &mut scene.hammers[0];
        unit.supply_pressure_pa *= 1.0 - 0.015 * i as f64;
        unit.standoff_m -= 0.003 * i as f64;
        scene.duration_s = 0.11 + 0.007 * i as f64;
        match i {
            4 => scene.solver.max_steps = 700,
            5 => scene.outputs.twins = 1,
            _ => {}
        }
        change(&mut scene);
        let job = RowJob::new(scene, Arc::clone(&modes), 1);
        // Its guide is on its spring: where that of the others is tied, it has another shape.
        if i == 6 { job.with_numerical_twin(Some(Arc::clone(&modes))) } else { job }
    };
    (0..11).map(&mut row).collect()
}

/// Bits of every number of an outcome, as far as its text shows them: Rust writes the shortest digits that give a number back.
fn text(outcome: &RowOutcome) -> String {
    format!("{outcome:?}")
}

#[track_caller]
fn same_in_any_order(jobs: &[RowJob]) {
    let alone: Vec<String> = jobs.iter().map(|job| text(&without_time(job.clone().run()))).collect();
    let count = jobs.len();
    let orders: [Vec<usize>; 3] =
        [(0..count).collect(), (0..count).rev().collect(), (0..count).map(|i| (3 * i + 2) % count).collect()];
    let ways = available();
    for (order, registers) in orders.iter().flat_map(|order| ways.clone().map(move |registers| (order, registers))) {
        let run = |source: &mut dyn JobSource| run_jobs_in(registers, source);
        let ended = side_by_side(run, order.iter().map(|&row| (row as u64, jobs[row].clone())));
        for (row, alone) in alone.iter().enumerate() {
            assert_eq!(text(&ended[&(row as u64)]), *alone, "row {row} in the order {order:?}, {registers:?}");
        }
    }
}

/// Condensed and integrated modes, guides tied and on their springs, with refills, a budget that ends in the middle, and twins.
#[test]
fn lanes_equal_rows_alone() {
    for settings in [
        ["solver.guide=tied", "solver.modes=condensed"],
        ["solver.guide=tied", "solver.modes=integrated"],
        ["solver.guide=spring", "solver.modes=condensed"],
    ] {
        let jobs = rows(&settings, |_| ());
        let budget = jobs[4].clone().run();
        assert_eq!(budget.status, RowStatus::BudgetExhausted, "{settings:?}");
        same_in_any_order(&jobs);
    }
}

/// Every law of contacts, each row with coefficients of its own: all of them differ from the neighbours'.
#[test]
fn lanes_equal_rows_alone_under_every_law() {
    for &law in ContactLawName::ALL {
        let mut share = 0.0;
        let jobs = rows(&["solver.guide=tied"], |scene| {
            share += 0.01;
            let p = &mut scene.hammers[0].parameters;
            for contact in [&mut p.chisel.cylinder_contact, &mut p.chisel.casting_contact, &mut p.piston.chisel_contact]
            {
                contact.law = law;
                contact.stiffness_n_per_m *= 1.0 - share;
                contact.restitution = Some(0.9 - share);
                contact.exponent = Some(1.5 + share);
            }
        });
        let law_of =
            |job: &RowJob| format!("{:?}", job.scene().unwrap().hammers[0].parameters.chisel.casting_contact.law(1.0));
        let [first, second] = [&jobs[0], &jobs[1]].map(law_of);
        assert!(first.split(',').zip(second.split(',')).all(|(one, other)| one != other), "{first}, {second}");
        same_in_any_order(&jobs);
    }
}

/// A budget of steps or of wall time that a row exceeds ends that row only: the others are what they are alone.
#[test]
fn budgets_end_one_row_only() {
    let mut jobs = rows(&["solver.guide=tied"], |_| ());
    let alone: Vec<String> = jobs.iter().map(|job| text(&without_time(job.clone().run()))).collect();
    assert!(alone[4].contains("more than 700 steps"), "{}", alone[4]);
    let mut slow = jobs[2].scene().unwrap();
    slow.solver.max_wall_time_s = 0.0;
    jobs[2] = RowJob::new(slow, Arc::clone(jobs[2].modes()), 1);
    for registers in available() {
        let run = |source: &mut dyn JobSource| run_jobs_in(registers, source);
        let ended = side_by_side(run, (0..).zip(jobs.iter().cloned()));
        for (row, alone) in (0..).zip(&alone).filter(|(row, _)| *row != 2) {
            assert_eq!(text(&ended[&row]), *alone, "row {row}");
        }
        assert_eq!(ended[&2].status, RowStatus::BudgetExhausted);
        assert!(ended[&2].reason.contains("more than 0 s of wall time"), "{}", ended[&2].reason);
    }
}

/// A panic while lanes advance, here of the numbers themselves when the third row's pressure is compared: every row is run alone, none is
/// lost, and what they give is the same.
#[test]
fn a_panic_in_a_lane_leaves_the_rows_whole() {
    let jobs = rows(&["solver.guide=tied"], |_| ());
    let breaking = jobs[2].scene().unwrap().hammers[0].supply_pressure_pa;
    Fragile::breaks_at(breaking);
    let ended = side_by_side(run_jobs_over::<Fragile>, (0..).zip(jobs.iter().cloned()));
    assert!(Fragile::broke() > 0, "no comparison saw the pressure");
    assert_eq!(ended.len(), jobs.len());
    for (row, job) in (0..).zip(&jobs) {
        assert_eq!(text(&ended[&row]), text(&without_time(job.clone().run())), "row {row}");
    }
}

/// Rows of two shapes in turn: each shape has its own group, and none waits for ever.
#[test]
fn rows_of_several_shapes() {
    let (one, two) = (rows(&["solver.guide=tied"], |_| ()), rows(&["solver.guide=spring"], |_| ()));
    let mixed: Vec<RowJob> = one.into_iter().zip(two).flat_map(|(one, two)| [one, two]).take(20).collect();
    same_in_any_order(&mixed);
}

/// Multiplies every number by a factor of its own, within 2 % of 1; the same numbers for the same `seed`.
fn scaled<T: serde::Serialize + serde::de::DeserializeOwned>(value: &T, seed: &mut u64) -> T {
    fn walk(value: &mut serde_json::Value, seed: &mut u64) {
        match value {
            serde_json::Value::Number(number) if number.is_f64() => {
                *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let factor = 1.0 + 0.02 * ((*seed >> 40) as f64 / f64::from(1 << 23) - 1.0);
                *value = serde_json::json!(number.as_f64().unwrap() * factor);
            }
            serde_json::Value::Array(values) => values.iter_mut().for_each(|value| walk(value, seed)),
            serde_json::Value::Object(values) => values.values_mut().for_each(|value| walk(value, seed)),
            _ => {}
        }
    }
    let mut json = serde_json::to_value(value).unwrap();
    walk(&mut json, seed);
    serde_json::from_value(json).unwrap()
}

/// Rows of which no two have any number in common: hammer, gas, casting, fixtures, place on the machine (so its modes too), times of
/// the supply, tolerance, windows of the outputs.
#[test]
fn lanes_equal_rows_alone_where_all_numbers_differ() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/placement.toml");
    for settings in [["solver.guide=tied", "solver.modes=condensed"], ["solver.guide=spring", "solver.modes=condensed"]]
    {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        let engine = Engine::load(&path, &settings).unwrap();
        let row = |i: usize| {
            let RowScene { mut scene, modes } = engine.scene(i).unwrap();
            let mut seed = i as u64 + 1;
            scene.environment = scaled(&scene.environment, &mut seed);
            scene.outputs = scaled(&scene.outputs, &mut seed);
            scene.outputs.settling_blows = i % 3;
            let share = 0.01 * (i + 1) as f64;
            let unit = &mut scene.hammers[0];
            unit.parameters = scaled(&unit.parameters, &mut seed);
            unit.standoff_m = 0.07 + 0.1 * share;
            unit.start_time_s += 0.1 * share;
            unit.gate_delay_s += 0.1 * share;
            unit.supply_switch_times_s = vec![0.2 + share, 0.22 + 1.5 * share];
            unit.strike_point_m[1] += 0.02 + share;
            let casting = &mut scene.castings[0];
            casting.mass_kg *= 1.0 - share;
            casting.inertia_kg_m2 = Some([0.0135 * (1.0 + share), 0.026 * (1.0 - share)]);
            for (k, fixture) in casting.fixtures.iter_mut().enumerate() {
                fixture.stiffness_n_per_m *= 1.0 + share * (k + 1) as f64;
                fixture.damping_n_s_per_m *= 1.0 - share * (k + 1) as f64;
                fixture.at_m[0] *= 1.0 - 0.1 * share * (k + 1) as f64;
            }
            scene.solver.tolerance *= 1.0 + 3.0 * share;
            scene.duration_s = 0.35 + share;
            RowJob::new(scene, modes, 1)
        };
        let jobs: Vec<RowJob> = (0..11).map(row).collect();
        for job in &jobs {
            let outcome = job.clone().run();
            let metrics = outcome.metrics.as_ref().unwrap_or_else(|| panic!("{}", outcome.reason));
            assert!(metrics.blows.len() > 3, "{}", metrics.blows.len());
        }
        same_in_any_order(&jobs);
    }
}
