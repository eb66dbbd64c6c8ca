//! Groups of modes by frequency: slower modes are rebased less often.
//!
//! A base holds for one horizon, in which the fastest mode turns by 4 rad. Modes of a half, a quarter or an eighth of its frequency
//! keep a base of their own for twice, four or eight times as long. At the bases in between, a group's part of the free motion of
//! the points is only written again, as a polynomial of the time from there. With `d_j[n]` its derivatives at the base, `D` the time
//! from the base to the next, `z` the integrals of the forces over it and the group's own `Gamma`:
//!
//! ```text
//! d_j[n] <- sum_i d_{i+j}[n] D^i / i!  +  sum_m sum_k Gamma_k[n, m] z_{k+1-j, m}
//! Z_k    <- z_k  +  sum_i Z_{k-i} D^i / i!
//! ```
//!
//! `Z` are the integrals from the group's own base on, which its modes are brought up to date with. Both are exact: what is
//! left of the motion is the error of the modes' impulse responses over the group's longer horizon.

use std::ops::Range;

use crate::system::kernel::{GAMMAS, ORDER};
use decore_math::number::{Number, load, store};

/// Modes treated together in a rebase: sums along the series are long chains, and several hide each other's latency.
pub(super) const WIDTH: usize = 16;
/// Angle in rad by which modes of a slower group may turn between two of its own rebases: less than what the fastest modes may, as
/// slower ones move more. Their impulse responses err by 3e-9 there, close to critical damping by 3e-8.
const TURN_RAD: f64 = 3.0;
/// Numbers of horizons that slower groups may last.
const FACTORS: [f64; 3] = [2.0, 4.0, 8.0];
/// Largest number of points for groups: the cost of a group's intermediate bases grows with its square.
const MOST_POINTS: usize = 8;

/// `tau^k / k!` from 0 on.
pub(super) type Terms = [f64; ORDER + 1];
/// Some of as many numbers, all of them in registers of four.
pub(super) type Parts<Q> = [Q; 3];

/// `1 / k` from 1 on.
const INVERSE: Terms = {
    let mut inverse = [1.0; ORDER + 1];
    let mut k = 1;
    while k <= ORDER {
        inverse[k] = 1.0 / k as f64;
        k += 1;
    }
    inverse
};

/// `tau^k / k!` from 0 on.
#[inline(always)]
pub(super) fn scaled_powers(tau: f64) -> Terms {
    let mut term = 1.0;
    std::array::from_fn(|k| {
        if k > 0 {
            term *= tau * INVERSE[k];
        }
        term
    })
}

/// The same number everywhere.
#[inline(always)]
pub(super) fn splat<R: Number, const N: usize>(value: f64) -> [R; N] {
    [R::splat(value); N]
}

/// Modes that are brought to the base's time together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    /// The modes, by falling rate.
    pub modes: Range<usize>,
    /// Number of horizons that they last.
    pub factor: f64,
}

/// Groups of modes of falling `rates` (rad/s), the fastest first: those for which rebases cost the least. All but the last are of whole
/// blocks.
pub(super) fn groups(rates: &[f64], horizon_s: f64, points: usize) -> Vec<Group> {
    let subsets = if points <= MOST_POINTS { 1 << FACTORS.len() } else { 1 };
    let grouped = |subset: usize| -> Vec<Group> {
        let mut groups = vec![Group { modes: 0..rates.len(), factor: 1.0 }];
        for (_, factor) in FACTORS.iter().enumerate().filter(|(i, _)| subset >> i & 1 == 1) {
            let slow = |rate: f64| rate * horizon_s * factor <= TURN_RAD;
            let first = rates.partition_point(|rate| !slow(*rate)).next_multiple_of(WIDTH).min(rates.len());
            if let Some(faster) = groups.last_mut() {
                faster.modes.end = first;
            }
            groups.push(Group { modes: first..rates.len(), factor: *factor });
        }
        groups.retain(|group| !group.modes.is_empty());
        groups
    };
    let work = |groups: &[Group]| -> f64 {
        let (points, order) = (points as f64, ORDER as f64);
        let (mode, between) = (order * (2.0 * points + 6.0), order * points * (10.0 + 10.0 * points));
        let of_group = |group: &Group| {
            group.modes.len() as f64 * mode / group.factor + if group.factor > 1.0 { between } else { 0.0 }
        };
        groups.iter().map(of_group).sum()
    };
    let all = (0..subsets).map(grouped);
    all.min_by(|a, b| work(a).total_cmp(&work(b))).unwrap_or_default()
}

/// Integrals of as many points as modes are grouped for, with as many zeros before them.
const ROOM: usize = 2 * ORDER * MOST_POINTS;

/// Room for the integrals since the own base of a group.
pub(super) struct Integrals([f64; ROOM / 2]);

impl Integrals {
    pub const NONE: Self = Self([0.0; ROOM / 2]);
}

/// Motion of the points by a group's modes between two of its own rebases.
#[derive(Debug, Clone)]
pub(super) struct RebaseGroup {
    /// Time from the group's own base to the base of all, s.
    since_s: f64,
    /// Integrals of the forces over it, after as many zeros as there may be integrals.
    integrals: [f64; ROOM],
    /// Derivatives of the free displacement of each point at the base of all.
    pub derivatives: Vec<ByOrder>,
}

/// Changes from one common base to the next.
pub(super) struct Passed<'p> {
    /// The time between them, s.
    pub tau: f64,
    /// Scaled powers of the time.
    pub terms: &'p Terms,
    /// The integrals of the forces.
    pub z: &'p [f64],
    /// The same for series whose order falls.
    pub falling: &'p Falling,
}

impl RebaseGroup {
    /// Modes at rest.
    pub fn at_rest(points: usize) -> Self {
        Self { since_s: 0.0, integrals: [0.0; ROOM], derivatives: vec![NONE; points] }
    }

    /// Time since the group's own base when `tau` has passed since that of all, s.
    pub fn age_s(&self, tau: f64) -> f64 {
        self.since_s + tau
    }

    /// Integrals of the forces since the group's own base, where they are `z` since that of all and its `terms` belong to the time
    /// since then; `own` is room for them.
    #[inline(always)]
    pub fn integrals<'z, W: Number, const P: usize>(
        &self,
        terms: &Terms,
        z: &'z [f64],
        Integrals(own): &'z mut Integrals,
    ) -> &'z [f64] {
        if self.since_s == 0.0 {
            return z;
        }
        let points = if P > 0 { P } else { z.len() / ORDER };
        let count = ORDER * points;
        own[..count].copy_from_slice(&z[..count]);
        for at in (0..count).step_by(W::LANES) {
            let mut sum: W = load(own, at);
            // Earlier by i orders, as long as there are such.
            for (i, term) in terms[..ORDER].iter().enumerate().take((at + W::LANES - 1) / points + 1) {
                sum = W::splat(*term).mul_add(load(&self.integrals, ROOM / 2 + at - i * points), sum);
            }
            store(sum, own, at);
        }
        &own[..count]
    }

    /// The group's own base is that of all from now on: its integrals, which are not read then, begin again with the next base of all.
    pub fn begin(&mut self) {
        self.since_s = 0.0;
    }

    /// Writes the free motion anew from the next base of all on; `kernel` is the group's own.
    #[inline(always)]
    pub fn pass<W: Number, Q: Number, const P: usize>(
        &mut self,
        kernel: &[f64],
        &Passed { tau, terms, z, falling }: &Passed<'_>,
    ) {
        let points = if P > 0 { P } else { self.derivatives.len() };
        for first in (0..=ORDER).step_by(3 * Q::LANES) {
            let mut moved = [splat::<Q, 3>(0.0); MOST_POINTS];
            for (i, term) in terms.iter().enumerate() {
                for (moved, derivatives) in moved[..points].iter_mut().zip(&self.derivatives[..points]) {
                    *moved = fused(*moved, *term, parts(derivatives, first + i));
                }
            }
            for (k, kernel) in kernel.chunks_exact(points * points).enumerate() {
                for (falling, kernel) in falling.0.iter().zip(kernel.chunks_exact(points)) {
                    let integrals = parts(falling, first + GAMMAS - 1 - k);
                    for (moved, kernel) in moved[..points].iter_mut().zip(kernel) {
                        *moved = fused(*moved, *kernel, integrals);
                    }
                }
            }
            for (derivatives, moved) in self.derivatives.iter_mut().zip(moved) {
                for (part, moved) in moved.into_iter().enumerate() {
                    store(moved, derivatives, first + part * Q::LANES);
                }
            }
        }
        let mut room = Integrals::NONE;
        let since_own = self.integrals::<W, P>(terms, z, &mut room);
        self.integrals[ROOM / 2..ROOM / 2 + since_own.len()].copy_from_slice(since_own);
        self.since_s += tau;
    }
}

/// Numbers by order, with as many zeros after them.
pub(super) type ByOrder = [f64; 2 * (ORDER + 1)];
const NONE: ByOrder = [0.0; 2 * (ORDER + 1)];

/// Integrals of the forces on each point by falling order: the first is of order `ORDER`.
#[derive(Debug, Clone)]
pub(super) struct Falling([ByOrder; MOST_POINTS]);

impl Falling {
    pub const NONE: Self = Self([NONE; MOST_POINTS]);

    /// Takes the integrals over, the index of the point fastest.
    #[inline(always)]
    pub fn put(&mut self, z: &[f64], points: usize) {
        for (k, z) in z.chunks_exact(points).take(ORDER).enumerate() {
            for (falling, z) in self.0.iter_mut().zip(z) {
                falling[ORDER - 1 - k] = *z;
            }
        }
    }
}

/// Parts from `first` on.
#[inline(always)]
fn parts<Q: Number>(numbers: &ByOrder, first: usize) -> Parts<Q> {
    [load(numbers, first), load(numbers, first + Q::LANES), load(numbers, first + 2 * Q::LANES)]
}

/// `a + b c`, rounded once.
#[inline(always)]
fn fused<Q: Number>(a: Parts<Q>, b: f64, c: Parts<Q>) -> Parts<Q> {
    let b = Q::splat(b);
    [b.mul_add(c[0], a[0]), b.mul_add(c[1], a[1]), b.mul_add(c[2], a[2])]
}
