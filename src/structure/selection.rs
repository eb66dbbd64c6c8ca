//! The modes that matter to some rows of the interface, by a stated bound; the others as static flexibility.
//!
//! A mode that is dropped is replaced by its static part `phi phi' / omega_s^2`. With `x = (omega / omega_s)^2` and
//! `a = 4 xi_s^2` that errs by `phi phi' / omega_s^2` times `sqrt((x^2 + a x) / ((1 - x)^2 + a x))`, which rises up to
//! `x = (1 + sqrt(1 + 2 a)) / 2`, just above the resonance. `g_s` is the largest error per `phi phi'` up to the band edge.
//!
//! Modes are dropped as long as for every row n the sum `sum phi_ns^2 g_s` stays within `tolerance * F_nn`, F the static
//! flexibility of the modes. By Cauchy and Schwarz the error of every receptance between two rows n, m is then within
//! `tolerance * sqrt(F_nn F_mm)` at all frequencies of the band.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::error::StructureError;
use super::modes::StructureModes;

/// A weighted set of points and a direction, as in [`StructureModes::row`].
pub type DirectedPoints = (Vec<(String, f64)>, [f64; 3]);

/// What is kept and what the rest leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeSelection {
    /// Indices of the kept modes, rising.
    pub kept: Vec<usize>,
    /// Modes there are.
    pub available: usize,
    /// The rows over the kept modes (rows x kept), 1/sqrt(kg).
    pub rows: DMatrix<f64>,
    /// Static flexibility of the dropped modes between the rows (rows x rows), m/N; modes above the cut-off of the structure
    /// included where it stands.
    pub residual_m_per_n: DMatrix<f64>,
    /// The bound that was reached: largest `sum phi_ns^2 g_s / F_nn` of a row; at most the tolerance.
    pub bound: f64,
}

/// How modes are selected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionSettings {
    /// Largest error of a receptance relative to the static flexibility of its rows; 0 keeps every mode that moves a row.
    pub tolerance: f64,
    /// Edge of the band in Hz.
    pub band_hz: f64,
}

impl StructureModes {
    /// Selects the modes that matter to these rows.
    ///
    /// Rigid-body motions are always kept.
    ///
    /// # Errors
    /// As for [`StructureModes::row`]; a tolerance that is negative or not finite, a band edge that is not positive.
    pub fn select(
        &self,
        rows: &[DirectedPoints],
        settings: SelectionSettings,
    ) -> Result<ModeSelection, StructureError> {
        let SelectionSettings { tolerance, band_hz } = settings;
        if !(tolerance.is_finite() && tolerance >= 0.0) {
            return Err(StructureError::argument("mode tolerance", "a number >= 0", tolerance));
        }
        if !(band_hz.is_finite() && band_hz > 0.0) {
            return Err(StructureError::argument("band edge", "a positive frequency in Hz", band_hz));
        }
        let phi: Vec<Vec<f64>> =
            rows.iter().map(|(points, direction)| self.row(points, *direction)).collect::<Result<_, _>>()?;
        let shares = self.shares(&phi, TAU * band_hz);
        let mut order: Vec<usize> = (0..self.len()).filter(|mode| self.omega_rad_s[*mode] > 0.0).collect();
        let largest = |mode: usize| shares.iter().map(|row| row[mode]).fold(0.0, f64::max);
        order.sort_by(|a, b| largest(*a).total_cmp(&largest(*b)));
        let mut kept = vec![true; self.len()];
        let mut sums = vec![0.0; rows.len()];
        for mode in order {
            let next: Vec<f64> = sums.iter().zip(&shares).map(|(sum, row)| sum + row[mode]).collect();
            if next.iter().any(|sum| *sum > tolerance) {
                break;
            }
            sums = next;
            kept[mode] = false;
        }
        let kept: Vec<usize> = (0..self.len()).filter(|mode| kept[*mode]).collect();
        let residual_m_per_n = self.residual(rows, &phi, &kept)?;
        Ok(ModeSelection {
            rows: DMatrix::from_fn(rows.len(), kept.len(), |row, column| phi[row][kept[column]]),
            available: self.len(),
            kept,
            residual_m_per_n,
            bound: sums.into_iter().fold(0.0, f64::max),
        })
    }

    /// `phi_ns^2 g_s / F_nn` per row and mode; 0 for rigid-body motions.
    fn shares(&self, phi: &[Vec<f64>], band: f64) -> Vec<Vec<f64>> {
        let elastic = |omega: &f64| *omega > 0.0;
        let share = |row: &Vec<f64>| {
            let terms = row.iter().zip(&self.omega_rad_s).filter(|(_, omega)| elastic(omega));
            let flexibility: f64 = terms.map(|(value, omega)| (value / omega).powi(2)).sum();
            let of_mode = |((value, &omega), &xi): ((&f64, &f64), &f64)| {
                if !elastic(&omega) || *value == 0.0 {
                    return 0.0;
                }
                let error = static_error(omega, xi, band);
                value * value * error / flexibility
            };
            row.iter().zip(&self.omega_rad_s).zip(&self.damping_ratio).map(of_mode).collect()
        };
        phi.iter().map(share).collect()
    }

    fn residual(
        &self,
        rows: &[DirectedPoints],
        phi: &[Vec<f64>],
        kept: &[usize],
    ) -> Result<DMatrix<f64>, StructureError> {
        let elastic: Vec<usize> = (0..self.len()).filter(|mode| self.omega_rad_s[*mode] > 0.0).collect();
        let dropped: Vec<usize> = elastic.into_iter().filter(|mode| kept.binary_search(mode).is_err()).collect();
        let mut residual = DMatrix::zeros(rows.len(), rows.len());
        for (i, first) in rows.iter().enumerate() {
            for (j, second) in rows.iter().enumerate() {
                let above = self.residual_flexibility((&first.0, first.1), (&second.0, second.1))?.unwrap_or(0.0);
                let below: f64 =
                    dropped.iter().map(|&mode| phi[i][mode] * phi[j][mode] / self.omega_rad_s[mode].powi(2)).sum();
                residual[(i, j)] = above + below;
            }
        }
        Ok(residual)
    }
}

/// `g_s`: the largest error in s2 that the static part of a mode makes up to the band edge; infinite for an undamped mode
/// within the band.
fn static_error(omega: f64, xi: f64, band: f64) -> f64 {
    let a = 4.0 * xi * xi;
    let peak = 0.5 * (1.0 + (1.0 + 2.0 * a).sqrt());
    let x = (band / omega).powi(2).min(peak);
    ((x * x + a * x) / ((1.0 - x).powi(2) + a * x)).sqrt() / (omega * omega)
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
