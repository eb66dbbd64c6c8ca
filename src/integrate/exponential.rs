//! The method of order 5 with the linear part of hard contacts taken exactly.
//!
//! While contacts stay closed their springs and dampers are linear, and stability bounds an explicit step by their
//! period although nothing moves that fast. For the bodies `u' = L u + N(t, y)`; with `F = L u + N` at the start,
//! `D_j = N_j - N_1` and the coefficients of the explicit method, its stages and its end become
//!
//! ```text
//! U_i = u + c_i h phi_1(c_i h L) F + 2 h phi_2(c_i h L) sum_j a_ij D_j
//! u_1 = u + h phi_1(h L) (F + E_0) + h phi_2(h L) E_1 + 2 h phi_3(h L) E_2,   E_m = sum_j q_jm D_j
//! ```
//!
//! where `sum_j (q_j0 + q_j1 theta + q_j2 theta^2) N_j` is a parabola through what `N` does over the step whose integral
//! is the explicit method's own sum. Where `L` vanishes this is the explicit method, which all other components follow
//! anyway. Integrals, `z_1' = F`, `z_{k+1}' = z_k`, and components that relax by themselves have a linear part too, with
//! functions in closed form. The error estimate is `2 h phi_2(h L) sum_j e_j D_j`.

use pulp::{Arch, Simd, WithSimd};

use crate::integrate::explicit::Correction;
use crate::integrate::phi::{BODIES, Linear, NODES, STATES as SIZE, Vector, add_product, scalar_phi};
use crate::integrate::stepper::Trial;
use crate::integrate::system::{Integrals, LinearPart, StiffBlock, StiffMatrices};
use crate::integrate::tsit5::{A, C, ERROR, STAGES};

/// Discrete states whose matrices are kept.
const KEPT: usize = 8;
/// The last stage: the end of the step.
const END: usize = STAGES - 1;

/// `q_jm` of stages 2 to 6, by powers `m`: the solution of least norm of the conditions above.
const PARABOLA: [[f64; NODES]; 3] = [
    [
        0.096_809_300_943_770_85,
        -0.131_992_396_368_606_35,
        0.706_528_284_049_285_4,
        -2.432_469_102_796_403_6,
        1.775_581_608_717_783_6,
    ],
    [
        0.466_204_073_004_803_3,
        3.665_492_502_830_949,
        1.828_276_145_714_409_8,
        -1.746_462_081_321_675_4,
        -0.207_545_989_405_969_83,
    ],
    [
        -0.959_734_012_338_516_9,
        -3.662_592_613_897_106_6,
        -0.724_973_348_408_249,
        0.046_891_884_063_484_06,
        1.958_705_730_254_930_4,
    ],
];

/// What is kept of one discrete state.
#[derive(Debug, Clone)]
struct Kept {
    state: Option<u64>,
    linear: Linear,
    matrices: StiffMatrices,
}

/// Memory of the exponential steps of one integration.
#[derive(Debug)]
pub(super) struct Exponential {
    block: StiffBlock,
    /// Matrices by discrete state, and which are in use.
    kept: Vec<Kept>,
    present: usize,
    /// Entry of `kept` that is given up next.
    oldest: usize,
    rung: usize,
    h: f64,
    /// Rates of the active bodies at the start: `[v, a]`.
    first: Vector,
    /// `D` of stages 2 to 7: accelerations of the active bodies.
    differences: [[f64; BODIES]; END],
    /// Change of positions and velocities of the active bodies from the start to stages 2 to 7.
    changes: [Vector; END],
    /// Components that relax during the step.
    relaxing: Vec<Relaxing>,
    rates: Vec<f64>,
    /// Whether the integrals are anything but zero at the start.
    integrals_passed: bool,
    /// `1 / k`, as far as the chain of integrals asks for it; infinite for 0.
    inverses: Vec<f64>,
}

/// A component that relaxes by itself at `rate_per_s`.
#[derive(Debug, Clone, Copy)]
struct Relaxing {
    index: usize,
    rate_per_s: f64,
    /// `c phi_1`, `2 phi_2`, `2 phi_3` at each node.
    phi: [[f64; 3]; NODES],
    /// `D` of stages 2 to 7.
    differences: [f64; END],
}

/// `sum_j w_j D_j`.
#[inline(always)]
fn weighted(weights: &[f64], differences: &[f64]) -> f64 {
    weights.iter().zip(differences).map(|(weight, d)| weight * d).sum()
}

impl Exponential {
    pub fn new(block: StiffBlock) -> Self {
        let matrices = StiffMatrices::zeros(&block);
        Self {
            kept: vec![Kept { state: None, linear: Linear::default(), matrices }; KEPT],
            present: 0,
            oldest: 0,
            rung: 0,
            h: 0.0,
            first: [0.0; SIZE],
            differences: [[0.0; BODIES]; END],
            changes: [[0.0; SIZE]; END],
            relaxing: Vec::with_capacity(block.relaxing.len()),
            rates: vec![0.0; block.relaxing.len()],
            integrals_passed: false,
            inverses: (0..=block.integrals.depth + 2).map(|k| 1.0 / k as f64).collect(),
            block,
        }
    }

    /// The linear part of the system's present discrete state.
    pub fn select<S: LinearPart>(&mut self, system: &mut S) -> &Linear {
        let state = system.discrete_state();
        if self.kept[self.present].state != Some(state) {
            self.present = self.kept.iter().position(|kept| kept.state == Some(state)).unwrap_or_else(|| {
                let at = self.oldest;
                self.oldest = (at + 1) % KEPT;
                let kept = &mut self.kept[at];
                system.stiff_matrices(&mut kept.matrices);
                kept.state = Some(state);
                kept.linear.assign(&kept.matrices.stiffness, &kept.matrices.damping);
                at
            });
        }
        self.linear()
    }

    #[inline(always)]
    fn linear(&self) -> &Linear {
        &self.kept[self.present].linear
    }

    /// Begins a step on a rung of the linear part selected last.
    pub fn begin<S: LinearPart>(&mut self, system: &S, rung: usize, trial: &Trial<'_>) {
        let (y, rate) = (trial.y, trial.rate());
        let linear = &mut self.kept[self.present].linear;
        linear.prepare(rung);
        (self.rung, self.h) = (rung, linear.step_s(rung));
        self.first = [0.0; SIZE];
        for (i, body) in linear.active[..linear.count].iter().enumerate() {
            self.first[i] = rate[self.block.positions + body];
            self.first[BODIES + i] = rate[self.block.velocities + body];
        }
        system.relaxation(trial.t, y, &mut self.rates);
        self.relaxing.clear();
        for (at, &rate_per_s) in self.rates.iter().enumerate().filter(|(_, rate)| **rate > 0.0) {
            let phi = std::array::from_fn(|node| {
                let [first, second, third] = scalar_phi(-C[node + 1] * self.h * rate_per_s);
                [C[node + 1] * first, 2.0 * second, 2.0 * third]
            });
            let index = self.block.relaxing.start + at;
            self.relaxing.push(Relaxing { index, rate_per_s, phi, differences: [0.0; END] });
        }
        self.integrals_passed = y[self.block.integrals.range()].iter().any(|z| *z != 0.0);
    }

    /// `sum_j w_j D_j` of the bodies.
    #[inline(always)]
    fn combined(&self, weights: &[f64]) -> [f64; BODIES] {
        let mut sum = [0.0; BODIES];
        for (weight, d) in weights.iter().zip(&self.differences) {
            for i in 0..BODIES {
                sum[i] += weight * d[i];
            }
        }
        sum
    }

    /// `F + E_0`, `E_1` and `E_2` of the bodies.
    #[inline(always)]
    fn parabola(&self) -> (Vector, [[f64; BODIES]; 2]) {
        let [e0, e1, e2] = [0, 1, 2].map(|power| self.combined(&PARABOLA[power]));
        let mut first = self.first;
        for i in 0..BODIES {
            first[BODIES + i] += e0[i];
        }
        (first, [e1, e2])
    }

    #[inline(always)]
    fn correct_bodies(&self, k: usize, y: &[f64], out: &mut [f64]) {
        let linear = self.linear();
        let (table, node) = (linear.table(self.rung), k.min(NODES) - 1);
        let mut change = [0.0; SIZE];
        if k == END {
            let (first, powers) = self.parabola();
            add_product(&table.first[node], &first, &mut change);
            add_product(&table.second[node], &powers[0].map(|e| 0.5 * e), &mut change);
            add_product(&table.third, &powers[1], &mut change);
            self.correct_impulses((&first, &powers), &change, out);
        } else {
            add_product(&table.first[node], &self.first, &mut change);
            add_product(&table.second[node], &self.combined(&A[k][1..k]), &mut change);
        }
        let (x, v) = (self.block.positions, self.block.velocities);
        for (i, body) in linear.active[..linear.count].iter().enumerate() {
            out[x + body] = y[x + body] + change[i];
            out[v + body] = y[v + body] + change[BODIES + i];
        }
    }

    #[inline(always)]
    fn correct_relaxing(&self, k: usize, y: &[f64], rates: &[f64], out: &mut [f64]) {
        for component in &self.relaxing {
            let (i, d) = (component.index, &component.differences);
            let [first, second, third] = component.phi[k.min(NODES) - 1];
            let rate = if k == END {
                let [e0, e1, e2] = [0, 1, 2].map(|power| weighted(&PARABOLA[power], d));
                first * (rates[i] + e0) + 0.5 * second * e1 + third * e2
            } else {
                first * rates[i] + second * weighted(&A[k][1..k], d)
            };
            out[i] = y[i] + self.h * rate;
        }
    }

    /// Component `k` of `phi_j(s S) e_1` is `s^(k - 1) / (k - 1 + j)!`, with the matrix `S` of the chain of integrals.
    #[inline(always)]
    fn correct_integrals(&self, k: usize, y: &[f64], rates: &[f64], out: &mut [f64]) {
        let Integrals { from, width, depth } = self.block.integrals;
        let (n, c) = (y.len(), C[k]);
        let (s, inverses) = (c * self.h, &self.inverses);
        for point in from..from + width {
            let first = rates[point];
            let differences: [f64; NODES] =
                std::array::from_fn(|j| if j + 1 < k.min(END) { rates[(j + 1) * n + point] - first } else { 0.0 });
            let (constant, linear, square) = if k == END {
                let [e0, e1, e2] = [0, 1, 2].map(|power| weighted(&PARABOLA[power], &differences));
                (first + e0, e1, 2.0 * e2)
            } else {
                (first, 2.0 * weighted(&A[k][1..k], &differences) / c, 0.0)
            };
            let mut coefficient = 1.0;
            for order in 1..=depth {
                coefficient *= s * inverses[order];
                let rest = linear + inverses[order + 2] * square;
                out[point + (order - 1) * width] = coefficient * (constant + inverses[order + 1] * rest);
            }
        }
        if !self.integrals_passed {
            return;
        }
        // What the integrals were passes on to those of higher order.
        let (z, out) = (&y[self.block.integrals.range()], &mut out[self.block.integrals.range()]);
        let mut passed = 1.0;
        for order in 0..depth {
            for (out, z) in out[order * width..].iter_mut().zip(z) {
                *out += passed * z;
            }
            passed *= s * inverses[order + 1];
        }
    }

    /// Makes the first integrals at the end what the bodies have felt of the same forces: the sum over the stages takes the
    /// linear part of the forces, `R u`, for smooth, here it is taken along the bodies' own motion. So momentum is conserved.
    #[inline(always)]
    fn correct_impulses(&self, (first, powers): (&Vector, &[[f64; BODIES]; 2]), change: &Vector, out: &mut [f64]) {
        let Kept { linear, matrices, .. } = &self.kept[self.present];
        let (constant, others) = &linear.table(self.rung).integral;
        let mut area = [0.0; BODIES];
        add_product(constant, first, &mut area);
        for (matrix, e) in others.iter().zip(powers) {
            add_product(matrix, e, &mut area);
        }
        let Integrals { from, width, .. } = self.block.integrals;
        for (i, body) in linear.active[..linear.count].iter().enumerate() {
            let stages = |at: usize| -> f64 {
                A[END][1..].iter().zip(&self.changes).map(|(weight, change)| weight * change[at]).sum()
            };
            let position = area[i] - self.h * stages(i);
            // What the bodies moved, less what the stages' velocities make of it.
            let velocity = change[i] - self.h * (self.first[i] + stages(BODIES + i));
            for point in 0..width {
                out[from + point] += matrices.integrated_stiffness[(point, *body)] * position
                    + matrices.integrated_damping[(point, *body)] * velocity;
            }
        }
    }

    /// Largest error estimate of bodies and relaxing components in units of the scales. For the other components `masked`
    /// gets the inverse scales with zeros for these.
    pub fn error(&self, inverse_scales: &[f64], masked: &mut [f64]) -> f64 {
        masked.copy_from_slice(inverse_scales);
        let mut largest = 0.0_f64;
        let mut take = |index: usize, estimate: f64| {
            largest = largest.max((estimate * inverse_scales[index]).abs());
            masked[index] = 0.0;
        };
        for component in &self.relaxing {
            let sum = weighted(&ERROR[1..], &component.differences);
            take(component.index, self.h * component.phi[NODES - 1][1] * sum);
        }
        let linear = self.linear();
        let mut change = [0.0; SIZE];
        add_product(&linear.table(self.rung).second[NODES - 1], &self.combined(&ERROR[1..]), &mut change);
        for (i, body) in linear.active[..linear.count].iter().enumerate() {
            take(self.block.positions + body, change[i]);
            take(self.block.velocities + body, change[BODIES + i]);
        }
        largest
    }
}

impl Correction for Exponential {
    fn correct(&mut self, k: usize, y: &[f64], rates: &[f64], out: &mut [f64]) {
        Arch::new().dispatch(Corrected { method: self, k, y, rates, out });
    }

    /// Takes note of `D = f - f_1 - L (U - u)`.
    fn observe(&mut self, k: usize, y: &[f64], state: &[f64], rates: &[f64]) {
        let (first, rate) = (&rates[..y.len()], &rates[k * y.len()..]);
        let linear = &self.kept[self.present].linear;
        let (x, v) = (self.block.positions, self.block.velocities);
        let mut d = [0.0; BODIES];
        for (j, body) in linear.active[..linear.count].iter().enumerate() {
            let (dx, dv) = (state[x + body] - y[x + body], state[v + body] - y[v + body]);
            (self.changes[k - 1][j], self.changes[k - 1][BODIES + j]) = (dx, dv);
            d[j] += rate[v + body] - self.first[BODIES + j];
            let columns = linear.stiffness[j].iter().zip(&linear.damping[j]);
            for (d, (stiffness, damping)) in d.iter_mut().zip(columns) {
                *d += stiffness * dx + damping * dv;
            }
        }
        self.differences[k - 1] = d;
        for component in &mut self.relaxing {
            let i = component.index;
            component.differences[k - 1] = rate[i] - first[i] + component.rate_per_s * (state[i] - y[i]);
        }
    }
}

/// A stage to be corrected.
struct Corrected<'c> {
    method: &'c mut Exponential,
    k: usize,
    y: &'c [f64],
    rates: &'c [f64],
    out: &'c mut [f64],
}

impl WithSimd for Corrected<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { method, k, y, rates, out } = self;
        method.correct_relaxing(k, y, rates, out);
        method.correct_integrals(k, y, rates, out);
        // Adds the bodies' impulses to the integrals.
        method.correct_bodies(k, y, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parabola gives back every parabola, and its integral is the explicit method's sum.
    #[test]
    fn analytic_conditions_of_the_parabola() {
        // A constant has no differences to stage 1: it is kept whatever the weights.
        for power in 1..3_i32 {
            for (m, weights) in PARABOLA.iter().enumerate() {
                let sum: f64 = weights.iter().zip(&C[1..]).map(|(q, c)| q * c.powi(power)).sum();
                let expected = f64::from(u8::from(m as i32 == power));
                assert!((sum - expected).abs() < 1e-13, "power {power}, coefficient {m}: {sum}");
            }
        }
        for j in 0..NODES {
            let integral = PARABOLA[0][j] + PARABOLA[1][j] / 2.0 + PARABOLA[2][j] / 3.0;
            assert!((integral - A[END][j + 1]).abs() < 1e-13, "stage {}: {integral}", j + 2);
        }
    }
}
