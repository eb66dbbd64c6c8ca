//! The table of features: its figures are those of the dataset's tables.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::synthetic::{ROWS, dataset, described, info, outcome};
use decore_dataset::{DatasetInfo, DatasetReader, DatasetWriter, Existing, FactorColumn, RowRecord};
use decore_lab::features::{
    FeatureColumn, FeatureSettings, Features, FeaturesError, Format, Role, Splits, export, features,
};
use decore_model::metrics::CastingMetrics;
use decore_quantity::{Kind, Value};
use tempfile::TempDir;

fn table(folder: &Path, settings: &FeatureSettings) -> Features {
    features(&DatasetReader::open(folder).expect("opened"), settings).expect("features")
}

fn column<'a>(features: &'a Features, name: &str) -> &'a FeatureColumn {
    features.columns.iter().find(|column| column.name == name).unwrap_or_else(|| panic!("no column {name}"))
}

fn number(features: &Features, name: &str, row: usize) -> Option<f64> {
    column(features, name).values.number(row)
}

#[test]
fn figures_are_those_of_the_tables() {
    let (_scratch, folder) = dataset();
    let settings = FeatureSettings { dose_threshold_j: 60.0, work_j: Some(20.0), ..FeatureSettings::default() };
    let features = table(&folder, &settings);
    assert_eq!((features.runs, features.done), (ROWS, 129));
    for row in 0..ROWS as usize {
        let figure = |name: &str| number(&features, name, row);
        assert_eq!(figure("row"), Some(row as f64));
        if row % 7 == 3 {
            // Kept, with its factors, how it ended and nothing else.
            assert_eq!(column(&features, "status").values.text(row), "invalid");
            assert_eq!(column(&features, "reason").values.text(row), "hammer `left` misses its casting");
            assert_eq!(figure("factor_hammer_left_supply_bar"), Some(4.0 + row as f64 / 100.0));
            let targets = features.columns.iter().filter(|column| column.role == Role::Target);
            let known = ["hammers", "modes"];
            for target in targets.filter(|target| !known.contains(&target.name.as_str())) {
                assert_eq!(target.values.text(row), "", "row {row}: {}", target.name);
            }
            continue;
        }
        let energy = 60.0 + (row as f64).sin();
        let windows = 0.1 * energy + 2.0 + row as f64;
        let close = |name: &str, expected: f64| {
            let found = figure(name).unwrap_or_else(|| panic!("row {row}: no {name}"));
            assert!(
                (found - expected).abs() <= 1e-12 * expected.abs().max(1.0),
                "row {row}: {name} {found} {expected}"
            );
        };
        close("work_j", row as f64);
        close("work_in_windows_j", windows);
        close("struck_blows", 3.0);
        close("blow_energy_mean_j", energy);
        close("blow_energy_std_j", 0.0);
        close("peak_force_max_n", 1e5);
        close("dose_j", if energy >= 60.0 { 3.0 * energy } else { 0.0 });
        close("hit_frequency_mean_hz", 20.0);
        close("first_impact_energy_j", if row.is_multiple_of(5) { energy } else { 2.0 * energy });
        close("air_used_nl", 10.0);
        close("peak_velocity_m_s", 0.5);
        // The last blow starts at 0.1 + 6 / 20 s; before it, the first two bring in 0.1 energy + 2.
        assert_eq!(figure("time_to_work_s"), (windows >= 20.0).then_some(0.4), "row {row}");
    }
}

/// Without a threshold every blow that reaches the casting is in the dose.
#[test]
fn a_table_without_threshold_says_what_its_dose_follows_from() {
    let (_scratch, folder) = dataset();
    let all = table(&folder, &FeatureSettings::default());
    assert_eq!(column(&all, "dose_j").derived_from, ["blow_energy_mean_j", "struck_blows"]);
    assert!(all.columns.iter().all(|column| column.name != "time_to_work_s"));
    let over = table(&folder, &FeatureSettings { dose_threshold_j: 1.0, ..FeatureSettings::default() });
    // By its formula it need not; here it does, as all blows of a row have one energy.
    assert_eq!(column(&over, "dose_j").derived_from, ["blow_energy_mean_j"]);
    let lengths: Vec<usize> = all.columns.iter().map(|column| column.values.count).collect();
    assert!(lengths.iter().all(|length| *length == ROWS as usize), "{lengths:?}");
}

/// A dataset of two castings, in which a factor says which of them the right-hand hammer strikes.
fn two_castings(scratch: &TempDir) -> PathBuf {
    let text = r#"
[hammer.left]
casting = "b"
[hammer."right-hand"]
casting = "a"
[design.factor.struck]
path = 'hammer."right-hand".casting'
values = ["a", "b"]
"#;
    let struck = FactorColumn {
        name: "struck".to_owned(),
        kind: Kind::Text,
        unit: String::new(),
        description: "which casting".to_owned(),
    };
    let info = described(DatasetInfo {
        study_text: text.to_owned(),
        castings: ["a", "b"].map(str::to_owned).to_vec(),
        factors: vec![struck],
        rows: 4,
        ..info()
    });
    let folder = scratch.path().join("two");
    let mut writer = DatasetWriter::create(&folder, &info, Existing::Refuse).expect("created");
    for row in 0..4_u64 {
        let mut outcome = outcome(row);
        if let Some(metrics) = &mut outcome.metrics {
            let casting = CastingMetrics { peak_velocity_m_s: row as f64, ..CastingMetrics::default() };
            metrics.castings = vec![casting.clone(), CastingMetrics { peak_velocity_m_s: 10.0, ..casting }];
            metrics.blows.iter_mut().for_each(|blow| {
                blow.casting = if blow.hammer == 0 { 1 } else { row as usize % 2 };
            });
        }
        let casting = if row % 2 == 0 { "a" } else { "b" };
        let record = RowRecord { row, factors: vec![Value::Text(casting.to_owned())], outcome };
        writer.write(&record).expect("written");
    }
    writer.finish().expect("finished");
    folder
}

#[test]
fn hammers_count_for_the_casting_that_they_strike_in_the_row() {
    let scratch = TempDir::new().expect("scratch folder");
    let features = table(&two_castings(&scratch), &FeatureSettings::default());
    // Rows of the table: a and b of row 0, then of row 1, ...; row 3 is invalid.
    let numbers = |name: &str| (0..8).map(|row| number(&features, name, row)).collect::<Vec<_>>();
    let some = |values: [f64; 6]| values.map(Some).into_iter().chain([None, None]).collect::<Vec<_>>();
    assert_eq!(numbers("hammers")[..6], [1.0, 1.0, 0.0, 2.0, 1.0, 1.0].map(Some));
    assert_eq!(numbers("work_j"), some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]));
    assert_eq!(numbers("struck_blows"), some([1.0, 2.0, 0.0, 3.0, 1.0, 2.0]));
    assert_eq!(numbers("peak_velocity_m_s"), some([0.0, 10.0, 1.0, 10.0, 2.0, 10.0]));
    // No blow, no energy of one.
    assert_eq!(number(&features, "blow_energy_mean_j", 2), None);
    let castings = &column(&features, "casting").values;
    assert_eq!(
        (castings.kind(), [0, 1].map(|row| castings.cell(row))),
        (Kind::Category, ["a", "b"].map(|name| Some(Value::Text(name))))
    );
}

#[test]
fn files_that_are_there_stay_and_the_readers_agree() {
    let (scratch, folder) = dataset();
    let reader = DatasetReader::open(&folder).expect("opened");
    let splits = Splits::new(&[0.7, 0.15, 0.15], 1).expect("shares");
    let settings = FeatureSettings { work_j: Some(20.0), splits: Some(splits), ..FeatureSettings::default() };
    let [parquet, csv] = Format::ALL.map(|format| {
        let folder = scratch.path().join("features").join(format.name());
        let settings = FeatureSettings { format, ..settings.clone() };
        let written = export(&reader, &folder, &settings).expect("exported");
        assert!(written.files.iter().all(|file| file.is_file()));
        folder
    });
    let before = fs::read(parquet.join("features.parquet")).expect("bytes");
    let refused = export(&reader, &parquet, &settings);
    assert!(matches!(refused, Err(FeaturesError::Exists { .. })), "{refused:?}");
    let replaced = FeatureSettings { replace: true, ..settings };
    export(&reader, &parquet, &replaced).expect("replaced");
    assert!(before == fs::read(parquet.join("features.parquet")).expect("bytes"), "other bytes for the same dataset");
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the Python readers were not tried");
        return;
    };
    let scripts: [(&str, &[&PathBuf]); 3] = [
        ("features_alike.py", &[&parquet, &csv]),
        ("croissant_streams.py", &[&parquet]),
        ("croissant_streams.py", &[&csv]),
    ];
    for (script, arguments) in scripts {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script);
        let output = Command::new(&python).arg(script).args(arguments).output().expect("started");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        print!("{}", String::from_utf8_lossy(&output.stdout));
    }
}

/// Two factors of the synthetic dataset count its rows as its work does.
#[test]
fn factors_that_hold_a_result_are_named() {
    let (scratch, folder) = dataset();
    let features = table(&folder, &FeatureSettings::default());
    for (name, rule) in [("factor_hammer_left_supply_bar", "4.0"), ("factor_modes", "-7.5")] {
        let derived = features.derived.iter().find(|derived| derived.column == name).expect(name);
        assert_eq!(derived.from, ["work_j"]);
        assert!(derived.rule.starts_with(rule), "{}", derived.rule);
        assert_eq!(column(&features, name).derived_from, ["work_j"]);
    }
    assert!(column(&features, "work_j").derived_from.is_empty());
    // The card says it too, and the dictionary.
    let target = scratch.path().join("features");
    export(&DatasetReader::open(&folder).expect("opened"), &target, &FeatureSettings::default()).expect("exported");
    let card = fs::read_to_string(target.join("README.md")).expect("a card");
    assert!(card.contains("- `factor_modes` follows from work_j\n"), "{card}");
    assert!(card.contains("| `invalid` | 21 |\n") && card.contains("| `done` | 129 |\n"), "{card}");
    assert!(card.contains("    name = \"synthetic\"  # Gußteil\n"), "{card}");
}
