//! Values of factors that come from outside: the levels and scenes of rows, and what is wrong with others.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use decore_model::run::{RowOutcome, RowStatus};
use decore_quantity::Value;
use decore_statistics::design::Level;
use decore_study::StudyError;
use decore_study::engine::{Engine, RowRunner};

fn engine(settings: &[&str]) -> Engine {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/pressure_grid.toml");
    let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
    Engine::load(&study, &settings).unwrap_or_else(|error| panic!("{error}"))
}

/// The values of a row by the factors' names.
fn given(engine: &Engine, row: usize) -> Vec<(String, Value)> {
    let names = engine.study().factors().iter().map(|factor| factor.name.clone());
    names.zip(engine.checked().row_values(row)).collect()
}

#[test]
fn values_of_a_row_are_that_row_alone_and_side_by_side() {
    let engine = engine(&["duration_s=0.12", "outputs.numerical_twin=none"]);
    let rows = 0..engine.checked().row_count();
    let levels = |row| engine.checked().levels(&given(&engine, row)).unwrap_or_else(|error| panic!("{error}"));
    let points: Vec<Vec<Level>> = rows.clone().map(levels).collect();
    let together = engine.outcomes_at(&points, 2, &AtomicBool::new(false)).expect("threads").expect("all");
    let untimed = |outcome: RowOutcome| RowOutcome { wall_time_s: 0.0, numerical_twin_wall_time_s: None, ..outcome };
    for ((row, levels), side_by_side) in rows.zip(&points).zip(together) {
        assert_eq!(Some(levels), engine.checked().design().row(row).as_ref());
        assert_eq!(engine.checked().values_at(levels), engine.checked().row_values(row));
        let alone = untimed(engine.outcome(row));
        assert_eq!(alone.status, RowStatus::Done);
        assert_eq!(untimed(engine.outcome_at(levels)), alone);
        assert_eq!(untimed(side_by_side), alone);
    }
    let stopped = engine.outcomes_at(&points, 1, &AtomicBool::new(true)).expect("threads");
    assert!(stopped.is_none(), "what did not begin is not there");
}

#[test]
fn values_between_the_design_s_are_scenes_and_others_are_faults() {
    let engine = engine(&[]);
    let mut values = given(&engine, 0);
    values[1].1 = Value::Integer(6);
    let levels = engine.checked().levels(&values).expect("beyond the range, not beyond what is possible");
    assert_eq!(levels[1], Level::Real(6.0));
    let scene = engine.checked().scene_at(&levels).expect("a scene");
    let gauge_pa = scene.hammers[0].supply_pressure_pa - scene.environment.ambient_pressure_pa;
    assert!((gauge_pa - 6e5).abs() < 1e-6, "{gauge_pa}");
    for (change, key, words) in [
        ((0, "mount", Value::Text("R4".into())), "design.factor.mount", "expected: one of R3 | R5"),
        ((1, "pressure", Value::Text("high".into())), "design.factor.pressure", "expected: a finite number"),
        ((1, "pressure", Value::Real(f64::NAN)), "design.factor.pressure", "is NaN"),
        ((1, "presure", Value::Real(5.0)), "design.factor.presure", "did you mean `pressure`?"),
    ] {
        let ((place, name, value), mut values) = (change, given(&engine, 0));
        values[place] = (name.to_owned(), value);
        let error = engine.checked().levels(&values).expect_err(words);
        assert!(error.problems().iter().any(|problem| problem.key == key), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn a_factor_that_drives_nothing_any_more_needs_no_value_and_takes_none() {
    let engine = engine(&["hammer.hammer.supply_bar=4.25"]);
    let free: Vec<&str> = engine.checked().free_factors().map(|factor| factor.name.as_str()).collect();
    assert_eq!(free, ["mount", "standoff"]);
    let values = given(&engine, 3);
    let error: StudyError = engine.checked().levels(&values).expect_err("overridden");
    assert_eq!(error.problems().len(), 1, "{error}");
    let free: Vec<(String, Value)> = values.into_iter().filter(|(name, _)| name != "pressure").collect();
    let levels = engine.checked().levels(&free).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(engine.checked().values_at(&levels)[1], Value::Real(4.25));
}
