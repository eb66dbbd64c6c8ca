//! Modes of a scene.

use nalgebra::DMatrix;

/// A weighted set of points and the direction in which they are followed. It is used as given: a unit vector gives displacements in m and
/// takes forces in N.
pub type DirectedPoints = (Vec<(String, f64)>, [f64; 3]);

/// Mass-normalised modes of the machine with its housings at some points of it, in the order of rising frequency.
///
/// Per mode s: `x_s'' = -omega_s^2 x_s - 2 xi_s omega_s x_s' + sum_n phi_ns F_n`; a point moves by
/// `w_n = sum_s phi_ns x_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesAt {
    /// Circular frequencies omega_s in rad/s; 0 for rigid-body motions.
    pub omega_rad_s: Vec<f64>,
    /// Damping ratios xi_s.
    pub damping_ratio: Vec<f64>,
    /// `phi_n = d' R_n T Phi` (points x modes) in 1/sqrt(kg): the points' translations along their directions.
    pub rows: DMatrix<f64>,
    /// Modes that are only known together; `None`: all modes are there.
    pub rest: Option<TruncatedModes>,
}

/// Modes above an edge, known only by their sum for the rows; the last modes replace them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruncatedModes {
    /// The first mode that stands for them.
    pub first: usize,
    /// Circular frequency in rad/s above which they are.
    pub edge_rad_s: f64,
    /// Number of modes.
    pub count: usize,
}
