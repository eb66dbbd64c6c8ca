//! Compares the machine's mobilities with measured ones.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use super::fit::{Near, fit};
use super::peaks::{Peak, peaks};
use super::response::{MeasuredDof, MeasuredFrf};
use super::table::damping_table;
use crate::structure::error::StructureError;
use crate::structure::modes::{DirectedPoints, ModesAt};
use crate::structure::reduced::{Damping, ModalOptions, ReducedStructure};

/// Resonances whose frequencies differ by more than this share are not the same mode.
const SAME_MODE: f64 = 0.2;

/// Settings of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredSettings {
    /// Damping of the machine's modes.
    pub damping: Damping,
    /// Damping ratios are proposed for modes up to this frequency in Hz.
    pub cutoff_hz: f64,
    /// Interface point of each node, by the node's number as text; names of points stand for themselves.
    pub points_of_nodes: BTreeMap<String, String>,
}

/// A measured response and the machine's.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredCurve {
    /// Point of the velocity, as named in the file.
    pub response: String,
    /// Point of the force.
    pub force: String,
    /// Frequencies in Hz.
    pub frequency_hz: Vec<f64>,
    /// Magnitude of the measured mobility in m/(s N).
    pub measured: Vec<f64>,
    /// The machine's.
    pub machine: Vec<f64>,
    /// Largest distance of the complex curves, relative to the machine's largest magnitude.
    pub largest_relative_difference: f64,
}

/// A resonance in the measured responses with the machine's nearest one.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredMode {
    /// Number of the machine's mode, counted from 1; none for a resonance that the machine does not have.
    pub mode: Option<usize>,
    /// Frequency of the machine's resonance in Hz, from its responses in the same way as the measured one.
    pub machine_hz: Option<f64>,
    /// Measured frequency in Hz; none if no resonance was found.
    pub measured_hz: Option<f64>,
    /// Damping ratio of the machine's resonance, from its responses.
    pub machine_damping_ratio: Option<f64>,
    /// Measured damping ratio; none if it could not be fitted.
    pub measured_damping_ratio: Option<f64>,
    /// Level of the measured resonance over the machine's in dB, over all responses.
    pub level_db: Option<f64>,
}

/// The comparison.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredReport {
    /// One entry per response, in the order of the file.
    pub curves: Vec<MeasuredCurve>,
    /// Resonances in rising order.
    pub modes: Vec<MeasuredMode>,
    /// Damping ratios for the machine's modes up to the cut-off: the measured ones where a resonance was found, else the machine's.
    pub proposed_damping_ratio: Vec<f64>,
    /// Doubtful results, one sentence each.
    pub remarks: Vec<String>,
}

impl MeasuredReport {
    /// The proposed damping ratios as a table for the study's key `damping_ratio_file`.
    pub fn damping_table(&self) -> String {
        damping_table(&self.proposed_damping_ratio)
    }
}

/// Compares measured mobilities with the machine's, without hammers.
///
/// # Errors
/// A place that is no interface point, a direction that the reduction did not keep, no convergence.
pub fn compare(
    structure: &ReducedStructure,
    measured: &[MeasuredFrf],
    settings: &MeasuredSettings,
) -> Result<MeasuredReport, StructureError> {
    let mut places: BTreeMap<&MeasuredDof, usize> = BTreeMap::new();
    let mut rows: Vec<DirectedPoints> = Vec::new();
    for dof in measured.iter().flat_map(|frf| [&frf.response, &frf.force]) {
        if !places.contains_key(dof) {
            places.insert(dof, rows.len());
            rows.push((vec![(point(structure, settings, dof)?, 1.0)], dof.direction()));
        }
    }
    let modes = machine_modes(structure, settings, &rows)?;
    let place = |dof: &MeasuredDof| places.get(dof).copied().unwrap_or_default();
    let machine: Vec<MeasuredFrf> = measured
        .iter()
        .map(|frf| MeasuredFrf {
            mobility: mobility(&modes, [place(&frf.response), place(&frf.force)], frf),
            ..frf.clone()
        })
        .collect();
    let curves: Vec<MeasuredCurve> = measured.iter().zip(&machine).map(|(frf, machine)| curve(frf, machine)).collect();
    let compared = resonances(measured, &machine, &modes);
    let proposed_damping_ratio = proposals(&modes, &compared, settings.cutoff_hz);
    let remarks = remarks(&compared);
    Ok(MeasuredReport { curves, modes: compared, proposed_damping_ratio, remarks })
}

fn point(
    structure: &ReducedStructure,
    settings: &MeasuredSettings,
    dof: &MeasuredDof,
) -> Result<String, StructureError> {
    let points = structure.interface().points();
    if points.get(&dof.place).is_ok() {
        return Ok(dof.place.clone());
    }
    settings.points_of_nodes.get(&dof.place).cloned().ok_or_else(|| {
        let known: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        let expected = format!(
            "an interface point or its node; add one at this place to points_file (known: {})",
            known.join(", ")
        );
        StructureError::argument(format!("place of the measured response {dof}"), expected, &dof.place)
    })
}

/// All modes of the machine, those above the cut-off for the static flexibility that they bring.
fn machine_modes(
    structure: &ReducedStructure,
    settings: &MeasuredSettings,
    rows: &[DirectedPoints],
) -> Result<ModesAt, StructureError> {
    let (listed, damping) = match &settings.damping {
        Damping::PerMode(ratios) => (ratios.as_slice(), Damping::Ratio(ratios.last().copied().unwrap_or(0.0))),
        other => (&[][..], other.clone()),
    };
    let options = ModalOptions { cutoff_hz: f64::MAX, damping };
    let mut modes = structure.modes_at(&[], &options, rows)?;
    if !structure.has_own_damping() {
        modes.damping_ratio.iter_mut().zip(listed).for_each(|(ratio, listed)| *ratio = *listed);
    }
    Ok(modes)
}

/// `j omega sum phi_i phi_j / (omega_s^2 - omega^2 + 2 j xi omega_s omega)` at the frequencies of a response.
fn mobility(modes: &ModesAt, [response, force]: [usize; 2], frf: &MeasuredFrf) -> Vec<[f64; 2]> {
    let at = |hz: &f64| {
        let omega = TAU * hz;
        let mut sum = [0.0; 2];
        for (mode, (own, ratio)) in modes.omega_rad_s.iter().zip(&modes.damping_ratio).enumerate() {
            let (re, im) = (own * own - omega * omega, 2.0 * ratio * own * omega);
            let scale = modes.rows[(response, mode)] * modes.rows[(force, mode)] / (re * re + im * im);
            sum[0] += scale * re;
            sum[1] -= scale * im;
        }
        [-omega * sum[1], omega * sum[0]]
    };
    frf.frequency_hz.iter().map(at).collect()
}

fn magnitude([re, im]: &[f64; 2]) -> f64 {
    libm::hypot(*re, *im)
}

fn curve(measured: &MeasuredFrf, machine: &MeasuredFrf) -> MeasuredCurve {
    let largest = machine.mobility.iter().map(magnitude).fold(f64::MIN_POSITIVE, f64::max);
    let pairs = measured.mobility.iter().zip(&machine.mobility);
    let distance = pairs.map(|(a, b)| magnitude(&[a[0] - b[0], a[1] - b[1]])).fold(0.0, f64::max);
    MeasuredCurve {
        response: measured.response.to_string(),
        force: measured.force.to_string(),
        frequency_hz: measured.frequency_hz.clone(),
        measured: measured.mobility.iter().map(magnitude).collect(),
        machine: machine.mobility.iter().map(magnitude).collect(),
        largest_relative_difference: distance / largest,
    }
}

/// A resonance of a set of responses.
struct Resonance {
    hz: f64,
    damping_ratio: Option<f64>,
    /// Root of the sum of squared magnitudes over all responses.
    level: f64,
}

/// Resonances of responses that share their frequencies; responses with others form sets of their own, and of resonances that several
/// sets show the strongest counts.
fn found(responses: &[MeasuredFrf]) -> Vec<Resonance> {
    let mut sets: Vec<Vec<&MeasuredFrf>> = Vec::new();
    for frf in responses {
        match sets.iter_mut().find(|set| set[0].frequency_hz == frf.frequency_hz) {
            Some(set) => set.push(frf),
            None => sets.push(vec![frf]),
        }
    }
    let mut out: Vec<Resonance> = sets.iter().flat_map(|set| resonances_of(set)).collect();
    out.sort_by(|a, b| a.hz.total_cmp(&b.hz));
    if sets.len() > 1 {
        out.dedup_by(|next, kept| {
            let same = next.hz < kept.hz * (1.0 + kept.damping_ratio.unwrap_or(0.01));
            if same && next.level > kept.level {
                std::mem::swap(next, kept);
            }
            same
        });
    }
    out
}

fn resonances_of(set: &[&MeasuredFrf]) -> Vec<Resonance> {
    let Some(first) = set.first() else { return Vec::new() };
    let sum = |at: usize| set.iter().filter_map(|frf| frf.mobility.get(at)).map(|value| magnitude(value).powi(2)).sum();
    let power: Vec<f64> = (0..first.frequency_hz.len()).map(sum).collect();
    let resonance = |peak: Peak| {
        let near = |frf: &&MeasuredFrf| {
            let omega: Vec<f64> = frf.frequency_hz[peak.range.clone()].iter().map(|hz| TAU * hz).collect();
            // Receptance: the mobility over j omega.
            let receptance = frf.mobility[peak.range.clone()].iter().zip(&omega);
            Near { receptance: receptance.map(|([re, im], omega)| [im / omega, -re / omega]).collect(), omega }
        };
        let near: Vec<Near> = set.iter().map(near).collect();
        let top_hz = first.frequency_hz[peak.top];
        let within = |hz: f64| {
            let [begin, end] = [peak.range.start, peak.range.end - 1].map(|at| first.frequency_hz[at]);
            (begin..=end).contains(&hz)
        };
        let fitted = fit(&near, TAU * top_hz).map(|(omega, ratio)| (omega / TAU, ratio)).filter(|(hz, _)| within(*hz));
        Resonance {
            hz: fitted.map_or(top_hz, |(hz, _)| hz),
            damping_ratio: fitted.map(|(_, ratio)| ratio),
            level: power[peak.top].sqrt(),
        }
    };
    peaks(&power).into_iter().map(resonance).collect()
}

/// Resonances of both in rising order, in pairs.
fn resonances(measured: &[MeasuredFrf], machine: &[MeasuredFrf], modes: &ModesAt) -> Vec<MeasuredMode> {
    let (measured, machine) = (found(measured), found(machine));
    let pairs = pairs(&machine, &measured);
    let mut out = Vec::new();
    for (own, seen) in pairs {
        let (own, seen) = (own.map(|at| &machine[at]), seen.map(|at| &measured[at]));
        // The mode that the machine's resonance is.
        let distance = |mode: &usize, hz: f64| (modes.omega_rad_s[*mode] / TAU - hz).abs();
        let mode = own.and_then(|own| {
            let all = 0..modes.omega_rad_s.len();
            all.min_by(|a, b| distance(a, own.hz).total_cmp(&distance(b, own.hz)))
        });
        out.push(MeasuredMode {
            mode: mode.map(|mode| mode + 1),
            machine_hz: own.map(|own| own.hz),
            measured_hz: seen.map(|seen| seen.hz),
            machine_damping_ratio: own.and_then(|own| own.damping_ratio),
            measured_damping_ratio: seen.and_then(|seen| seen.damping_ratio),
            level_db: own.zip(seen).map(|(own, seen)| 20.0 * libm::log10(seen.level / own.level)),
        });
    }
    out
}

/// Pairs of resonances in rising order that lie nearest to each other in all, by dynamic programming: a pair costs its distance as a
/// share of [`SAME_MODE`], a resonance alone half.
fn pairs(own: &[Resonance], seen: &[Resonance]) -> Vec<(Option<usize>, Option<usize>)> {
    const ALONE: f64 = 0.5;
    let (n, m) = (own.len(), seen.len());
    let cost = |i: usize, j: usize| libm::log(own[i].hz / seen[j].hz).abs() / SAME_MODE;
    let mut best = vec![vec![0.0; m + 1]; n + 1];
    for i in (0..=n).rev() {
        for j in (0..=m).rev() {
            best[i][j] = match (i < n, j < m) {
                (false, false) => 0.0,
                (true, false) => ALONE + best[i + 1][j],
                (false, true) => ALONE + best[i][j + 1],
                (true, true) => {
                    (ALONE + best[i + 1][j]).min(ALONE + best[i][j + 1]).min(cost(i, j) + best[i + 1][j + 1])
                }
            };
        }
    }
    let (mut i, mut j) = (0, 0);
    let mut out = Vec::new();
    while i < n || j < m {
        if i < n && j < m && cost(i, j) < 2.0 * ALONE && best[i][j] == cost(i, j) + best[i + 1][j + 1] {
            out.push((Some(i), Some(j)));
            (i, j) = (i + 1, j + 1);
        } else if i < n && best[i][j] == ALONE + best[i + 1][j] {
            out.push((Some(i), None));
            i += 1;
        } else {
            out.push((None, Some(j)));
            j += 1;
        }
    }
    out
}

fn proposals(modes: &ModesAt, compared: &[MeasuredMode], cutoff_hz: f64) -> Vec<f64> {
    let below = modes.omega_rad_s.iter().take_while(|omega| **omega < TAU * cutoff_hz).count();
    let mut out = modes.damping_ratio[..below].to_vec();
    for one in compared {
        // Neighbouring resonances influence both fits alike.
        if let (Some(mode), Some(own), Some(seen)) = (one.mode, one.machine_damping_ratio, one.measured_damping_ratio)
            && let Some(slot) = out.get_mut(mode - 1)
        {
            *slot *= seen / own;
        }
    }
    out
}

/// Differences that hint at a cause.
fn remarks(compared: &[MeasuredMode]) -> Vec<String> {
    /// Share by which frequencies must differ for a note.
    const FREQUENCY: f64 = 0.01;
    /// Difference of levels for a note, dB.
    const LEVEL_DB: f64 = 3.0;
    let mut out = Vec::new();
    let shifts: Vec<(f64, f64)> = compared
        .iter()
        .filter_map(|one| Some((one.machine_hz?, one.measured_hz?)))
        .filter(|(own, _)| *own > 0.0)
        .collect();
    let off = shifts.iter().filter(|(own, seen)| (seen / own - 1.0).abs() > FREQUENCY).count();
    if off > 0 {
        let (own, seen) = shifts.iter().copied().fold((1.0, 1.0), |most: (f64, f64), one| {
            if (one.1 / one.0 - 1.0).abs() > (most.1 / most.0 - 1.0).abs() { one } else { most }
        });
        out.push(format!(
            "{off} of {} resonances are off by more than 1 % in frequency, the most {:+.2} Hz ({:+.1} %) at {own:.2} Hz",
            shifts.len(),
            seen - own,
            100.0 * (seen / own - 1.0)
        ));
    }
    let alone = compared.iter().filter(|one| one.machine_hz.is_none()).count();
    if alone > 0 {
        out.push(format!("{alone} measured resonances are none of the machine's"));
    }
    let missing = compared.iter().filter(|one| one.measured_hz.is_none()).count();
    if missing > 0 {
        out.push(format!("{missing} of the machine's resonances were not measured"));
    }
    let levels: Vec<f64> = compared.iter().filter_map(|one| one.level_db).collect();
    let mean = levels.iter().sum::<f64>() / levels.len().max(1) as f64;
    if mean.abs() > LEVEL_DB {
        out.push(format!(
            "measured levels are {mean:+.1} dB off on average: is the calibration right, and are units stated in the file (data set 164)?"
        ));
    }
    out
}
