//! Statements of the paper on the machine: Table 3 and Figure 14.

use super::compared::{Evidence, EvidenceRow, FigureGroup, Printed, Tolerance};
use super::mobility::MobilityPeak;
use super::quoted::{ISOLATORS_HZ, NATURAL_FREQUENCIES, NOT_CALCULATED_HZ, NaturalFrequency};
use super::rig::Ours;

/// The group that the mobilities belong to.
pub(super) const MOBILITY: &str = "Mobility at the hammer's mount";
/// Tolerance: the accuracy of the fit, and of the paper's own calculation (its largest difference is 5.1 %).
const TOLERANCE: Tolerance = Tolerance::Share { of_calculation: 0.01, of_measurement: 0.05 };
/// A measured mode belongs to a peak within this share of its frequency.
const SAME_MODE: f64 = 0.05;

/// Compares natural frequencies and mobilities with ours.
pub(super) fn groups(ours: &Ours) -> Vec<FigureGroup> {
    vec![natural_frequencies(ours), mobility(ours)]
}

fn natural_frequencies(ours: &Ours) -> FigureGroup {
    let mode = |(index, row): (usize, &NaturalFrequency)| {
        let ours_hz = nearest(&ours.frequencies_hz, row.calculated_hz);
        TOLERANCE.judge(Printed::both(
            format!("mode {}", index + 1),
            "Hz",
            [row.calculated_hz, row.measured_hz],
            ours_hz,
        ))
    };
    let figures: Vec<_> = NATURAL_FREQUENCIES.iter().enumerate().map(mode).collect();
    let farthest = figures.iter().filter_map(|figure| figure.calculated).map(|one| one.difference.abs());
    let isolators = ours.frequencies_hz.iter().filter(|hz| **hz < ISOLATORS_HZ).count();
    let neighbours = NOT_CALCULATED_HZ.map(|hz| format!("{hz} Hz ({:.1} Hz)", nearest(&ours.frequencies_hz, hz)));
    let remarks = vec![
        format!(
            "decore stays within {:.2} % of the calculation, because the built-in station was fitted to it. So it differs from the \
             measurement as the paper's calculation does, because of the simplified structure.",
            100.0 * farthest.fold(0.0, f64::max)
        ),
        format!(
            "Measured, but not calculated by the paper or by decore (with the nearest mode of decore): {}. Below {ISOLATORS_HZ} Hz, \
             decore has {isolators} modes of the isolators. The paper states no number.",
            neighbours.join(", ")
        ),
    ];
    FigureGroup {
        name: "Natural frequencies",
        source: "Table 3",
        tolerance: TOLERANCE,
        figures,
        remarks,
        evidence: Vec::new(),
    }
}

fn mobility(ours: &Ours) -> FigureGroup {
    let peaks = &ours.mobility.peaks;
    let is_seen = |hz: f64| peaks.iter().any(|peak| (peak.frequency_hz / hz - 1.0).abs() <= SAME_MODE);
    let list = |wanted: bool| -> String {
        let measured = NATURAL_FREQUENCIES.iter().map(|row| row.measured_hz).chain(NOT_CALCULATED_HZ);
        let mut listed: Vec<f64> = measured.filter(|hz| is_seen(*hz) == wanted).collect();
        listed.sort_by(f64::total_cmp);
        listed.iter().map(|hz| format!("{hz}")).collect::<Vec<_>>().join(", ")
    };
    let remarks = vec![
        format!(
            "The paper prints a curve without figures, and no geometry. So only the frequencies of peaks can be compared, not their \
             heights. Measured modes with a peak of decore within {:.0} %: {} Hz; without: {} Hz.",
            100.0 * SAME_MODE,
            list(true),
            list(false)
        ),
        "The paper calls 32 Hz underrepresented in its calculation. decore has no mode there either. A mode with little motion \
         along the strike at the mount makes no peak there."
            .to_owned(),
    ];
    let measured_hz = |peak: &MobilityPeak| {
        let all: Vec<f64> = NATURAL_FREQUENCIES.iter().map(|row| row.measured_hz).collect();
        Some(nearest(&all, peak.frequency_hz)).filter(|hz| (peak.frequency_hz / hz - 1.0).abs() <= SAME_MODE)
    };
    let row = |(index, peak): (usize, &MobilityPeak)| {
        let values = [Some(peak.frequency_hz), measured_hz(peak), Some(1e6 * peak.mobility_m_per_s_n)];
        EvidenceRow::new(format!("peak {}", index + 1), &values)
    };
    let columns = ["ours (Hz)", "measured (Hz)", "1e-6 m/(s N)"];
    FigureGroup {
        name: MOBILITY,
        source: "Figure 14",
        tolerance: TOLERANCE,
        figures: Vec::new(),
        remarks,
        evidence: vec![Evidence::new(
            "Peaks of the mobility, mount to mount",
            &columns,
            peaks.iter().enumerate().map(row).collect(),
        )],
    }
}

/// The value nearest to another; itself if there is none.
fn nearest(values: &[f64], to: f64) -> f64 {
    let distance = |value: &&f64| (**value - to).abs();
    values.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied().unwrap_or(to)
}
