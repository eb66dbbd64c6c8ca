//! Modes of a flexible part as they are integrated: motion of its points, accelerations under forces on them; masses tied to points.

use nalgebra::{DMatrix, DVector};

use crate::system::products::{Blocks, LANES, add_columns, put_all};
use decore_math::number::Number;

/// Modes of a flexible part.
#[derive(Debug, Clone)]
pub(super) struct Modes {
    pub omega_squared: DVector<f64>,
    /// `2 xi omega` per mode.
    pub damping: DVector<f64>,
    /// Mode shapes at the driven points: modes x points.
    pub phi: DMatrix<f64>,
}

/// Motion of the points. Accelerations exclude the direct effect of the forces on the points.
pub(super) struct Motion<'a, R> {
    pub displacement: &'a mut [R],
    pub velocity: &'a mut [R],
    /// Of the first points only, as many as are requested.
    pub acceleration: &'a mut [R],
}

impl Modes {
    /// Value at point `n` of a field given by its modal coordinates.
    pub fn at(&self, n: usize, modal: &[f64]) -> f64 {
        self.phi.column(n).iter().zip(modal).map(|(phi, x)| phi * x).sum()
    }

    /// Strain and kinetic energy, J.
    pub fn energy(&self, x: &[f64], v: &[f64]) -> f64 {
        let squares = self.omega_squared.iter().zip(x).zip(v);
        squares.map(|((omega_squared, x), v)| 0.5 * (omega_squared * x * x + v * v)).sum()
    }
}

/// Modes of each lane, to be integrated.
#[derive(Debug, Clone)]
pub(super) struct ModalRates<R> {
    points: usize,
    omega_squared: Vec<R>,
    damping: Vec<R>,
    /// Shapes at the points, one point after the other.
    phi: Vec<R>,
    /// The same, several points together.
    shapes: Blocks<R>,
}

impl<R: Number> ModalRates<R> {
    /// Room for modes of a shape.
    pub fn like(modes: &Modes) -> Self {
        let (count, points) = modes.phi.shape();
        let zeros = |length: usize| vec![R::splat(0.0); length];
        Self {
            points,
            omega_squared: zeros(count),
            damping: zeros(count),
            phi: zeros(count * points),
            shapes: Blocks::zeros((count, points)),
        }
    }

    /// Sets the modes of a lane.
    pub fn put(&mut self, lane: usize, modes: &Modes) {
        put_all(&mut self.omega_squared, lane, &modes.omega_squared);
        put_all(&mut self.damping, lane, &modes.damping);
        put_all(&mut self.phi, lane, &modes.phi);
        self.shapes.put(lane, &modes.phi);
    }

    /// Writes the accelerations that modes have without forces, `-omega^2 x - 2 xi omega v`; returns the power dissipated, W.
    #[inline(always)]
    pub fn free_accelerations(&self, x: &[R], v: &[R], acceleration: &mut [R]) -> R {
        let mut losses = [R::splat(0.0); LANES];
        let (blocks, rest) = acceleration.as_chunks_mut::<LANES>();
        let given = [&self.omega_squared[..], &self.damping, x, v].map(|values| values.as_chunks::<LANES>());
        for (at, acceleration) in blocks.iter_mut().enumerate() {
            let [omega_squared, damping, x, v] = given.map(|(blocks, _)| blocks[at]);
            for lane in 0..LANES {
                let resistance = damping[lane] * v[lane];
                acceleration[lane] = (-omega_squared[lane]).mul_add(x[lane], -resistance);
                losses[lane] = resistance.mul_add(v[lane], losses[lane]);
            }
        }
        for (at, acceleration) in rest.iter_mut().enumerate() {
            let [omega_squared, damping, x, v] = given.map(|(_, rest)| rest[at]);
            let resistance = damping * v;
            *acceleration = (-omega_squared).mul_add(x, -resistance);
            losses[at] = resistance.mul_add(v, losses[at]);
        }
        (losses[0] + losses[1]) + (losses[2] + losses[3])
    }

    /// Motion of all points from the modes' displacements, velocities and free accelerations.
    #[inline(always)]
    pub fn motion(&self, [x, v, free]: [&[R]; 3], out: &mut Motion<'_, R>) {
        let accelerated = out.acceleration.len();
        for (at, first) in (0..self.points).step_by(LANES).enumerate() {
            let range = first..self.points.min(first + LANES);
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

    /// Adds the effect of the forces on the points, `Phi F`, to the modes' accelerations.
    #[inline(always)]
    pub fn add_forces(&self, force: &[R], acceleration: &mut [R]) {
        add_columns(acceleration, &self.phi, force);
    }

    /// Shapes at point `n`.
    #[inline(always)]
    pub fn shapes_at(&self, n: usize) -> &[R] {
        let count = self.omega_squared.len();
        &self.phi[n * count..(n + 1) * count]
    }
}

/// Masses tied rigidly to the first points, as guides are to their mounts: `(I + sum m phi phi') a = a0` solved by a low-rank update,
/// in terms of forces: each mass takes its inertia force from the force on its point.
#[derive(Debug, Clone)]
pub(super) struct TiedMasses {
    /// Mass at each of the first points, kg.
    pub mass: Vec<f64>,
    /// `-(diag(1/m) + Phi_t' Phi_t)^-1`, `Phi_t` the shapes at the points with masses.
    update: DMatrix<f64>,
    /// `Phi_t' Phi`: acceleration of each point with a mass per force on each point.
    direct: DMatrix<f64>,
}

impl TiedMasses {
    /// Prepares the update for masses `mass` on the first columns of `phi`; `None` for masses that are not positive.
    pub fn new(phi: &DMatrix<f64>, mass: Vec<f64>) -> Option<Self> {
        let columns = phi.columns(0, mass.len());
        let mut matrix = columns.tr_mul(&columns);
        for (at, mass) in mass.iter().enumerate() {
            matrix[(at, at)] += 1.0 / mass;
        }
        let update = -matrix.cholesky()?.inverse();
        Some(Self { mass, update, direct: columns.tr_mul(phi) })
    }
}

/// Tied masses of each lane.
#[derive(Debug, Clone)]
pub(super) struct MassShares<R> {
    count: usize,
    update: Vec<R>,
    direct: Vec<R>,
}

impl<R: Number> MassShares<R> {
    /// Allocates a number of masses.
    pub fn like(tied: &TiedMasses) -> Self {
        let zeros = |length: usize| vec![R::splat(0.0); length];
        Self { count: tied.mass.len(), update: zeros(tied.update.len()), direct: zeros(tied.direct.len()) }
    }

    /// Sets the masses of a lane.
    pub fn put(&mut self, lane: usize, tied: &TiedMasses) {
        put_all(&mut self.update, lane, &tied.update);
        put_all(&mut self.direct, lane, &tied.direct);
    }

    /// Number of masses.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Subtracts the inertia forces of the masses from the forces on their points. `own` are the accelerations of the points without any
    /// force; they become the accelerations with the forces but without the masses.
    #[inline(always)]
    pub fn share(&self, force: &mut [R], own: &mut [R]) {
        add_columns(&mut own[..self.count], &self.direct, force);
        add_columns(&mut force[..self.count], &self.update, &own[..self.count]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sharing forces gives the result of the full matrix: `(I + sum m phi phi')^-1 (a + Phi F)`.
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
        let tied = TiedMasses::new(&phi, mass).unwrap();
        let mut shares = MassShares::<f64>::like(&tied);
        shares.put(0, &tied);
        shares.share(force.as_mut_slice(), phi.tr_mul(&free).as_mut_slice());
        assert!((free + phi * force - expected).amax() < 1e-13);
        // A mount that no mode moves is still positive definite; a negative mass is not.
        assert!(TiedMasses::new(&DMatrix::zeros(2, 1), vec![1.0]).is_some());
        assert!(TiedMasses::new(&DMatrix::zeros(2, 1), vec![-1.0]).is_none());
    }

    /// Motion of the points and accelerations of the modes are the sums over modes that they stand for.
    #[test]
    fn analytic_motion_and_accelerations() {
        let (count, points, accelerated) = (7, 6, 5);
        let wave = |seed: f64| DVector::from_fn(count, |s, _| (seed * (s + 1) as f64).sin());
        let (omega_squared, damping) = (wave(0.3).abs() * 1e4, wave(0.7).abs());
        let phi = DMatrix::from_fn(count, points, |s, n| (0.9 * (s + 5 * n) as f64).cos());
        let modes = Modes { omega_squared: omega_squared.clone(), damping: damping.clone(), phi: phi.clone() };
        let mut rates = ModalRates::<f64>::like(&modes);
        rates.put(0, &modes);
        let (x, v) = (wave(1.1), wave(1.3));
        let mut free = vec![0.0; count];
        let loss = rates.free_accelerations(x.as_slice(), v.as_slice(), &mut free);
        let expected = -omega_squared.component_mul(&x) - damping.component_mul(&v);
        assert!((DVector::from_row_slice(&free) - &expected).amax() < 1e-10);
        assert!((loss - damping.component_mul(&v).dot(&v)).abs() < 1e-13);

        let mut found = vec![vec![f64::NAN; points]; 3];
        let [displacement, velocity, acceleration] = &mut found[..] else { unreachable!() };
        let mut motion = Motion { displacement, velocity, acceleration: &mut acceleration[..accelerated] };
        rates.motion([x.as_slice(), v.as_slice(), &free], &mut motion);
        for (found, (modal, count)) in found.iter().zip([(&x, points), (&v, points), (&expected, accelerated)]) {
            for (n, found) in found.iter().enumerate().take(count) {
                let expected = phi.column(n).dot(modal);
                assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()));
                assert!((modes.at(n, modal.as_slice()) - expected).abs() < 1e-12 * (1.0 + expected.abs()));
            }
        }
    }
}
