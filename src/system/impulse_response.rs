//! Impulse-response condensation of the structure's modes to its interface points, exact to about 1e-7: no modes in the state.
//!
//! From a base time on, each mode's free motion is known and its response to the interface forces is a convolution with its
//! impulse response `g`, `g'' + 2 xi omega g' + omega^2 g = 0`, `g(0) = 0`, `g'(0) = 1`. With a polynomial
//! `g(tau) = sum_k gamma_k tau^k / k!`, the convolution needs only the repeated integrals of the forces, `z_1' = F`,
//! `z_{k+1}' = z_k`:
//!
//! ```text
//! w_n(t0 + tau)   = free_n(tau)   + sum_m sum_k Gamma_k[n, m] z_{k+1, m}
//! w_n'(t0 + tau)  = free_n'(tau)  + sum_m sum_k Gamma_k[n, m] z_{k, m}
//! w_n''(t0 + tau) = free_n''(tau) + sum_m (Gamma_1[n, m] F_m + sum_k Gamma_{k+1}[n, m] z_{k, m})
//!
//! Gamma_k[n, m] = sum_s phi_ns phi_ms gamma_ks,  k = 1 to ORDER - 1
//! ```
//!
//! `gamma_1 = 1`, so that every impulse gives its whole momentum; the others make `g` satisfy its equation at the Chebyshev
//! points of the horizon (collocation), where the same degree comes far closer to `g` than its Taylor series. The free
//! motion is the response to the same `g`: that of a mode with displacement `q` and velocity `v` is `q` plus what an impulse
//! `v` and a constant force `-omega^2 q` would cause, so both are one sum over `k`.
//!
//! The state carries `ORDER` integrals per interface point instead of two states per mode, and a right-hand side costs nothing
//! per mode. Before the fastest mode has turned by [`TURN_RAD`] the base moves on: the modes are brought up to date and the
//! integrals start again at zero.

use nalgebra::{DMatrix, SMatrix, SVector};
use pulp::{Simd, WithSimd};

use crate::number::{Number, on_widest};
use crate::system::kernel::{Free, Kernel, ORDER, TERMS};
use crate::system::modal::Modes;

/// Coefficients of `g`.
const GAMMAS: usize = ORDER - 1;
/// Angle by which the fastest mode may turn between rebases, rad. With ten coefficients the fastest mode's `g` errs by 1e-7 of
/// its amplitude, `g'` by 5e-7 and `g''` by 3e-6, close to critical damping by three times that; slower modes err far less.
const TURN_RAD: f64 = 4.0;
/// Time in s that a right-hand side advances by on average, a sixth of a step between contacts.
const ADVANCE_S: f64 = 8e-6;

/// Whether condensing costs less than integrating the modes, by multiplications per right-hand side; their weights are
/// measured (`cargo bench --bench rig`, growth with hammers and with modes).
///
/// Integrated, each mode costs two products with its shape and its part of the stages; condensed, each point costs its
/// rows, and each mode its share of the rebases, which come the more often the faster the fastest mode is.
pub(super) fn pays(modes: &Modes) -> bool {
    let (count, points) = modes.phi.shape();
    let (count, points) = (count as f64, points as f64);
    let order = ORDER as f64;
    let integrated = count * (3.0 * points + 25.0);
    let rebase = count * order * (2.0 * points + 6.0);
    let condensed = points * order * (3.0 * points + 11.0);
    condensed + rebase * ADVANCE_S * fastest(modes) / TURN_RAD < integrated
}

/// Largest magnitude of an eigenvalue of a mode, rad/s: its natural circular frequency unless it is damped aperiodically.
fn fastest(modes: &Modes) -> f64 {
    let rate = |(omega_squared, damping): (&f64, &f64)| {
        let decay = 0.5 * damping;
        omega_squared.sqrt().max(decay + (decay * decay - omega_squared).max(0.0).sqrt())
    };
    modes.omega_squared.iter().zip(&modes.damping).map(rate).fold(0.0, f64::max)
}

/// `gamma_1` to `gamma_GAMMAS` of a mode, `gamma_k` in s^(1-k), for times up to the horizon `T`.
///
/// With `g'' = sum_j a_j x^j`, `x = tau / T`, and its integrals `g' = 1 + ...`, `g = tau + ...` the equation of `g` holds at the
/// Chebyshev points of `0 < x < 1`: one small linear system for `T a_j`. `None` if the mode is not finite.
fn impulse_response(omega_squared: f64, damping: f64, horizon_s: f64) -> Option<[f64; GAMMAS]> {
    const N: usize = GAMMAS - 1;
    let mut gamma = [0.0; GAMMAS];
    gamma[0] = 1.0;
    if omega_squared == 0.0 && damping == 0.0 {
        // Floats, however far the horizon.
        return Some(gamma);
    }
    let (by_velocity, by_displacement) = (damping * horizon_s, omega_squared * horizon_s * horizon_s);
    let node = |i: usize| 0.5 - 0.5 * libm::cos((i as f64 + 0.5) * std::f64::consts::PI / N as f64);
    let matrix = SMatrix::<f64, N, N>::from_fn(|i, j| {
        let (x, power, j) = (node(i), node(i).powi(j as i32), j as f64);
        power * (1.0 + x / (j + 1.0) * (by_velocity + by_displacement * x / (j + 2.0)))
    });
    let load = SVector::<f64, N>::from_fn(|i, _| -by_velocity - by_displacement * node(i));
    let solution = matrix.lu().solve(&load)?;
    let mut factor = 1.0 / horizon_s;
    for (j, value) in solution.iter().enumerate() {
        gamma[j + 1] = value * factor;
        factor *= (j + 1) as f64 / horizon_s;
    }
    gamma.iter().all(|gamma| gamma.is_finite()).then_some(gamma)
}

/// Constants of the condensation.
#[derive(Debug, Clone)]
pub(super) struct Condensation {
    /// Longest time from one rebase to the next, s.
    pub horizon_s: f64,
    points: usize,
    /// The modes, several together; those that fill the last block up are zero.
    blocks: Vec<Block>,
    /// Shapes of each block at each point, the index of the point fastest.
    shapes: Vec<Lanes>,
    kernel: Kernel<f64>,
}

/// Some modes: `omega^2`, `2 xi omega` and `gamma_1` to `gamma_GAMMAS`.
#[derive(Debug, Clone, Copy)]
struct Block {
    stiffness: Lanes,
    damping: Lanes,
    gamma: [Lanes; GAMMAS],
}

impl Condensation {
    /// Condenses modes; `None`, and they are integrated, for a structure without modes or with one that is not finite.
    pub fn new(modes: &Modes) -> Option<Self> {
        if modes.omega_squared.is_empty() {
            return None;
        }
        let (count, points) = modes.phi.shape();
        // Infinite for a structure that only floats.
        let horizon_s = TURN_RAD / fastest(modes);
        let mut gamma = DMatrix::zeros(count, GAMMAS);
        for (s, mut row) in gamma.row_iter_mut().enumerate() {
            row.copy_from_slice(&impulse_response(modes.omega_squared[s], modes.damping[s], horizon_s)?);
        }
        let mut kernel = vec![0.0; ORDER * points * points];
        for (k, gamma) in gamma.column_iter().enumerate() {
            let weighted = DMatrix::from_fn(count, points, |s, n| gamma[s] * modes.phi[(s, n)]);
            let product = modes.phi.tr_mul(&weighted);
            for n in 0..points {
                for m in 0..points {
                    kernel[(n * ORDER + k) * points + m] = product[(n, m)];
                }
            }
        }
        let padded = |values: &[f64], block: usize| -> Lanes {
            std::array::from_fn(|lane| values.get(block * WIDTH + lane).copied().unwrap_or(0.0))
        };
        let blocks = 0..count.div_ceil(WIDTH);
        let shape = |block: usize, point: usize| padded(modes.phi.column(point).as_slice(), block);
        Some(Self {
            horizon_s,
            points,
            shapes: blocks.clone().flat_map(|block| (0..points).map(move |point| shape(block, point))).collect(),
            blocks: blocks
                .map(|block| Block {
                    stiffness: padded(modes.omega_squared.as_slice(), block),
                    damping: padded(modes.damping.as_slice(), block),
                    gamma: std::array::from_fn(|k| padded(gamma.column(k).as_slice(), block)),
                })
                .collect(),
            kernel: Kernel { points, entries: kernel },
        })
    }

    /// Number of states: the integrals `z_1` of all points, then `z_2`, and so on.
    pub fn states(&self) -> usize {
        ORDER * self.points
    }

    /// Number of interface points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// What motion of the points follows from.
    pub fn kernel(&self) -> &Kernel<f64> {
        &self.kernel
    }

    /// Scale of the first integral at a point whose velocity has scale 1, infinite for a point that cannot move.
    pub fn force_scale(&self, point: usize) -> f64 {
        let largest = (0..self.points).map(|n| self.kernel.direct(n, point).abs()).fold(0.0, f64::max);
        1.0 / largest
    }

    /// Displacement, velocity and acceleration (without its direct part) of point `n` at `tau` after the base; `z` are the
    /// integrals.
    pub fn point(&self, base: &Base, tau: f64, z: &[f64], n: usize) -> [f64; 3] {
        f64::dispatch(Point { kernel: &self.kernel, free: &base.free, tau, z, n })
    }
}

/// Modes treated together in a rebase: sums along the series are long chains, and several hide each other's latency.
const WIDTH: usize = 16;
type Lanes = [f64; WIDTH];
/// Coefficients of a series, by powers of the time.
type Series = [Lanes; ORDER + 1];
/// Coefficients that are summed in one pass over the modes: as many sums as there are registers for.
const SUMMED: usize = 3;
const _: () = assert!((ORDER + 1).is_multiple_of(SUMMED));

/// `a + b c` lane by lane, rounded once: by one instruction where this is inlined into code for a processor that has it, the same
/// elsewhere.
#[inline(always)]
fn fused(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    let mut fused = a;
    for lane in 0..WIDTH {
        fused[lane] = b[lane].mul_add(c[lane], a[lane]);
    }
    fused
}

#[inline(always)]
fn product(a: Lanes, b: Lanes) -> Lanes {
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
    /// Coefficients of the free displacement of each block's modes while they are summed.
    coefficients: Vec<Series>,
}

impl Base {
    /// The structure at rest at time 0.
    pub fn at_rest(condensation: &Condensation) -> Self {
        let (blocks, points) = (condensation.blocks.len(), condensation.points);
        Self {
            time_s: 0.0,
            displacement: vec![[0.0; WIDTH]; blocks],
            velocity: vec![[0.0; WIDTH]; blocks],
            free: vec![[[0.0; TERMS]; 3]; points],
            coefficients: vec![[[0.0; WIDTH]; ORDER + 1]; blocks],
        }
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
    fn velocity(&self, condensation: &Condensation, at: usize, terms: &[f64; ORDER + 1], z: &[f64]) -> Lanes {
        let (block, points) = (&condensation.blocks[at], condensation.points);
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
    fn moved(&self, condensation: &Condensation, at: usize, terms: &[f64; ORDER + 1], z: &[f64]) -> [Lanes; 2] {
        let (block, points) = (&condensation.blocks[at], condensation.points);
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

    /// Coefficients `first` and on of the free displacement of point `n`, not yet divided by factorials: sums over all modes.
    #[inline(always)]
    fn summed(&self, condensation: &Condensation, n: usize, first: usize) -> [f64; SUMMED] {
        let mut sums = [[0.0; WIDTH]; SUMMED];
        for (at, coefficients) in self.coefficients.iter().enumerate() {
            let shape = condensation.shapes[at * condensation.points + n];
            for i in 0..SUMMED {
                sums[i] = fused(sums[i], shape, coefficients[first + i]);
            }
        }
        let mut over_lanes = [0.0; SUMMED];
        for i in 0..SUMMED {
            over_lanes[i] = sums[i].iter().sum();
        }
        over_lanes
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
        let terms = scaled_powers(t - self.time_s);
        for (at, block) in condensation.blocks.iter().enumerate() {
            [self.displacement[at], self.velocity[at]] = self.moved(condensation, at, &terms, z);
            let [impulse, constant] = self.free_loads(block, at);
            let coefficients = &mut self.coefficients[at];
            coefficients[0] = self.displacement[at];
            coefficients[1] = impulse;
            for (coefficient, gamma) in coefficients[2..ORDER].iter_mut().zip(block.gamma.windows(2)) {
                *coefficient = fused(product(gamma[1], impulse), gamma[0], constant);
            }
            coefficients[ORDER] = product(block.gamma[GAMMAS - 1], constant);
        }
        // 1 / k!.
        let factor = scaled_powers(1.0);
        for n in 0..condensation.points {
            for first in (0..=ORDER).step_by(SUMMED) {
                let sums = self.summed(condensation, n, first);
                for (i, sum) in sums.iter().enumerate() {
                    let (k, [displacement, velocity, acceleration]) = (first + i, &mut self.free[n]);
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
        self.time_s = t;
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
            let [displacement, velocity] = base.moved(condensation, at, &terms, z);
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
        let Self { base, condensation, t, z } = self;
        let terms = scaled_powers(t - base.time_s);
        let mut power = [0.0; WIDTH];
        for (at, block) in condensation.blocks.iter().enumerate() {
            let velocity = base.velocity(condensation, at, &terms, z);
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
    use nalgebra::DVector;

    use super::*;

    /// Two points, three modes: one that floats, one undamped, one damped.
    fn modes() -> Modes {
        let (omega, ratio): ([f64; 3], [f64; 3]) = ([0.0, 700.0, 2000.0], [0.0, 0.0, 0.05]);
        Modes {
            omega_squared: DVector::from_fn(3, |s, _| omega[s] * omega[s]),
            damping: DVector::from_fn(3, |s, _| 2.0 * ratio[s] * omega[s]),
            phi: DMatrix::from_row_slice(3, 2, &[0.1, 0.1, 0.3, -0.2, 0.25, 0.4]),
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

    /// The polynomial of a mode against the closed form `g = (exp(a t) - exp(b t)) / (a - b)`, oscillating, nearly critical and
    /// aperiodic, over the horizon of its faster eigenvalue.
    #[test]
    fn analytic_impulse_response() {
        let omega = 900.0_f64;
        for ratio in [0.0, 0.02, 0.5, 0.999, 1.001, 5.0_f64] {
            let (decay, rest) = (ratio * omega, (1.0 - ratio * ratio).abs().sqrt() * omega);
            let one = Modes {
                omega_squared: DVector::from_element(1, omega * omega),
                damping: DVector::from_element(1, 2.0 * decay),
                phi: DMatrix::from_element(1, 1, 1.0),
            };
            let horizon_s = TURN_RAD / fastest(&one);
            let gamma = impulse_response(omega * omega, 2.0 * decay, horizon_s).unwrap();
            for part in 0..=50_u32 {
                let t = horizon_s * f64::from(part) / 50.0;
                let terms = scaled_powers(t);
                let (g, slope): (f64, f64) = gamma
                    .iter()
                    .enumerate()
                    .fold((0.0, 0.0), |(g, s), (k, c)| (g + c * terms[k + 1], s + c * terms[k]));
                let (sine, cosine) = if ratio < 1.0 {
                    ((rest * t).sin(), (rest * t).cos())
                } else {
                    ((rest * t).sinh(), (rest * t).cosh())
                };
                let fade = (-decay * t).exp();
                let (exact, exact_slope) = (fade * sine / rest, fade * (cosine - decay / rest * sine));
                assert!((g - exact).abs() * fastest(&one) < 5e-7, "ratio {ratio}, {part}: {g} and {exact}");
                assert!((slope - exact_slope).abs() < 2e-6, "ratio {ratio}, {part}: {slope} and {exact_slope}");
            }
        }
    }

    /// Under constant forces the integrals are powers of time: motion of the points and energy of the modes, over many
    /// rebases, are those of the closed forms.
    #[test]
    fn analytic_step_forces() {
        let modes = modes();
        let condensation = Condensation::new(&modes).unwrap();
        let force = [40.0, -15.0];
        let z = |tau: f64| -> Vec<f64> {
            let term = |k: usize| tau.powi(k as i32) / (1..=k).product::<usize>() as f64;
            (1..=ORDER).flat_map(|k| force.map(|f| f * term(k))).collect()
        };
        let mut base = Base::at_rest(&condensation);
        let exact = |t: f64| {
            let modal = |s: usize| force[0] * modes.phi[(s, 0)] + force[1] * modes.phi[(s, 1)];
            [0, 1, 2].map(|s| step_response((modes.omega_squared[s], modes.damping[s]), modal(s), t))
        };
        for rebase in 1..=40 {
            let t0 = base.time_s;
            for part in [0.3, 1.0] {
                let tau = part * condensation.horizon_s;
                let modal = exact(t0 + tau);
                for n in 0..2 {
                    let [w, v, a] = condensation.point(&base, tau, &z(tau), n);
                    let direct: f64 = (0..2).map(|m| condensation.kernel().direct(n, m) * force[m]).sum();
                    let sum = |value: &dyn Fn(usize) -> f64| (0..3).map(|s| modes.phi[(s, n)] * value(s)).sum::<f64>();
                    let (we, ve) = (sum(&|s| modal[s][0]), sum(&|s| modal[s][1]));
                    let ae = sum(&|s| {
                        let push = force[0] * modes.phi[(s, 0)] + force[1] * modes.phi[(s, 1)];
                        push - modes.damping[s] * modal[s][1] - modes.omega_squared[s] * modal[s][0]
                    });
                    assert!((w - we).abs() < 2e-12, "rebase {rebase}: {w} and {we}");
                    assert!((v - ve).abs() < 4e-9, "rebase {rebase}: {v} and {ve}");
                    assert!((a + direct - ae).abs() < 3e-5, "rebase {rebase}: {} and {ae}", a + direct);
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
        assert!((found / energy - 1.0).abs() < 1e-8, "{found} and {energy}");
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
        let [w, v, a] = floating.point(&Base::at_rest(&floating), 3.0, &z, 0);
        assert!((w - 9.0).abs() < 1e-12 && (v - 6.0).abs() < 1e-12 && a == 0.0, "{w}, {v}, {a}");
    }

    /// Few points and slow modes are condensed, many points or fast modes are integrated.
    #[test]
    fn what_pays() {
        let some = |count: usize, points: usize, fastest: f64| Modes {
            omega_squared: DVector::from_element(count, fastest * fastest),
            damping: DVector::zeros(count),
            phi: DMatrix::from_element(count, points, 0.1),
        };
        assert!(pays(&some(60, 2, 6283.0)) && pays(&some(171, 2, 18_850.0)));
        // Where both cost the same was measured: between three hammers on fixtures of their own and four.
        assert!(pays(&some(60, 6, 6283.0)) && !pays(&some(60, 8, 6283.0)));
        assert!(!pays(&some(10, 2, 300.0)) && !pays(&some(60, 16, 6283.0)) && !pays(&some(60, 2, 3e5)));
    }
}
