//! Dissipation of condensed modes, `int sum 2 xi omega x'^2 dt`, from their velocities and damping alone.
//!
//! The velocities of condensed modes are not states. They are followed separately, from node to node at the middles of equal intervals `h`.
//! For an oscillation that is read more than once per period, equal weights give the mean exactly. The remaining error comes from the ends
//! of the run, where the modes hardly move. With the repeated integrals `z` of the forces since the last node, which `moments` carries,
//!
//! ```text
//! [x, x'] <- exp(A h) [x, x'] + sum_m phi_m sum_k gamma_k [z_{k+1, m}, z_{k, m}]
//! ```
//!
//! where `g = sum_k gamma_k tau^k / k!` is the mode's impulse response over one interval. Over so short a time few coefficients are enough:
//! as many as the fastest mode of a block needs.

use std::sync::Arc;

use crate::system::impulse_response::{self, Collocation, Condensation, Lanes, rate};
use crate::system::kernel::{GAMMAS, for_points};
use crate::system::rebase_group::{WIDTH, scaled_powers, splat};
use crate::system::register_pair::{fused, pair, product, put_pair, unrolled};
use decore_math::number::{Number, OverArrays, in_widest};

/// Longest time between two nodes in s: the duration of an impact, which changes the modes' velocities.
const LONGEST_INTERVAL_S: f64 = 1.25e-4;
/// Angle by which the fastest mode turns between two nodes at most, rad: its squared velocity by less than a whole period.
const INTERVAL_RAD: f64 = 3.0;
/// Permitted error of the impulse responses, as a share of their amplitudes.
const IMPULSE_RESPONSE_ERROR: f64 = 2e-7;
/// Number of past nodes with known power: as many as there are in a step.
const REMEMBERED: usize = 8;

/// Constants of the dissipation.
#[derive(Debug)]
pub(super) struct Damping {
    condensation: Arc<Condensation>,
    /// Time between two nodes, s.
    pub interval_s: f64,
    blocks: Vec<CondensedBlock>,
}

/// Modes of a block of the condensation over one interval.
#[derive(Debug)]
struct CondensedBlock {
    /// `exp(A h)`, row by row.
    propagator: [Lanes; 4],
    /// `gamma_1` on, as many as the fastest mode needs.
    gamma: Vec<Lanes>,
}

/// Time between two nodes for a run of `duration_s`, s.
pub(super) fn interval_s(condensation: &Condensation, duration_s: f64) -> f64 {
    let longest_s = (INTERVAL_RAD / condensation.fastest_rad_s).min(LONGEST_INTERVAL_S);
    let count = (duration_s / longest_s).ceil().max(1.0);
    // A duration that no budget lets end may have more intervals than there are numbers.
    if count.is_finite() { duration_s / count } else { longest_s }
}

/// Coefficients that the impulse response of a mode needs which turns by an angle, rad: `count` of them at Chebyshev points err by
/// `2 (angle / 4)^count / count!`.
fn coefficients(angle: f64) -> usize {
    let mut error = 2.0;
    for count in 1..GAMMAS {
        error *= 0.25 * angle / count as f64;
        if error <= IMPULSE_RESPONSE_ERROR {
            return count.max(2);
        }
    }
    GAMMAS
}

impl CondensedBlock {
    /// Modes of a block of the condensation; `None` if one of them is not finite.
    fn new(modes: &impulse_response::ModeBlock, interval_s: f64) -> Option<Self> {
        let modes = || modes.stiffness.iter().zip(&modes.damping).map(|(stiffness, damping)| (*stiffness, *damping));
        let fastest = modes().map(|(stiffness, damping)| rate(stiffness, damping)).fold(0.0, f64::max);
        let count = coefficients(fastest * interval_s);
        let (few, all) = (Collocation::new(count), Collocation::new(GAMMAS));
        let terms = scaled_powers(interval_s);
        let mut block = Self { propagator: [[0.0; WIDTH]; 4], gamma: vec![[0.0; WIDTH]; count] };
        for (lane, (stiffness, damping)) in modes().enumerate() {
            let gamma = few.impulse_response(stiffness, damping, interval_s)?;
            block.gamma.iter_mut().zip(gamma).for_each(|(own, gamma)| own[lane] = gamma);
            let gamma = all.impulse_response(stiffness, damping, interval_s)?;
            // At the end of the interval: the rate of the response to an impulse, that response, and its integral.
            let series = |from: usize| gamma.iter().zip(&terms[from..]).map(|(gamma, term)| gamma * term).sum::<f64>();
            let [velocity, response, integral] = [0, 1, 2].map(series);
            let propagator = [1.0 - stiffness * integral, response, -stiffness * response, velocity];
            block.propagator.iter_mut().zip(propagator).for_each(|(own, entry)| own[lane] = entry);
        }
        Some(block)
    }
}

impl Damping {
    /// Condensed modes read every `interval_s`; `None` if one of them is not finite.
    pub fn new(condensation: &Arc<Condensation>, interval_s: f64) -> Option<Self> {
        let blocks =
            condensation.blocks.iter().map(|modes| CondensedBlock::new(modes, interval_s)).collect::<Option<_>>()?;
        Some(Self { condensation: Arc::clone(condensation), interval_s, blocks })
    }

    /// Time of a node, counted from 0, s.
    pub fn node_s(&self, node: u64) -> f64 {
        (node as f64 + 0.5) * self.interval_s
    }

    /// Integrals of the forces that are needed.
    pub fn orders(&self) -> usize {
        1 + self.blocks.iter().map(|block| block.gamma.len()).max().unwrap_or(0)
    }
}

/// Modes of a row at the last node, and their dissipated energy.
#[derive(Debug, Clone)]
pub(super) struct Dissipation {
    displacement: Vec<Lanes>,
    velocity: Vec<Lanes>,
    /// Nodes passed.
    nodes: u64,
    dissipated_j: f64,
    /// Power at the last nodes, the latest first, W.
    powers_w: [f64; REMEMBERED],
}

impl Dissipation {
    /// Modes at rest.
    pub fn at_rest(damping: &Damping) -> Self {
        let none = vec![[0.0; WIDTH]; damping.blocks.len()];
        let powers_w = [0.0; REMEMBERED];
        Self { displacement: none.clone(), velocity: none, nodes: 0, dissipated_j: 0.0, powers_w }
    }

    /// Time of the next node, s.
    pub fn next_s(&self, damping: &Damping) -> f64 {
        damping.node_s(self.nodes)
    }

    /// Brings the modes to the next node; `moments` are the integrals of the forces since the last, by order, then by point.
    pub fn advance(&mut self, damping: &Damping, moments: &[f64]) {
        let power_w = in_widest(Advance { modes: self, damping, moments });
        self.powers_w.rotate_right(1);
        self.powers_w[0] = power_w;
        self.dissipated_j += damping.interval_s * power_w;
        self.nodes += 1;
    }

    /// Energy dissipated by all intervals whose nodes have been passed, J.
    pub fn whole_j(&self) -> f64 {
        self.dissipated_j
    }

    /// Energy dissipated up to a time within or at the end of the last step, J, if the power is `power_w(t)`: whole intervals, then the
    /// rest at that power.
    pub fn up_to_j(&self, damping: &Damping, t: f64, power_w: f64) -> f64 {
        let nodes = ((t / damping.interval_s + 0.5).floor() as u64).min(self.nodes);
        let later = self.powers_w.iter().take((self.nodes - nodes) as usize).sum::<f64>();
        self.dissipated_j - damping.interval_s * later + (t - nodes as f64 * damping.interval_s) * power_w
    }
}

/// Modes to be brought to the next node; gives the power that they dissipate there.
struct Advance<'a> {
    modes: &'a mut Dissipation,
    damping: &'a Damping,
    moments: &'a [f64],
}

impl OverArrays for Advance<'_> {
    type Output = f64;

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) -> f64 {
        for_points!(unrolled::<W>(self.damping.condensation.points()), self.power::<W>())
    }
}

impl Advance<'_> {
    #[inline(always)]
    fn power<W: Number, const P: usize>(self) -> f64 {
        let Self { modes, damping, moments } = self;
        let condensation = &damping.condensation;
        let points = if P > 0 { P } else { condensation.points() };
        let mut sums = [0.0; WIDTH];
        let states = modes.displacement.iter_mut().zip(&mut modes.velocity);
        let constants = damping.blocks.iter().zip(&condensation.blocks).zip(condensation.shapes.chunks_exact(points));
        for ((displacements, velocities), ((block, whole), shapes)) in states.zip(constants) {
            for first in (0..WIDTH).step_by(2 * W::LANES) {
                let [xx, xv, vx, vv] = block.propagator.each_ref().map(|entries| pair::<W>(entries, first));
                let (x, v) = (pair(displacements, first), pair(velocities, first));
                let mut displacement = fused(product(xx, x), xv, v);
                let mut velocity = fused(product(vx, x), vv, v);
                let mut last = None;
                // Displacement meets each coefficient one order later than velocity.
                for (k, moments) in moments.chunks_exact(points).take(block.gamma.len() + 1).enumerate() {
                    let mut load = splat(0.0);
                    for (shape, moment) in shapes.iter().zip(moments) {
                        load = fused(load, splat(*moment), pair(shape, first));
                    }
                    if let Some(gamma) = last {
                        displacement = fused(displacement, gamma, load);
                    }
                    last = block.gamma.get(k).map(|gamma| pair(gamma, first));
                    if let Some(gamma) = last {
                        velocity = fused(velocity, gamma, load);
                    }
                }
                put_pair(displacement, displacements, first);
                put_pair(velocity, velocities, first);
                let sum = fused(pair(&sums, first), pair(&whole.damping, first), product(velocity, velocity));
                put_pair(sum, &mut sums, first);
            }
        }
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::system::modal::Modes;

    /// Velocity of a mode under a constant force of 1 per modal mass from rest: the closed form.
    fn step_velocity(omega: f64, ratio: f64, t: f64) -> f64 {
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        (-ratio * omega * t).exp() * (damped * t).sin() / damped
    }

    /// Displacement, as a share of the static one.
    fn step_displacement(omega: f64, ratio: f64, t: f64) -> f64 {
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        let (sine, cosine) = (damped * t).sin_cos();
        1.0 - (-ratio * omega * t).exp() * (cosine + ratio * omega / damped * sine)
    }

    /// Under constant forces the power at every node, displacements of slow modes and the energy up to the end are those of the closed
    /// form, whatever the number of
    /// points that loops are unrolled for: modes of several blocks, fast ones that need all coefficients and slow ones that need few.
    #[test]
    fn analytic_step_forces() {
        let (fastest, ratio, duration_s) = (30_000.0, 0.02, 0.01);
        let omega = |s: usize| fastest * 0.88_f64.powi(s as i32);
        let count = 40;
        for points in [1, 2, 3, 4, 5, 6, 8, 11] {
            let force: Vec<f64> = (0..points).map(|n| [40.0, -15.0, 25.0][n % 3]).collect();
            let modes = Modes {
                omega_squared: DVector::from_fn(count, |s, _| omega(s).powi(2)),
                damping: DVector::from_fn(count, |s, _| 2.0 * ratio * omega(s)),
                phi: DMatrix::from_fn(count, points, |s, n| 0.4 * (1.3 * (s + 3 * n) as f64).sin()),
            };
            let modal_force = &modes.phi * DVector::from_vec(force.clone());
            let power_at = |t: f64| -> f64 {
                let power = |s: usize| modes.damping[s] * (modal_force[s] * step_velocity(omega(s), ratio, t)).powi(2);
                (0..count).map(power).sum()
            };
            let condensation = Arc::new(Condensation::new(&modes).unwrap());
            let damping = Damping::new(&condensation, interval_s(&condensation, duration_s)).unwrap();
            let needed: Vec<usize> = damping.blocks.iter().map(|block| block.gamma.len()).collect();
            assert_eq!((needed[0], damping.orders()), (GAMMAS, GAMMAS + 1));
            // An odd number too, whose last coefficient is not next to nothing.
            assert_eq!(needed, [GAMMAS, 5, 4]);
            let mut dissipation = Dissipation::at_rest(&damping);
            let mut last_s = 0.0;
            let largest_w = (0..4000).map(|i| power_at(duration_s * f64::from(i) / 4000.0)).fold(0.0, f64::max);
            while dissipation.next_s(&damping) < duration_s {
                let t = dissipation.next_s(&damping);
                let terms = scaled_powers(t - last_s);
                let moments: Vec<f64> =
                    terms[1..=damping.orders()].iter().flat_map(|term| force.iter().map(move |f| f * term)).collect();
                dissipation.advance(&damping, &moments);
                for s in 0..count {
                    let found = dissipation.displacement[s / WIDTH][s % WIDTH] * omega(s).powi(2) / modal_force[s];
                    let exact = step_displacement(omega(s), ratio, t);
                    let near = (found - exact).abs() < IMPULSE_RESPONSE_ERROR;
                    assert!(s < WIDTH || near, "mode {s}, {t} s: {found} and {exact}");
                }
                let (found, exact) = (dissipation.powers_w[0], power_at(t));
                // What the impulse responses err by adds up over the 25 nodes until it is damped away, and enters the square twice.
                assert!(
                    (found - exact).abs() < 50.0 * IMPULSE_RESPONSE_ERROR * largest_w,
                    "{points} points, {t} s: {found} and {exact} W"
                );
                last_s = t;
            }
            // The midpoint rule, as it is known in the middle and at the end.
            for end in [0.5 * duration_s, duration_s] {
                let steps = 200_000;
                let exact = (0..steps).map(|i| power_at(end * (f64::from(i) + 0.5) / f64::from(steps))).sum::<f64>()
                    * end
                    / f64::from(steps);
                let within_reach = dissipation.nodes - ((end / damping.interval_s + 0.5) as u64);
                if within_reach as usize <= REMEMBERED {
                    let found = dissipation.up_to_j(&damping, end, power_at(end));
                    assert!((found - exact).abs() < 1e-3 * exact, "{points} points: {found} and {exact} J");
                }
            }
            assert_eq!(dissipation.whole_j(), dissipation.up_to_j(&damping, duration_s, 7.0));
        }
    }

    /// As many coefficients as keep the error, never fewer than two, never more than there are.
    #[test]
    fn analytic_coefficients() {
        assert_eq!([0.0, 0.1, 0.785, 3.0, 4.0, 50.0].map(coefficients), [2, 4, 6, 10, 10, 10]);
    }
}
