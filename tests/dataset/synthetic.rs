//! A synthetic study and its dataset.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use decore_dataset::{Columns, DatasetInfo, DatasetWriter, Existing, FactorColumn, Manifest, RowRecord};
use decore_model::integrate::Counters;
use decore_model::metrics::{Blow, BlowKind, CastingMetrics, HammerMetrics, Percussion, RunMetrics, RunTotals};
use decore_model::run::{BatchSettings, RowOutcome, RowStatus, run_batch};
use decore_quantity::{Kind, Value};
use tempfile::TempDir;

/// Rows of the synthetic study.
pub const ROWS: u64 = 150;

fn factor(name: &str, kind: Kind, unit: &str) -> FactorColumn {
    FactorColumn { name: name.to_owned(), kind, unit: unit.to_owned(), description: format!("drives {name}") }
}

/// The synthetic study.
pub fn info() -> DatasetInfo {
    described(DatasetInfo {
        study_name: "synthetic".to_owned(),
        study_text: "[study]\nname = \"synthetic\"  # Gußteil\n".to_owned(),
        study_hash: "0123456789abcdef".to_owned(),
        frame_hash: String::new(),
        budget_free_hash: String::new(),
        rows_hash: String::new(),
        overrides: Vec::new(),
        inputs: BTreeMap::new(),
        hammer_files: BTreeMap::new(),
        settings: BTreeMap::new(),
        seed: 18_446_744_073_709_551_615,
        program_version: "0.1.0".to_owned(),
        columns_hash: String::new(),
        rows: ROWS,
        rows_per_part: 64,
        factors: vec![
            factor("hammer.left.supply_bar", Kind::Real, "bar"),
            factor("modes", Kind::Integer, "1"),
            factor("2nd mount", Kind::Text, ""),
        ],
        twins: 0,
        numerical_twins: false,
        hammers: vec!["left".to_owned(), "right-hand".to_owned()],
        castings: vec!["1st".to_owned()],
        elastic_castings: Vec::new(),
        cores: Vec::new(),
        pads: Vec::new(),
        fixture_energies: Vec::new(),
        core_spectra: false,
        design_quality: serde_json::Value::Null,
        row_groups: Some(Vec::new()),
        signals: Vec::new(),
    })
}

/// A study with the hash of the columns that it has.
pub fn described(info: DatasetInfo) -> DatasetInfo {
    let columns_hash = Columns::new(&info).expect("columns").hash();
    DatasetInfo { columns_hash, ..info }
}

/// Every seventh row is invalid; the right-hand hammer of every fifth row misses its first impact.
pub fn outcome(row: u64) -> RowOutcome {
    let invalid = row % 7 == 3;
    let metrics = (!invalid).then(|| metrics(row));
    RowOutcome {
        status: if invalid { RowStatus::Invalid } else { RowStatus::Done },
        reason: if invalid { "hammer `left` misses its casting".to_owned() } else { String::new() },
        time_reached_s: if invalid { 0.0 } else { 1.0 },
        modes: 12,
        states: 70,
        metrics,
        counters: Counters {
            steps: 1000 + row,
            rejected_steps: row,
            rhs_evaluations: 7000 + row,
            located_events: 50,
            retries: row % 2,
            ..Counters::default()
        },
        wall_time_s: 0.25,
        numerical_twin_wall_time_s: None,
    }
}

fn metrics(row: u64) -> RunMetrics {
    let energy = 60.0 + (row as f64).sin();
    let struck = |yes: bool| yes.then_some(energy);
    let hammer = |strikes: bool| HammerMetrics {
        first_impact_time_s: strikes.then_some(0.1),
        first_impact_energy_j: struck(strikes),
        first_impact_work_j: strikes.then_some(0.1 * energy),
        periodic_blows: 9,
        percussion: if strikes { Percussion::Periodic } else { Percussion::Stalled },
        delivered_work_j: 0.5 * row as f64,
        periodic_energy_mean_j: Some(12.0),
        periodic_work_mean_j: Some(2.0),
        hit_frequency_hz: Some(20.0),
        contact_count: 31,
        air_used_nl: 5.0,
        ..HammerMetrics::default()
    };
    let blow = |hammer, number, kind, work_j| Blow {
        hammer,
        number,
        kind,
        start_time_s: 0.1 + number as f64 / 20.0,
        energy_j: energy,
        chisel_velocity_m_s: 4.0,
        work_j,
        impulse_n_s: 3.0,
        peak_force_n: 1e5,
        casting_peak_velocity_m_s: 0.2,
        ..Blow::default()
    };
    RunMetrics {
        hammers: vec![hammer(true), hammer(!row.is_multiple_of(5))],
        castings: vec![CastingMetrics {
            peak_velocity_m_s: 0.5,
            peak_velocity_time_s: 0.11,
            peak_point: "hammer.left".to_owned(),
            ..CastingMetrics::default()
        }],
        blows: vec![
            blow(0, 0, BlowKind::FirstImpact, 0.1 * energy),
            blow(0, 1, BlowKind::Settling, 2.0),
            blow(1, 6, BlowKind::Periodic, row as f64),
        ],
        totals: RunTotals {
            delivered_work_j: row as f64,
            strike_energy_j: row as f64,
            energy_residual: if row == 20 { -2e-3 } else { 1e-5 },
            chamber_residual: 1e-10,
            warnings: if row.is_multiple_of(50) { "deep_contact, damper_jump".to_owned() } else { String::new() },
            ..RunTotals::default()
        },
        ..RunMetrics::default()
    }
}

/// A row as the writer takes it.
pub fn record(row: u64, outcome: RowOutcome) -> RowRecord {
    RowRecord {
        row,
        factors: vec![
            Value::Real(4.0 + row as f64 / 100.0),
            Value::Integer(row as i64 - 75),
            Value::Text(if row.is_multiple_of(2) { "beam_1" } else { "beam_2" }.to_owned()),
        ],
        outcome,
    }
}

/// Writes the synthetic dataset through the batch runner.
pub fn write(folder: &Path, threads: usize) -> Manifest {
    let stop = AtomicBool::new(false);
    let settings = BatchSettings { threads, window: 32, stop: &stop, tick: &|| () };
    let mut writer = DatasetWriter::create(folder, &info(), Existing::Refuse).expect("created");
    run_batch(0..ROWS, &settings, &outcome, |row, outcome: RowOutcome| {
        // Wall times differ between runs; the rest must not.
        let wall_time_s = outcome.wall_time_s + threads as f64;
        writer.write(&record(row, RowOutcome { wall_time_s, ..outcome }))
    })
    .expect("all rows taken");
    writer.finish().expect("finished")
}

/// The synthetic dataset in a scratch folder.
pub fn dataset() -> (TempDir, PathBuf) {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = scratch.path().join("sweep");
    write(&folder, 2);
    (scratch, folder)
}

/// Bytes of all files below a folder, by path.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).expect("folder") {
            let path = entry.expect("entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let relative = path.strip_prefix(folder).expect("below").to_owned();
                found.insert(relative, fs::read(&path).expect("file"));
            }
        }
    }
    found
}

/// Everything but what depends on the machine.
pub fn contract(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = files(folder);
    found.retain(|name, _| !name.starts_with("timings") && name != Path::new("timings.json"));
    found
}
