//! The table of signals: as durable as the others, and the means that it says.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use decore_dataset::{
    DatasetInfo, DatasetReader, DatasetWriter, Existing, RowRecord, RowSpan, SignalColumn, TableName, merge, verify,
};
use decore_lab::features::{FeatureSettings, export, features};
use decore_study::engine::{Engine, RowRunner, SweepSettings};
use tempfile::TempDir;

use crate::synthetic::{self, ROWS, contract, described, outcome};

/// Settings with which a shipped study is quick and keeps two signals of some rows.
const KEEPS: [&str; 4] = [
    "duration_s=0.15",
    "outputs.signals=[\"hammer_casting_force_n\", \"part_heave_velocity_m_s\"]",
    "outputs.signal_rows=[1, 4, 6]",
    "outputs.signal_interval_s=0.001",
];

fn engine(settings: &[&str]) -> Engine {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/pressure_grid.toml");
    let settings: Vec<String> = settings.iter().map(|one| (*one).to_owned()).collect();
    Engine::load(&study, &settings).expect("a study")
}

fn sweep(engine: &Engine, folder: &Path, threads: usize) {
    let settings = SweepSettings { threads, ..SweepSettings::default() };
    let status = engine.run(folder, &settings).expect("run");
    assert_eq!((status.rows_done, status.rows_failed), (8, 0));
}

/// Row, time and values of the table of signals.
fn table(folder: &Path) -> Vec<Vec<f64>> {
    let reader = DatasetReader::open(folder).expect("opened");
    let names: Vec<String> = reader.columns(TableName::Signals).iter().map(|column| column.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut rows = Vec::new();
    let number = |cell: &Option<decore_quantity::Value<&str>>| cell.and_then(|value| value.number()).expect("a number");
    reader.visit(TableName::Signals, &names, |cells| rows.push(cells.iter().map(number).collect())).expect("read");
    rows
}

/// Parts are as large as the signals of the longest row allow, wherever it stands in the design.
#[test]
fn the_longest_row_decides_how_many_a_part_holds() {
    let rows_per_part = |durations: &str| {
        let driven = [
            "design.factor.standoff.path=duration_s",
            "design.factor.standoff.unit=s",
            durations,
            "outputs.signal_interval_s=1e-5",
        ];
        engine(&[&driven, &KEEPS[1..3]].concat()).info().rows_per_part
    };
    let [short, first, last] = ["[0.01, 0.02]", "[40.0, 0.02]", "[0.01, 40.0]"]
        .map(|values| rows_per_part(&format!("design.factor.standoff.values={values}")));
    assert!(first == last && first < short, "{short}, {first}, {last}");
}

#[test]
fn kept_signals_are_means_of_those_of_a_scene() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    let engine = engine(&KEEPS);
    sweep(&engine, &folder, 2);
    let rows = table(&folder);
    // 0 to 0.15 s every 0.001 s, of three rows; both ends are instants.
    let instants = rows.len() / 3;
    assert_eq!((rows.len(), instants), (3 * instants, 151));
    for (index, row) in [1, 4, 6].into_iter().enumerate() {
        let signals = engine.outcome_with_signals(row, 0.001 / 50.0).expect("run").1.expect("signals");
        let named = |name: &str| &signals.iter().find(|signal| signal.name == name).expect("signal").values;
        for (place, name) in ["hammer_casting_force_n", "part_heave_velocity_m_s"].into_iter().enumerate() {
            let values = named(name);
            let size = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(size > 0.0, "{name}");
            assert_eq!(instants, (values.len() - 1) / 50 + 1);
            for instant in 0..instants {
                let kept = &rows[index * instants + instant];
                assert_eq!((kept[0], kept[1]), (row as f64, instant as f64 * 0.001));
                let (from, to) = ((50 * instant).saturating_sub(25), (50 * instant + 25).min(values.len() - 1));
                let integral: f64 = values[from..=to].windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
                let mean = integral / (to - from) as f64;
                assert!(
                    (kept[2 + place] - mean).abs() <= 1e-12 * size,
                    "{name} of row {row} at {instant}: {mean}, {kept:?}"
                );
            }
        }
    }
}

#[test]
fn bytes_do_not_depend_on_threads_and_other_tables_not_on_signals() {
    let scratch = TempDir::new().expect("scratch folder");
    let [one, two, without] = ["one", "two", "without"].map(|name| scratch.path().join(name));
    sweep(&engine(&KEEPS), &one, 1);
    sweep(&engine(&KEEPS), &two, 2);
    assert_eq!(contract(&one).keys().collect::<Vec<_>>(), contract(&two).keys().collect::<Vec<_>>());
    for (name, bytes) in contract(&one) {
        // How long it took.
        assert!(name == Path::new("status.json") || contract(&two)[&name] == bytes, "{} differs", name.display());
    }
    sweep(&engine(&KEEPS[..1]), &without, 2);
    assert!(!without.join("signals").exists() && one.join("signals").exists());
    let runs = |folder: &Path| {
        let reader = DatasetReader::open(folder).expect("opened");
        let mut found = Vec::new();
        let visit = |cells: &[decore_quantity::Cell<'_>]| found.push(format!("{cells:?}"));
        reader.visit(TableName::Runs, &["delivered_work_j", "solver_steps"], visit).expect("read");
        found
    };
    assert_eq!(runs(&one), runs(&without));
}

#[test]
fn what_cannot_be_kept_is_refused() {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/pressure_grid.toml");
    let cases = [
        ("outputs.signals=[\"hammer_casting_forze_n\"]", "did you mean `hammer_casting_force_n`?"),
        ("outputs.signals=[\"time_s\"]", "is the time"),
        ("outputs.signal_rows=[8]", "names row 8, but the study has the rows 0 to 7"),
    ];
    for (setting, expected) in cases {
        let settings: Vec<String> = KEEPS.iter().chain([&setting]).map(|one| (*one).to_owned()).collect();
        let error = Engine::load(&study, &settings).expect_err("refused").to_string();
        assert!(error.starts_with("outputs.signal") && error.contains(expected), "{error}");
    }
}

/// The synthetic study, which keeps two signals.
fn info() -> DatasetInfo {
    let column = |name: &str, unit: &str| SignalColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
        description: "made up.".to_owned(),
    };
    described(DatasetInfo { signals: vec![column("a_m", "m"), column("b_n", "N")], ..synthetic::info() })
}

/// A row of it; every third one has signals.
fn record(row: u64) -> RowRecord {
    let mut outcome = outcome(row);
    if let Some(metrics) = outcome.metrics.as_mut().filter(|_| row.is_multiple_of(3)) {
        metrics.signals = (0..20).map(|k| vec![f64::from(k), row as f64, (row as f64 * f64::from(k)).sqrt()]).collect();
    }
    synthetic::record(row, outcome)
}

fn write(folder: &Path, range: RowSpan) {
    let mut writer = DatasetWriter::open(folder, &info(), range, Existing::Resume).expect("opened");
    let rows: Vec<u64> = writer.rows_left().iter().flat_map(|span| span.first..span.end).collect();
    rows.into_iter().for_each(|row| writer.write(&record(row)).expect("taken"));
    writer.finish().expect("finished");
}

fn whole(folder: &Path) {
    write(folder, RowSpan { first: 0, end: ROWS });
}

#[test]
fn a_sweep_that_was_killed_goes_on_to_the_same_bytes() {
    let scratch = TempDir::new().expect("scratch folder");
    let [folder, other] = ["whole", "killed"].map(|name| scratch.path().join(name));
    whole(&folder);
    assert_eq!(table(&folder).len(), (0..ROWS).filter(|row| row.is_multiple_of(3) && row % 7 != 3).count() * 20);
    for done in [1, 30, 64, 70, 149] {
        let mut writer = DatasetWriter::create(&other, &info(), Existing::Replace).expect("opened");
        // In an order of their own.
        (0..ROWS).map(|step| step * 77 % ROWS).take(done).for_each(|row| writer.write(&record(row)).expect("taken"));
        // As a process that ends: nothing is finished, the journal has what no part has.
        drop(writer);
        whole(&other);
        assert!(contract(&folder) == contract(&other), "{done} rows before the end");
    }
}

#[test]
fn shards_are_merged_and_damage_is_found_and_repaired() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("whole");
    whole(&folder);
    let spans = [(0, 50), (50, 101), (101, ROWS)];
    let shards: Vec<PathBuf> = spans.iter().map(|(first, _)| scratch.path().join(format!("shard {first}"))).collect();
    spans.iter().zip(&shards).for_each(|((first, end), shard)| write(shard, RowSpan { first: *first, end: *end }));
    let merged = scratch.path().join("merged");
    assert!(merge(&shards, &merged, Existing::Refuse).expect("merged").manifest.complete);
    assert!(contract(&folder) == contract(&merged));

    assert_eq!(verify(&merged).expect("read").faults, Vec::<String>::new());
    let part = merged.join("signals/signals-000000000064.parquet");
    let mut bytes = fs::read(&part).expect("part");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&part, bytes).expect("damaged");
    let faults = verify(&merged).expect("read").faults;
    assert!(faults.len() == 1 && faults[0].contains("signals-000000000064.parquet"), "{faults:?}");
    whole(&merged);
    assert!(merged.join(".damaged/signals-000000000064.parquet").exists());
    fs::remove_dir_all(merged.join(".damaged")).expect("removed");
    assert!(contract(&folder) == contract(&merged));

    // Without its manifest the dataset is the sum of its parts.
    fs::remove_file(merged.join("manifest.json")).expect("removed");
    whole(&merged);
    assert!(contract(&folder) == contract(&merged));
}

#[test]
fn pyarrow_sees_values_and_units() {
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the table of signals was not read");
        return;
    };
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    sweep(&engine(&KEEPS), &folder, 2);
    let script = "import sys, pyarrow.parquet as p\n\
        t = p.read_table(sys.argv[1])\n\
        print(t.num_rows, [(f.name, f.metadata[b'unit'].decode()) for f in t.schema])\n\
        print(t.schema.field('hammer_casting_force_n').metadata[b'description'].decode())\n\
        print(t['hammer_casting_force_n'].null_count, sum(t['hammer_casting_force_n'].to_pylist()) != 0)";
    let output = Command::new(python).arg("-c").arg(script).arg(folder.join("signals")).output().expect("started");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let columns =
        "[('row', '1'), ('time_s', 's'), ('hammer_casting_force_n', 'N'), ('part_heave_velocity_m_s', 'm/s')]";
    let (count, rest) = text.split_once(' ').expect("a count");
    assert!(["450", "453"].contains(&count) && rest.starts_with(&format!("{columns}\n")), "{text}");
    assert!(text.contains("mean over 0.001 s around the instant") && text.contains("\n0 True"), "{text}");
}

/// Bands and accelerations in the table of features are those that NumPy makes of the kept means; rows without means have nulls.
#[test]
fn numpy_finds_the_bands_of_the_features() {
    let Some(python) = std::env::var_os("DECORE_PYTHON") else {
        eprintln!("DECORE_PYTHON is not set: the bands were not computed anew");
        return;
    };
    let scratch = TempDir::new().expect("scratch folder");
    let [folder, table] = ["sweep", "features"].map(|name| scratch.path().join(name));
    let settings = [&KEEPS[1..], &["duration_s=0.5"]].concat();
    sweep(&engine(&settings), &folder, 2);
    export(&DatasetReader::open(&folder).expect("opened"), &table, &FeatureSettings::default()).expect("exported");
    let script = "import sys, numpy as np, pyarrow.parquet as p\n\
        s, f = p.read_table(sys.argv[1]).to_pydict(), p.read_table(sys.argv[2]).to_pydict()\n\
        row, v, T = np.array(s['row']), np.array(s['part_heave_velocity_m_s']), 0.001\n\
        def figures(v):\n\
        \x20   a = np.diff(v[1:-1]) / T\n\
        \x20   found = {'heave_velocity_rms_m_s': np.sqrt(np.mean(v**2))}\n\
        \x20   found |= {'heave_acceleration_peak_m_s2': abs(a).max(), 'heave_acceleration_rms_m_s2': np.sqrt(np.mean(a**2))}\n\
        \x20   hz = np.fft.rfftfreq(len(v), T)\n\
        \x20   power = 2 * abs(np.fft.rfft(v - v.mean()))**2 / len(v)**2 / np.sinc(hz * T)**2\n\
        \x20   for x, name in enumerate(['31_5', '63', '125', '250'], -5):\n\
        \x20       low, high = (1000 * 10**(0.3 * (x + side)) for side in (-0.5, 0.5))\n\
        \x20       found[f'heave_velocity_rms_{name}_hz_m_s'] = np.sqrt(power[(hz >= low) & (hz < high)].sum())\n\
        \x20   return found\n\
        names = {name for name in f if name.startswith('heave_')}\n\
        for place, r in enumerate(f['row']):\n\
        \x20   if r in (1, 4, 6):\n\
        \x20       expected = figures(v[row == r])\n\
        \x20       assert names == set(expected), names\n\
        \x20       for name in names:\n\
        \x20           assert abs(f[name][place] / expected[name] - 1) < 1e-10, (r, name, f[name][place], expected[name])\n\
        \x20   else:\n\
        \x20       assert all(f[name][place] is None for name in names), r";
    let output = Command::new(python)
        .arg("-c")
        .arg(script)
        .args([folder.join("signals"), table.join("features.parquet")])
        .output()
        .expect("started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Rows that failed and rows whose signals are not kept have nulls, a dataset without the velocity has no such column.
#[test]
fn features_of_rows_without_signals_are_nulls() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("made up");
    let velocity = SignalColumn {
        name: "signals_1st_heave_velocity_m_s".to_owned(),
        unit: "m/s".to_owned(),
        description: "made up.".to_owned(),
    };
    let [info, other] =
        [vec![velocity], info().signals].map(|signals| described(DatasetInfo { signals, ..synthetic::info() }));
    let make = |folder: &Path, info: &DatasetInfo| {
        let mut writer = DatasetWriter::create(folder, info, Existing::Refuse).expect("created");
        for row in 0..ROWS {
            let mut record = record(row);
            let signals = record.outcome.metrics.iter_mut().flat_map(|metrics| metrics.signals.iter_mut());
            signals.for_each(|instant| instant.truncate(1 + info.signals.len()));
            writer.write(&record).expect("taken");
        }
        writer.finish().expect("finished");
        features(&DatasetReader::open(folder).expect("opened"), &FeatureSettings::default()).expect("features")
    };
    let found = make(&folder, &info);
    let heave: Vec<_> = found.columns.iter().filter(|column| column.name.starts_with("heave_")).collect();
    // 20 instants have too few lines for any band.
    assert_eq!(heave.len(), 3);
    for row in 0..ROWS as usize {
        // The velocity of a row is its number, throughout.
        let kept = row % 3 == 0 && row % 7 != 3;
        let expected = if kept { [Some(row as f64), Some(0.0), Some(0.0)] } else { [None; 3] };
        let numbers = [0, 1, 2].map(|place| heave[place].values.number(row));
        assert_eq!(numbers, expected, "row {row}");
    }
    let without = make(&scratch.path().join("other"), &other);
    assert!(without.signal_interval_s.is_none());
    assert!(without.columns.iter().all(|column| !column.name.starts_with("heave_")));
}
