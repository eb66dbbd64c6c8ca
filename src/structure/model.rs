//! A finite element model: mass, stiffness and the points that other parts act on.

use std::path::Path;

use sprs::CsMat;

use super::error::StructureError;
use super::matrix_market::{asymmetric_pair, parse_matrix_market, read_matrix_market};
use super::points::InterfacePoints;
use crate::linalg::{LinalgError, SparseCholesky};

/// Finite element matrices of a machine with its interface points.
///
/// `M u'' + K u = F` in SI units; both matrices are symmetric and hold both triangles. M is positive definite, K may be
/// singular. A value of this type has passed [`FeModel::new`].
#[derive(Debug, Clone)]
pub struct FeModel {
    mass: CsMat<f64>,
    stiffness: CsMat<f64>,
    points: InterfacePoints,
}

/// The names that errors use for the three sources.
struct Sources<'a> {
    mass: &'a str,
    stiffness: &'a str,
    points: &'a str,
}

impl FeModel {
    /// The hammer station that comes with the program: 546 DOF, 2176 kg without hammers, see `studies/station`.
    ///
    /// # Errors
    /// None with the data as shipped.
    pub fn station() -> Result<Self, StructureError> {
        const MASS: &[u8] = include_bytes!("../../studies/station/M_bare.mtx.gz");
        const STIFFNESS: &[u8] = include_bytes!("../../studies/station/K.mtx.gz");
        const POINTS: &str = include_str!("../../studies/station/interface_points.csv");
        let names = Sources {
            mass: "station/M_bare.mtx.gz",
            stiffness: "station/K.mtx.gz",
            points: "station/interface_points.csv",
        };
        Self {
            mass: parse_matrix_market(names.mass, MASS)?,
            stiffness: parse_matrix_market(names.stiffness, STIFFNESS)?,
            points: InterfacePoints::parse(names.points, POINTS)?,
        }
        .validated(&names)
    }

    /// Reads mass and stiffness (Matrix Market) and the table of interface points (CSV with `first_row_0based`).
    ///
    /// # Errors
    /// As for [`read_matrix_market`], [`InterfacePoints::read`] and [`FeModel::new`], with the file's name.
    pub fn read(mass: &Path, stiffness: &Path, points: &Path) -> Result<Self, StructureError> {
        let names = [mass, stiffness, points].map(|path| path.display().to_string());
        let [mass_name, stiffness_name, points_name] = &names;
        Self {
            mass: read_matrix_market(mass)?,
            stiffness: read_matrix_market(stiffness)?,
            points: InterfacePoints::read(points)?,
        }
        .validated(&Sources { mass: mass_name, stiffness: stiffness_name, points: points_name })
    }

    /// A model from matrices in memory, both triangles stored.
    ///
    /// # Errors
    /// Sizes that differ, a matrix that is not square, not symmetric or not finite, a mass matrix that is not positive
    /// definite, a negative diagonal of the stiffness, a point whose six rows lie outside the matrices.
    pub fn new(mass: CsMat<f64>, stiffness: CsMat<f64>, points: InterfacePoints) -> Result<Self, StructureError> {
        Self { mass, stiffness, points }.validated(&Sources { mass: "mass", stiffness: "stiffness", points: "points" })
    }

    fn validated(self, names: &Sources) -> Result<Self, StructureError> {
        let fault = |file: &str, reason: String| StructureError::Matrix { file: file.to_owned(), reason };
        require_symmetric(names.mass, &self.mass)?;
        require_symmetric(names.stiffness, &self.stiffness)?;
        let (order, rows) = (self.mass.rows(), self.stiffness.rows());
        if order != rows {
            let reason = format!("{order} rows, but the stiffness {} has {rows}: both must be equal", names.stiffness);
            return Err(fault(names.mass, reason));
        }
        for row in 0..order {
            let at = |matrix: &CsMat<f64>| matrix.get(row, row).copied().unwrap_or(0.0);
            if at(&self.mass) <= 0.0 {
                let reason = format!("diagonal {} is {:e}: every mass must be positive", row + 1, at(&self.mass));
                return Err(fault(names.mass, reason));
            }
            if at(&self.stiffness) < 0.0 {
                let reason = format!("diagonal {} is {:e}: a stiffness is not negative", row + 1, at(&self.stiffness));
                return Err(fault(names.stiffness, reason));
            }
        }
        SparseCholesky::new(&self.mass).map_err(|error| match error {
            LinalgError::NotPositiveDefinite { .. } => {
                fault(names.mass, "the mass matrix is not positive definite".to_owned())
            }
            other => fault(names.mass, other.to_string()),
        })?;
        for point in self.points.iter() {
            let name = &point.name;
            match point.first_row {
                None => {
                    let reason =
                        format!("column first_row_0based is missing: point {name} has no place in the matrices");
                    return Err(fault(names.points, reason));
                }
                Some(row) if row.saturating_add(6) > order => {
                    let reason =
                        format!("point {name}: rows {row} to {} exceed the matrices' {order}", row.saturating_add(5));
                    return Err(fault(names.points, reason));
                }
                Some(_) => {}
            }
        }
        Ok(self)
    }

    /// The mass matrix, both triangles.
    pub fn mass(&self) -> &CsMat<f64> {
        &self.mass
    }

    /// The stiffness matrix, both triangles.
    pub fn stiffness(&self) -> &CsMat<f64> {
        &self.stiffness
    }

    /// The interface points.
    pub fn points(&self) -> &InterfacePoints {
        &self.points
    }

    /// Number of degrees of freedom.
    pub fn order(&self) -> usize {
        self.mass.rows()
    }
}

fn require_symmetric(file: &str, matrix: &CsMat<f64>) -> Result<(), StructureError> {
    let fault = |reason: String| Err(StructureError::Matrix { file: file.to_owned(), reason });
    if matrix.rows() != matrix.cols() {
        return fault(format!("not square: {} rows, {} columns", matrix.rows(), matrix.cols()));
    }
    if matrix.data().iter().any(|value| !value.is_finite()) {
        return fault("an entry is not finite".to_owned());
    }
    if let Some((row, column)) = asymmetric_pair(matrix) {
        return fault(format!("not symmetric: entries ({0}, {1}) and ({1}, {0}) differ", row + 1, column + 1));
    }
    Ok(())
}
