//! Selects the modes that matter to some rows of the interface, with a given bound; residual modes replace the others.
//!
//! A mode that is dropped is replaced by its static part `phi phi' / omega_s^2`. With `x = (omega / omega_s)^2` and
//! `a = 4 xi_s^2` that errs by `phi phi' / omega_s^2` times `sqrt((x^2 + a x) / ((1 - x)^2 + a x))`, which rises up to
//! `x = (1 + sqrt(1 + 2 a)) / 2`, just above the resonance. `g_s` is the largest error per `phi phi'` up to the band edge.
//!
//! The static part of all dropped modes together, `R = sum phi phi' / omega_s^2`, must carry mass to be integrated in time.
//! It is given the mass of the same modes, `A = sum phi phi'`, by residual modes ([`super::standing`]). The rows so keep their static
//! flexibility and their response to a jump of force, exactly, whatever is dropped.
//!
//! Modes are dropped as long as for every row n the sum `sum phi_ns^2 g_s` over dropped and residual modes stays within
//! `tolerance * F_nn`, F the static flexibility of the modes. By Cauchy and Schwarz the error of every receptance between two
//! rows n, m is then within `tolerance * sqrt(F_nn F_mm)` at all frequencies of the band.
//!
//! Modes above an edge that are only known together ([`TruncatedModes`]) are dropped. With `phi^2 g = (phi / omega)^2 h(omega)`, where h
//! falls
//! with the frequency above the band, theirs is at most `h(edge) R_nn`, R their static flexibility.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::combined_modes::{CombinedModes, ModeSums};
use super::error::StructureError;
use super::modes::{ModesAt, TruncatedModes};

/// Smallest part of the tolerance that is tried for the dropped modes before none is dropped.
const LEAST_PART: f64 = 1e-6;

/// Kept modes and the error of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeSelection {
    /// Indices of the kept modes, rising.
    pub kept: Vec<usize>,
    /// Modes there are.
    pub available: usize,
    /// The rows over the kept modes (rows x kept), 1/sqrt(kg).
    pub rows: DMatrix<f64>,
    /// Residual modes for the dropped modes.
    pub residual: ResidualModes,
    /// The bound that was reached: largest `sum phi_ns^2 g_s / F_nn` of a row; at most the tolerance.
    pub bound: f64,
}

/// Modes that together have the static flexibility and the mass of many.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualModes {
    /// Circular frequencies in rad/s.
    pub omega_rad_s: Vec<f64>,
    /// Damping ratios: the damping of the dropped modes seen along each residual mode.
    pub damping_ratio: Vec<f64>,
    /// The rows over the residual modes (rows x modes), 1/sqrt(kg).
    pub rows: DMatrix<f64>,
}

/// Settings of the selection of modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionSettings {
    /// Largest error of a receptance relative to the static flexibility of its rows; 0 keeps every mode that moves a row.
    pub tolerance: f64,
    /// Edge of the band in Hz.
    pub band_hz: f64,
}

/// Rows of interface points: of the modes, and the share of each mode in their flexibility.
struct InterfaceRows<'a> {
    phi: &'a [Vec<f64>],
    shares: &'a [Vec<f64>],
}

impl ModesAt {
    /// Selects the modes that matter to these points.
    ///
    /// Rigid-body motions are always kept.
    ///
    /// # Errors
    /// A tolerance that is negative or not finite, a band edge that is not positive.
    pub fn select(&self, settings: SelectionSettings) -> Result<ModeSelection, StructureError> {
        let SelectionSettings { tolerance, band_hz } = settings;
        if !(tolerance.is_finite() && tolerance >= 0.0) {
            return Err(StructureError::argument("mode tolerance", "a number >= 0", tolerance));
        }
        if !(band_hz.is_finite() && band_hz > 0.0) {
            return Err(StructureError::argument("band edge", "a positive frequency in Hz", band_hz));
        }
        let phi: Vec<Vec<f64>> = self.rows.row_iter().map(|row| row.iter().copied().collect()).collect();
        let shares = self.shares(&phi, TAU * band_hz);
        let mut order: Vec<usize> = (0..self.known()).filter(|mode| self.omega_rad_s[*mode] > 0.0).collect();
        let largest = |mode: usize| shares.iter().map(|row| row[mode]).fold(0.0, f64::max);
        order.sort_by(|a, b| largest(*a).total_cmp(&largest(*b)));
        // The residual modes take their part of the tolerance: less is left to the dropped ones until both fit.
        let mut allowance = tolerance;
        loop {
            let (kept, dropped) = self.split(&order, &shares, allowance);
            let residual = self.residual(&phi, &dropped);
            let bound = self.bound(&InterfaceRows { phi: &phi, shares: &shares }, &dropped, &residual, TAU * band_hz);
            if bound <= tolerance || dropped.len() + self.known() == self.omega_rad_s.len() {
                let rows = DMatrix::from_fn(phi.len(), kept.len(), |row, column| phi[row][kept[column]]);
                let available = self.known() + self.rest.map_or(0, |rest| rest.count);
                return Ok(ModeSelection { rows, available, kept, residual, bound });
            }
            allowance = if allowance > LEAST_PART * tolerance { 0.5 * allowance } else { 0.0 };
        }
    }

    /// Modes that are known one by one; behind them are those that stand for the rest.
    fn known(&self) -> usize {
        self.rest.map_or(self.omega_rad_s.len(), |rest| rest.first)
    }

    /// The largest share of a row that the rest errs by.
    pub(super) fn rest_share(&self, settings: SelectionSettings) -> f64 {
        let phi: Vec<Vec<f64>> = self.rows.row_iter().map(|row| row.iter().copied().collect()).collect();
        let of_row = |row: &Vec<f64>| row.iter().skip(self.known()).sum::<f64>();
        self.shares(&phi, TAU * settings.band_hz).iter().map(of_row).fold(0.0, f64::max)
    }

    /// Kept and dropped modes, both rising, if the shares of the dropped ones may sum up to `allowance` in every row.
    fn split(&self, order: &[usize], shares: &[Vec<f64>], allowance: f64) -> (Vec<usize>, Vec<usize>) {
        let mut is_kept = vec![true; self.omega_rad_s.len()];
        is_kept[self.known()..].fill(false);
        let mut sums: Vec<f64> = shares.iter().map(|row| row[self.known()..].iter().sum()).collect();
        for &mode in order {
            sums.iter_mut().zip(shares).for_each(|(sum, row)| *sum += row[mode]);
            if sums.iter().any(|sum| *sum > allowance) {
                break;
            }
            is_kept[mode] = false;
        }
        (0..self.omega_rad_s.len()).partition(|mode| is_kept[*mode])
    }

    /// Largest share of a row that dropped and residual modes err by together.
    fn bound(
        &self,
        InterfaceRows { phi, shares }: &InterfaceRows<'_>,
        dropped: &[usize],
        residual: &ResidualModes,
        band: f64,
    ) -> f64 {
        let of_row = |row: usize| {
            let of_dropped: f64 = dropped.iter().map(|&mode| shares[row][mode]).sum();
            let parameters = residual.omega_rad_s.iter().zip(&residual.damping_ratio);
            let squares = residual.rows.row(row).map(|psi| psi * psi);
            let errors = parameters.map(|(omega, xi)| static_error(*omega, *xi, band));
            let of_residual: f64 = squares.iter().zip(errors).map(|(square, error)| square * error).sum();
            let flexibility = self.flexibility(&phi[row]);
            of_dropped + if flexibility > 0.0 { of_residual / flexibility } else { 0.0 }
        };
        (0..phi.len()).map(of_row).fold(0.0, f64::max)
    }

    /// Static flexibility of a row, rigid-body motions left out, m/N.
    fn flexibility(&self, row: &[f64]) -> f64 {
        let elastic = row.iter().zip(&self.omega_rad_s).filter(|(_, omega)| **omega > 0.0);
        elastic.map(|(value, omega)| (value / omega).powi(2)).sum()
    }

    /// `phi_ns^2 g_s / F_nn` per row and mode; 0 for rigid-body motions.
    fn shares(&self, phi: &[Vec<f64>], band: f64) -> Vec<Vec<f64>> {
        let of_mode = |(mode, (&omega, &xi)): (usize, (&f64, &f64))| match self.rest {
            _ if omega == 0.0 => 0.0,
            Some(TruncatedModes { first, edge_rad_s, .. }) if mode >= first => {
                dynamic_part(edge_rad_s, xi, band) / (omega * omega)
            }
            _ => static_error(omega, xi, band),
        };
        let errors: Vec<f64> = self.omega_rad_s.iter().zip(&self.damping_ratio).enumerate().map(of_mode).collect();
        let share = |row: &Vec<f64>| {
            let flexibility = self.flexibility(row);
            // A mode that does not move the row has no share, however large its error.
            let of_mode =
                |(value, error): (&f64, &f64)| if *value == 0.0 { 0.0 } else { value * value * error / flexibility };
            row.iter().zip(&errors).map(of_mode).collect()
        };
        phi.iter().map(share).collect()
    }

    /// The residual modes of some modes.
    fn residual(&self, phi: &[Vec<f64>], dropped: &[usize]) -> ResidualModes {
        let shapes = DMatrix::from_fn(phi.len(), dropped.len(), |row, column| phi[row][dropped[column]]);
        let weighted = |weight: &dyn Fn(usize) -> f64| {
            let mut scaled = shapes.clone();
            for (mut column, &mode) in scaled.column_iter_mut().zip(dropped) {
                column.scale_mut(weight(mode));
            }
            scaled * shapes.transpose()
        };
        let flexibility = weighted(&|mode| self.omega_rad_s[mode].powi(-2));
        let omegas = || dropped.iter().map(|mode| self.omega_rad_s[*mode]);
        let range_rad_s = [omegas().fold(f64::INFINITY, f64::min), omegas().fold(0.0, f64::max)];
        let CombinedModes { omega_rad_s, rows, inverse } =
            ModeSums { mass: weighted(&|_| 1.0), flexibility }.standing(range_rad_s);
        let rate = weighted(&|mode| 2.0 * self.damping_ratio[mode] * self.omega_rad_s[mode]);
        let rate = inverse.tr_mul(&(rate * &inverse));
        let damping_ratio = omega_rad_s.iter().zip(rate.diagonal().iter()).map(|(w, rate)| 0.5 * rate / w).collect();
        ResidualModes { omega_rad_s, damping_ratio, rows }
    }
}

/// `g_s`: the largest error in s2 that the static part of a mode makes up to the band edge; infinite for an undamped mode
/// within the band.
fn static_error(omega: f64, xi: f64, band: f64) -> f64 {
    dynamic_part(omega, xi, band) / (omega * omega)
}

/// `h`: the same over `1 / omega_s^2`; of modes with one damping ratio it falls with the frequency.
pub(super) fn dynamic_part(omega: f64, xi: f64, band: f64) -> f64 {
    let a = 4.0 * xi * xi;
    let peak = 0.5 * (1.0 + (1.0 + 2.0 * a).sqrt());
    let x = (band / omega).powi(2).min(peak);
    ((x * x + a * x) / ((1.0 - x).powi(2) + a * x)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_static_error_is_the_largest_over_the_band() {
        for (omega, xi, band) in [(10.0, 0.02, 100.0), (10.0, 0.3, 9.0), (50.0, 0.01, 20.0), (10.0, 0.9, 100.0)] {
            let error = |w: f64| {
                let (re, im) = (omega * omega - w * w, 2.0 * xi * omega * w);
                let norm = re * re + im * im;
                (re / norm - 1.0 / (omega * omega)).hypot(im / norm)
            };
            let sampled = (0..=200_000).map(|i| error(band * f64::from(i) / 200_000.0)).fold(0.0, f64::max);
            let bound = static_error(omega, xi, band);
            assert!(sampled <= bound * (1.0 + 1e-12) && sampled > 0.999 * bound, "{sampled} {bound}");
        }
        assert_eq!(static_error(10.0, 0.0, 20.0), f64::INFINITY);
    }
}
