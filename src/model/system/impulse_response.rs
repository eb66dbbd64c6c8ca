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
//! per mode. Before the fastest mode has turned by [`TURN_RAD`] the base moves on: the modes are brought up to date, slower ones less
//! often (see `octave`), and the integrals start again at zero.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::system::kernel::{GAMMAS, Kernel, ORDER};
use crate::system::modal::Modes;
use crate::system::rebase_group::{self, WIDTH};

/// Angle by which the fastest mode may turn between rebases, rad. With ten coefficients the fastest mode's `g` errs by 1e-7 of
/// its amplitude, `g'` by 5e-7 and `g''` by 3e-6, close to critical damping by three times that; slower modes err far less. With
/// 5 rad there are fewer rebases, but ten times these errors, which blows that creep amplify beyond a preset's promise.
const TURN_RAD: f64 = 4.0;
/// Integrals of each point's force that have a scale of their own: those of its impulse and of that one's. Higher ones err by what
/// these do.
pub(super) const SCALED_INTEGRALS: usize = 2;
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
pub(super) fn rate(omega_squared: f64, damping: f64) -> f64 {
    let decay = 0.5 * damping;
    omega_squared.sqrt().max(decay + (decay * decay - omega_squared).max(0.0).sqrt())
}

/// Rates of all modes.
fn rates(modes: &Modes) -> impl Iterator<Item = f64> {
    modes.omega_squared.iter().zip(&modes.damping).map(|(omega_squared, damping)| rate(*omega_squared, *damping))
}

/// The largest of them.
fn fastest(modes: &Modes) -> f64 {
    rates(modes).fold(0.0, f64::max)
}

/// The Chebyshev points of `0 < x < 1`, each with its powers from 0 on, as many as there are points: where the equation of an impulse
/// response is to hold.
#[derive(Debug)]
pub(super) struct Collocation(DMatrix<f64>);

impl Collocation {
    /// Coefficients for `gamma_1` to `gamma_count`; the equation gives all except the first.
    pub fn new(count: usize) -> Self {
        let sought = count.saturating_sub(1);
        let point = |i: usize| 0.5 - 0.5 * libm::cos((i as f64 + 0.5) * std::f64::consts::PI / sought as f64);
        Self(DMatrix::from_fn(sought, sought, |i, j| point(i).powi(j as i32)))
    }

    /// `gamma_1` to `gamma_count` of a mode, `gamma_k` in s^(1-k), for times up to the horizon `T`; zeros after them.
    ///
    /// With `g'' = sum_j a_j x^j`, `x = tau / T`, and its integrals `g' = 1 + ...`, `g = tau + ...` the equation of `g` holds at the
    /// points: one small linear system for `T a_j`. `None` if the mode is not finite.
    pub fn impulse_response(&self, omega_squared: f64, damping: f64, horizon_s: f64) -> Option<[f64; GAMMAS]> {
        let mut gamma = [0.0; GAMMAS];
        gamma[0] = 1.0;
        if omega_squared == 0.0 && damping == 0.0 {
            // Floats, however far the horizon.
            return Some(gamma);
        }
        let sought = self.0.nrows();
        let x = |i: usize| self.0.get((i, 1)).copied().unwrap_or(0.5);
        let (by_velocity, by_displacement) = (damping * horizon_s, omega_squared * horizon_s * horizon_s);
        let matrix = DMatrix::from_fn(sought, sought, |i, j| {
            let (x, power, j) = (x(i), self.0[(i, j)], j as f64);
            power * (1.0 + x / (j + 1.0) * (by_velocity + by_displacement * x / (j + 2.0)))
        });
        let load = DVector::from_fn(sought, |i, _| -by_velocity - by_displacement * x(i));
        let solution = matrix.lu().solve(&load)?;
        let mut factor = 1.0 / horizon_s;
        for (j, value) in solution.iter().enumerate() {
            gamma[j + 1] = value * factor;
            factor *= (j + 1) as f64 / horizon_s;
        }
        gamma.iter().all(|gamma| gamma.is_finite()).then_some(gamma)
    }
}

/// Constants of the condensation.
#[derive(Debug, Clone)]
pub(super) struct Condensation {
    /// Longest time from one rebase to the next, s.
    pub horizon_s: f64,
    /// Largest magnitude of an eigenvalue of a mode, rad/s.
    pub fastest_rad_s: f64,
    points: usize,
    /// The modes in groups, the fastest first; all except the last are of whole blocks.
    pub groups: Vec<Group>,
    /// The modes, several together; those that fill the last block up are zero.
    pub blocks: Vec<ModeBlock>,
    /// Shapes of each block at each point, the index of the point fastest.
    pub shapes: Vec<Lanes>,
    /// The same by modes, those of a mode at all points one after the other, and what the series of its free motion is made of.
    pub shapes_by_mode: Vec<f64>,
    pub series: Vec<Series>,
    /// `omega^2` of the modes.
    pub stiffness: Vec<f64>,
    /// Indices among the given modes.
    pub numbers: Vec<usize>,
    kernel: Kernel<f64>,
}

/// Modes that are brought to the base's time together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub blocks: Range<usize>,
    pub modes: Range<usize>,
    /// Age from which on they do not last until the next rebase of all, s.
    pub patience_s: f64,
    /// `Gamma_k[n, m]` of the modes, by `k`, then `m`, then `n`.
    pub kernel: Vec<f64>,
}

/// Some modes: `omega^2`, `2 xi omega` and `gamma_1` to `gamma_GAMMAS`.
#[derive(Debug, Clone, Copy)]
pub(super) struct ModeBlock {
    pub stiffness: Lanes,
    pub damping: Lanes,
    pub gamma: [Lanes; GAMMAS],
}

/// A mode of a group: its index in the structure, and its impulse response over the group's horizon.
struct Member {
    mode: usize,
    gamma: [f64; GAMMAS],
}

impl Condensation {
    /// Condenses modes; `None`, and they are integrated, for a structure without modes or with one that is not finite.
    pub fn new(modes: &Modes) -> Option<Self> {
        if modes.omega_squared.is_empty() {
            return None;
        }
        let points = modes.phi.ncols();
        // Infinite for a structure that only floats.
        let fastest_rad_s = fastest(modes);
        let mut condensation = Self {
            horizon_s: TURN_RAD / fastest_rad_s,
            fastest_rad_s,
            points,
            groups: Vec::new(),
            blocks: Vec::new(),
            shapes: Vec::new(),
            shapes_by_mode: Vec::new(),
            series: Vec::new(),
            stiffness: Vec::new(),
            numbers: Vec::new(),
            kernel: Kernel { points, entries: vec![0.0; ORDER * points * points] },
        };
        let rate: Vec<f64> = rates(modes).collect();
        let mut falling: Vec<usize> = (0..rate.len()).collect();
        falling.sort_by(|a, b| rate[*b].total_cmp(&rate[*a]));
        let rate: Vec<f64> = falling.iter().map(|mode| rate[*mode]).collect();
        let collocation = Collocation::new(GAMMAS);
        for group in rebase_group::groups(&rate, condensation.horizon_s, points) {
            let horizon_s = group.factor * condensation.horizon_s;
            let member = |mode: &usize| -> Option<Member> {
                let gamma =
                    collocation.impulse_response(modes.omega_squared[*mode], modes.damping[*mode], horizon_s)?;
                Some(Member { mode: *mode, gamma })
            };
            let members = falling[group.modes].iter().map(member).collect::<Option<Vec<Member>>>()?;
            condensation.add(modes, &members, group.factor);
        }
        Some(condensation)
    }

    /// Adds a group of modes that lasts `factor` horizons.
    fn add(&mut self, modes: &Modes, members: &[Member], factor: f64) {
        let points = self.points;
        let mut kernel = Vec::with_capacity(GAMMAS * points * points);
        let shape = DMatrix::from_fn(members.len(), points, |s, n| modes.phi[(members[s].mode, n)]);
        for k in 0..GAMMAS {
            let weighted = DMatrix::from_fn(members.len(), points, |s, n| members[s].gamma[k] * shape[(s, n)]);
            kernel.extend_from_slice(shape.tr_mul(&weighted).as_slice());
        }
        for (at, gamma) in kernel.iter().enumerate() {
            let (k, m, n) = (at / (points * points), at / points % points, at % points);
            self.kernel.entries[(n * ORDER + k) * points + m] += gamma;
        }
        let first = self.blocks.len();
        for members in members.chunks(WIDTH) {
            let padded = |value: &dyn Fn(&Member) -> f64| -> Lanes {
                std::array::from_fn(|lane| members.get(lane).map_or(0.0, value))
            };
            self.blocks.push(ModeBlock {
                stiffness: padded(&|member| modes.omega_squared[member.mode]),
                damping: padded(&|member| modes.damping[member.mode]),
                gamma: std::array::from_fn(|k| padded(&|member| member.gamma[k])),
            });
            self.shapes.extend((0..points).map(|point| padded(&|member| modes.phi[(member.mode, point)])));
            for member in members {
                let mut series = [0.0; ORDER + 2];
                series[2..2 + GAMMAS].copy_from_slice(&member.gamma);
                self.series.push(series);
                self.stiffness.push(modes.omega_squared[member.mode]);
                self.numbers.push(member.mode);
                self.shapes_by_mode.extend((0..points).map(|point| modes.phi[(member.mode, point)]));
            }
        }
        self.groups.push(Group {
            blocks: first..self.blocks.len(),
            modes: first * WIDTH..first * WIDTH + members.len(),
            // Not by a product: the horizon may be infinite.
            patience_s: if factor > 1.0 { (factor - 1.0) * self.horizon_s } else { 0.0 },
            kernel,
        });
    }

    /// Number of states: the integrals `z_1` of all points, then `z_2`, and so on.
    pub fn states(&self) -> usize {
        ORDER * self.points
    }

    /// Number of interface points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Kernel of the motion of the points.
    pub fn kernel(&self) -> &Kernel<f64> {
        &self.kernel
    }

    /// Scale of the first integral at a point whose velocity has scale 1, infinite for a point that cannot move.
    pub fn force_scale(&self, point: usize) -> f64 {
        let largest = (0..self.points).map(|n| self.kernel.direct(n, point).abs()).fold(0.0, f64::max);
        1.0 / largest
    }
}

/// One number of each mode of a block.
pub(super) type Lanes = [f64; WIDTH];
/// Of one mode: 0, 0, then `gamma_1` to `gamma_GAMMAS`, then 0: read from its second entry on what an impulse makes of the free
/// displacement, by powers of the time, and read from its first what a constant force does.
pub(super) type Series = [f64; ORDER + 2];

#[cfg(test)]
mod tests {
    use super::*;

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
            let gamma = Collocation::new(GAMMAS).impulse_response(omega * omega, 2.0 * decay, horizon_s).unwrap();
            for part in 0..=50_u32 {
                let t = horizon_s * f64::from(part) / 50.0;
                let terms: Vec<f64> = (0..=ORDER)
                    .scan(1.0, |term, k| Some(std::mem::replace(term, *term * t / (k + 1) as f64)))
                    .collect();
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
