//! The matrices of a model.

use sprs::CsMat;

use super::label::DofLabel;

/// Matrices of a model, with both triangles, and the known labels of their rows.
#[derive(Debug, Clone)]
pub struct ModelMatrices {
    /// Mass, positive semidefinite.
    pub mass: CsMat<f64>,
    /// Stiffness, positive semidefinite.
    pub stiffness: CsMat<f64>,
    /// Viscous damping, if the model has one.
    pub damping: Option<CsMat<f64>>,
    /// One label per row; empty if the rows have none.
    pub labels: Vec<DofLabel>,
}
