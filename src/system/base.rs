//! Condensed modes at their last rebase: their free motion from there, their energy, what they dissipate, and the next rebase.

use pulp::{Simd, WithSimd};

use crate::number::{Number, on_widest};
use crate::system::impulse_response::{Block, Condensation, GAMMAS, Lanes, WIDTH};
use crate::system::kernel::{Free, Kernel, ORDER, TERMS, for_points};

/// Points whose free motion is summed in one pass over the modes: a pass has as many sums as there are registers for.
const SUMMED: usize = 5;

/// `a + b c` lane by lane, rounded once: by one instruction where this is inlined into code for a processor that has it, the same
/// elsewhere.
#[inline(always)]
fn fused<const N: usize>(a: [f64; N], b: [f64; N], c: [f64; N]) -> [f64; N] {
    let mut fused = a;
    for lane in 0..N {
        fused[lane] = b[lane].mul_add(c[lane], a[lane]);
    }
    fused
}

#[inline(always)]
fn product<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|lane| a[lane] * b[lane])
}

/// `tau^k / k!` from 0 on.
#[inline(always)]
fn scaled_powers(tau: f64) -> [f64; ORDER + 1] {
    let mut terms = [1.0; ORDER + 1];
    for k in 1..=ORDER {
        terms[k] = terms[k - 1] * (tau / k as f64);
    }
    terms
}

/// The modes at the last rebase, and what follows from them.
#[derive(Debug, Clone)]
pub(super) struct Base {
    /// Time of the rebase, s.
    pub time_s: f64,
    displacement: Vec<Lanes>,
    velocity: Vec<Lanes>,
    /// The free motion of each interface point.
    pub free: Vec<Free<f64>>,
}

impl Base {
    /// The structure at rest at time 0.
    pub fn at_rest(condensation: &Condensation) -> Self {
        let (blocks, points) = (condensation.blocks.len(), condensation.points());
        Self {
            time_s: 0.0,
            displacement: vec![[0.0; WIDTH]; blocks],
            velocity: vec![[0.0; WIDTH]; blocks],
            free: vec![[[0.0; TERMS]; 3]; points],
        }
    }

    /// Displacement, velocity and acceleration (without its direct part) of point `n` at `tau` after the base; `z` are the
    /// integrals.
    pub fn point(&self, condensation: &Condensation, (tau, z): (f64, &[f64]), n: usize) -> [f64; 3] {
        f64::dispatch(Point { kernel: condensation.kernel(), free: &self.free, tau, z, n })
    }

    /// Strain and kinetic energy of the modes at `t`, J.
    pub fn energy(&self, condensation: &Condensation, t: f64, z: &[f64]) -> f64 {
        on_widest(Energy { base: self, condensation, t, z })
    }

    /// Power that the modes dissipate at `t`, `sum 2 xi omega x'^2`, in W: from their velocities and damping alone, whatever
    /// work is done on them.
    pub fn dissipation_w(&self, condensation: &Condensation, t: f64, z: &[f64]) -> f64 {
        on_widest(Dissipation { base: self, condensation, t, z })
    }

    /// Velocity of the modes of block `at`, as [`Base::moved`] gives it beside the displacement.
    #[inline(always)]
    fn velocity<const P: usize>(
        &self,
        condensation: &Condensation,
        at: usize,
        terms: &[f64; ORDER + 1],
        z: &[f64],
    ) -> Lanes {
        let (block, points) = (&condensation.blocks[at], if P > 0 { P } else { condensation.points() });
        let [impulse, constant] = self.free_loads(block, at);
        let shapes = &condensation.shapes[at * points..(at + 1) * points];
        let mut velocity = [0.0; WIDTH];
        for (k, (gamma, z)) in block.gamma.iter().zip(z.chunks_exact(points)).enumerate() {
            let mut load = fused(product([terms[k]; WIDTH], impulse), [terms[k + 1]; WIDTH], constant);
            for (shape, z) in shapes.iter().zip(z) {
                load = fused(load, [*z; WIDTH], *shape);
            }
            velocity = fused(velocity, *gamma, load);
        }
        velocity
    }

    /// Displacement and velocity of the modes of block `at` when `tau` with its `terms` has passed since the base.
    #[inline(always)]
    fn moved<const P: usize>(
        &self,
        condensation: &Condensation,
        at: usize,
        terms: &[f64; ORDER + 1],
        z: &[f64],
    ) -> [Lanes; 2] {
        let (block, points) = (&condensation.blocks[at], if P > 0 { P } else { condensation.points() });
        let (mut displacement, mut velocity) = (self.displacement[at], [0.0; WIDTH]);
        let [impulse, constant] = self.free_loads(block, at);
        let shapes = &condensation.shapes[at * points..(at + 1) * points];
        for (k, z) in z.chunks_exact(points).enumerate() {
            // The integral of order k + 1 of all that moves the modes.
            let mut load = fused(product([terms[k]; WIDTH], impulse), [terms[k + 1]; WIDTH], constant);
            for (shape, z) in shapes.iter().zip(z) {
                load = fused(load, [*z; WIDTH], *shape);
            }
            if k < GAMMAS {
                velocity = fused(velocity, block.gamma[k], load);
            }
            if k > 0 {
                displacement = fused(displacement, block.gamma[k - 1], load);
            }
        }
        [displacement, velocity]
    }

    /// Coefficients of the free displacement of `P` points from `point` on by `K` powers of the time from `power` on, not yet divided by
    /// factorials: sums over all modes.
    #[inline(always)]
    fn summed<const P: usize, const K: usize>(
        &self,
        condensation: &Condensation,
        point: usize,
        power: usize,
    ) -> [[f64; K]; P] {
        let mut sums = [[0.0; K]; P];
        let (displacement, velocity) = (self.displacement.as_flattened(), self.velocity.as_flattened());
        let by_mode = condensation.shapes_by_mode.chunks_exact(condensation.points());
        let states = displacement.iter().zip(velocity).zip(&condensation.stiffness);
        for ((series, shapes), ((displacement, impulse), stiffness)) in
            condensation.series.iter().zip(by_mode).zip(states)
        {
            let constant = -stiffness * displacement;
            let of_constant: [f64; K] = std::array::from_fn(|k| series[power + k]);
            let of_impulse: [f64; K] = std::array::from_fn(|k| series[power + k + 1]);
            let mut coefficients = fused(product([constant; K], of_constant), [*impulse; K], of_impulse);
            if power == 0 {
                coefficients[..1].fill(*displacement);
            }
            for (sums, shape) in sums.iter_mut().zip(&shapes[point..point + P]) {
                *sums = fused(*sums, [*shape; K], coefficients);
            }
        }
        sums
    }

    /// Sums the series of the free motion of all points.
    #[inline(always)]
    fn sum_all(&mut self, condensation: &Condensation) {
        let points = condensation.points();
        for first in (0..points).step_by(SUMMED) {
            match points - first {
                1 => self.sum_some::<1, 12, 0>(condensation, first),
                2 => self.sum_some::<2, 12, 0>(condensation, first),
                3 => self.sum_some::<3, 12, 0>(condensation, first),
                4 => self.sum_some::<4, 8, 4>(condensation, first),
                _ => self.sum_some::<SUMMED, 8, 4>(condensation, first),
            }
        }
    }

    /// Sums those of `P` points from `first` on, the first `EARLY` and the other `LATE` coefficients each in a pass of their own.
    #[inline(always)]
    fn sum_some<const P: usize, const EARLY: usize, const LATE: usize>(
        &mut self,
        condensation: &Condensation,
        first: usize,
    ) {
        const { assert!(EARLY + LATE == ORDER + 1, "all coefficients") };
        let early = self.summed::<P, EARLY>(condensation, first, 0);
        let late = self.summed::<P, LATE>(condensation, first, EARLY);
        // 1 / k!.
        let factor = scaled_powers(1.0);
        for ((early, late), [displacement, velocity, acceleration]) in
            early.iter().zip(&late).zip(&mut self.free[first..])
        {
            for (k, sum) in early.iter().chain(late).enumerate() {
                let coefficient = factor[k] * sum;
                displacement[k] = coefficient;
                if k >= 1 {
                    velocity[k - 1] = k as f64 * coefficient;
                }
                if k >= 2 {
                    acceleration[k - 2] = (k * (k - 1)) as f64 * coefficient;
                }
            }
        }
    }

    /// Impulse and constant force that stand for the velocity and the displacement of the modes of block `at`.
    #[inline(always)]
    fn free_loads(&self, block: &Block, at: usize) -> [Lanes; 2] {
        let displacement = &self.displacement[at];
        [self.velocity[at], std::array::from_fn(|lane| -block.stiffness[lane] * displacement[lane])]
    }

    /// Rebases at time `t`.
    pub fn rebase(&mut self, condensation: &Condensation, t: f64, z: &[f64]) {
        on_widest(Rebase { base: self, condensation, t, z });
    }

    /// Brings the modes to time `t` and sums the series of their free motion from there.
    #[inline(always)]
    fn rebase_all(&mut self, condensation: &Condensation, t: f64, z: &[f64]) {
        for_points!(condensation.points(), self.rebase_points(condensation, t, z));
        self.time_s = t;
    }

    #[inline(always)]
    fn rebase_points<const P: usize>(&mut self, condensation: &Condensation, t: f64, z: &[f64]) {
        let terms = scaled_powers(t - self.time_s);
        for at in 0..condensation.blocks.len() {
            [self.displacement[at], self.velocity[at]] = self.moved::<P>(condensation, at, &terms, z);
        }
        self.sum_all(condensation);
    }
}

/// Motion of a point to be computed.
struct Point<'p> {
    kernel: &'p Kernel<f64>,
    free: &'p [Free<f64>],
    tau: f64,
    z: &'p [f64],
    n: usize,
}

impl WithSimd for Point<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        self.kernel.point(self.free, self.tau, self.z, self.n)
    }
}

/// Energy to be summed.
struct Energy<'e> {
    base: &'e Base,
    condensation: &'e Condensation,
    t: f64,
    z: &'e [f64],
}

impl WithSimd for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { base, condensation, t, z } = self;
        let terms = scaled_powers(t - base.time_s);
        let mut twice = [0.0; WIDTH];
        for (at, block) in condensation.blocks.iter().enumerate() {
            let [displacement, velocity] = base.moved::<0>(condensation, at, &terms, z);
            twice = fused(twice, block.stiffness, product(displacement, displacement));
            twice = fused(twice, velocity, velocity);
        }
        0.5 * twice.iter().sum::<f64>()
    }
}

/// A dissipated power to be summed.
struct Dissipation<'d> {
    base: &'d Base,
    condensation: &'d Condensation,
    t: f64,
    z: &'d [f64],
}

impl WithSimd for Dissipation<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        for_points!(self.condensation.points(), self.sum())
    }
}

impl Dissipation<'_> {
    #[inline(always)]
    fn sum<const P: usize>(&self) -> f64 {
        let Self { base, condensation, t, z } = self;
        let terms = scaled_powers(t - base.time_s);
        let mut power = [0.0; WIDTH];
        for (at, block) in condensation.blocks.iter().enumerate() {
            let velocity = base.velocity::<P>(condensation, at, &terms, z);
            power = fused(power, block.damping, product(velocity, velocity));
        }
        power.iter().sum()
    }
}

/// A rebase to be done.
struct Rebase<'r> {
    base: &'r mut Base,
    condensation: &'r Condensation,
    t: f64,
    z: &'r [f64],
}

impl WithSimd for Rebase<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.base.rebase_all(self.condensation, self.t, self.z);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::system::modal::Modes;

    /// Three modes at some points: one that floats, one undamped, one damped.
    fn modes(points: usize) -> Modes {
        let (omega, ratio): ([f64; 3], [f64; 3]) = ([0.0, 700.0, 2000.0], [0.0, 0.0, 0.05]);
        Modes {
            omega_squared: DVector::from_fn(3, |s, _| omega[s] * omega[s]),
            damping: DVector::from_fn(3, |s, _| 2.0 * ratio[s] * omega[s]),
            phi: DMatrix::from_fn(3, points, |s, n| if s == 0 { 0.1 } else { 0.4 * (1.3 * (s + 3 * n) as f64).sin() }),
        }
    }

    /// Displacement and velocity of a mode under the constant modal force `f` from rest: the closed form.
    fn step_response((omega_squared, damping): (f64, f64), f: f64, t: f64) -> [f64; 2] {
        if omega_squared == 0.0 {
            return [0.5 * f * t * t, f * t];
        }
        let decay = 0.5 * damping;
        let wd = (omega_squared - decay * decay).sqrt();
        let (sin, cos) = (wd * t).sin_cos();
        let fade = (-decay * t).exp();
        [f / omega_squared * (1.0 - fade * (cos + decay / wd * sin)), f * fade * sin / wd]
    }

    /// Under constant forces the integrals are powers of time: motion of the points and energy of the modes, over many rebases, are
    /// those of the closed forms, whatever the number of points that the loops are unrolled for.
    #[test]
    fn analytic_step_forces() {
        [1, 2, 3, 4, 5, 6, 8, 11].into_iter().for_each(step_forces_at);
    }

    fn step_forces_at(points: usize) {
        let modes = modes(points);
        let condensation = Condensation::new(&modes).unwrap();
        let force = DVector::from_fn(points, |n, _| [40.0, -15.0, 25.0][n % 3]);
        let modal_force = &modes.phi * &force;
        // Errors of displacement, velocity and acceleration that a modal force of 15 N may cause.
        let bounds = [2e-12, 4e-9, 3e-5].map(|bound| bound * modal_force.amax() / 15.0);
        let z = |tau: f64| -> Vec<f64> {
            let term = |k: usize| tau.powi(k as i32) / (1..=k).product::<usize>() as f64;
            (1..=ORDER).flat_map(|k| force.iter().map(move |f| f * term(k))).collect()
        };
        let mut base = Base::at_rest(&condensation);
        let exact =
            |t: f64| [0, 1, 2].map(|s| step_response((modes.omega_squared[s], modes.damping[s]), modal_force[s], t));
        for rebase in 1..=40 {
            let t0 = base.time_s;
            for part in [0.3, 1.0] {
                let tau = part * condensation.horizon_s;
                let modal = exact(t0 + tau);
                for n in 0..points {
                    let [w, v, a] = base.point(&condensation, (tau, &z(tau)), n);
                    let direct: f64 = (0..points).map(|m| condensation.kernel().direct(n, m) * force[m]).sum();
                    let sum = |value: &dyn Fn(usize) -> f64| (0..3).map(|s| modes.phi[(s, n)] * value(s)).sum::<f64>();
                    let (we, ve) = (sum(&|s| modal[s][0]), sum(&|s| modal[s][1]));
                    let ae = sum(&|s| {
                        modal_force[s] - modes.damping[s] * modal[s][1] - modes.omega_squared[s] * modal[s][0]
                    });
                    let at = format!("point {n} of {points}, rebase {rebase}");
                    assert!((w - we).abs() < bounds[0], "{at}: {w} and {we}");
                    assert!((v - ve).abs() < bounds[1], "{at}: {v} and {ve}");
                    assert!((a + direct - ae).abs() < bounds[2], "{at}: {} and {ae}", a + direct);
                }
            }
            // Rebases at uneven times.
            let tau = condensation.horizon_s * (0.5 + 0.0125 * f64::from(rebase));
            base.rebase(&condensation, t0 + tau, &z(tau));
        }
        let modal = exact(base.time_s);
        let energy: f64 =
            (0..3).map(|s| 0.5 * (modes.omega_squared[s] * modal[s][0].powi(2) + modal[s][1].powi(2))).sum();
        let found = base.energy(&condensation, base.time_s, &z(0.0));
        assert!((found / energy - 1.0).abs() < 1e-8, "{points} points: {found} and {energy}");
        // What an error of 1e-8 m/s of the modes' velocities makes of it.
        let loss = |power: i32| (0..3).map(|s| modes.damping[s] * modal[s][1].abs().powi(power)).sum::<f64>();
        let (found, loss, bound) = (base.dissipation_w(&condensation, base.time_s, &z(0.0)), loss(2), 2e-8 * loss(1));
        assert!((found - loss).abs() < bound, "{points} points: {found} and {loss}, bound {bound}");
    }

    /// A mode that is not a number is not condensed; one that only floats is, for ever.
    #[test]
    fn modes_that_are_not_finite() {
        let one = |omega_squared: f64, damping: f64| Modes {
            omega_squared: DVector::from_element(1, omega_squared),
            damping: DVector::from_element(1, damping),
            phi: DMatrix::from_element(1, 1, 0.5),
        };
        for (omega_squared, damping) in [(f64::NAN, 0.0), (1e6, f64::NAN), (f64::INFINITY, 0.0)] {
            assert!(Condensation::new(&one(omega_squared, damping)).is_none(), "{omega_squared}, {damping}");
        }
        let floating = Condensation::new(&one(0.0, 0.0)).unwrap();
        assert_eq!(floating.horizon_s, f64::INFINITY);
        // A force of 8 N for 3 s on 1 / 0.25 kg: 9 m at 6 m/s.
        let z: Vec<f64> = scaled_powers(3.0)[1..].iter().map(|power| 8.0 * power).collect();
        let [w, v, a] = Base::at_rest(&floating).point(&floating, (3.0, &z), 0);
        assert!((w - 9.0).abs() < 1e-12 && (v - 6.0).abs() < 1e-12 && a == 0.0, "{w}, {v}, {a}");
    }
}
