//! Readers of a dataset: the report, and pyarrow, pandas, polars and DuckDB.

use std::path::Path;
use std::process::Command;

use crate::synthetic::{ROWS, dataset, info};
use decore_dataset::{DatasetError, DatasetReader, DatasetWriter, Existing};
use decore_lab::report::{ReportSettings, WorstResidual, summarise};
use tempfile::TempDir;

#[test]
fn the_report_ranks_rows_and_names_the_tables() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let report = summarise(&reader, &ReportSettings::default()).expect("summarised");
    // The work of row n is n: the last rows are the best.
    let best: Vec<u64> = report.best.iter().map(|best| best.row).collect();
    assert_eq!(best, [149, 148, 147, 146, 145], "{report}");
    assert_eq!(report.statuses["done"] + report.statuses["invalid"], ROWS);
    assert_eq!(report.worst_residual, Some(WorstResidual { row: 20, energy_residual: -2e-3 }));
    assert_eq!((report.percussions["periodic"], report.percussions["stalled"]), (103, 26));
    assert_eq!((report.warnings["deep_contact"], report.warnings["damper_jump"]), (3, 3));
    let frequency = report.ranges.iter().find(|range| range.unit == "Hz").expect("frequencies");
    assert_eq!((frequency.min, frequency.max), (20.0, 20.0));
    let text = report.to_string();
    for expected in [
        "Rows: 150 of 150 (129 done, 21 invalid), 387 blows",
        "21 x hammer `left` misses its casting",
        "1. row 149: ",
        "hammer.left.supply_bar = 5.490 bar, modes = 74, 2nd mount = beam_2",
        "at worst -0.2000 % (row 20)",
        "103 periodic, 26 stalled",
        "warning: `deep_contact` in 3 rows: a chisel goes deeper into its casting than a quarter of its free travel",
        "warning: `damper_jump` in 3 rows: ",
        Path::new("runs").join("*.parquet").to_str().expect("a path"),
    ] {
        assert!(text.contains(expected), "{expected} in\n{text}");
    }
    let by_text = ReportSettings { rank_by: "status".to_owned(), ..ReportSettings::default() };
    assert!(matches!(summarise(&reader, &by_text), Err(DatasetError::NotANumber { .. })));
}

#[test]
fn equal_rows_are_ranked_by_index() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let settings = ReportSettings { rank_by: "-total_air_used_nl".to_owned(), best: 3, ..ReportSettings::default() };
    let report = summarise(&reader, &settings).expect("summarised");
    let best: Vec<u64> = report.best.iter().map(|best| best.row).collect();
    assert_eq!(best, [0, 1, 2]);
}

#[test]
fn the_better_end_of_an_output_comes_first_and_a_sign_turns_it() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let ranks = |rank_by: &str| {
        let settings = ReportSettings { rank_by: rank_by.to_owned(), best: 1000, ..ReportSettings::default() };
        let report = summarise(&reader, &settings).expect("summarised");
        (report.least_first, report.best.iter().map(|best| best.rank).collect::<Vec<f64>>())
    };
    let rises = |ranks: &[f64]| ranks.windows(2).all(|pair| pair[0] <= pair[1]);
    for (name, least_first) in [("max_casting_point_velocity_m_s", true), ("strike_energy_j", false)] {
        let ((first, better), (turned, mut worse)) = (ranks(name), ranks(&format!("-{name}")));
        assert_eq!((first, turned), (least_first, !least_first), "{name}");
        assert_eq!(better.len(), worse.len());
        assert!(better.len() > 100 && rises(if least_first { &better } else { &worse }), "{name}: {better:?}");
        worse.reverse();
        assert_eq!(better, worse, "{name}");
    }
}

/// A report reads the runs and nothing else.
#[test]
fn a_damaged_part_is_refused_by_a_report_that_reads_it() {
    let (_scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let report = || summarise(&reader, &ReportSettings::default());
    let whole = report().expect("summarised");
    std::fs::write(folder.join("blows/blows-000000000064.parquet"), "no table").expect("written");
    assert_eq!(report().expect("summarised"), whole);
    std::fs::copy(folder.join("runs/runs-000000000000.parquet"), folder.join("runs/runs-000000000064.parquet"))
        .expect("copied over");
    let error = report().expect_err("refused");
    assert!(
        matches!(&error, DatasetError::Damaged { path, .. } if path.ends_with("runs-000000000064.parquet")),
        "{error}"
    );
}

#[test]
fn a_dataset_without_rows_has_a_report() {
    let scratch = TempDir::new().expect("scratch folder");
    DatasetWriter::create(scratch.path(), &info(), Existing::Refuse).expect("created");
    let reader = DatasetReader::open(scratch.path()).expect("opened");
    let text = summarise(&reader, &ReportSettings::default()).expect("summarised").to_string();
    assert!(text.contains("Rows: 0 of 150, 0 blows") && text.contains("No row has"), "{text}");
}

/// Opens the dataset in pyarrow, pandas, polars and DuckDB, if an interpreter is named that has them.
/// The examples of `decore help reading`, as they stand.
#[test]
fn the_guide_s_readers_read() {
    let (_scratch, folder) = dataset();
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the guide's examples were not tried");
        return;
    };
    let page = decore::guide::TOPICS.iter().find(|topic| topic.name == "reading").expect("page").text;
    let examples: Vec<&str> = page.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(examples.len(), 4);
    for example in examples {
        let text = example.replace("DATASET", folder.to_str().expect("path"));
        let output = Command::new(&python).arg("-c").arg(text).output().expect("interpreter started");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !said.contains("Warning") && output.stdout.len() > 50, "{example}\n{said}");
    }
}

#[test]
fn python_readers_agree() {
    let (_scratch, folder) = dataset();
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the Python readers were not tried");
        return;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_back.py");
    let output = Command::new(python).arg(script).arg(&folder).output().expect("interpreter started");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("pyarrow, pandas, polars, duckdb agree on 150 runs, 387 blows"), "{text}");
}
