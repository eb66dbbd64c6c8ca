//! The reduced structure and its second eigenproblem.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::attached::{RigidMass, mass_factor};
use super::error::{Step, StructureError};
use super::modal_table::ModalTable;
use super::modes::{DirectedPoints, ModesAt};
use super::own::{CHECK_INPUT, OwnModes, SHIFT, ScaledMatrices};
use super::points::{Interface, InterfacePoint, InterfacePoints, PointPlace};
use super::selection::SelectionSettings;
use super::symmetric::congruence;
use super::truncated_modes::ReductionDemand;
use crate::parameter::Numbers;
use decore_math::linalg::{cholesky, multiply_transposed, solve_lower};

/// Modal damping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Damping {
    /// One ratio for all modes.
    Ratio(f64),
    /// One ratio per mode, in the order of the modes: at least as many as kept modes. Further ratios are ignored, because the number of
    /// modes below a cut-off changes with the placement.
    PerMode(Vec<f64>),
    /// Pairs of frequency in Hz and ratio, by rising frequency: linear between them, constant below the first and above the last.
    Table(Vec<[f64; 2]>),
    /// Rayleigh damping `D = mass_per_s M + stiffness_s K`: the ratio is `mass_per_s / (2 omega) + stiffness_s omega / 2`.
    Rayleigh {
        /// Factor of the mass in 1/s.
        mass_per_s: f64,
        /// Factor of the stiffness in s.
        stiffness_s: f64,
    },
}

impl Numbers for Damping {
    fn visit(&self, see: &mut dyn FnMut(f64)) {
        match self {
            Self::Ratio(ratio) => ratio.visit(see),
            Self::PerMode(ratios) => ratios.visit(see),
            Self::Table(pairs) => pairs.iter().for_each(|[_, ratio]| see(*ratio)),
            Self::Rayleigh { .. } => {}
        }
    }
}

impl Damping {
    /// Ratio of a mode by its number and its circular frequency in rad/s; `None` where a list per mode is too short.
    pub fn ratio(&self, mode: usize, omega_rad_s: f64) -> Option<f64> {
        match self {
            Self::Ratio(ratio) => Some(*ratio),
            Self::PerMode(ratios) => ratios.get(mode).copied(),
            Self::Table(pairs) => between(pairs, omega_rad_s / TAU),
            Self::Rayleigh { mass_per_s, stiffness_s } => {
                Some(0.5 * (mass_per_s / omega_rad_s + stiffness_s * omega_rad_s))
            }
        }
    }

    /// The fault of a list or a table; `None` for a sound one.
    pub fn fault(&self) -> Option<&'static str> {
        match self {
            Self::PerMode(list) if list.is_empty() => Some("is an empty list, expected one ratio per mode"),
            Self::Table(pairs) => {
                let rises = pairs.windows(2).all(|pair| pair[0][0] < pair[1][0]);
                let sound = pairs.iter().all(|[hertz, _]| hertz.is_finite() && *hertz >= 0.0);
                (!(rises && sound)).then_some("needs pairs [frequency_hz, ratio] by rising frequency")
            }
            Self::Rayleigh { mass_per_s, stiffness_s } => {
                let sound = [mass_per_s, stiffness_s].iter().all(|factor| factor.is_finite() && **factor >= 0.0);
                (!sound).then_some("needs `mass_per_s` and `stiffness_s` of at least 0")
            }
            Self::Ratio(_) | Self::PerMode(_) => None,
        }
    }
}

/// Linear interpolation in pairs by rising first number, constant outside.
fn between(pairs: &[[f64; 2]], at: f64) -> Option<f64> {
    let above = pairs.iter().position(|[x, _]| *x >= at);
    match above {
        Some(0) => pairs.first().map(|[_, y]| *y),
        Some(above) => {
            let ([x0, y0], [x1, y1]) = (pairs[above - 1], pairs[above]);
            Some(y0 + (y1 - y0) * (at - x0) / (x1 - x0))
        }
        None => pairs.last().map(|[_, y]| *y),
    }
}

/// Settings of [`ReducedStructure::modes_at`].
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
    interface: Interface,
    static_flexibility: Option<DMatrix<f64>>,
    own: OwnModes,
    table: Option<TableModes>,
    remarks: Vec<String>,
}

/// Reduced matrices and the transfer `u_b = B z` (n_b x n_z).
pub(super) struct ReducedMatrices {
    pub m_zz: DMatrix<f64>,
    pub k_zz: DMatrix<f64>,
    pub d_zz: Option<DMatrix<f64>>,
    pub transfer: DMatrix<f64>,
}

/// Modes of a modal table; they are returned unchanged if nothing is attached.
#[derive(Debug, Clone)]
struct TableModes {
    omega_rad_s: Vec<f64>,
    damping_ratio: Vec<f64>,
    shapes: DMatrix<f64>,
}

impl ReducedStructure {
    /// From reduced matrices.
    pub(super) fn new(matrices: ReducedMatrices, interface: Interface) -> Result<Self, StructureError> {
        let ReducedMatrices { m_zz, k_zz, d_zz, transfer } = matrices;
        let l = cholesky(&k_zz + &m_zz * SHIFT).step("factorisation of the reduced structure", CHECK_INPUT)?;
        let mut shapes = transfer.transpose();
        solve_lower(&l, &mut shapes).step("factorisation of the reduced structure", CHECK_INPUT)?;
        let own = OwnModes::new(&ScaledMatrices {
            mass: congruence(&l, m_zz.clone())?,
            shapes: shapes.transpose(),
            damping: d_zz.clone().map(|d_zz| congruence(&l, d_zz)).transpose()?,
        })?;
        let static_flexibility = if own.floats() { None } else { Some(flexibility(&k_zz, &transfer)?) };
        Ok(Self { m_zz, k_zz, d_zz, transfer, interface, static_flexibility, own, table: None, remarks: Vec::new() })
    }

    /// From a table of mass-normalised modes: `M_zz = I`, `K_zz = diag(omega^2)`, B the table's columns.
    ///
    /// # Errors
    /// A column for a point that `points` does not know, a table whose parts do not fit together.
    pub fn from_modal_table(table: &ModalTable, points: InterfacePoints) -> Result<Self, StructureError> {
        let table = &table.at_points(&points);
        table.validate()?;
        let is_unknown = |name: &str| table.dofs.iter().all(|dof| dof.point != name);
        let several = |point: &&InterfacePoint| matches!(point.place, PointPlace::Nodes(_)) && is_unknown(&point.name);
        if let Some(point) = points.iter().find(several) {
            let name = format!("interface point {}", point.name);
            let found = "several: a point that is the mean of nodes needs finite element matrices";
            return Err(StructureError::argument(name, "one node of the modal table", found));
        }
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
        structure.table = Some(TableModes {
            omega_rad_s: omega,
            damping_ratio: table.damping_ratio.clone(),
            shapes: table.shapes.clone(),
        });
        Ok(structure)
    }

    /// Number of rigid-body motions.
    pub(super) fn rigid_motions(&self) -> usize {
        self.own.rigid_motions()
    }

    /// Adds doubtful properties of the full model.
    pub(super) fn with_remarks(self, remarks: Vec<String>) -> Self {
        Self { remarks, ..self }
    }

    /// Doubtful properties of the full model, one sentence each: units, exchanged matrices.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Reduced mass `M_zz` (n_z x n_z).
    pub fn m_zz(&self) -> &DMatrix<f64> {
        &self.m_zz
    }

    /// Reduced stiffness `K_zz` (n_z x n_z).
    pub fn k_zz(&self) -> &DMatrix<f64> {
        &self.k_zz
    }

    /// Reduced damping `D_zz` (n_z x n_z), if the structure brings its own.
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
        self.own.are_damped()
    }

    /// Static flexibility of the interface DOFs, `B K_zz^-1 B'` in m/N (n_b x n_b); `None` for a structure that floats.
    pub fn static_flexibility(&self) -> Option<&DMatrix<f64>> {
        self.static_flexibility.as_ref()
    }

    /// The modes of the structure that carries `attached` rigid bodies, `K_zz phi = omega^2 M phi` with
    /// `M = M_zz + sum W' M_body W`, mass-normalised, those below the cut-off, in the order of rising frequency, at a scene's points.
    ///
    /// The sign of a mode is fixed: its largest entry at the points is positive. Modes below 0.01 Hz are rigid-body motions
    /// and get omega = 0. A modal table to which nothing is attached returns its own modes and damping unchanged (its
    /// frequencies may include the housings). Damping that the structure brings, `diag(2 xi omega)` of a table or a matrix D,
    /// becomes the diagonal of `Phi' D Phi`: couplings of modes by damping are left out.
    ///
    /// # Errors
    /// A mount that is unknown or lacks one of its six DOFs, arguments out of range, fewer damping ratios than modes, no
    /// mode below the cut-off; an unknown point, a direction that was not kept, is 0 or not finite.
    pub fn modes_at(
        &self,
        attached: &[RigidMass],
        options: &ModalOptions,
        rows: &[DirectedPoints],
    ) -> Result<ModesAt, StructureError> {
        let (solution, damping_ratio) = self.solve(attached, options, &self.combinations(rows)?)?;
        Ok(ModesAt { omega_rad_s: solution.omega_rad_s, damping_ratio, rows: solution.shapes, rest: None })
    }

    /// Modes from which [`ModesAt::select`] chooses at a scene's points with these settings: all, or those below a frequency above which
    /// only the sum of the others is needed.
    ///
    /// # Errors
    /// As for [`ReducedStructure::modes_at`].
    pub fn modes_to_select(
        &self,
        attached: &[RigidMass],
        damping: &Damping,
        rows: &[DirectedPoints],
        settings: SelectionSettings,
    ) -> Result<ModesAt, StructureError> {
        if let (Damping::Ratio(damping_ratio), None, false) = (damping, &self.table, self.own.are_damped()) {
            let damping_ratio = damping_ratios(damping, &[1.0])?.first().copied().unwrap_or(*damping_ratio);
            let factor = mass_factor(&self.interface, attached)?;
            let asked = ReductionDemand { rows: &self.combinations(rows)?, damping_ratio, settings };
            if let Some(edge) = asked.edge(&self.own)
                && let Some(modes) = asked.modes(&self.own, &factor, edge)?
            {
                return Ok(modes);
            }
        }
        // The selection starts from all modes of the basis.
        self.modes_at(attached, &ModalOptions { cutoff_hz: f64::MAX, damping: damping.clone() }, rows)
    }

    /// Points and directions as combinations of interface rows.
    fn combinations(&self, rows: &[DirectedPoints]) -> Result<Vec<Vec<(usize, f64)>>, StructureError> {
        rows.iter().map(|(points, direction)| self.interface.translation(points, *direction)).collect()
    }

    /// Modes over some combinations of interface rows, with their damping.
    fn solve(
        &self,
        attached: &[RigidMass],
        options: &ModalOptions,
        rows: &[Vec<(usize, f64)>],
    ) -> Result<(Solution, Vec<f64>), StructureError> {
        let cutoff_hz = options.cutoff_hz;
        if !(cutoff_hz.is_finite() && cutoff_hz > 0.0) {
            return Err(StructureError::argument("cutoff_hz", "a positive, finite frequency in Hz", cutoff_hz));
        }
        let solution = match &self.table {
            Some(table) if attached.is_empty() => table.below(cutoff_hz, rows)?,
            _ => self.loaded(attached, cutoff_hz, rows)?,
        };
        let damping_ratio = match &solution.damping_ratio {
            Some(own) => own.clone(),
            None => damping_ratios(&options.damping, &solution.omega_rad_s)?,
        };
        Ok((solution, damping_ratio))
    }

    fn loaded(
        &self,
        attached: &[RigidMass],
        cutoff_hz: f64,
        rows: &[Vec<(usize, f64)>],
    ) -> Result<Solution, StructureError> {
        let factor = mass_factor(&self.interface, attached)?;
        let modes = self.own.with_bodies(&factor, TAU * cutoff_hz)?;
        if modes.omega_rad_s.is_empty() {
            return Err(StructureError::NoModes { cutoff_hz, lowest_hz: self.own.lowest_hz(&factor)? });
        }
        let mut shapes = self.own.shapes(&modes, rows)?;
        fix_signs(&mut shapes);
        let damping_ratio = self.own.damping_ratios(&modes)?;
        Ok(Solution { omega_rad_s: modes.omega_rad_s, damping_ratio, shapes })
    }
}

/// Kept modes; the damping only where the structure brings it.
struct Solution {
    omega_rad_s: Vec<f64>,
    damping_ratio: Option<Vec<f64>>,
    shapes: DMatrix<f64>,
}

impl TableModes {
    fn below(&self, cutoff_hz: f64, rows: &[Vec<(usize, f64)>]) -> Result<Solution, StructureError> {
        let kept = self.omega_rad_s.iter().take_while(|omega| **omega < TAU * cutoff_hz).count();
        if kept == 0 {
            let lowest_hz = self.omega_rad_s.first().copied().unwrap_or(0.0) / TAU;
            return Err(StructureError::NoModes { cutoff_hz, lowest_hz });
        }
        Ok(Solution {
            omega_rad_s: self.omega_rad_s.iter().take(kept).copied().collect(),
            damping_ratio: Some(self.damping_ratio.iter().take(kept).copied().collect()),
            shapes: DMatrix::from_fn(rows.len(), kept, |row, mode| {
                rows[row].iter().map(|&(index, weight)| weight * self.shapes[(index, mode)]).sum()
            }),
        })
    }
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

pub(super) fn damping_ratios(damping: &Damping, omega_rad_s: &[f64]) -> Result<Vec<f64>, StructureError> {
    let modes = omega_rad_s.len();
    let ratio = |(mode, omega): (usize, &f64)| {
        let Some(ratio) = damping.ratio(mode, *omega) else {
            let expected = format!("one for each of the {modes} modes below the cut-off");
            return Err(StructureError::argument("damping ratios", expected, mode));
        };
        match damping {
            _ if !(ratio.is_finite() && ratio >= 0.0) => {
                Err(StructureError::argument("damping ratio", "a number >= 0", ratio))
            }
            Damping::Rayleigh { .. } if ratio >= 1.0 => {
                let found = format!("{ratio:.3} at {:.1} Hz", omega / TAU);
                Err(StructureError::argument("Rayleigh damping", "ratios below 1 of all modes", found))
            }
            _ => Ok(ratio),
        }
    };
    omega_rad_s.iter().enumerate().map(ratio).collect()
}
