//! Signals that a sweep stores: the request in `[outputs]`, checked against the available signals.

use std::collections::BTreeSet;

use super::error::EngineError;
use crate::{CheckedStudy, FactorInfo};
use decore_dataset::SignalColumn;
use decore_model::metrics::{MeanSettings, SignalRecorder, signal_list};
use decore_model::scene::Scene;
use decore_quantity::words::{did_you_mean, nearest};

/// Interval in s of the signals unless the study states another.
const DEFAULT_INTERVAL_S: f64 = 1e-3;
/// Largest number of bytes of the signals of a part, and of the waiting rows; a single row may exceed it.
const MOST_BYTES: u64 = 1 << 26;
/// Bytes of a value in the journal.
const CELL_BYTES: f64 = 9.0;

/// Rows and signals to store.
#[derive(Debug, Clone)]
pub(super) struct KeptSignals {
    /// Signals, and their averaging.
    pub settings: MeanSettings,
    /// Columns of the signals.
    pub columns: Vec<SignalColumn>,
    /// The rows; `None`: all.
    rows: Option<BTreeSet<u64>>,
    /// Bytes of a row's signals in memory.
    row_bytes: u64,
}

/// Longest duration of a row in s: the duration of the first row with a scene, if no factor drives it.
fn longest_duration_s(checked: &CheckedStudy) -> f64 {
    let drives = |factor: &FactorInfo| factor.paths().iter().any(|path| path == "duration_s");
    let looked_at = if checked.study().factors().iter().any(drives) { usize::MAX } else { 1 };
    let durations = (0..checked.row_count()).filter_map(|row| checked.scene(row).ok()).map(|scene| scene.duration_s);
    durations.take(looked_at).reduce(f64::max).unwrap_or_else(|| Scene::default().duration_s)
}

impl KeptSignals {
    /// Reads the request of a study; `None` if it keeps no signals.
    ///
    /// # Errors
    /// [`EngineError::Outputs`]: a signal that there is not, or twice; a row beyond the last.
    pub fn of(checked: &CheckedStudy) -> Result<Option<Self>, EngineError> {
        let (study, rows) = (checked.study(), checked.row_count() as u64);
        let outputs = study.outputs();
        if outputs.signals.is_empty() {
            return Ok(None);
        }
        let wrong = |key, message| Err(EngineError::Outputs { key, message });
        let interval_s = outputs.signal_interval_s.unwrap_or(DEFAULT_INTERVAL_S);
        if let Some(row) = outputs.signal_rows.iter().find(|row| **row >= rows) {
            return wrong("signal_rows", format!("names row {row}, but the study has the rows 0 to {}", rows - 1));
        }
        let known: Vec<SignalColumn> = signal_list(&study.hammer_names(), &study.castings(), &outputs.points)
            .iter()
            .map(|signal| SignalColumn::of(signal, interval_s))
            .collect();
        let mut signals = Vec::new();
        for name in &outputs.signals {
            // The first one is the time, which the table has anyway.
            let place = known.iter().position(|column| column.name == *name).filter(|place| *place > 0);
            let Some(place) = place.filter(|place| !signals.contains(place)) else {
                let names = known.iter().skip(1).map(|column| column.name.as_str());
                let hint = did_you_mean(nearest(name, names).filter(|meant| meant != name));
                let message = format!("`{name}` is not a signal of the study, is the time, or is listed twice{hint}");
                return wrong("signals", message);
            };
            signals.push(place);
        }
        let columns = signals.iter().filter_map(|place| known.get(*place).cloned()).collect();
        let instants = SignalRecorder::instants(longest_duration_s(checked), interval_s);
        let row_bytes = (instants * (signals.len() + 2) as f64 * CELL_BYTES).min(1e18) as u64;
        let chosen = (!outputs.signal_rows.is_empty()).then(|| outputs.signal_rows.iter().copied().collect());
        Ok(Some(Self { settings: MeanSettings { interval_s, signals }, columns, rows: chosen, row_bytes }))
    }

    /// Whether the signals of a row are kept.
    pub fn keep(&self, row: u64) -> bool {
        self.rows.as_ref().is_none_or(|rows| rows.contains(&row))
    }

    /// Rows of a part, `per_part` where their signals leave room; a power of two if that is one.
    pub fn rows_per_part(&self, per_part: u64) -> u64 {
        let mut rows = per_part;
        while rows > 1 && self.kept_of(rows).saturating_mul(self.row_bytes) > MOST_BYTES {
            rows /= 2;
        }
        rows
    }

    /// Most rows of `rows` consecutive ones that have signals.
    fn kept_of(&self, rows: u64) -> u64 {
        self.rows.as_ref().map_or(rows, |chosen| rows.min(chosen.len() as u64))
    }
}
