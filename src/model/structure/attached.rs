//! Rigid bodies attached to interface points.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Matrix3, Matrix6, Rotation3, Vector3};

use super::error::StructureError;
use super::points::{Interface, require_weights};
use crate::direction::{DOWN, unit};

/// A rigid body on a mount: a hammer's housing.
///
/// The mount is a weighted set of interface points (one point, or the two neighbours of a position on a rail); the body
/// follows their weighted mean in all six DOFs.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidMass {
    /// Interface points and weights; the weights of an interpolation sum to 1.
    pub points: Vec<(String, f64)>,
    /// Mass m in kg, positive.
    pub mass_kg: f64,
    /// Moments of inertia about the centre of mass, x, y, z, in kg m2; zero or positive.
    pub inertia_kg_m2: [f64; 3],
    /// Centre of mass relative to the mount, x, y, z, in m.
    pub centre_of_mass_m: [f64; 3],
    /// Direction in world axes of the body's -z: its axes are the world's, turned by the shortest way. Straight down for a body that
    /// hangs as it is described.
    pub axis: [f64; 3],
}

/// The rotation that takes -z to a direction by the shortest way; about x for straight up. `None` for straight down.
fn turn(axis: [f64; 3]) -> Option<Rotation3<f64>> {
    let (down, to) = (Vector3::from(DOWN), Vector3::from(unit(axis)));
    (to != down).then(|| {
        Rotation3::rotation_between(&down, &to).unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI))
    })
}

impl RigidMass {
    fn validate(&self) -> Result<(), StructureError> {
        if !(self.mass_kg.is_finite() && self.mass_kg > 0.0) {
            return Err(StructureError::argument("attached mass", "a positive mass in kg", self.mass_kg));
        }
        if self.inertia_kg_m2.iter().any(|value| !value.is_finite() || *value < 0.0) {
            let found = format!("{:?}", self.inertia_kg_m2);
            return Err(StructureError::argument("attached inertia", "three moments >= 0 in kg m2", found));
        }
        if self.centre_of_mass_m.iter().any(|value| !value.is_finite()) {
            let found = format!("{:?}", self.centre_of_mass_m);
            return Err(StructureError::argument("attached centre of mass", "finite coordinates in m", found));
        }
        require_weights(&self.points)
    }

    /// A factor B (6 x 6) with `B B' = [m I, -m S; m S, J - m S S]`, S the cross-product matrix of the offset r.
    ///
    /// The centre of mass moves by `u + theta x r = u - S theta`, so `B' = diag(sqrt m, sqrt J) [I, -S; 0, I]`.
    pub(super) fn factor(&self) -> Matrix6<f64> {
        let s = Vector3::from(self.centre_of_mass_m).cross_matrix();
        let mut b = Matrix6::zeros();
        b.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
        b.fixed_view_mut::<3, 3>(3, 0).copy_from(&s);
        b.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::identity());
        for axis in 0..3 {
            b.column_mut(axis).scale_mut(self.mass_kg.sqrt());
            b.column_mut(3 + axis).scale_mut(self.inertia_kg_m2[axis].sqrt());
        }
        if let Some(turn) = turn(self.axis) {
            for first in [0, 3] {
                let turned = turn.matrix() * b.fixed_view::<3, 6>(first, 0);
                b.fixed_view_mut::<3, 6>(first, 0).copy_from(&turned);
            }
        }
        b
    }
}

/// The factor `W' B` over the interface rows of all bodies side by side (n_b x 6 per body), so that their mass on the
/// interface is `(W' B)(W' B)'`.
pub(super) fn mass_factor(interface: &Interface, bodies: &[RigidMass]) -> Result<DMatrix<f64>, StructureError> {
    let mut factor = DMatrix::zeros(interface.len(), 6 * bodies.len());
    for (body, first) in bodies.iter().zip((0..).step_by(6)) {
        body.validate()?;
        let b = body.factor();
        for (point, weight) in &body.points {
            for dof in 0..6 {
                let row = interface.row_of(point, dof)?;
                for column in 0..6 {
                    factor[(row, first + column)] += weight * b[(dof, column)];
                }
            }
        }
    }
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that hangs along x has its centre there, and its moments about the axes that went with it.
    #[test]
    fn a_turned_body_turns_its_centre_and_its_moments() {
        let body = RigidMass {
            points: vec![("R5".to_owned(), 1.0)],
            mass_kg: 2.0,
            inertia_kg_m2: [0.5, 0.4, 0.1],
            centre_of_mass_m: [0.0, 0.0, -0.2],
            axis: [1.0, 0.0, 0.0],
        };
        let mass = body.factor() * body.factor().transpose();
        let expected = [0.1, 0.4 + 2.0 * 0.04, 0.5 + 2.0 * 0.04];
        for (about, moment) in expected.into_iter().enumerate() {
            assert!((mass[(3 + about, 3 + about)] - moment).abs() < 1e-15, "{about}: {mass}");
        }
        // A push along z at the mount turns it about y: the centre is 0.2 m ahead.
        assert!((mass[(2, 4)] + 2.0 * 0.2).abs() < 1e-15, "{mass}");
    }

    #[test]
    fn factor_squares_to_the_rigid_mass_matrix() {
        let body = RigidMass {
            points: vec![("R5".to_owned(), 1.0)],
            mass_kg: 27.0,
            inertia_kg_m2: [0.55, 0.5, 0.12],
            centre_of_mass_m: [0.03, -0.05, -0.2],
            axis: DOWN,
        };
        let s = Vector3::from(body.centre_of_mass_m).cross_matrix();
        let mut expected = Matrix6::zeros();
        expected.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * 27.0));
        expected.fixed_view_mut::<3, 3>(0, 3).copy_from(&(s * -27.0));
        expected.fixed_view_mut::<3, 3>(3, 0).copy_from(&(s * 27.0));
        let inertia = Matrix3::from_diagonal(&Vector3::from(body.inertia_kg_m2));
        expected.fixed_view_mut::<3, 3>(3, 3).copy_from(&(inertia - s * s * 27.0));
        let b = body.factor();
        assert!((b * b.transpose() - expected).amax() < 1e-13);
    }
}
