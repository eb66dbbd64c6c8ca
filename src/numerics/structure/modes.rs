//! The modes that a scene runs on.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::error::StructureError;
use super::points::Interface;

/// A weighted set of points and a direction, as in [`StructureModes::row`].
pub type DirectedPoints = (Vec<(String, f64)>, [f64; 3]);

/// Mass-normalised modes of the machine with its housings at some points of it, in the order of rising frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesAt {
    /// Circular frequencies omega_s in rad/s; 0 for rigid-body motions.
    pub omega_rad_s: Vec<f64>,
    /// Damping ratios xi_s.
    pub damping_ratio: Vec<f64>,
    /// The points' translations along their directions (points x modes) in 1/sqrt(kg), see [`StructureModes::row`].
    pub rows: DMatrix<f64>,
    /// Modes that are only known together; `None`: all modes are there.
    pub rest: Option<Rest>,
}

/// Modes above an edge, of which only is known what they are to the rows together: the last modes stand for them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// The first mode that stands for them.
    pub first: usize,
    /// Circular frequency in rad/s above which they are.
    pub edge_rad_s: f64,
    /// How many they are.
    pub count: usize,
}

/// Mass-normalised modes of the machine with its housings, in the order of rising frequency.
///
/// Per mode s: `x_s'' = -omega_s^2 x_s - 2 xi_s omega_s x_s' + sum_n phi_ns F_n`; a point moves by
/// `w_n = sum_s phi_ns x_s`.
#[derive(Debug, Clone)]
pub struct StructureModes {
    /// Circular frequencies omega_s in rad/s; 0 for rigid-body motions.
    pub omega_rad_s: Vec<f64>,
    /// Damping ratios xi_s.
    pub damping_ratio: Vec<f64>,
    pub(super) shapes: DMatrix<f64>,
    pub(super) interface: Arc<Interface>,
    pub(super) static_flexibility: Option<Arc<DMatrix<f64>>>,
}

/// A weighted mean of interface points, and a direction in which it moves.
#[derive(Debug, Clone, Copy)]
pub struct Directed<'a> {
    /// The points and their weights.
    pub points: &'a [(String, f64)],
    /// The direction, a unit vector.
    pub direction: [f64; 3],
}

impl StructureModes {
    /// Number of modes.
    pub fn len(&self) -> usize {
        self.omega_rad_s.len()
    }

    /// Whether there is no mode.
    pub fn is_empty(&self) -> bool {
        self.omega_rad_s.is_empty()
    }

    /// Natural frequencies in Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.omega_rad_s.iter().map(|omega| omega / TAU).collect()
    }

    /// The interface DOFs and the points' coordinates.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Modal displacements of the interface DOFs (n_b x modes) in 1/sqrt(kg), rotations in rad/(m sqrt(kg)).
    pub fn shapes(&self) -> &DMatrix<f64> {
        &self.shapes
    }

    /// `phi_n = d' R_n T Phi` in 1/sqrt(kg), one entry per mode: the translation of a weighted set of points along
    /// `direction`. The direction is used as given; a unit vector gives displacements in m and takes forces in N.
    ///
    /// # Errors
    /// An unknown point, a direction that was not kept, a direction that is 0 or not finite.
    pub fn row(&self, points: &[(String, f64)], direction: [f64; 3]) -> Result<Vec<f64>, StructureError> {
        let rows = self.interface.translation(points, direction)?;
        Ok(self.shapes.column_iter().map(|mode| rows.iter().map(|&(row, weight)| weight * mode[row]).sum()).collect())
    }

    /// The modes at some points: one row each as [`StructureModes::row`] has it.
    ///
    /// # Errors
    /// As for [`StructureModes::row`].
    pub fn at(&self, points: &[DirectedPoints]) -> Result<ModesAt, StructureError> {
        let mut rows = DMatrix::zeros(points.len(), self.len());
        for (index, (points, direction)) in points.iter().enumerate() {
            rows.row_mut(index).copy_from_slice(&self.row(points, *direction)?);
        }
        Ok(ModesAt {
            omega_rad_s: self.omega_rad_s.clone(),
            damping_ratio: self.damping_ratio.clone(),
            rows,
            rest: None,
        })
    }

    /// Static flexibility that the dropped modes leave between two rows,
    /// `R_nm = (full static)_nm - sum_kept phi_n phi_m / omega^2` in m/N.
    ///
    /// Each row is a weighted set of points and a direction as in [`StructureModes::row`]. Static deflections do not
    /// depend on the housings' mass. `None` for a structure that floats: it has no static deflection.
    ///
    /// # Errors
    /// As for [`StructureModes::row`].
    pub fn residual_flexibility(
        &self,
        first: Directed<'_>,
        second: Directed<'_>,
    ) -> Result<Option<f64>, StructureError> {
        let (n, m) = (
            self.interface.translation(first.points, first.direction)?,
            self.interface.translation(second.points, second.direction)?,
        );
        let Some(flexibility) = &self.static_flexibility else { return Ok(None) };
        let full: f64 = n.iter().flat_map(|&(i, p)| m.iter().map(move |&(j, q)| p * flexibility[(i, j)] * q)).sum();
        let (phi_n, phi_m) = (self.row(first.points, first.direction)?, self.row(second.points, second.direction)?);
        let kept: f64 =
            phi_n.iter().zip(&phi_m).zip(&self.omega_rad_s).map(|((p, q), omega)| p * q / (omega * omega)).sum();
        Ok(Some(full - kept))
    }
}
