//! Functions of the matrix of bodies joined by linear springs and dampers, for exponential steps.
//!
//! With `u = [x, v]` and `L = [[0, I], [-K, -C]]` a step needs products with `phi_0(z) = e^z`,
//! `phi_{k+1}(z) = (phi_k(z) - I / k!) / z` at multiples `z` of `h L`. They come from the series of `phi_4` at a small
//! argument and its recurrence, and from there by doubling,
//! `2^k phi_k(2 z) = phi_0(z) phi_k(z) + sum_{j=1..k} phi_j(z) / (k - j)!`. Steps are those of a ladder, so that the same
//! matrices serve again and again.

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

use crate::integrate::tsit5::C;

/// Most bodies that are joined: cylinder, spool, chisel and casting of one hammer. Sizes known to the compiler make the
/// products cheap; a scene with more bodies in contact at once seldom rests.
pub(super) const BODIES: usize = 4;
/// Positions and velocities of that many bodies; those that are fewer leave rows and columns of zeros.
pub(super) const STATES: usize = 2 * BODIES;
/// Nodes at which matrices are needed: those of stages 2 to 6.
pub(super) const NODES: usize = 5;
/// Rungs of the ladder of steps.
const RUNGS: usize = 8;
/// Rungs per doubling of the step.
const PER_DOUBLING: f64 = 2.0;
/// `h lambda` of the first rung, with the fastest circular frequency `lambda`: above what an explicit step can do.
const FIRST: f64 = 3.5;
/// Norm of the argument at which the series is summed.
const SMALL: f64 = 0.5;
/// Terms of the series of `phi_4`: the first one left out is below 1e-16.
const TERMS: usize = 11;

pub(super) type Vector = [f64; STATES];
/// Positions alone.
pub(super) type Positions = [f64; BODIES];
/// A square matrix by columns.
type Square = [Vector; STATES];
/// Columns that meet accelerations only.
pub(super) type Half = [Vector; BODIES];

/// Matrices of one step.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    filled: bool,
    /// `c h phi_1(c h L)` of each node `c`.
    pub first: [Square; NODES],
    /// `2 h phi_2(c h L)` of each node.
    pub second: [Half; NODES],
    /// `2 h phi_3(h L)`.
    pub third: Half,
    /// The integral over the step: what belongs to positions of `h^2 phi_2(h L)`, of `h^2 phi_3`, and of `2 h^2 phi_4`.
    pub integral: ([Positions; STATES], [[Positions; BODIES]; 2]),
}

/// The linear part in one discrete state, reduced to the bodies that it acts on.
#[derive(Debug, Clone, Default)]
pub(super) struct Linear {
    /// The bodies, as many as there are.
    pub active: [usize; BODIES],
    pub count: usize,
    /// `K` and `C` of these bodies, by columns.
    pub stiffness: [[f64; BODIES]; BODIES],
    pub damping: [[f64; BODIES]; BODIES],
    /// A bound of the fastest circular frequency, rad/s; 0 if nothing is joined or too many bodies are.
    pub fastest_rad_s: f64,
    tables: [Table; RUNGS],
}

impl Linear {
    /// Takes over the matrices of a discrete state.
    pub fn assign(&mut self, stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) {
        self.tables.iter_mut().for_each(|table| table.filled = false);
        (self.count, self.fastest_rad_s) = (0, 0.0);
        for body in (0..stiffness.nrows()).filter(|&body| stiffness[(body, body)] > 0.0) {
            if self.count == BODIES {
                (self.count, self.fastest_rad_s) = (0, 0.0);
                return;
            }
            self.active[self.count] = body;
            self.count += 1;
        }
        let active = &self.active[..self.count];
        (self.stiffness, self.damping) = ([[0.0; BODIES]; BODIES], [[0.0; BODIES]; BODIES]);
        for (j, &column) in active.iter().enumerate() {
            for (i, &row) in active.iter().enumerate() {
                self.stiffness[j][i] = stiffness[(row, column)];
                self.damping[j][i] = damping[(row, column)];
            }
        }
        // No eigenvalue of K exceeds the largest sum of a row.
        let sum = |i: usize| self.stiffness.iter().map(|column| column[i].abs()).sum::<f64>();
        self.fastest_rad_s = (0..self.count).map(sum).fold(0.0, f64::max).sqrt();
    }

    /// Length of the step on a rung, s.
    pub fn step_s(&self, rung: usize) -> f64 {
        FIRST * (rung as f64 / PER_DOUBLING).exp2() / self.fastest_rad_s
    }

    /// The highest rung whose step is at most `h`; `None` below the ladder.
    pub fn rung(&self, h: f64) -> Option<usize> {
        (0..RUNGS).rev().find(|rung| self.step_s(*rung) <= h)
    }

    /// Matrices of a rung that was prepared.
    #[inline(always)]
    pub fn table(&self, rung: usize) -> &Table {
        &self.tables[rung]
    }

    /// Computes the matrices of a rung unless they are known.
    pub fn prepare(&mut self, rung: usize) {
        if !self.tables[rung].filled {
            Arch::new().dispatch(Preparation { linear: self, rung });
        }
    }
}

/// A table to be computed.
struct Preparation<'p> {
    linear: &'p mut Linear,
    rung: usize,
}

impl WithSimd for Preparation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { linear, rung } = self;
        let h = linear.step_s(rung);
        for node in 0..NODES {
            let c = C[node + 1];
            let [_, first, second, third, fourth] = functions(linear, c * h);
            let table = &mut linear.tables[rung];
            let half = |phi: &Square| -> Half { std::array::from_fn(|j| phi[BODIES + j].map(|x| 2.0 * h * x)) };
            table.first[node] = first.map(|column| column.map(|x| c * h * x));
            table.second[node] = half(&second);
            // The last node is the end of the step.
            table.third = half(&third);
            let positions = |factor: f64, column: &Vector| std::array::from_fn(|i| factor * h * h * column[i]);
            let accelerations =
                |factor: f64, phi: &Square| std::array::from_fn(|j| positions(factor, &phi[BODIES + j]));
            table.integral = (
                std::array::from_fn(|j| positions(1.0, &second[j])),
                [accelerations(1.0, &third), accelerations(2.0, &fourth)],
            );
        }
        linear.tables[rung].filled = true;
    }
}

/// `phi_0` to `phi_4` at `s L`.
#[inline(always)]
fn functions(linear: &Linear, s: f64) -> [Square; 5] {
    // Positions in units of velocity / fastest frequency: all entries are of one size.
    let scale = linear.fastest_rad_s;
    let mut argument = [[0.0; STATES]; STATES];
    for j in 0..linear.count {
        argument[BODIES + j][j] = scale;
        for i in 0..linear.count {
            argument[j][BODIES + i] = -linear.stiffness[j][i] / scale;
            argument[BODIES + j][BODIES + i] = -linear.damping[j][i];
        }
    }
    let row_sum = |i: usize| argument.iter().map(|column| column[i].abs()).sum::<f64>();
    let norm = (0..STATES).map(row_sum).fold(0.0, f64::max);
    let halvings = (norm * s / SMALL).log2().ceil().max(0.0);
    let z = s * (-halvings).exp2();
    let mut phi = series(&argument.map(|column| column.map(|x| z * x)));
    for _ in 0..halvings as u32 {
        phi = doubled(&phi);
    }
    for j in 0..BODIES {
        for i in 0..BODIES {
            for phi in &mut phi {
                phi[BODIES + j][i] /= scale;
                phi[j][BODIES + i] *= scale;
            }
        }
    }
    phi
}

/// `phi_4 = sum z^k / (k + 4)!` by Horner's scheme, then `phi_k = z phi_{k+1} + I / k!`.
#[inline(always)]
fn series(z: &Square) -> [Square; 5] {
    let mut inverse_factorial = 1.0 / (1..=TERMS + 3).map(|k| k as f64).product::<f64>();
    let mut fourth = [[0.0; STATES]; STATES];
    add_identity(&mut fourth, inverse_factorial);
    for k in (4..TERMS + 3).rev() {
        inverse_factorial *= (k + 1) as f64;
        fourth = product(z, &fourth);
        add_identity(&mut fourth, inverse_factorial);
    }
    let lower = |above: &Square, inverse_factorial: f64| {
        let mut phi = product(z, above);
        add_identity(&mut phi, inverse_factorial);
        phi
    };
    let third = lower(&fourth, 1.0 / 6.0);
    let second = lower(&third, 0.5);
    let first = lower(&second, 1.0);
    [lower(&first, 1.0), first, second, third, fourth]
}

/// From the functions at `z` to those at `2 z`.
#[inline(always)]
fn doubled(phi: &[Square; 5]) -> [Square; 5] {
    let mut next = [0, 1, 2, 3, 4].map(|k| product(&phi[0], &phi[k]));
    let [_, first, second, third, fourth] = phi;
    for j in 0..STATES {
        for i in 0..STATES {
            let [one, two, three, four] = [first[j][i], second[j][i], third[j][i], fourth[j][i]];
            next[1][j][i] = 0.5 * (next[1][j][i] + one);
            next[2][j][i] = 0.25 * (next[2][j][i] + one + two);
            next[3][j][i] = 0.125 * (next[3][j][i] + 0.5 * one + two + three);
            next[4][j][i] = 0.0625 * (next[4][j][i] + one / 6.0 + 0.5 * two + three + four);
        }
    }
    next
}

#[inline(always)]
fn add_identity(matrix: &mut Square, factor: f64) {
    for (i, column) in matrix.iter_mut().enumerate() {
        column[i] += factor;
    }
}

#[inline(always)]
fn product(a: &Square, b: &Square) -> Square {
    let mut out = [[0.0; STATES]; STATES];
    for (out, b) in out.iter_mut().zip(b) {
        add_product(a, b, out);
    }
    out
}

/// `out += a x` for a matrix by columns.
#[inline(always)]
pub(super) fn add_product<const ROWS: usize, const COLUMNS: usize>(
    a: &[[f64; ROWS]; COLUMNS],
    x: &[f64; COLUMNS],
    out: &mut [f64; ROWS],
) {
    for (column, x) in a.iter().zip(x) {
        for i in 0..ROWS {
            out[i] += column[i] * x;
        }
    }
}

/// `phi_1` to `phi_3` of a number that is not positive.
pub(super) fn scalar_phi(z: f64) -> [f64; 3] {
    // Close to zero the recurrence cancels: there the series of phi_3, and the recurrence backwards.
    if z > -1.0 {
        let mut third = 0.0;
        for k in (3..18).rev() {
            third = (third * z + 1.0) / f64::from(k);
        }
        third *= 0.5;
        let second = z * third + 0.5;
        return [z * second + 1.0, second, third];
    }
    let first = z.exp_m1() / z;
    let second = (first - 1.0) / z;
    [first, second, (second - 0.5) / z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `e^x` and its relatives of a number from their definition.
    #[test]
    fn analytic_functions_of_a_number() {
        for z in [-1e-9, -0.3, -0.999, -1.001, -4.0, -30.0] {
            let z: f64 = z;
            let [first, second, third] = scalar_phi(z);
            // e^z = 1 + z + z^2/2 + z^3 phi_3, and so on: what the functions give back.
            for value in [1.0 + z * first, 1.0 + z + z * z * second, 1.0 + z + 0.5 * z * z + z * z * z * third] {
                assert!((value - z.exp()).abs() < 1e-14 * (1.0 + z * z), "{z}: {value} and {}", z.exp());
            }
            assert!((scalar_phi(z)[2] - 1.0 / 6.0).abs() < 0.05 * z.abs().max(1e-8));
        }
    }

    /// Two bodies, one free in between: the matrices solve `u' = L u + g theta^m` as a fine classical integration does.
    #[test]
    fn analytic_functions_solve_the_linear_equation() {
        let mut stiffness = DMatrix::zeros(3, 3);
        let mut damping = DMatrix::zeros(3, 3);
        for (i, j, k, c) in [(0, 0, 3e8, 500.0), (0, 2, -2e8, -300.0), (2, 0, -5e8, -900.0), (2, 2, 6e8, 4000.0)] {
            stiffness[(i, j)] = k;
            damping[(i, j)] = c;
        }
        let mut linear = Linear::default();
        linear.assign(&stiffness, &damping);
        assert_eq!((linear.count, linear.active), (2, [0, 2, 0, 0]));
        assert!((linear.fastest_rad_s - 1.1e9f64.sqrt()).abs() < 1e-6);
        let rung = linear.rung(2e-4).unwrap();
        let h = linear.step_s(rung);
        assert!(h <= 2e-4 && linear.step_s(rung + 1) > 2e-4);
        linear.prepare(rung);
        let table = linear.table(rung);
        let force = [700.0, -300.0];
        // From rest at velocity (0.2, -0.1): the rate at the start is F = (v, L u + g) with g constant, then growing.
        for (power, matrices) in [(0, None), (1, Some(&table.second[NODES - 1])), (2, Some(&table.third))] {
            let rate = |t: f64, u: [f64; 4]| {
                let theta = (t / h).powi(power);
                let a = |i: usize| {
                    let row = [0, 2][i];
                    force[i] * theta
                        - (stiffness[(row, 0)] * u[0] + stiffness[(row, 2)] * u[1])
                        - (damping[(row, 0)] * u[2] + damping[(row, 2)] * u[3])
                };
                [u[2], u[3], a(0), a(1)]
            };
            let (mut u, mut integral, steps) = ([0.0, 0.0, 0.2, -0.1], [0.0; 2], 20_000);
            let d = h / f64::from(steps);
            let along = |u: [f64; 4], k: [f64; 4], s: f64| -> [f64; 4] { std::array::from_fn(|i| u[i] + s * k[i]) };
            for step in 0..steps {
                let t = f64::from(step) * d;
                let k1 = rate(t, u);
                let k2 = rate(t + 0.5 * d, along(u, k1, 0.5 * d));
                let k3 = rate(t + 0.5 * d, along(u, k2, 0.5 * d));
                let k4 = rate(t + d, along(u, k3, d));
                let next: [f64; 4] = std::array::from_fn(|i| u[i] + d / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
                // Cubic between the ends: their mean, and the rates there.
                for i in 0..2 {
                    integral[i] += d * (0.5 * (u[i] + next[i]) + d / 12.0 * (u[i + 2] - next[i + 2]));
                }
                u = next;
            }
            let start = rate(0.0, [0.0, 0.0, 0.2, -0.1]);
            let mut found = [0.0; STATES];
            let placed = [start[0], start[1], 0.0, 0.0, start[2], start[3], 0.0, 0.0];
            add_product(&table.first[NODES - 1], &placed, &mut found);
            let mut area = [0.0; BODIES];
            add_product(&table.integral.0, &placed, &mut area);
            if power > 0 {
                add_product(&table.integral.1[power as usize - 1], &[force[0], force[1], 0.0, 0.0], &mut area);
            }
            for (found, expected) in area.iter().zip(integral) {
                assert!((found - expected).abs() < 1e-9 * 1e-5 * h, "{power}: {found} and {expected}");
            }
            if let Some(matrix) = matrices {
                // The table holds twice phi_2 and twice phi_3; theta^m meets m! phi_{m+1}.
                let factor = if power == 1 { 0.5 } else { 1.0 };
                add_product(matrix, &[factor * force[0], factor * force[1], 0.0, 0.0], &mut found);
            }
            found[BODIES] += 0.2;
            found[BODIES + 1] -= 0.1;
            for (i, expected) in u.iter().enumerate() {
                let at = if i < 2 { i } else { BODIES + i - 2 };
                let size = if i < 2 { 1e-5 } else { 0.2 };
                assert!((found[at] - expected).abs() < 1e-9 * size, "{power}, {i}: {} and {expected}", found[at]);
            }
        }
    }
}
