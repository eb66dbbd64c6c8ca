//! Modes of the machine alone, and of the machine with rigid bodies.
//!
//! With `L L' = K_zz + shift M_zz` the own modes come once from `L^-1 M_zz L^-T y = mu y`, `omega^2 = 1/mu - shift`: elastic ones
//! scaled to `s' K s = 1`, with `nu = 1/omega^2`; rigid-body motions (below 0.01 Hz) scaled to `r' M r = 1`. DOFs without mass have
//! `nu = 0`.
//!
//! Bodies bring the mass `W W'` on the interface. A mode `sum z_i s_i + sum c_j r_j` of the machine that carries them obeys, with
//! `U = S' W`, `F = R' W` and `q = W' u`,
//!
//! ```text
//! nu z = N z + U q,   c = -F q (the mode moves no rigid-body momentum),   q = U' z + F' c
//! ```
//!
//! and so `(N + U (I + F'F)^-1 U') z = nu z`: a diagonal problem with one of rank six per body added, of which
//! [`updated_pairs`] finds the pairs. The rigid-body motions stay, with the bodies in their mass: `R (I + F F')^-1/2`.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::error::{Step, StructureError};
use decore_math::linalg::{
    UpdatedPairs, cholesky, multiply, multiply_transposed, solve_lower, solve_lower_transposed, symmetric_eigen,
    updated_pairs,
};

/// Spectral shift in 1/s2, (2 pi 1 Hz)^2: makes `K_zz + shift M_zz` positive definite for machines that float. The result does
/// not depend on it beyond rounding.
pub(super) const SHIFT: f64 = TAU * TAU;

/// A mode below this frequency in Hz counts as a rigid-body motion and gets omega = 0, because rounding in the matrices hides such
/// frequencies.
pub(super) const RIGID_BODY_HZ: f64 = 0.01;

/// The same as a squared circular frequency in 1/s2.
const RIGID_BODY: f64 = (TAU * RIGID_BODY_HZ) * (TAU * RIGID_BODY_HZ);

/// Share of the largest `nu` below which a mode counts as one without mass.
const LEAST_MASS: f64 = 1e-11;

pub(super) const CHECK_INPUT: &str = "check signs and units of mass and stiffness";

/// Own modes of a structure.
#[derive(Debug, Clone)]
pub(super) struct OwnModes {
    /// `nu = 1/omega^2` of the elastic modes in s2, falling.
    nu: Vec<f64>,
    /// Interface shapes of the elastic modes, scaled by stiffness (n_b x modes).
    elastic: DMatrix<f64>,
    /// Interface shapes of the rigid-body motions, scaled by mass (n_b x motions).
    rigid: DMatrix<f64>,
    /// Damping over both, the elastic ones first, if the structure brings its own.
    damping: Option<DMatrix<f64>>,
}

/// Modes of the machine with its bodies over its own modes.
pub(super) struct LoadedModes {
    /// Circular frequencies in rad/s, rising; 0 for rigid-body motions.
    pub omega_rad_s: Vec<f64>,
    /// Mass-normalised modes over the own elastic ones (elastic x modes).
    elastic: DMatrix<f64>,
    /// And over the own rigid-body motions (motions x modes).
    rigid: DMatrix<f64>,
}

/// Matrices in the coordinates of `L^-1`: mass, interface shapes (n_b x n_z) and damping.
pub(super) struct ScaledMatrices {
    pub mass: DMatrix<f64>,
    pub shapes: DMatrix<f64>,
    pub damping: Option<DMatrix<f64>>,
}

impl OwnModes {
    /// Solves for the own modes.
    ///
    /// # Errors
    /// No convergence, a mass or stiffness that is not positive semidefinite.
    pub fn new(scaled: &ScaledMatrices) -> Result<Self, StructureError> {
        const STEP: &str = "modes of the reduced structure";
        let eigen = symmetric_eigen(&scaled.mass).step(STEP, CHECK_INPUT)?;
        let falling: Vec<usize> = (0..eigen.values.len()).rev().collect();
        let mut vectors = eigen.vectors.select_columns(&falling);
        let mut nu = Vec::new();
        let mut motions = 0;
        for (mut vector, &i) in vectors.column_iter_mut().zip(&falling) {
            let mu = eigen.values[i];
            // omega^2 / (omega^2 + shift), which is 1 for DOFs without mass.
            let stiff = 1.0 - SHIFT * mu.max(0.0);
            let omega_squared = stiff / mu.max(f64::MIN_POSITIVE);
            if omega_squared < -RIGID_BODY {
                return Err(StructureError::Indefinite { omega_squared });
            }
            if omega_squared <= RIGID_BODY {
                vector.unscale_mut(mu.sqrt());
                motions += 1;
            } else {
                vector.unscale_mut(stiff.sqrt());
                nu.push(mu.max(0.0) / stiff);
            }
        }
        let shapes = multiply(&scaled.shapes, &vectors).step(STEP, CHECK_INPUT)?;
        let elastic = shapes.columns(motions, nu.len()).into_owned();
        let order: Vec<usize> = (motions..falling.len()).chain(0..motions).collect();
        let damping = scaled.damping.as_ref().map(|damping| {
            let vectors = vectors.select_columns(&order);
            multiply(damping, &vectors).and_then(|product| multiply_transposed(&vectors, &product))
        });
        Ok(Self {
            nu,
            elastic,
            rigid: shapes.columns(0, motions).into_owned(),
            damping: damping.transpose().step(STEP, CHECK_INPUT)?,
        })
    }

    /// Whether the structure can move without being strained.
    pub fn floats(&self) -> bool {
        self.rigid_motions() > 0
    }

    /// Number of rigid-body motions.
    pub fn rigid_motions(&self) -> usize {
        self.rigid.ncols()
    }

    /// Whether the structure brings its own damping.
    pub fn are_damped(&self) -> bool {
        self.damping.is_some()
    }

    /// The modes with bodies whose mass on the interface is `factor factor'` (n_b x 6 per body), those below `omega_limit`.
    ///
    /// # Errors
    /// No convergence.
    pub fn with_bodies(&self, factor: &DMatrix<f64>, omega_limit: f64) -> Result<LoadedModes, StructureError> {
        const STEP: &str = "modes with the attached bodies";
        let momentum = multiply_transposed(&self.rigid, factor).step(STEP, CHECK_INPUT)?;
        let coupling = multiply_transposed(factor, &self.elastic).step(STEP, CHECK_INPUT)?;
        let held = with_unit(multiply_transposed(&momentum, &momentum).step(STEP, CHECK_INPUT)?);
        let l = cholesky(held).step(STEP, CHECK_INPUT)?;
        let mut columns = coupling;
        solve_lower(&l, &mut columns).step(STEP, CHECK_INPUT)?;
        let UpdatedPairs { values, vectors, coupled } =
            updated_pairs(&self.nu, &columns.transpose(), omega_limit.powi(2).recip()).step(STEP, CHECK_INPUT)?;
        let mut q = coupled;
        solve_lower_transposed(&l, &mut q).step(STEP, CHECK_INPUT)?;
        let (motions, modes) = (self.rigid.ncols(), values.len());
        let mut elastic = DMatrix::zeros(self.nu.len(), motions + modes);
        elastic.columns_mut(motions, modes).copy_from(&vectors);
        let mut rigid = DMatrix::zeros(motions, motions + modes);
        if motions > 0 {
            let mass = with_unit(multiply(&momentum, &momentum.transpose()).step(STEP, CHECK_INPUT)?);
            let mut motion = DMatrix::identity(motions, motions);
            solve_lower_transposed(&cholesky(mass).step(STEP, CHECK_INPUT)?, &mut motion).step(STEP, CHECK_INPUT)?;
            rigid.columns_mut(0, motions).copy_from(&motion);
            rigid.columns_mut(motions, modes).copy_from(&-multiply(&momentum, &q).step(STEP, CHECK_INPUT)?);
        }
        let mut omega_rad_s = vec![0.0; motions];
        for (mode, nu) in values.iter().enumerate() {
            let omega = nu.sqrt().recip();
            omega_rad_s.push(if omega.powi(2) <= RIGID_BODY { 0.0 } else { omega });
            elastic.column_mut(motions + mode).scale_mut(omega);
            rigid.column_mut(motions + mode).scale_mut(omega);
        }
        Ok(LoadedModes { omega_rad_s, elastic, rigid })
    }

    /// `nu = 1/omega^2` of the own elastic modes in s2, falling.
    pub fn nu(&self) -> &[f64] {
        &self.nu
    }

    /// Highest circular frequency in rad/s of modes with mass. Bodies make no mode faster.
    pub fn most_rad_s(&self) -> f64 {
        self.nu.iter().rfind(|nu| **nu > 0.0).map_or(0.0, |nu| nu.sqrt().recip())
    }

    /// Shapes of the own elastic modes, scaled by stiffness, at some combinations of interface rows (combinations x modes).
    pub fn elastic_at(&self, rows: &[Vec<(usize, f64)>]) -> DMatrix<f64> {
        combined(&self.elastic, rows)
    }

    /// `sum phi phi'` over all modes with bodies of that mass factor, at some combinations of interface rows: `S (N + U U')^-1 S'`. With
    /// `N^-1/2 U = Q T` it is `Y Y' + Z (I + T T')^-1 Z'`, `Z = S N^-1/2 Q`, `Y = S N^-1/2 - Z Q'`. `None` if the structure floats or
    /// a mode has no mass.
    ///
    /// # Errors
    /// No convergence.
    pub fn mass_at(
        &self,
        rows: &[Vec<(usize, f64)>],
        factor: &DMatrix<f64>,
    ) -> Result<Option<DMatrix<f64>>, StructureError> {
        const STEP: &str = "mass of all modes";
        let coupling = multiply_transposed(&self.elastic, factor).step(STEP, CHECK_INPUT)?;
        let largest = self.nu.first().map_or(0.0, |nu| nu + coupling.norm_squared());
        if self.floats() || self.nu.last().is_none_or(|least| *least < LEAST_MASS * largest) {
            return Ok(None);
        }
        let light = |mut shapes: DMatrix<f64>| {
            shapes.column_iter_mut().zip(&self.nu).for_each(|(mut column, nu)| column.unscale_mut(nu.sqrt()));
            shapes
        };
        let (q, t) = light(coupling.transpose()).transpose().qr().unpack();
        let shapes = light(self.elastic_at(rows));
        let held = &shapes * &q;
        let free = shapes - &held * q.transpose();
        let l = cholesky(with_unit(&t * t.transpose())).step(STEP, CHECK_INPUT)?;
        let mut held = held.transpose();
        solve_lower(&l, &mut held).step(STEP, CHECK_INPUT)?;
        Ok(Some(&free * free.transpose() + held.tr_mul(&held)))
    }

    /// Shapes of modes at combinations of interface rows (combinations x modes), from the own modes' shapes there.
    ///
    /// # Errors
    /// None that a caller could bring about.
    pub fn shapes(&self, modes: &LoadedModes, rows: &[Vec<(usize, f64)>]) -> Result<DMatrix<f64>, StructureError> {
        const STEP: &str = "shapes of the modes";
        let elastic = multiply(&combined(&self.elastic, rows), &modes.elastic).step(STEP, CHECK_INPUT)?;
        let rigid = multiply(&combined(&self.rigid, rows), &modes.rigid).step(STEP, CHECK_INPUT)?;
        Ok(elastic + rigid)
    }

    /// Ratios of the structure's own damping, `2 xi omega = phi' D phi`; 0 for rigid-body motions. `None` without such.
    ///
    /// # Errors
    /// None that a caller could bring about.
    pub fn damping_ratios(&self, modes: &LoadedModes) -> Result<Option<Vec<f64>>, StructureError> {
        let Some(damping) = &self.damping else { return Ok(None) };
        let mut all = DMatrix::zeros(damping.nrows(), modes.omega_rad_s.len());
        all.rows_mut(0, self.nu.len()).copy_from(&modes.elastic);
        all.rows_mut(self.nu.len(), self.rigid.ncols()).copy_from(&modes.rigid);
        let product = multiply(damping, &all).step("damping of the modes", CHECK_INPUT)?;
        let rates = all.column_iter().zip(product.column_iter()).map(|(mode, force)| mode.dot(&force));
        let ratio = |(rate, &omega): (f64, &f64)| if omega > 0.0 { rate / (2.0 * omega) } else { 0.0 };
        Ok(Some(rates.zip(&modes.omega_rad_s).map(ratio).collect()))
    }

    /// The lowest frequency of the machine with bodies, in Hz; 0 if it floats.
    ///
    /// # Errors
    /// As for [`OwnModes::with_bodies`].
    pub fn lowest_hz(&self, factor: &DMatrix<f64>) -> Result<f64, StructureError> {
        let modes = self.with_bodies(factor, f64::INFINITY)?;
        Ok(modes.omega_rad_s.first().copied().unwrap_or(0.0) / TAU)
    }
}

/// Combinations of the rows of a matrix.
fn combined(own: &DMatrix<f64>, rows: &[Vec<(usize, f64)>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), own.ncols(), |row, mode| {
        rows[row].iter().map(|&(index, weight)| weight * own[(index, mode)]).sum()
    })
}

/// `I + A`.
fn with_unit(mut a: DMatrix<f64>) -> DMatrix<f64> {
    (0..a.nrows()).for_each(|k| a[(k, k)] += 1.0);
    a
}
