//! The difference of two datasets: what belongs together, and what differs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use decore::cli::output_schemas;
use decore_dataset::{DatasetError, DatasetInfo, DatasetReader, DatasetWriter, Existing, RowRecord};
use decore_lab::comparison::{Comparison, ComparisonError, ComparisonSettings, compare};
use decore_model::metrics::{RunMetrics, Scatter, ScatterOf};
use decore_model::run::RowStatus;
use decore_quantity::Value;
use decore_study::engine::{Engine, SweepSettings};
use tempfile::TempDir;

use crate::sweeps::{decore, errors, output};
use crate::synthetic::{ROWS, described, info, outcome, record};

/// Rows of the synthetic study that are done: every seventh from the third on is not.
const DONE: u64 = 129;

/// Writes a dataset of the synthetic study's rows after a change.
fn written(folder: &Path, info: &DatasetInfo, change: impl Fn(&mut RowRecord)) -> PathBuf {
    let info = described(info.clone());
    let mut writer = DatasetWriter::create(folder, &info, Existing::Refuse).expect("created");
    for row in 0..info.rows {
        let mut made = record(row, outcome(row));
        change(&mut made);
        writer.write(&RowRecord { row, ..made }).expect("taken");
    }
    writer.finish().expect("finished");
    folder.to_owned()
}

fn compared(folders: [&Path; 2], settings: &ComparisonSettings) -> Result<Comparison, ComparisonError> {
    let [a, b] = folders.map(|folder| DatasetReader::open(folder).expect("opened"));
    compare(&a, &b, settings)
}

/// The difference of the synthetic dataset and the one after a change.
fn changed(info_b: &DatasetInfo, change: impl Fn(&mut RowRecord)) -> Comparison {
    let scratch = TempDir::new().expect("scratch");
    let a = written(&scratch.path().join("a"), &info(), |_| ());
    let b = written(&scratch.path().join("b"), info_b, change);
    compared([&a, &b], &ComparisonSettings::default()).expect("compared")
}

fn metrics(record: &mut RowRecord) -> &mut RunMetrics {
    record.outcome.metrics.as_mut().expect("done")
}

#[test]
fn a_dataset_does_not_differ_from_itself() {
    let found = changed(&info(), |_| ());
    assert!(found.is_same(), "{found:?}");
    assert_eq!((found.matched, found.a.rows, found.b.rows), (ROWS, ROWS, ROWS));
    assert_eq!(found.factors, ["hammer.left.supply_bar", "modes", "2nd mount"]);
    let energy = found.outputs.iter().find(|output| output.name == "left_first_impact_energy_j").expect("compared");
    assert_eq!((energy.pairs, energy.beyond, energy.median, &energy.worst), (DONE, 0, Some(0.0), &None));
    let [kinds, counts] = ["left_percussion", "left_contact_count"]
        .map(|name| found.outputs.iter().find(|output| output.name == name).map(|output| output.pairs));
    assert_eq!((kinds, counts), (Some(DONE), None), "main outputs, no others");
}

/// Rows are matched by their values, wherever they are.
#[test]
fn the_order_of_rows_does_not_matter() {
    let found = changed(&info(), |made| {
        *made = record(ROWS - 1 - made.row, outcome(ROWS - 1 - made.row));
    });
    assert!(found.is_same(), "{found:?}");
    let found = changed(&info(), |made| {
        *made = record(ROWS - 1 - made.row, outcome(ROWS - 1 - made.row));
        if made.row == 12 {
            metrics(made).totals.delivered_work_j = 13.0;
        }
    });
    let pair = &found.beyond.listed[0];
    assert_eq!((found.beyond.count, pair.output.as_str()), (1, "delivered_work_j"));
    assert_eq!((pair.row_a, pair.row_b), (12, ROWS - 1 - 12));
    assert_eq!((&pair.value_a, &pair.value_b), (&Some(Value::Real(12.0)), &Some(Value::Real(13.0))));
}

#[test]
fn what_is_beyond_the_rule_is_listed_farthest_first() {
    let found = changed(&info(), |made| match made.row {
        // Both first works are the row's number; 1e-4 of the larger one is allowed.
        20 => metrics(made).totals.delivered_work_j *= 1.0 + 0.9e-4,
        30 => metrics(made).totals.delivered_work_j *= 1.0 + 1.2e-4,
        40 => metrics(made).hammers[1].hit_frequency_hz = Some(25.0),
        50 => metrics(made).hammers[0].hit_frequency_hz = None,
        _ => {}
    });
    let listed: Vec<_> = found.beyond.listed.iter().map(|pair| (pair.row_a, pair.output.as_str())).collect();
    let expected = [(50, "left_hit_frequency_hz"), (40, "right_hand_hit_frequency_hz"), (30, "delivered_work_j")];
    assert_eq!((found.beyond.count, listed.as_slice()), (3, &expected[..]));
    let work = found.outputs.iter().find(|output| output.name == "delivered_work_j").expect("compared");
    let worst = work.worst.as_ref().and_then(|pair| pair.difference()).expect("a number");
    assert_eq!((work.beyond, work.measured, work.median), (1, 0, Some(0.0)));
    assert!((worst - 30.0 * 1.2e-4).abs() < 1e-12, "{worst}");
}

/// A pair of which one has no value has no difference: the worst is of the others.
#[test]
fn one_sided_pairs_are_counted_beside_the_worst_difference() {
    let scratch = TempDir::new().expect("scratch");
    let a = written(&scratch.path().join("a"), &info(), |_| ());
    let b = written(&scratch.path().join("b"), &info(), |made| match made.row {
        40 => metrics(made).hammers[1].hit_frequency_hz = Some(25.0),
        50 => metrics(made).hammers[1].hit_frequency_hz = None,
        _ => {}
    });
    let found = compared([&a, &b], &ComparisonSettings::default()).expect("compared");
    let frequency = found.outputs.iter().find(|output| output.name == "right_hand_hit_frequency_hz").expect("compared");
    let worst = frequency.worst.as_ref().expect("a worst pair");
    assert_eq!((frequency.beyond, frequency.one_sided, worst.row_a, worst.difference()), (2, 1, 40, Some(5.0)));
    assert_eq!((found.beyond.count, found.beyond.listed[0].row_a), (2, 50));
    let mut command = decore();
    command.arg("compare").args([&a, &b]);
    let text = String::from_utf8_lossy(&output(command).stdout).into_owned();
    let line = text.lines().find(|line| line.starts_with("right_hand_hit_frequency_hz")).expect("a line");
    let cells: Vec<&str> = line.split_whitespace().collect();
    assert_eq!(&cells[1..], ["129", "2", "0.000e0", "5.000e0", "Hz", "1", "one-sided"], "{text}");
    assert!(text.contains("one-sided: pairs of which only A or only B has a value"), "{text}");
}

#[test]
fn rows_that_ended_differently_are_listed_and_not_compared() {
    let found = changed(&info(), |made| {
        if made.row == 5 {
            metrics(made).totals.delivered_work_j = 1e3;
            made.outcome.status = RowStatus::Diverged;
        }
    });
    assert_eq!((found.statuses.count, found.beyond.count), (1, 0));
    let entry = &found.statuses.listed[0];
    assert_eq!((entry.row_a, entry.status_a.as_str(), entry.status_b.as_str()), (5, "done", "diverged"));
    assert!(!found.is_same());
}

/// Another design: rows that only one has, and a list that is cut.
#[test]
fn rows_of_another_design_are_in_one_only() {
    let fewer = DatasetInfo { rows: 100, ..info() };
    let found = changed(&fewer, |made| {
        if made.row >= 60 {
            made.factors[0] = Value::Real(made.row as f64);
        }
    });
    assert_eq!((found.matched, found.only_in_a.count, found.only_in_b.count), (60, 90, 40));
    assert_eq!(found.only_in_a.listed, (60..80).collect::<Vec<u64>>());
    assert_eq!(found.only_in_b.listed, (60..80).collect::<Vec<u64>>());
    assert!(!found.is_same());
}

/// Equal values are one, whatever their type, and repeated ones are matched in their order.
#[test]
fn repeated_rows_are_matched_in_their_order() {
    let scratch = TempDir::new().expect("scratch");
    let mut whole = info();
    whole.factors.truncate(2);
    let mut real = whole.clone();
    real.factors[1].kind = decore_quantity::Kind::Real;
    let a = written(&scratch.path().join("a"), &whole, |made| {
        made.factors = vec![Value::Real(1.0), Value::Integer((made.row / 2) as i64)];
    });
    let b = written(&scratch.path().join("b"), &real, |made| {
        made.factors = vec![Value::Real(1.0), Value::Real((made.row / 2) as f64)];
    });
    let found = compared([&a, &b], &ComparisonSettings::default()).expect("compared");
    assert!(found.is_same() && found.matched == ROWS, "{found:?}");
}

#[test]
fn columns_that_one_lacks_are_named() {
    let one_hammer = DatasetInfo { hammers: vec!["left".to_owned()], ..info() };
    let found = changed(&one_hammer, |made| {
        if let Some(metrics) = &mut made.outcome.metrics {
            metrics.hammers.truncate(1);
            metrics.blows.retain(|blow| blow.hammer == 0);
        }
    });
    assert!(!found.is_same() && found.beyond.count == 0, "{found:?}");
    assert!(found.outputs_only_in_b.is_empty());
    assert!(found.outputs_only_in_a.len() > 10, "{:?}", found.outputs_only_in_a);
    assert!(found.outputs_only_in_a.iter().all(|name| name.starts_with("right_hand_")));
    let scratch = TempDir::new().expect("scratch");
    let [a, b] = [("a", info()), ("b", described(one_hammer))].map(|(name, info)| {
        let writer = DatasetWriter::create(&scratch.path().join(name), &info, Existing::Refuse).expect("created");
        writer.finish().expect("finished");
        scratch.path().join(name)
    });
    let settings = |name: &str| ComparisonSettings { outputs: vec![name.to_owned()], ..ComparisonSettings::default() };
    let unknown = compared([&a, &b], &settings("left_contact_counts")).expect_err("unknown");
    assert!(matches!(unknown, ComparisonError::Dataset(DatasetError::UnknownColumn { .. })), "{unknown}");
    let empty = compared([&a, &b], &settings("left_contact_count")).expect("compared");
    assert!(empty.is_same() && empty.outputs.len() == 1 && empty.outputs[0].pairs == 0, "{empty:?}");
}

#[test]
fn other_factors_are_refused() {
    let scratch = TempDir::new().expect("scratch");
    let a = written(&scratch.path().join("a"), &info(), |_| ());
    let refused = |name: &str, change: &dyn Fn(&mut DatasetInfo)| {
        let mut other = info();
        change(&mut other);
        let other = described(other);
        let b = scratch.path().join(name);
        DatasetWriter::create(&b, &other, Existing::Refuse).expect("created").finish().expect("finished");
        compared([&a, &b], &ComparisonSettings::default()).expect_err("refused").to_string()
    };
    let unit = refused("unit", &|other| other.factors[0].unit = "Pa".to_owned());
    assert!(unit.contains("factor_hammer_left_supply_bar is in `bar` and in `Pa`"), "{unit}");
    let missing = refused("missing", &|other| _ = other.factors.remove(1));
    assert!(missing.contains("factor_modes alone"), "{missing}");
}

/// With twins: half ranges of 1 J in A and 2 J in B allow for 6 J.
#[test]
fn scatter_that_twins_measured_is_allowed_for() {
    let scratch = TempDir::new().expect("scratch");
    let info = DatasetInfo { twins: 4, ..info() };
    let with_scatter = |made: &mut RowRecord, half_range_j: f64| {
        let Some(metrics) = made.outcome.metrics.as_mut() else { return };
        let none = || ScatterOf::new();
        let totals = BTreeMap::from([("delivered_work_j", Some(half_range_j))]);
        metrics.scatter = Some(Scatter { twins_done: 4, hammers: vec![none(); 2], castings: vec![none()], totals });
    };
    let a = written(&scratch.path().join("a"), &info, |made| with_scatter(made, 1.0));
    let b = written(&scratch.path().join("b"), &info, |made| {
        with_scatter(made, 2.0);
        if let Some(metrics) = made.outcome.metrics.as_mut() {
            metrics.totals.delivered_work_j += if made.row == 11 { 6.5 } else { 5.5 };
        }
    });
    let found = compared([&a, &b], &ComparisonSettings::default()).expect("compared");
    let pair = &found.beyond.listed[0];
    assert_eq!((found.beyond.count, pair.row_a, pair.allowed, pair.measured), (1, 11, Some(6.0), true));
    let work = found.outputs.iter().find(|output| output.name == "delivered_work_j").expect("compared");
    assert_eq!((work.pairs, work.measured, work.beyond, work.median), (DONE, DONE, 1, Some(5.5)));
    // Without twins in B, it is taken to scatter as A does: 4 J.
    let plain = written(&scratch.path().join("plain"), &DatasetInfo { twins: 0, ..info }, |made| {
        if made.row == 12 {
            metrics(made).totals.delivered_work_j += 4.5;
        }
        if made.row == 13 {
            metrics(made).totals.delivered_work_j += 3.5;
        }
    });
    let found = compared([&a, &plain], &ComparisonSettings::default()).expect("compared");
    let rows: Vec<u64> = found.beyond.listed.iter().map(|pair| pair.row_a).collect();
    assert_eq!((rows, found.a.twins, found.b.twins), (vec![12], 4, 0));
}

/// Datasets of a simulated study: another tolerance moves values by less than a thousandth.
#[test]
fn simulated_datasets_of_another_tolerance_and_another_design() {
    let scratch = TempDir::new().expect("scratch");
    let run = |name: &str, settings: &[&str]| {
        let settings = settings.iter().map(|setting| (*setting).to_owned());
        let settings: Vec<String> = settings.chain(["duration_s=0.12".to_owned()]).collect();
        let engine = Engine::load(Path::new("studies/pressure_grid.toml"), &settings).expect("ready");
        let folder = scratch.path().join(name);
        engine.run(&folder, &SweepSettings::default()).expect("run");
        folder
    };
    let (a, tight) = (run("a", &[]), run("tight", &["solver.tolerance=1e-10"]));
    let rough = ComparisonSettings { relative: 1e-3, ..ComparisonSettings::default() };
    let found = compared([&a, &tight], &rough).expect("compared");
    assert!(found.is_same() && found.matched == 8, "{:?}", found.beyond);
    let exact = ComparisonSettings { relative: 0.0, ..ComparisonSettings::default() };
    let found = compared([&a, &tight], &exact).expect("compared");
    assert!(found.beyond.count > 50, "to the last bit: {}", found.beyond.count);
    let finer = run("finer", &["design.factor.pressure.levels=3"]);
    let found = compared([&a, &finer], &exact).expect("compared");
    assert_eq!((found.matched, found.only_in_a.count, found.only_in_b.count), (8, 0, 4));
    assert_eq!((found.beyond.count, found.is_same()), (0, false), "the same rows are the same");
}

/// What is printed, and how it ends.
#[test]
fn the_command_has_exit_codes_and_json_of_its_schema() {
    let scratch = TempDir::new().expect("scratch");
    let (a, b) = (scratch.path().join("a"), scratch.path().join("b"));
    written(&a, &info(), |_| ());
    written(&b, &info(), |made| {
        if made.row == 41 {
            metrics(made).totals.delivered_work_j = 42.0;
        }
    });
    let ran = |folders: [&Path; 2], options: &[&str]| {
        let mut command = decore();
        command.arg("compare").args(folders).args(options);
        let output = output(command);
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), errors(&output))
    };
    let (code, text, _) = ran([&a, &a], &[]);
    assert!(code == Some(0) && text.ends_with("Nothing differs.\n"), "{code:?} {text}");
    let (code, text, _) = ran([&a, &b], &[]);
    assert!(code == Some(9) && text.ends_with("They differ.\n"), "{code:?} {text}");
    assert!(
        text.contains("row 41: delivered_work_j 41.0000 -> 42.0000 J  |d| 1.00e0, allowed 4.20e-3 (rule)"),
        "{text}"
    );
    assert!(text.contains("150 rows matched by hammer.left.supply_bar, modes, 2nd mount"), "{text}");
    let (code, text, _) = ran([&a, &b], &["--relative", "0.1"]);
    assert!(code == Some(0), "{text}");
    let (code, text, _) = ran([&a, &b], &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let (_, schema) = output_schemas().into_iter().find(|(name, _)| *name == "comparison").expect("schema");
    let keys = |value: &serde_json::Value| value.as_object().expect("object").keys().cloned().collect::<Vec<_>>();
    assert_eq!((code, keys(&json)), (Some(9), keys(&schema["properties"])));
    assert_eq!(keys(&json["outputs"][0]), keys(&schema["$defs"]["OutputDifference"]["properties"]));
    assert_eq!(keys(&json["beyond"]["listed"][0]), keys(&schema["$defs"]["PairDifference"]["properties"]));
    let (code, _, said) = ran([&a, &scratch.path().join("c")], &[]);
    assert!(code == Some(2) && said.contains("there is no dataset"), "{said}");
    let (code, _, said) = ran([&a, &b], &["--output", "delivered_work"]);
    assert!(code == Some(2) && said.contains("did you mean `delivered_work_j`?"), "{said}");
    // A dataset of another format is the wrong argument, no result that could not be written.
    std::fs::write(b.join("manifest.json"), "{\n  \"format_version\": 7 }").expect("written");
    let (code, _, said) = ran([&a, &b], &[]);
    assert!(code == Some(2) && said.contains("`format_version` is 7, expected 6"), "{code:?} {said}");
}
