//! Modes above an edge, known only by their sum, which follows from the structure without solving for them.
//!
//! Static deflections do not depend on bodies: with the own modes scaled by stiffness, `S` their shapes at the rows, the flexibility
//! of all modes is `F = S S'`. Their mass is that of the whole machine with its bodies, `A = S (N + U U')^-1 S'`
//! ([`super::own`]). What the modes below the edge leave of both belongs to the rest; modes that stand for it ([`super::standing`]) have
//! the same damping ratio.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::combined_modes::{CombinedModes, ModeSums};
use super::error::StructureError;
use super::modes::{ModesAt, TruncatedModes};
use super::own::OwnModes;
use super::selection::{SelectionSettings, dynamic_part};

/// Share of the tolerance that the own modes above the edge may err by.
const SHARE: f64 = 0.05;
/// Share of the own modes from which on solving for all of them costs hardly more.
const MOST: f64 = 0.8;

/// Task of a reduction: rows as combinations of interface rows, one damping ratio for all modes, a selection.
pub(super) struct ReductionDemand<'a> {
    pub rows: &'a [Vec<(usize, f64)>],
    pub damping_ratio: f64,
    pub settings: SelectionSettings,
}

impl ReductionDemand<'_> {
    /// Circular frequency in rad/s above which single modes are not needed, according to the own modes; `None` if this saves nothing.
    pub fn edge(&self, own: &OwnModes) -> Option<f64> {
        let shapes = own.elastic_at(self.rows);
        let SelectionSettings { tolerance, band_hz } = self.settings;
        let whole: Vec<f64> = shapes.row_iter().map(|row| row.norm_squared()).collect();
        let mut above = vec![0.0; whole.len()];
        let omega = |mode: usize| own.nu()[mode].sqrt().recip();
        let mut first = own.nu().len();
        while let Some(mode) = first.checked_sub(1) {
            above.iter_mut().zip(shapes.column(mode).iter()).for_each(|(sum, value)| *sum += value * value);
            let dynamic = dynamic_part(omega(mode), self.damping_ratio, TAU * band_hz);
            if above.iter().zip(&whole).any(|(above, whole)| dynamic * above > SHARE * tolerance * whole) {
                break;
            }
            first = mode;
        }
        let saves = (first as f64) < MOST * own.nu().len() as f64 && omega(first) > TAU * band_hz;
        saves.then(|| omega(first))
    }

    /// The modes below the edge with those that stand for the rest; `None` if the rest errs by more than half the tolerance.
    ///
    /// # Errors
    /// No convergence.
    pub fn modes(
        &self,
        own: &OwnModes,
        factor: &DMatrix<f64>,
        edge_rad_s: f64,
    ) -> Result<Option<ModesAt>, StructureError> {
        let Some(mass) = own.mass_at(self.rows, factor)? else { return Ok(None) };
        let below = own.with_bodies(factor, edge_rad_s)?;
        let known = own.shapes(&below, self.rows)?;
        let own_shapes = own.elastic_at(self.rows);
        let mut deflections = known.clone();
        for (mut column, omega) in deflections.column_iter_mut().zip(&below.omega_rad_s) {
            column.unscale_mut(*omega);
        }
        let rest = ModeSums {
            mass: mass - &known * known.transpose(),
            flexibility: &own_shapes * own_shapes.transpose() - &deflections * deflections.transpose(),
        };
        let CombinedModes { omega_rad_s, rows, .. } = rest.standing([edge_rad_s, own.most_rad_s().max(edge_rad_s)]);
        let first = below.omega_rad_s.len();
        let count = own.nu().len() - first;
        let mut all = known.resize_horizontally(first + omega_rad_s.len(), 0.0);
        all.columns_mut(first, omega_rad_s.len()).copy_from(&rows);
        let omega_rad_s = [below.omega_rad_s, omega_rad_s].concat();
        let modes = ModesAt {
            damping_ratio: vec![self.damping_ratio; omega_rad_s.len()],
            omega_rad_s,
            rows: all,
            rest: Some(TruncatedModes { first, edge_rad_s, count }),
        };
        let errs = modes.rest_share(self.settings);
        Ok(Some(modes).filter(|_| errs <= 0.5 * self.settings.tolerance))
    }
}
