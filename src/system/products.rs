//! Products of short vectors, written so that the compiler puts them into the widest registers of where they are inlined.
//! The order of sums is fixed: results are the same with registers of any width.

use nalgebra::DMatrix;

/// Independent sums.
pub(super) const LANES: usize = 4;

/// Adds `a b` to independent sums; returns the sum of what fills no whole block of them.
#[inline(always)]
pub(super) fn add_products(sums: &mut [f64; LANES], a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum()
}

/// `out += A factors`, the columns of `A` one after the other. Several columns are taken in one pass over `out`.
#[inline(always)]
pub(super) fn add_columns(out: &mut [f64], columns: &[f64], factors: &[f64]) {
    let rows = out.len();
    if rows == 0 {
        return;
    }
    let (blocks, rest) = factors.as_chunks::<LANES>();
    let (block_columns, rest_columns) = columns.split_at(blocks.len() * LANES * rows);
    for (factors, columns) in blocks.iter().zip(block_columns.chunks_exact(LANES * rows)) {
        add_scaled(out, std::array::from_fn(|i| &columns[i * rows..(i + 1) * rows]), factors);
    }
    for (factor, column) in rest.iter().zip(rest_columns.chunks_exact(rows)) {
        add_scaled(out, [column], &[*factor]);
    }
}

/// `out += sum_i factors[i] vectors[i]` of vectors as long as `out`.
#[inline(always)]
fn add_scaled<const N: usize>(out: &mut [f64], vectors: [&[f64]; N], factors: &[f64; N]) {
    let (blocks, rest) = out.as_chunks_mut::<LANES>();
    let whole = vectors.map(|vector| &vector.as_chunks::<LANES>().0[..blocks.len()]);
    for (at, out) in blocks.iter_mut().enumerate() {
        let mut sums = *out;
        for (factor, vector) in factors.iter().zip(whole) {
            let values = vector[at];
            for lane in 0..LANES {
                sums[lane] += factor * values[lane];
            }
        }
        *out = sums;
    }
    for (factor, vector) in factors.iter().zip(vectors) {
        for (out, value) in rest.iter_mut().zip(vector.as_chunks::<LANES>().1) {
            *out += factor * value;
        }
    }
}

/// A matrix whose columns stand in blocks: several of them together, row by row, filled up with zeros.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    rows: usize,
    entries: Vec<[f64; LANES]>,
}

impl Blocks {
    /// Takes a matrix.
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let entry = |i: usize, j: usize| if j < columns { matrix[(i, j)] } else { 0.0 };
        let places = (0..columns.div_ceil(LANES)).flat_map(|at| (0..rows).map(move |i| (i, LANES * at)));
        let entries = places.map(|(i, first)| std::array::from_fn(|lane| entry(i, first + lane)));
        Self { rows, entries: entries.collect() }
    }

    /// Products of the columns of block `at` with several vectors: one pass over the block serves all.
    #[inline(always)]
    pub fn products<const D: usize>(&self, at: usize, vectors: [&[f64]; D]) -> [[f64; LANES]; D] {
        // Rows two by two: two chains of sums per product hide each other's latency.
        let (pairs, last) = self.entries[at * self.rows..(at + 1) * self.rows].as_chunks::<2>();
        let factors = vectors.map(|vector| &vector.as_chunks::<2>().0[..pairs.len()]);
        let mut sums = [[[0.0; LANES]; 2]; D];
        for (i, pair) in pairs.iter().enumerate() {
            for (sums, factors) in sums.iter_mut().zip(factors) {
                for half in 0..2 {
                    for lane in 0..LANES {
                        sums[half][lane] += factors[i][half] * pair[half][lane];
                    }
                }
            }
        }
        for entries in last {
            for (sums, vector) in sums.iter_mut().zip(vectors) {
                for lane in 0..LANES {
                    sums[0][lane] += vector[self.rows - 1] * entries[lane];
                }
            }
        }
        sums.map(|[even, odd]| std::array::from_fn(|lane| even[lane] + odd[lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// Products of sizes around whole blocks, against nalgebra's.
    #[test]
    fn analytic_products() {
        for (rows, columns) in [(0, 3), (1, 1), (3, 5), (8, 4), (13, 9)] {
            let matrix = DMatrix::from_fn(rows, columns, |i, j| (0.37 * (i + 13 * j) as f64).sin());
            let factors = DVector::from_fn(columns, |i, _| (1.7 * i as f64).cos());
            let mut out = DVector::from_element(rows, 0.25);
            let expected = &out + &matrix * &factors;
            add_columns(out.as_mut_slice(), matrix.as_slice(), factors.as_slice());
            assert!((&out - expected).iter().all(|d| d.abs() < 1e-14));

            let (blocks, other) = (Blocks::new(&matrix), out.map(|value| value * value - 3.0));
            let expected = [matrix.tr_mul(&out), matrix.tr_mul(&other)];
            for at in 0..columns.div_ceil(LANES) {
                let found = blocks.products(at, [out.as_slice(), other.as_slice()]);
                for (found, expected) in found.iter().zip(&expected) {
                    for (lane, found) in found.iter().enumerate() {
                        let expected = expected.get(LANES * at + lane).copied().unwrap_or(0.0);
                        assert!((found - expected).abs() < 1e-13, "{rows} x {columns}: {found} instead of {expected}");
                    }
                }
            }
        }
    }
}
