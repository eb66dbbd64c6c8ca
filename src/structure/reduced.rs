//! The reduced structure and its second eigenproblem.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::attached::{RigidMass, mass_factor};
use super::error::{Step, StructureError};
use super::modal_table::ModalTable;
use super::modes::StructureModes;
use super::points::{Interface, InterfacePoints};
use super::symmetric::congruence;
use crate::linalg::{cholesky, multiply, multiply_transposed, solve_lower, symmetric_eigen, symmetric_eigenvalues};
use crate::parameter::Numbers;

/// Spectral shift in 1/s2, (2 pi 1 Hz)^2: makes `K_zz + shift M_zz` positive definite for machines that float. The result does
/// not depend on it beyond rounding.
const SHIFT: f64 = TAU * TAU;

/// A mode below this frequency in Hz counts as a rigid-body motion and gets omega = 0: rounding in the matrices does not
/// let a frequency be told from zero.
pub(super) const RIGID_BODY_HZ: f64 = 0.01;

const CHECK_INPUT: &str = "check signs and units of mass and stiffness";

/// Modal damping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Damping {
    /// One ratio for all modes.
    Ratio(f64),
    /// One ratio per mode, in the order of the modes; at least as many as modes are kept, the rest is not used (the number of
    /// modes below a cut-off changes with the placement).
    PerMode(Vec<f64>),
}

impl Numbers for Damping {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        match self {
            Self::Ratio(ratio) => ratio.visit(see),
            Self::PerMode(ratios) => ratios.visit(see),
        }
    }
}

/// What [`ReducedStructure::modes`] keeps.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalOptions {
    /// Modes below this frequency are kept, in Hz.
    pub cutoff_hz: f64,
    /// Damping of the kept modes. A structure with damping of its own (modal table, damping matrix) uses that instead.
    pub damping: Damping,
}

/// Mass and stiffness of the machine over few coordinates z, with access to the interface DOFs: `u_b = B z`.
///
/// Immutable and cheap to share between threads; made once per study by [`super::reduce`] or
/// [`ReducedStructure::from_modal_table`].
#[derive(Debug, Clone)]
pub struct ReducedStructure {
    m_zz: DMatrix<f64>,
    k_zz: DMatrix<f64>,
    d_zz: Option<DMatrix<f64>>,
    transfer: DMatrix<f64>,
    interface: Arc<Interface>,
    static_flexibility: Option<Arc<DMatrix<f64>>>,
    /// `C = L^-1 M_zz L^-T` with `L L' = K_zz + shift M_zz`.
    c: DMatrix<f64>,
    /// `P = B L^-T`, interface rows over the coordinates of C.
    p: DMatrix<f64>,
    /// `L^-1 D_zz L^-T`, for a structure with damping of its own.
    d: Option<DMatrix<f64>>,
    own: Option<OwnModes>,
}

/// Reduced matrices and the transfer `u_b = B z` (n_b x n_z).
pub(super) struct ReducedMatrices {
    pub m_zz: DMatrix<f64>,
    pub k_zz: DMatrix<f64>,
    pub d_zz: Option<DMatrix<f64>>,
    pub transfer: DMatrix<f64>,
}

/// What a modal table brings: modes that are returned as they are when nothing is attached.
#[derive(Debug, Clone)]
struct OwnModes {
    omega_rad_s: Vec<f64>,
    damping_ratio: Vec<f64>,
    shapes: DMatrix<f64>,
}

impl ReducedStructure {
    /// From reduced matrices.
    pub(super) fn new(matrices: ReducedMatrices, interface: Interface) -> Result<Self, StructureError> {
        let ReducedMatrices { m_zz, k_zz, d_zz, transfer } = matrices;
        let l = cholesky(&k_zz + &m_zz * SHIFT).step("factorisation of the reduced structure", CHECK_INPUT)?;
        let c = congruence(&l, m_zz.clone())?;
        let d = d_zz.clone().map(|d_zz| congruence(&l, d_zz)).transpose()?;
        let mut p = transfer.transpose();
        solve_lower(&l, &mut p).step("factorisation of the reduced structure", CHECK_INPUT)?;
        let largest = symmetric_eigenvalues(&c)
            .step("eigenvalues of the reduced structure", CHECK_INPUT)?
            .last()
            .copied()
            .unwrap_or(0.0);
        let static_flexibility =
            if omega_of(largest)? > 0.0 { Some(Arc::new(flexibility(&k_zz, &transfer)?)) } else { None };
        let interface = Arc::new(interface);
        Ok(Self { m_zz, k_zz, d_zz, transfer, interface, static_flexibility, c, p: p.transpose(), d, own: None })
    }

    /// From a table of mass-normalised modes: `M_zz = I`, `K_zz = diag(omega^2)`, B the table's columns.
    ///
    /// # Errors
    /// A column for a point that `points` does not know, a table whose parts do not fit together.
    pub fn from_modal_table(table: &ModalTable, points: InterfacePoints) -> Result<Self, StructureError> {
        table.validate()?;
        for dof in &table.dofs {
            points.get(&dof.point)?;
        }
        let order = table.frequency_hz.len();
        let omega: Vec<f64> = table.frequency_hz.iter().map(|hz| TAU * hz).collect();
        let k_zz = DMatrix::from_diagonal(&DVector::from_iterator(order, omega.iter().map(|value| value * value)));
        let rows: Vec<_> = table.dofs.iter().cloned().zip(0..).collect();
        let interface = Interface::new(points, &rows);
        let rates = omega.iter().zip(&table.damping_ratio).map(|(omega, ratio)| 2.0 * ratio * omega);
        let d_zz = Some(DMatrix::from_diagonal(&DVector::from_iterator(order, rates)));
        let m_zz = DMatrix::identity(order, order);
        let mut structure = Self::new(ReducedMatrices { m_zz, k_zz, d_zz, transfer: table.shapes.clone() }, interface)?;
        structure.own = Some(OwnModes {
            omega_rad_s: omega,
            damping_ratio: table.damping_ratio.clone(),
            shapes: table.shapes.clone(),
        });
        Ok(structure)
    }

    /// Reduced mass `M_zz` (n_z x n_z).
    pub fn m_zz(&self) -> &DMatrix<f64> {
        &self.m_zz
    }

    /// Reduced stiffness `K_zz` (n_z x n_z).
    pub fn k_zz(&self) -> &DMatrix<f64> {
        &self.k_zz
    }

    /// Reduced damping `D_zz` (n_z x n_z), where the structure brings its own.
    pub fn d_zz(&self) -> Option<&DMatrix<f64>> {
        self.d_zz.as_ref()
    }

    /// The transfer B of `u_b = B z` (n_b x n_z).
    pub fn transfer(&self) -> &DMatrix<f64> {
        &self.transfer
    }

    /// The interface DOFs and the points' coordinates.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Whether the structure brings its own damping (modal table, damping matrix), so that [`ModalOptions::damping`] is not
    /// used.
    pub fn has_own_damping(&self) -> bool {
        self.d.is_some()
    }

    /// Static flexibility of the interface DOFs, `B K_zz^-1 B'` in m/N (n_b x n_b); `None` for a structure that floats.
    pub fn static_flexibility(&self) -> Option<&DMatrix<f64>> {
        self.static_flexibility.as_deref()
    }

    /// The modes of the structure that carries `attached` rigid bodies, `K_zz phi = omega^2 M phi` with
    /// `M = M_zz + sum W' M_body W`, mass-normalised, those below the cut-off, in the order of rising frequency.
    ///
    /// The sign of a mode is fixed: its largest interface entry is positive. Modes below 0.01 Hz are rigid-body motions
    /// and get omega = 0. A modal table to which nothing is attached returns its own modes and damping unchanged (its
    /// frequencies may include the housings). Damping that the structure brings, `diag(2 xi omega)` of a table or a matrix D,
    /// becomes the diagonal of `Phi' D Phi`: couplings of modes by damping are left out.
    ///
    /// # Errors
    /// A mount that is unknown or lacks one of its six DOFs, arguments out of range, fewer damping ratios than modes, no
    /// mode below the cut-off.
    pub fn modes(&self, attached: &[RigidMass], options: &ModalOptions) -> Result<StructureModes, StructureError> {
        let cutoff_hz = options.cutoff_hz;
        if !(cutoff_hz.is_finite() && cutoff_hz > 0.0) {
            return Err(StructureError::argument("cutoff_hz", "a positive, finite frequency in Hz", cutoff_hz));
        }
        let solution = match &self.own {
            Some(own) if attached.is_empty() => own.below(cutoff_hz)?,
            _ => self.solve(attached, cutoff_hz)?,
        };
        let damping_ratio = match solution.damping_ratio {
            Some(own) => own,
            None => damping_ratios(&options.damping, solution.omega_rad_s.len())?,
        };
        Ok(StructureModes {
            omega_rad_s: solution.omega_rad_s,
            damping_ratio,
            shapes: solution.shapes,
            interface: Arc::clone(&self.interface),
            static_flexibility: self.static_flexibility.clone(),
        })
    }

    /// Solves with `A = G (C + U U') G`, `A y = mu y`, `omega^2 = 1/mu - shift`.
    ///
    /// U carries the bodies' mass into the coordinates of C. The shift acts on the bodies too:
    /// `L^-1 (K + shift M) L^-T = I + shift U U'`, and G is the inverse square root of that.
    fn solve(&self, attached: &[RigidMass], cutoff_hz: f64) -> Result<Solution, StructureError> {
        const STEP: &str = "second eigenproblem";
        let factor = mass_factor(&self.interface, attached)?;
        let u = multiply_transposed(&self.p, &factor).step(STEP, CHECK_INPUT)?;
        let g = InverseRoot::new(&u)?;
        let mut a = &self.c + multiply(&u, &u.transpose()).step(STEP, CHECK_INPUT)?;
        g.apply(&mut a)?;
        a.transpose_mut();
        g.apply(&mut a)?;
        let eigen = symmetric_eigen(&a).step(STEP, CHECK_INPUT)?;
        let least = ((TAU * cutoff_hz).powi(2) + SHIFT).recip();
        let kept: Vec<usize> = (0..eigen.values.len()).rev().take_while(|&i| eigen.values[i] > least).collect();
        if kept.is_empty() {
            let lowest = eigen.values.last().copied().map_or(Ok(0.0), omega_of)?;
            return Err(StructureError::NoModes { cutoff_hz, lowest_hz: lowest / TAU });
        }
        let mut y = eigen.vectors.select_columns(&kept);
        for (mut column, &i) in y.column_iter_mut().zip(&kept) {
            column.unscale_mut(eigen.values[i].sqrt());
        }
        g.apply(&mut y)?;
        let omega_rad_s = kept.iter().map(|&i| omega_of(eigen.values[i])).collect::<Result<Vec<_>, _>>()?;
        let mut shapes = multiply(&self.p, &y).step(STEP, CHECK_INPUT)?;
        fix_signs(&mut shapes);
        let damping_ratio = self.d.as_ref().map(|d| projected_damping(d, &y, &omega_rad_s)).transpose()?;
        Ok(Solution { omega_rad_s, damping_ratio, shapes })
    }
}

/// Kept modes; the damping only where the structure brings it.
struct Solution {
    omega_rad_s: Vec<f64>,
    damping_ratio: Option<Vec<f64>>,
    shapes: DMatrix<f64>,
}

impl OwnModes {
    fn below(&self, cutoff_hz: f64) -> Result<Solution, StructureError> {
        let kept = self.omega_rad_s.iter().take_while(|omega| **omega < TAU * cutoff_hz).count();
        if kept == 0 {
            let lowest_hz = self.omega_rad_s.first().copied().unwrap_or(0.0) / TAU;
            return Err(StructureError::NoModes { cutoff_hz, lowest_hz });
        }
        Ok(Solution {
            omega_rad_s: self.omega_rad_s.iter().take(kept).copied().collect(),
            damping_ratio: Some(self.damping_ratio.iter().take(kept).copied().collect()),
            shapes: self.shapes.columns(0, kept).into_owned(),
        })
    }
}

/// Ratios of modes `phi = L^-T y`: `2 xi_s omega_s = y_s' (L^-1 D L^-T) y_s`; 0 for rigid-body motions.
fn projected_damping(d: &DMatrix<f64>, y: &DMatrix<f64>, omega_rad_s: &[f64]) -> Result<Vec<f64>, StructureError> {
    let product = multiply(d, y).step("damping of the modes", CHECK_INPUT)?;
    let rates = y.column_iter().zip(product.column_iter()).map(|(y, dy)| y.dot(&dy));
    Ok(rates.zip(omega_rad_s).map(|(rate, &omega)| if omega > 0.0 { rate / (2.0 * omega) } else { 0.0 }).collect())
}

/// `(I + shift U U')^-1/2 = I + V diag(f(lambda)) V'` with `U'U = Q diag(lambda) Q'`, `V = U Q` and
/// `f(lambda) = -shift / (r (1 + r))`, `r = sqrt(1 + shift lambda)`.
struct InverseRoot {
    v: DMatrix<f64>,
    scaled: DMatrix<f64>,
}

impl InverseRoot {
    fn new(u: &DMatrix<f64>) -> Result<Self, StructureError> {
        const STEP: &str = "mass of the attached bodies";
        let eigen = multiply_transposed(u, u).and_then(|gram| symmetric_eigen(&gram)).step(STEP, CHECK_INPUT)?;
        let v = multiply(u, &eigen.vectors).step(STEP, CHECK_INPUT)?;
        let mut scaled = v.clone();
        for (mut column, lambda) in scaled.column_iter_mut().zip(&eigen.values) {
            let r = (1.0 + SHIFT * lambda.max(0.0)).sqrt();
            column.scale_mut(-SHIFT / (r * (1.0 + r)));
        }
        Ok(Self { v, scaled })
    }

    /// Multiplies from the left, in place.
    fn apply(&self, x: &mut DMatrix<f64>) -> Result<(), StructureError> {
        let correction = multiply_transposed(&self.v, x).and_then(|small| multiply(&self.scaled, &small));
        *x += correction.step("mass of the attached bodies", CHECK_INPUT)?;
        Ok(())
    }
}

/// Circular frequency of an eigenvalue `mu = 1/(omega^2 + shift)`; 0 for rigid-body motions, infinite without mass.
fn omega_of(mu: f64) -> Result<f64, StructureError> {
    if mu <= 0.0 {
        return Ok(f64::INFINITY);
    }
    let omega_squared = mu.recip() - SHIFT;
    let limit = (TAU * RIGID_BODY_HZ).powi(2);
    if omega_squared < -limit {
        return Err(StructureError::Indefinite { omega_squared });
    }
    Ok(if omega_squared.abs() <= limit { 0.0 } else { omega_squared.sqrt() })
}

/// `B K^-1 B'`.
fn flexibility(k_zz: &DMatrix<f64>, transfer: &DMatrix<f64>) -> Result<DMatrix<f64>, StructureError> {
    const STEP: &str = "static flexibility of the interface";
    let mut half = transfer.transpose();
    let l = cholesky(k_zz.clone()).step(STEP, CHECK_INPUT)?;
    solve_lower(&l, &mut half).step(STEP, CHECK_INPUT)?;
    multiply_transposed(&half, &half).step(STEP, CHECK_INPUT)
}

/// Makes the largest entry of every column positive; of entries equal to 1e-6 the first decides.
fn fix_signs(shapes: &mut DMatrix<f64>) {
    for mut column in shapes.column_iter_mut() {
        let limit = (1.0 - 1e-6) * column.amax();
        if column.iter().find(|value| value.abs() >= limit).is_some_and(|value| *value < 0.0) {
            column.neg_mut();
        }
    }
}

fn damping_ratios(damping: &Damping, modes: usize) -> Result<Vec<f64>, StructureError> {
    let valid = |ratio: &f64| ratio.is_finite() && *ratio >= 0.0;
    match damping {
        Damping::Ratio(ratio) if valid(ratio) => Ok(vec![*ratio; modes]),
        Damping::Ratio(ratio) => Err(StructureError::argument("damping ratio", "a number >= 0", ratio)),
        Damping::PerMode(ratios) => {
            if ratios.len() < modes {
                let expected = format!("one for each of the {modes} modes below the cut-off");
                return Err(StructureError::argument("damping ratios", expected, ratios.len()));
            }
            match ratios.iter().find(|ratio| !valid(ratio)) {
                Some(ratio) => Err(StructureError::argument("damping ratio", "a number >= 0", ratio)),
                None => Ok(ratios.iter().take(modes).copied().collect()),
            }
        }
    }
}
