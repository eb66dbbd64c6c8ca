//! Sums over all poles, the only part of the work that grows with their number.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use nalgebra::DMatrix;

use crate::number::on_widest;

/// Independent sums, so that the order of additions does not depend on the width of registers.
const LANES: usize = 8;

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
        on_widest(Sum { poles: self, at, factors, out: out.as_mut_slice() });
    }

    /// The unit vector along `u_i' q / (at - nu_i)`, for the poles that were left out along `near`.
    pub fn vector(&mut self, at: f64, q: &[f64], (left_out, near): (Range<usize>, &[f64]), out: &mut [f64]) {
        on_widest(Vector { poles: self, at, q, left_out, near, out });
    }
}

struct Sum<'a> {
    poles: &'a mut Poles,
    at: f64,
    factors: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Poles { values, columns, rank, weights, scaled } = self.poles;
        let (padded, rank) = (values.len(), *rank);
        for ((weight, factor), pole) in weights.iter_mut().zip(self.factors).zip(values.iter()) {
            *weight = factor / (self.at - pole);
        }
        for k in 0..rank {
            let column = &columns[k * padded..(k + 1) * padded];
            for ((scaled, value), weight) in scaled.iter_mut().zip(column).zip(weights.iter()) {
                *scaled = value * weight;
            }
            for l in 0..=k {
                let sum = dot(scaled, &columns[l * padded..(l + 1) * padded]);
                self.out[k * rank + l] = sum;
                self.out[l * rank + k] = sum;
            }
        }
    }
}

struct Vector<'a> {
    poles: &'a mut Poles,
    at: f64,
    q: &'a [f64],
    left_out: Range<usize>,
    near: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Vector<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Poles { values, columns, scaled, .. } = self.poles;
        scaled.fill(0.0);
        for (column, q) in columns.chunks_exact(values.len()).zip(self.q) {
            for (sum, value) in scaled.iter_mut().zip(column) {
                *sum += value * q;
            }
        }
        for (entry, pole) in scaled.iter_mut().zip(values.iter()) {
            *entry /= self.at - pole;
        }
        scaled[self.left_out].copy_from_slice(self.near);
        let norm = dot(scaled, scaled).sqrt();
        for (out, entry) in self.out.iter_mut().zip(scaled.iter()) {
            *out = entry / norm;
        }
    }
}

/// `sum weight_i z_i^2`.
pub(super) fn weighted_square(weights: &[f64], z: &[f64]) -> f64 {
    on_widest(WeightedSquare { weights, z })
}

struct WeightedSquare<'a> {
    weights: &'a [f64],
    z: &'a [f64],
}

impl WithSimd for WeightedSquare<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut sums = [0.0; LANES];
        let ((weights, last_weights), (z, last_z)) = (self.weights.as_chunks::<LANES>(), self.z.as_chunks::<LANES>());
        for (weights, z) in weights.iter().zip(z) {
            for lane in 0..LANES {
                sums[lane] += weights[lane] * (z[lane] * z[lane]);
            }
        }
        let rest: f64 = last_weights.iter().zip(last_z).map(|(weight, z)| weight * (z * z)).sum();
        sums.iter().sum::<f64>() + rest
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum()
}
