//! Motion of the interface points from the integrals of the forces on them, see `impulse_response`.

use crate::system::modal::Motion;
use crate::system::products::{LANES, put_all, sum};
use decore_math::number::Number;

/// Repeated integrals per interface point.
pub(super) const ORDER: usize = 11;
/// Coefficients of a mode's impulse response.
pub(super) const GAMMAS: usize = ORDER - 1;
/// Terms of the series of the free motion, from `tau^0` to `tau^ORDER`, rounded up to whole vector registers.
pub(super) const TERMS: usize = (ORDER + 1).next_multiple_of(LANES);

/// Calls a function of as many interface points as there are, the usual numbers of them as a constant, by which loops over points are
/// unrolled; 0 stands for the others.
macro_rules! for_points {
    ($points:expr, $call:ident.$method:ident$(::<$($type:ident),+>)?($($argument:expr),*)) => {
        match $points {
            2 => $call.$method::<$($($type,)+)? 2>($($argument),*),
            3 => $call.$method::<$($($type,)+)? 3>($($argument),*),
            4 => $call.$method::<$($($type,)+)? 4>($($argument),*),
            5 => $call.$method::<$($($type,)+)? 5>($($argument),*),
            6 => $call.$method::<$($($type,)+)? 6>($($argument),*),
            8 => $call.$method::<$($($type,)+)? 8>($($argument),*),
            _ => $call.$method::<$($($type,)+)? 0>($($argument),*),
        }
    };
}

pub(super) use for_points;

/// Kernel of the motion of the points, for one row or one row in each lane.
#[derive(Debug, Clone)]
pub(super) struct Kernel<R> {
    pub points: usize,
    /// `Gamma_k[n, m]`, the index of `n` slowest, that of `m` fastest: what meets the integrals in their own order.
    /// `Gamma_ORDER` is zero.
    pub entries: Vec<R>,
}

/// Derivatives of the free displacement of an interface point at the base, from order 0 on, and zeros: with `tau^k / k!` the first give
/// its displacement, those from order 1 on its velocity, those from order 2 on its acceleration.
pub(super) type Free<R> = [R; TERMS + 2];

impl<R: Number> Kernel<R> {
    /// Room for that of a number of points.
    pub fn like(other: &Kernel<f64>) -> Self {
        Self { points: other.points, entries: vec![R::splat(0.0); other.entries.len()] }
    }

    /// Sets a lane.
    pub fn put(&mut self, lane: usize, other: &Kernel<f64>) {
        put_all(&mut self.entries, lane, &other.entries);
    }

    /// `Gamma_1[n, m]`: acceleration of point `n` per force on point `m`.
    #[inline(always)]
    pub fn direct(&self, n: usize, m: usize) -> R {
        self.entries[n * ORDER * self.points + m]
    }

    /// Motion of all points at `tau` after the base; `z` are the integrals.
    #[inline(always)]
    pub fn motion(&self, free: &[Free<R>], tau: R, z: &[R], out: &mut Motion<'_, R>) {
        // For a row alone the unrolled loops would be compiled for processors without vector registers too.
        if R::LANES == 1 {
            self.motion_of::<0>(free, tau, z, out);
        } else {
            for_points!(self.points, self.motion_of(free, tau, z, out));
        }
    }

    #[inline(always)]
    fn motion_of<const P: usize>(&self, free: &[Free<R>], tau: R, z: &[R], out: &mut Motion<'_, R>) {
        let terms = terms(tau);
        for (n, free) in free.iter().enumerate() {
            if n < out.acceleration.len() {
                [out.displacement[n], out.velocity[n], out.acceleration[n]] = self.at::<3, P>(free, &terms, z, n);
            } else {
                [out.displacement[n], out.velocity[n]] = self.at::<2, P>(free, &terms, z, n);
            }
        }
    }

    /// Displacement, velocity and acceleration (without its direct part) of point `n`.
    #[inline(always)]
    pub fn point(&self, free: &[Free<R>], tau: R, z: &[R], n: usize) -> [R; 3] {
        self.at::<3, 0>(&free[n], &terms(tau), z, n)
    }

    /// The first `D` of displacement, velocity and acceleration of point `n`: one pass over the kernel serves all.
    #[inline(always)]
    fn at<const D: usize, const P: usize>(&self, free: &Free<R>, terms: &[R; TERMS], z: &[R], n: usize) -> [R; D] {
        let points = if P > 0 { P } else { self.points };
        let states = ORDER * points;
        let kernel = &self.entries[n * states..(n + 1) * states];
        let mut sums = [[R::splat(0.0); LANES]; D];
        for (at, terms) in terms.as_chunks::<LANES>().0.iter().enumerate() {
            for lane in 0..LANES {
                for order in 0..D {
                    sums[order][lane] = free[at * LANES + lane + order].mul_add(terms[lane], sums[order][lane]);
                }
            }
        }
        // Velocity reads z_k where displacement reads z_{k+1} and acceleration z_{k-1}. What is read is used for all at once: reading
        // takes longer than the products.
        let count = states - points;
        let (first, first_left) = kernel[..count].as_chunks::<LANES>();
        let (next, next_left) = kernel[points..][..count].as_chunks::<LANES>();
        let (early, early_left) = z[..count].as_chunks::<LANES>();
        let (late, late_left) = z[points..][..count].as_chunks::<LANES>();
        for ((first, next), (early, late)) in first.iter().zip(next).zip(early.iter().zip(late)) {
            for lane in 0..LANES {
                sums[0][lane] = first[lane].mul_add(late[lane], sums[0][lane]);
                sums[1][lane] = next[lane].mul_add(late[lane], sums[1][lane]);
                if D == 3 {
                    sums[2][lane] = next[lane].mul_add(early[lane], sums[2][lane]);
                }
            }
        }
        let mut rest = [
            sum(first_left, late_left),
            sum(next_left, late_left),
            if D == 3 { sum(next_left, early_left) } else { R::splat(0.0) },
        ];
        rest[1] += sum(&kernel[..points], &z[..points]);
        let mut values = [R::splat(0.0); D];
        for i in 0..D {
            values[i] = (sums[i][0] + sums[i][2]) + (sums[i][1] + sums[i][3]) + rest[i];
        }
        values
    }
}

/// `tau^k / k!` from 0 on.
#[inline(always)]
fn terms<R: Number>(tau: R) -> [R; TERMS] {
    let square = tau * tau;
    let mut terms = [R::splat(1.0); TERMS];
    terms[1] = tau;
    for k in 2..TERMS {
        terms[k] = terms[k - 2] * (square * R::splat(1.0 / (k * (k - 1)) as f64));
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_math::number::{Four, Lanes as _};

    /// In lanes, where loops over some numbers of points are unrolled, each number of points moves with the bits that it has alone.
    #[test]
    fn lanes_move_as_alone() {
        for points in 1..=8 {
            let wave =
                |seed: f64, count: usize| -> Vec<f64> { (0..count).map(|i| (seed * (i + 1) as f64).sin()).collect() };
            let alone = Kernel { points, entries: wave(0.7, ORDER * points * points) };
            let free: Vec<Free<f64>> = (0..points)
                .map(|n| {
                    let mut free = [0.0; TERMS + 2];
                    free.copy_from_slice(&wave(0.3 + n as f64, TERMS + 2));
                    free
                })
                .collect();
            let z = wave(1.9, ORDER * points);
            let mut kernel = Kernel::<Four>::like(&alone);
            let mut lanes_free = vec![[Four::splat(0.0); TERMS + 2]; points];
            let mut lanes_z = vec![Four::splat(0.0); z.len()];
            for lane in 0..Four::LANES {
                kernel.put(lane, &alone);
                put_all(lanes_free.as_flattened_mut(), lane, free.iter().flatten());
                put_all(&mut lanes_z, lane, &z);
            }
            let mut tau = Four::splat(0.0);
            (0..Four::LANES).for_each(|lane| tau.put(lane, &(0.2 * lane as f64)));
            let found = moved(&kernel, &lanes_free, tau, &lanes_z);
            for lane in 0..Four::LANES {
                let expected = moved(&alone, &free, 0.2 * lane as f64, &z);
                for (found, expected) in found.iter().zip(&expected) {
                    assert_eq!(found.lane(lane).to_bits(), expected.to_bits(), "{points} points, lane {lane}");
                }
            }
        }
    }

    /// Displacements, velocities, and the acceleration of the first point.
    fn moved<R: Number>(kernel: &Kernel<R>, free: &[Free<R>], tau: R, z: &[R]) -> Vec<R> {
        let (points, none) = (kernel.points, R::splat(0.0));
        let (mut displacement, mut velocity, mut acceleration) =
            (vec![none; points], vec![none; points], vec![none; 1]);
        let mut motion =
            Motion { displacement: &mut displacement, velocity: &mut velocity, acceleration: &mut acceleration };
        kernel.motion(free, tau, z, &mut motion);
        [displacement, velocity, acceleration].concat()
    }
}
