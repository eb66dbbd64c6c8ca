//! Condensed modes at their last rebase: free motion, energy, dissipation, and the next rebase.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::system::impulse_response::{Condensation, Lanes, ModeBlock};
use crate::system::kernel::{Free, GAMMAS, Kernel, ORDER, TERMS, for_points};
use crate::system::rebase_group::{Falling, Integrals, Parts, Passed, RebaseGroup, Terms, WIDTH, scaled_powers, splat};
use crate::system::register_pair::{RegisterPair, fused, pair, product, put_pair, unrolled};
use decore_math::number::{Number, OverArrays, in_widest, load, store};

/// Modes at the last rebase, and constants that follow from them.
#[derive(Debug, Clone)]
pub(super) struct ModalState {
    /// Time of the rebase, s.
    pub time_s: f64,
    /// Of the modes, each at the own base of its group.
    displacement: Vec<Lanes>,
    velocity: Vec<Lanes>,
    octaves: Vec<RebaseGroup>,
    falling: Falling,
    /// The free motion of each interface point.
    pub free: Vec<Free<f64>>,
}

/// Some modes of a block with their loads, and the time since the own base of their group: terms of the time, and the integrals.
#[derive(Clone, Copy)]
struct Mover<'m> {
    base: &'m ModalState,
    condensation: &'m Condensation,
    terms: &'m Terms,
    z: &'m [f64],
}

impl<'m> Mover<'m> {
    fn block(&self, at: usize) -> &'m ModeBlock {
        &self.condensation.blocks[at]
    }

    /// Loads of the free motion of block `at` from mode `first` on: an impulse and a constant force that replace velocity and displacement.
    #[inline(always)]
    fn free_loads<W: Number>(&self, (at, first): (usize, usize)) -> [RegisterPair<W>; 2] {
        let (impulse, displacement) = (pair(&self.base.velocity[at], first), pair(&self.base.displacement[at], first));
        let stiffness: RegisterPair<W> = pair(&self.block(at).stiffness, first);
        [impulse, product([-stiffness[0], -stiffness[1]], displacement)]
    }

    /// The integral of order `k + 1` of all that moves them; `z` are those of the forces on the points.
    #[inline(always)]
    fn load<W: Number>(
        &self,
        k: usize,
        [impulse, constant]: [RegisterPair<W>; 2],
        (first, shapes, z): Forces<'_>,
    ) -> RegisterPair<W> {
        let mut load = fused(product(splat(self.terms[k]), impulse), splat(self.terms[k + 1]), constant);
        for (shape, z) in shapes.iter().zip(z) {
            load = fused(load, splat(*z), pair(shape, first));
        }
        load
    }

    /// Displacement and velocity of modes of block `at` from mode `first` on.
    #[inline(always)]
    fn moved<W: Number, const P: usize>(&self, (at, first): (usize, usize)) -> [RegisterPair<W>; 2] {
        let (block, points) = (self.block(at), if P > 0 { P } else { self.condensation.points() });
        let (mut displacement, mut velocity) = (pair(&self.base.displacement[at], first), splat(0.0));
        let free = self.free_loads((at, first));
        let shapes = &self.condensation.shapes[at * points..][..points];
        for (k, z) in self.z.chunks_exact(points).take(ORDER).enumerate() {
            let load = self.load(k, free, (first, shapes, z));
            if k < GAMMAS {
                velocity = fused(velocity, pair(&block.gamma[k], first), load);
            }
            if k > 0 {
                displacement = fused(displacement, pair(&block.gamma[k - 1], first), load);
            }
        }
        [displacement, velocity]
    }

    /// Velocity only.
    #[inline(always)]
    fn velocity<W: Number, const P: usize>(&self, (at, first): (usize, usize)) -> RegisterPair<W> {
        let (block, points) = (self.block(at), if P > 0 { P } else { self.condensation.points() });
        let mut velocity = splat(0.0);
        let free = self.free_loads((at, first));
        let shapes = &self.condensation.shapes[at * points..][..points];
        for (k, (gamma, z)) in block.gamma.iter().zip(self.z.chunks_exact(points)).enumerate() {
            velocity = fused(velocity, pair(gamma, first), self.load(k, free, (first, shapes, z)));
        }
        velocity
    }
}

/// The first of some modes of a block, shapes of the block at the points, and integrals of one order of the forces on these.
type Forces<'f> = (usize, &'f [Lanes], &'f [f64]);

/// A time after the base, and the integrals there.
#[derive(Clone, Copy)]
pub struct Since<'z> {
    /// The time, s.
    pub tau: f64,
    /// The integrals of the forces.
    pub z: &'z [f64],
}

/// Begin of the coefficients of the free motion.
#[derive(Clone, Copy)]
struct First {
    point: usize,
    power: usize,
}

impl ModalState {
    /// The structure at rest at time 0.
    pub fn at_rest(condensation: &Condensation) -> Self {
        let (blocks, points) = (condensation.blocks.len(), condensation.points());
        Self {
            time_s: 0.0,
            displacement: vec![[0.0; WIDTH]; blocks],
            velocity: vec![[0.0; WIDTH]; blocks],
            octaves: vec![RebaseGroup::at_rest(points); condensation.groups.len()],
            falling: Falling::NONE,
            free: vec![[0.0; TERMS + 2]; points],
        }
    }

    /// Displacement, velocity and acceleration (without its direct part) of point `n` at `tau` after the base; `z` are the
    /// integrals.
    pub fn point(&self, condensation: &Condensation, Since { tau, z }: Since<'_>, n: usize) -> [f64; 3] {
        f64::dispatch(Point { kernel: condensation.kernel(), free: &self.free, tau, z, n })
    }

    /// Strain and kinetic energy of the modes at `t`, J.
    pub fn energy(&self, condensation: &Condensation, t: f64, z: &[f64]) -> f64 {
        in_widest(Energy(Moment { base: self, condensation, t, z }))
    }

    /// Shows displacement and velocity of each mode at a time after the base by its number.
    pub fn each_mode(&self, condensation: &Condensation, since: Since<'_>, see: &mut dyn FnMut(usize, [f64; 2])) {
        in_widest(EachMode { base: self, condensation, since, see });
    }

    /// Power that the modes dissipate at `t`, `sum 2 xi omega x'^2`, in W: from their velocities and damping alone, whatever
    /// work is done on them.
    pub fn dissipation_w(&self, condensation: &Condensation, t: f64, z: &[f64]) -> f64 {
        in_widest(Dissipation(Moment { base: self, condensation, t, z }))
    }

    /// Rebases at time `t`.
    pub fn rebase(&mut self, condensation: &Condensation, t: f64, z: &[f64]) {
        in_widest(Rebase { base: self, condensation, t, z });
    }

    /// Coefficients of the free displacement of `P` points from `point` on by powers of the time from `power` on, not yet divided by
    /// factorials: sums over some modes.
    #[inline(always)]
    fn summed<Q: Number, const P: usize>(
        &self,
        condensation: &Condensation,
        modes: Range<usize>,
        First { point, power }: First,
    ) -> [Parts<Q>; P] {
        let (displacement, velocity) = (self.displacement.as_flattened(), self.velocity.as_flattened());
        let points = condensation.points();
        let shapes = &condensation.shapes_by_mode[modes.start * points..modes.end * points];
        let stiffness = &condensation.stiffness[modes.clone()];
        let states = displacement[modes.clone()].iter().zip(&velocity[modes.clone()]).zip(stiffness);
        let constants = condensation.series[modes].iter().zip(shapes.chunks_exact(points));
        let mut unit = [0.0; WIDTH];
        unit[0] = 1.0;
        let unit: Q = load(&unit, 0);
        let mut sums = [[Q::splat(0.0); 3]; P];
        for ((series, shapes), ((displacement, impulse), stiffness)) in constants.zip(states) {
            let (constant, impulse) = (Q::splat(-stiffness * displacement), Q::splat(*impulse));
            let mut coefficients: Parts<Q> = splat(0.0);
            for (part, coefficient) in (0..).zip(&mut coefficients) {
                let k = power + part * Q::LANES;
                *coefficient = impulse.mul_add(load(series, k + 1), constant * load(series, k));
            }
            if power == 0 {
                coefficients[0] = Q::splat(*displacement).mul_add(unit, coefficients[0]);
            }
            for (sums, shape) in sums.iter_mut().zip(&shapes[point..point + P]) {
                for (sum, coefficient) in sums.iter_mut().zip(coefficients) {
                    *sum = Q::splat(*shape).mul_add(coefficient, *sum);
                }
            }
        }
        sums
    }

    /// Sums the series of the free motion of all points over the modes of group `at`, for as many points in one pass over the modes as
    /// there are registers for.
    #[inline(always)]
    fn sum_all<W: Number, Q: Number>(&mut self, condensation: &Condensation, at: usize) {
        let (points, most) = (condensation.points(), if W::LANES > 4 { 5 } else { 3 });
        for first in (0..points).step_by(most) {
            match (points - first).min(most) {
                1 => self.sum_some::<Q, 1>(condensation, at, first),
                2 => self.sum_some::<Q, 2>(condensation, at, first),
                3 => self.sum_some::<Q, 3>(condensation, at, first),
                4 => self.sum_some::<Q, 4>(condensation, at, first),
                _ => self.sum_some::<Q, 5>(condensation, at, first),
            }
        }
    }

    /// Sums those of `P` points from `first` on.
    #[inline(always)]
    fn sum_some<Q: Number, const P: usize>(&mut self, condensation: &Condensation, at: usize, first: usize) {
        for power in (0..=ORDER).step_by(3 * Q::LANES) {
            let sums =
                self.summed::<Q, P>(condensation, condensation.groups[at].modes.clone(), First { point: first, power });
            for (derivatives, sums) in self.octaves[at].derivatives[first..].iter_mut().zip(sums) {
                for (part, sum) in sums.into_iter().enumerate() {
                    store(sum, derivatives, power + part * Q::LANES);
                }
            }
        }
    }

    /// Writes the free motion of the points from all groups.
    #[inline(always)]
    fn gather(&mut self) {
        for (point, free) in self.free.iter_mut().enumerate() {
            free.fill(0.0);
            for octave in &self.octaves {
                for (sum, own) in free[..=ORDER].iter_mut().zip(&octave.derivatives[point]) {
                    *sum += own;
                }
            }
        }
    }

    /// Brings the modes to time `t` (slower groups only if they would not last until the next rebase), and writes the free motion of the
    /// points from there.
    #[inline(always)]
    fn rebase_points<W: Number, Q: Number>(&mut self, condensation: &Condensation, t: f64, z: &[f64]) {
        let points = unrolled::<W>(condensation.points());
        let tau = t - self.time_s;
        let terms = &scaled_powers(tau);
        if condensation.groups.len() > 1 {
            self.falling.put(z, condensation.points());
        }
        for (at, group) in condensation.groups.iter().enumerate() {
            let (octave, kernel) = (&mut self.octaves[at], &group.kernel);
            if octave.age_s(tau) < group.patience_s {
                let passed = &Passed { terms, tau, z, falling: &self.falling };
                for_points!(points, octave.pass::<W, Q>(kernel, passed));
            } else {
                let base = &mut *self;
                for_points!(points, base.move_modes::<W>(condensation, at, Since { tau, z }));
                // Not in the code for each number of points: it is long and the same.
                self.sum_all::<W, Q>(condensation, at);
            }
        }
        self.gather();
        self.time_s = t;
    }

    /// Brings the modes of group `at` from its own base to a time after the base of all, which is their base from then on.
    #[inline(always)]
    fn move_modes<W: Number, const P: usize>(
        &mut self,
        condensation: &Condensation,
        at: usize,
        Since { tau, z }: Since<'_>,
    ) {
        let mut room = Integrals::NONE;
        let own_terms = scaled_powers(self.octaves[at].age_s(tau));
        let z = self.octaves[at].integrals::<W, P>(&scaled_powers(tau), z, &mut room);
        for block in condensation.groups[at].blocks.clone() {
            for first in (0..WIDTH).step_by(2 * W::LANES) {
                let mover = Mover { base: self, condensation, terms: &own_terms, z };
                let [displacement, velocity] = mover.moved::<W, P>((block, first));
                put_pair(displacement, &mut self.displacement[block], first);
                put_pair(velocity, &mut self.velocity[block], first);
            }
        }
        self.octaves[at].begin();
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

/// The modes at a time.
struct Moment<'e> {
    base: &'e ModalState,
    condensation: &'e Condensation,
    t: f64,
    z: &'e [f64],
}

impl Moment<'_> {
    /// A power or an energy of all modes: the sum of `M` over the modes.
    #[inline(always)]
    fn total<W: Number, const P: usize, M: OfModes>(&self) -> f64 {
        let Self { base, condensation, t, z } = self;
        let tau = t - base.time_s;
        let terms = scaled_powers(tau);
        let (mut room, mut sums) = (Integrals::NONE, [0.0; WIDTH]);
        for (group, octave) in condensation.groups.iter().zip(&base.octaves) {
            let own_terms = scaled_powers(octave.age_s(tau));
            let z = octave.integrals::<W, P>(&terms, z, &mut room);
            let mover = Mover { base, condensation, terms: &own_terms, z };
            for block in group.blocks.clone() {
                for first in (0..WIDTH).step_by(2 * W::LANES) {
                    let sum = M::added::<W, P>(&mover, (block, first), pair(&sums, first));
                    put_pair(sum, &mut sums, first);
                }
            }
        }
        sums.iter().sum()
    }
}

/// A quantity that is a sum over modes.
trait OfModes {
    /// Adds that of modes of a block, from the first of them on.
    fn added<W: Number, const P: usize>(mover: &Mover<'_>, at: (usize, usize), sum: RegisterPair<W>)
    -> RegisterPair<W>;
}

/// Twice the energy of the modes.
struct Energy<'e>(Moment<'e>);

impl OfModes for Energy<'_> {
    #[inline(always)]
    fn added<W: Number, const P: usize>(
        mover: &Mover<'_>,
        at: (usize, usize),
        sum: RegisterPair<W>,
    ) -> RegisterPair<W> {
        let [displacement, velocity] = mover.moved::<W, P>(at);
        let strain = fused(sum, pair(&mover.block(at.0).stiffness, at.1), product(displacement, displacement));
        fused(strain, velocity, velocity)
    }
}

impl OverArrays for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) -> f64 {
        0.5 * self.0.total::<W, 0, Self>()
    }
}

/// The power that the modes dissipate.
struct Dissipation<'d>(Moment<'d>);

impl OfModes for Dissipation<'_> {
    #[inline(always)]
    fn added<W: Number, const P: usize>(
        mover: &Mover<'_>,
        at: (usize, usize),
        sum: RegisterPair<W>,
    ) -> RegisterPair<W> {
        let velocity = mover.velocity::<W, P>(at);
        fused(sum, pair(&mover.block(at.0).damping, at.1), product(velocity, velocity))
    }
}

impl OverArrays for Dissipation<'_> {
    type Output = f64;

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) -> f64 {
        for_points!(unrolled::<W>(self.0.condensation.points()), self.total::<W>())
    }
}

impl Dissipation<'_> {
    #[inline(always)]
    fn total<W: Number, const P: usize>(&self) -> f64 {
        self.0.total::<W, P, Self>()
    }
}

/// Each mode to be shown.
struct EachMode<'e, 's> {
    base: &'e ModalState,
    condensation: &'e Condensation,
    since: Since<'e>,
    see: &'s mut dyn FnMut(usize, [f64; 2]),
}

impl OverArrays for EachMode<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) {
        let Self { base, condensation, since: Since { tau, z }, see } = self;
        let (terms, mut room) = (scaled_powers(tau), Integrals::NONE);
        for (group, octave) in condensation.groups.iter().zip(&base.octaves) {
            let own_terms = scaled_powers(octave.age_s(tau));
            let z = octave.integrals::<W, 0>(&terms, z, &mut room);
            let mover = Mover { base, condensation, terms: &own_terms, z };
            for block in group.blocks.clone() {
                let [mut displacements, mut velocities] = [[0.0; WIDTH]; 2];
                for first in (0..WIDTH).step_by(2 * W::LANES) {
                    let [displacement, velocity] = mover.moved::<W, 0>((block, first));
                    put_pair(displacement, &mut displacements, first);
                    put_pair(velocity, &mut velocities, first);
                }
                let numbers = &condensation.numbers[block * WIDTH..condensation.numbers.len().min((block + 1) * WIDTH)];
                for (number, (x, v)) in numbers.iter().zip(displacements.iter().zip(&velocities)) {
                    see(*number, [*x, *v]);
                }
            }
        }
    }
}

/// A rebase to be done.
struct Rebase<'r> {
    base: &'r mut ModalState,
    condensation: &'r Condensation,
    t: f64,
    z: &'r [f64],
}

impl OverArrays for Rebase<'_> {
    type Output = ();

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) {
        let Self { base, condensation, t, z } = self;
        base.rebase_points::<W, Q>(condensation, t, z);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::system::modal::Modes;

    /// Modes at some points: one that floats, one undamped, one damped, and `slower` ones, damped.
    fn modes(points: usize, slower: usize) -> Modes {
        let first: [(f64, f64); 3] = [(0.0, 0.0), (700.0, 0.0), (2000.0, 0.05)];
        let omega_and_ratio = |s: usize| *first.get(s).unwrap_or(&(2000.0 * 0.97_f64.powi(s as i32), 0.02));
        let shape = |s: usize, n: usize| if s == 0 { 0.1 } else { 0.4 * (1.3 * (s + 3 * n) as f64).sin() };
        let count = first.len() + slower;
        Modes {
            omega_squared: DVector::from_fn(count, |s, _| omega_and_ratio(s).0.powi(2)),
            damping: DVector::from_fn(count, |s, _| 2.0 * omega_and_ratio(s).1 * omega_and_ratio(s).0),
            phi: DMatrix::from_fn(count, points, shape),
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

    /// Under constant forces the integrals are powers of time: motion of the points, energy of the modes and what they dissipate, over
    /// many rebases, are those of the closed forms, whatever the number of points that the loops are unrolled for, of modes of one
    /// group and of several.
    #[test]
    fn analytic_step_forces() {
        for points in [1, 2, 3, 4, 5, 6, 8, 11] {
            for slower in [0, 150] {
                step_forces_at(points, slower);
            }
        }
    }

    fn step_forces_at(points: usize, slower: usize) {
        let modes = modes(points, slower);
        let condensation = Condensation::new(&modes).unwrap();
        assert_eq!(condensation.groups.len() > 1, slower > 0 && points < 9, "{points} points");
        let force = DVector::from_fn(points, |n, _| [40.0, -15.0, 25.0][n % 3]);
        let forced = Forced { modal_force: &modes.phi * &force, modes };
        let z = |tau: f64| -> Vec<f64> {
            let term = |k: usize| tau.powi(k as i32) / (1..=k).product::<usize>() as f64;
            (1..=ORDER).flat_map(|k| force.iter().map(move |f| f * term(k))).collect()
        };
        // Errors of displacement, velocity, acceleration, power (relative to what moves in all modes) and energy: those of the fastest
        // mode, in proportion to what it has of the motion.
        let bounds = if slower == 0 { [6e-7, 1e-6, 5e-6, 2e-6, 3e-7] } else { [3e-11, 1e-9, 1e-7, 3e-9, 3e-9] };
        let mut base = ModalState::at_rest(&condensation);
        for rebase in 1..=40 {
            for part in [0.0, 0.3, 1.0] {
                let tau = part * condensation.horizon_s;
                let (t, z) = (base.time_s + tau, z(tau));
                let state = forced.at(t);
                let check = |what: usize, found: f64, exact: f64, size: f64| {
                    let words = format!("{what}: {points} points, {slower} slower modes, rebase {rebase}, {part}");
                    assert!((found - exact).abs() <= bounds[what] * size, "{words}: {found} and {exact} of {size}");
                };
                for n in 0..points {
                    let [w, v, a] = base.point(&condensation, Since { tau, z: &z }, n);
                    let direct: f64 = (0..points).map(|m| condensation.kernel().direct(n, m) * force[m]).sum();
                    for (what, found) in [w, v, a + direct].into_iter().enumerate() {
                        let [exact, size] = forced.point(&state, n, what);
                        check(what, found, exact, size);
                    }
                }
                let [[power, size], [energy, _]] = forced.power_and_energy(&state);
                check(3, base.dissipation_w(&condensation, t, &z), power, size);
                check(4, base.energy(&condensation, t, &z), energy, energy);
            }
            // Rebases at uneven times.
            let tau = condensation.horizon_s * (0.5 + 0.0125 * f64::from(rebase));
            base.rebase(&condensation, base.time_s + tau, &z(tau));
        }
    }

    /// Modes under constant modal forces from rest, by the closed form.
    struct Forced {
        modes: Modes,
        modal_force: DVector<f64>,
    }

    impl Forced {
        /// Displacement, velocity and acceleration of each mode at `t`.
        fn at(&self, t: f64) -> Vec<[f64; 3]> {
            let mode = |s: usize| {
                let (omega_squared, damping) = (self.modes.omega_squared[s], self.modes.damping[s]);
                let [x, v] = step_response((omega_squared, damping), self.modal_force[s], t);
                [x, v, self.modal_force[s] - damping * v - omega_squared * x]
            };
            (0..self.modal_force.len()).map(mode).collect()
        }

        /// Displacement (`what` is 0), velocity or acceleration of point `n`, and the sum of the amplitudes that modes give it.
        fn point(&self, state: &[[f64; 3]], n: usize, what: usize) -> [f64; 2] {
            let (phi, mut sums) = (self.modes.phi.column(n), [0.0; 2]);
            for (s, state) in state.iter().enumerate() {
                sums[0] += phi[s] * state[what];
                if s > 0 {
                    sums[1] += (phi[s] * self.amplitude(s, what)).abs();
                }
            }
            sums
        }

        fn amplitude(&self, s: usize, what: usize) -> f64 {
            self.modal_force[s] / self.modes.omega_squared[s].sqrt().powi(2 - what as i32)
        }

        /// Power dissipated and its largest, energy of the modes and again.
        fn power_and_energy(&self, state: &[[f64; 3]]) -> [[f64; 2]; 2] {
            let mut sums = [[0.0; 2]; 2];
            for (s, [x, v, _]) in state.iter().enumerate() {
                sums[0][0] += self.modes.damping[s] * v * v;
                if s > 0 {
                    sums[0][1] += self.modes.damping[s] * self.amplitude(s, 1).powi(2);
                }
                sums[1] = sums[1].map(|sum| sum + 0.5 * (self.modes.omega_squared[s] * x * x + v * v));
            }
            sums
        }
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
        let [w, v, a] = ModalState::at_rest(&floating).point(&floating, Since { tau: 3.0, z: &z }, 0);
        assert!((w - 9.0).abs() < 1e-12 && (v - 6.0).abs() < 1e-12 && a == 0.0, "{w}, {v}, {a}");
    }
}
