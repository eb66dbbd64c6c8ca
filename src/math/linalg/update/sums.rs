//! Sums over all poles, the only part of the work that grows with their number.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::number::{Number, OverArrays, in_widest, load, store};

/// Independent sums, so that the order of additions does not depend on the width of registers.
const LANES: usize = 8;
/// Lists whose products with as many others are summed in one pass: one sum alone waits for itself.
const TILE: usize = 3;

/// Poles with their rows of U, column after column, filled up with poles that count nothing.
pub(super) struct Poles {
    values: Vec<f64>,
    columns: Vec<f64>,
    rank: usize,
    weights: Vec<f64>,
    scaled: Vec<f64>,
}

impl Poles {
    pub fn new(values: &[f64], columns: &DMatrix<f64>) -> Self {
        let padded = values.len().next_multiple_of(LANES);
        let mut own = Self {
            values: values.to_vec(),
            columns: vec![0.0; padded * columns.ncols()],
            rank: columns.ncols(),
            weights: vec![0.0; padded],
            scaled: vec![0.0; padded],
        };
        own.values.resize(padded, f64::INFINITY);
        for (own, column) in own.columns.chunks_exact_mut(padded.max(1)).zip(columns.column_iter()) {
            own[..values.len()].iter_mut().zip(column.iter()).for_each(|(own, value)| *own = *value);
        }
        own
    }

    /// Length of lists of factors: the number of poles, filled up.
    pub fn padded(&self) -> usize {
        self.values.len()
    }

    /// Leaves poles out of all sums.
    pub fn leave_out(&mut self, poles: Range<usize>) {
        self.values[poles].fill(f64::INFINITY);
    }

    /// Takes poles back in.
    pub fn take_in(&mut self, poles: Range<usize>, values: &[f64]) {
        self.values[poles.clone()].copy_from_slice(&values[poles]);
    }

    /// `sum factor_i u_i u_i' / (at - nu_i)` into a matrix of as many rows as U has columns; factors are finite.
    pub fn sum(&mut self, at: f64, factors: &[f64], out: &mut DMatrix<f64>) {
        in_widest(Sum { poles: self, at, factors, out: out.as_mut_slice() });
    }

    /// The unit vector along `u_i' q / (at - nu_i)`, for the poles that were left out as they are given.
    pub fn vector(&mut self, at: f64, q: &[f64], left_out: LeftOut<'_>, out: &mut [f64]) {
        in_widest(Vector { poles: self, at, q, left_out, out });
    }
}

/// Poles that a sum leaves out, and their replacement in a vector.
pub struct LeftOut<'a> {
    /// Range of the poles.
    pub poles: Range<usize>,
    /// The vector's entries there.
    pub near: &'a [f64],
}

struct Sum<'a> {
    poles: &'a mut Poles,
    at: f64,
    factors: &'a [f64],
    out: &'a mut [f64],
}

impl OverArrays for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) {
        let Poles { values, columns, rank, weights, .. } = self.poles;
        let rank = *rank;
        let mut square = Square { entries: self.out, rank };
        for first in (0..values.len()).step_by(W::LANES) {
            let weight = load::<W>(self.factors, first) / (W::splat(self.at) - load(values, first));
            store(weight, weights, first);
        }
        for (k, l) in (0..rank).step_by(TILE).flat_map(|k| (0..=k).step_by(TILE).map(move |l| (k, l))) {
            if k + TILE <= rank {
                put(&tile::<W, TILE>(columns, weights, (k, l)), (k, l), &mut square);
            } else {
                for k in k..rank {
                    for l in l..(l + TILE).min(rank) {
                        put(&tile::<W, 1>(columns, weights, (k, l)), (k, l), &mut square);
                    }
                }
            }
        }
    }
}

/// A symmetric matrix.
struct Square<'a> {
    entries: &'a mut [f64],
    rank: usize,
}

/// Puts a tile into a symmetric matrix, at its place and at the mirrored one.
fn put<const N: usize>(tile: &[[f64; N]; N], (k, l): (usize, usize), square: &mut Square<'_>) {
    for (k, row) in (k..).zip(tile) {
        for (l, value) in (l..).zip(row) {
            square.entries[k * square.rank + l] = *value;
            square.entries[l * square.rank + k] = *value;
        }
    }
}

/// Weighted products of the lists from `k` on with those from `l` on, `N` each.
#[inline(always)]
fn tile<W: Number, const N: usize>(lists: &[f64], weights: &[f64], (k, l): (usize, usize)) -> [[f64; N]; N] {
    let length = weights.len();
    let mut sums = [[[0.0; LANES]; N]; N];
    for lanes in (0..LANES).step_by(W::LANES) {
        let mut own = [[W::splat(0.0); N]; N];
        for at in (lanes..length).step_by(LANES) {
            let weight: W = load(weights, at);
            let mut others = [W::splat(0.0); N];
            for n in 0..N {
                others[n] = load(&lists[(l + n) * length..][..length], at);
            }
            for n in 0..N {
                let scaled = load::<W>(&lists[(k + n) * length..][..length], at) * weight;
                for m in 0..N {
                    own[n][m] = scaled.mul_add(others[m], own[n][m]);
                }
            }
        }
        for n in 0..N {
            for m in 0..N {
                store(own[n][m], &mut sums[n][m], lanes);
            }
        }
    }
    let mut tile = [[0.0; N]; N];
    for (tile, sums) in tile.as_flattened_mut().iter_mut().zip(sums.as_flattened()) {
        *tile = sums.iter().sum();
    }
    tile
}

struct Vector<'a> {
    poles: &'a mut Poles,
    at: f64,
    q: &'a [f64],
    left_out: LeftOut<'a>,
    out: &'a mut [f64],
}

impl OverArrays for Vector<'_> {
    type Output = ();

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) {
        let Poles { values, columns, scaled, .. } = self.poles;
        for first in (0..values.len()).step_by(W::LANES) {
            let mut sum = W::splat(0.0);
            for (column, q) in columns.chunks_exact(values.len()).zip(self.q) {
                sum = W::splat(*q).mul_add(load(column, first), sum);
            }
            store(sum / (W::splat(self.at) - load(values, first)), scaled, first);
        }
        scaled[self.left_out.poles].copy_from_slice(self.left_out.near);
        let norm = square::<W>(scaled).sqrt();
        for (out, entry) in self.out.iter_mut().zip(scaled.iter()) {
            *out = entry / norm;
        }
    }
}

/// `sum weight_i z_i^2`.
pub(super) fn weighted_square(weights: &[f64], z: &[f64]) -> f64 {
    in_widest(WeightedSquare { weights, z })
}

struct WeightedSquare<'a> {
    weights: &'a [f64],
    z: &'a [f64],
}

impl OverArrays for WeightedSquare<'_> {
    type Output = f64;

    #[inline(always)]
    fn compute<W: Number, Q: Number>(self) -> f64 {
        let whole = self.z.len() / LANES * LANES;
        let mut sums = [0.0; LANES];
        for lanes in (0..LANES).step_by(W::LANES) {
            let mut own = W::splat(0.0);
            for at in (lanes..whole).step_by(LANES) {
                let z: W = load(self.z, at);
                own = load::<W>(self.weights, at).mul_add(z * z, own);
            }
            store(own, &mut sums, lanes);
        }
        let rest: f64 = self.weights[whole..].iter().zip(&self.z[whole..]).map(|(weight, z)| weight * (z * z)).sum();
        sums.iter().sum::<f64>() + rest
    }
}

/// Sum of the squares of a list.
#[inline(always)]
fn square<W: Number>(list: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for lanes in (0..LANES).step_by(W::LANES) {
        let mut own = W::splat(0.0);
        for at in (lanes..list.len()).step_by(LANES) {
            let value: W = load(list, at);
            own = value.mul_add(value, own);
        }
        store(own, &mut sums, lanes);
    }
    sums.iter().sum()
}
