//! Mobility: velocity at one point of the machine per force at another, over frequency.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use decore_model::system::InterfaceModes;

/// Frequencies of the curves in Hz: from, to, and how many, at equal ratios.
const CURVE_HZ: [f64; 2] = [5.0, 300.0];
const CURVE_POINTS: usize = 600;
/// Distance in Hz at which peaks are looked for.
const PEAK_STEP_HZ: f64 = 0.02;

/// Magnitudes of the machine's mobility along the strike.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Mobility {
    /// Frequencies in Hz.
    pub frequency_hz: Vec<f64>,
    /// Velocity at the hammer's mount per force there, m/(s N).
    pub mount_m_per_s_n: Vec<f64>,
    /// Velocity at the fixture's point of the table per force there, m/(s N).
    pub table_m_per_s_n: Vec<f64>,
    /// Velocity at the mount per force at the fixture's point, m/(s N).
    pub cross_m_per_s_n: Vec<f64>,
    /// Peaks of the mount's.
    pub peaks: Vec<MobilityPeak>,
}

/// A peak of a mobility.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct MobilityPeak {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Height, m/(s N).
    pub mobility_m_per_s_n: f64,
}

impl Mobility {
    /// The mobilities of modes with their shapes at the mount and at the fixture's point.
    pub(super) fn of(modes: &InterfaceModes, mount: &[f64], table: &[f64]) -> Self {
        let [from_hz, to_hz] = CURVE_HZ;
        let ratio = (to_hz / from_hz).ln() / (CURVE_POINTS - 1) as f64;
        let frequency_hz: Vec<f64> = (0..CURVE_POINTS).map(|k| from_hz * (ratio * k as f64).exp()).collect();
        let curve = |response: &[f64], force: &[f64]| -> Vec<f64> {
            frequency_hz.iter().map(|hz| magnitude(modes, [response, force], *hz)).collect()
        };
        Self {
            mount_m_per_s_n: curve(mount, mount),
            table_m_per_s_n: curve(table, table),
            cross_m_per_s_n: curve(mount, table),
            peaks: peaks(|hz| magnitude(modes, [mount, mount], hz)),
            frequency_hz,
        }
    }
}

/// `|i omega sum_s phi_s psi_s / (omega_s^2 - omega^2 + 2 i xi_s omega_s omega)|`.
fn magnitude(modes: &InterfaceModes, [response, force]: [&[f64]; 2], hz: f64) -> f64 {
    let omega = TAU * hz;
    let [mut real, mut imaginary] = [0.0; 2];
    let modes = modes.omega_rad_s.iter().zip(&modes.damping_ratio);
    for ((own, ratio), (phi, psi)) in modes.zip(response.iter().zip(force)) {
        let [elastic, damped] = [own * own - omega * omega, 2.0 * ratio * own * omega];
        let scale = phi * psi / (elastic * elastic + damped * damped);
        real += scale * elastic;
        imaginary -= scale * damped;
    }
    omega * real.hypot(imaginary)
}

/// Finds the peaks of a curve.
fn peaks(curve: impl Fn(f64) -> f64) -> Vec<MobilityPeak> {
    let [from_hz, to_hz] = CURVE_HZ;
    let count = ((to_hz - from_hz) / PEAK_STEP_HZ).round() as usize;
    let points = (0..=count).map(|k| from_hz + PEAK_STEP_HZ * k as f64);
    let points: Vec<MobilityPeak> =
        points.map(|frequency_hz| MobilityPeak { frequency_hz, mobility_m_per_s_n: curve(frequency_hz) }).collect();
    let highest = |three: &&[MobilityPeak]| match three {
        [before, at, after] => {
            at.mobility_m_per_s_n > before.mobility_m_per_s_n && at.mobility_m_per_s_n >= after.mobility_m_per_s_n
        }
        _ => false,
    };
    points.windows(3).filter(highest).filter_map(|three| three.get(1)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode alone has its peak at its own frequency, `phi^2 / (2 xi omega)` high; far above, its mass moves: `phi^2 / omega`.
    #[test]
    fn analytic_one_mode() {
        let (own_hz, ratio, phi) = (40.0, 0.02, 0.5);
        let modes =
            InterfaceModes { omega_rad_s: vec![TAU * own_hz], damping_ratio: vec![ratio], shapes: Default::default() };
        let mobility = Mobility::of(&modes, &[phi], &[-2.0 * phi]);
        let [peak] = mobility.peaks.as_slice() else { panic!("{:?}", mobility.peaks) };
        assert!((peak.frequency_hz - own_hz).abs() < 1e-9, "{peak:?}");
        let height = phi * phi / (2.0 * ratio * TAU * own_hz);
        assert!((peak.mobility_m_per_s_n / height - 1.0).abs() < 1e-12, "{peak:?}, not {height}");
        let (last, mass) = (mobility.mount_m_per_s_n[CURVE_POINTS - 1], phi * phi / (TAU * 300.0));
        assert!((last / mass - 1.0).abs() < 0.02, "{last}, not {mass}");
        assert!((mobility.frequency_hz[CURVE_POINTS - 1] - 300.0).abs() < 1e-9);
        for (k, mount) in mobility.mount_m_per_s_n.iter().enumerate() {
            let [table, cross] = [mobility.table_m_per_s_n[k] / mount, mobility.cross_m_per_s_n[k] / mount];
            assert!((table - 4.0).abs() < 1e-12 && (cross - 2.0).abs() < 1e-12, "{table} {cross}");
        }
    }
}
