//! The structure's modes as they are integrated: motion of the interface points, accelerations under forces on them.

use nalgebra::{DMatrix, DVector};

use crate::system::products::{Blocks, LANES, add_columns};

/// The structure's modes.
#[derive(Debug, Clone)]
pub(super) struct Modes {
    pub omega_squared: DVector<f64>,
    /// `2 xi omega` per mode.
    pub damping: DVector<f64>,
    /// Mode shapes at the interface points: modes x points of the structure.
    pub phi: DMatrix<f64>,
    /// The same, several points together.
    shapes: Blocks,
}

/// Motion of the interface points, accelerations without what forces on them cause at once.
pub(super) struct Motion<'a> {
    pub displacement: &'a mut [f64],
    pub velocity: &'a mut [f64],
    /// Of the first points only, as many as are asked for.
    pub acceleration: &'a mut [f64],
}

impl Modes {
    /// Modes of given `omega^2`, `2 xi omega` and shapes.
    pub fn new(omega_squared: DVector<f64>, damping: DVector<f64>, phi: DMatrix<f64>) -> Self {
        let shapes = Blocks::new(&phi);
        Self { omega_squared, damping, phi, shapes }
    }

    /// Value at interface point `n` of a field given by its modal coordinates.
    pub fn at(&self, n: usize, modal: &[f64]) -> f64 {
        self.phi.column(n).iter().zip(modal).map(|(phi, x)| phi * x).sum()
    }

    /// Writes the accelerations that modes have without forces, `-omega^2 x - 2 xi omega v`; returns the power dissipated, W.
    #[inline(always)]
    pub fn free_accelerations(&self, x: &[f64], v: &[f64], acceleration: &mut [f64]) -> f64 {
        let mut loss = 0.0;
        let constants = self.omega_squared.as_slice().iter().zip(self.damping.as_slice());
        for (((acceleration, (omega_squared, damping)), x), v) in acceleration.iter_mut().zip(constants).zip(x).zip(v) {
            let resistance = damping * v;
            *acceleration = -omega_squared * x - resistance;
            loss += resistance * v;
        }
        loss
    }

    /// Motion of all points from the modes' displacements, velocities and free accelerations.
    #[inline(always)]
    pub fn motion(&self, [x, v, free]: [&[f64]; 3], out: &mut Motion<'_>) {
        let (points, accelerated) = (self.phi.ncols(), out.acceleration.len());
        for (at, first) in (0..points).step_by(LANES).enumerate() {
            let range = first..points.min(first + LANES);
            let (displacement, velocity);
            if first < accelerated {
                let acceleration;
                [displacement, velocity, acceleration] = self.shapes.products(at, [x, v, free]);
                let range = first..range.end.min(accelerated);
                out.acceleration[range.clone()].copy_from_slice(&acceleration[..range.len()]);
            } else {
                [displacement, velocity] = self.shapes.products(at, [x, v]);
            }
            out.displacement[range.clone()].copy_from_slice(&displacement[..range.len()]);
            out.velocity[range.clone()].copy_from_slice(&velocity[..range.len()]);
        }
    }

    /// Adds to the modes' accelerations what forces on the interface points cause, `Phi F`.
    #[inline(always)]
    pub fn add_forces(&self, force: &[f64], acceleration: &mut [f64]) {
        add_columns(acceleration, self.phi.as_slice(), force);
    }
}

/// Guides tied rigidly to their mounts, the first interface points: `(I + sum m phi phi') a = a0` solved by a low-rank update,
/// in terms of forces: each guide takes from the force on its mount what moves it.
#[derive(Debug, Clone)]
pub(super) struct TiedGuides {
    /// Mass of each guide, kg.
    pub mass: Vec<f64>,
    /// `-(diag(1/m) + Phi_t' Phi_t)^-1`, `Phi_t` the shapes at the mounts.
    update: DMatrix<f64>,
    /// `Phi_t' Phi`: acceleration of each mount per force on each interface point.
    direct: DMatrix<f64>,
}

impl TiedGuides {
    /// Prepares the update for guides of mass `mass` on the first columns of `phi`; `None` for masses that are not positive.
    pub fn new(phi: &DMatrix<f64>, mass: Vec<f64>) -> Option<Self> {
        let columns = phi.columns(0, mass.len());
        let mut matrix = columns.tr_mul(&columns);
        for (at, mass) in mass.iter().enumerate() {
            matrix[(at, at)] += 1.0 / mass;
        }
        let update = -matrix.cholesky()?.inverse();
        Some(Self { mass, update, direct: columns.tr_mul(phi) })
    }

    /// Takes from the forces on the interface points what moves the guides; `own` are the accelerations of their mounts without
    /// any force, changed to those with the forces but without the guides.
    #[inline(always)]
    pub fn share(&self, force: &mut [f64], own: &mut [f64]) {
        let guides = self.mass.len();
        add_columns(&mut own[..guides], self.direct.as_slice(), force);
        add_columns(&mut force[..guides], self.update.as_slice(), &own[..guides]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sharing forces gives what the full matrix gives: `(I + sum m phi phi')^-1 (a + Phi F)`.
    #[test]
    fn analytic_low_rank_update() {
        let phi = DMatrix::from_fn(5, 4, |i, j| ((3 * i + 7 * j) as f64 * 0.37).sin());
        let mass = vec![1.0, 0.3, 40.0];
        let mut full = DMatrix::identity(5, 5);
        for (mount, mass) in mass.iter().enumerate() {
            full += *mass * phi.column(mount) * phi.column(mount).transpose();
        }
        let free = DVector::from_fn(5, |i, _| 1.0 - 0.7 * i as f64);
        let mut force = DVector::from_fn(4, |i, _| 3.0 - i as f64);
        let expected = full.lu().solve(&(&free + &phi * &force)).unwrap();
        let tied = TiedGuides::new(&phi, mass).unwrap();
        tied.share(force.as_mut_slice(), phi.tr_mul(&free).as_mut_slice());
        assert!((free + phi * force - expected).amax() < 1e-13);
        // A mount that no mode moves is still positive definite; a negative mass is not.
        assert!(TiedGuides::new(&DMatrix::zeros(2, 1), vec![1.0]).is_some());
        assert!(TiedGuides::new(&DMatrix::zeros(2, 1), vec![-1.0]).is_none());
    }

    /// Motion of the points and accelerations of the modes are the sums over modes that they stand for.
    #[test]
    fn analytic_motion_and_accelerations() {
        let (count, points, accelerated) = (7, 6, 5);
        let wave = |seed: f64| DVector::from_fn(count, |s, _| (seed * (s + 1) as f64).sin());
        let (omega_squared, damping) = (wave(0.3).abs() * 1e4, wave(0.7).abs());
        let phi = DMatrix::from_fn(count, points, |s, n| (0.9 * (s + 5 * n) as f64).cos());
        let modes = Modes::new(omega_squared.clone(), damping.clone(), phi.clone());
        let (x, v) = (wave(1.1), wave(1.3));
        let mut free = vec![0.0; count];
        let loss = modes.free_accelerations(x.as_slice(), v.as_slice(), &mut free);
        let expected = -omega_squared.component_mul(&x) - damping.component_mul(&v);
        assert!((DVector::from_row_slice(&free) - &expected).amax() < 1e-10);
        assert!((loss - damping.component_mul(&v).dot(&v)).abs() < 1e-13);

        let mut found = vec![vec![f64::NAN; points]; 3];
        let [displacement, velocity, acceleration] = &mut found[..] else { unreachable!() };
        let mut motion = Motion { displacement, velocity, acceleration: &mut acceleration[..accelerated] };
        modes.motion([x.as_slice(), v.as_slice(), &free], &mut motion);
        for (found, (modal, count)) in found.iter().zip([(&x, points), (&v, points), (&expected, accelerated)]) {
            for (n, found) in found.iter().enumerate().take(count) {
                let expected = phi.column(n).dot(modal);
                assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()));
                assert!((modes.at(n, modal.as_slice()) - expected).abs() < 1e-12 * (1.0 + expected.abs()));
            }
        }
    }
}
