//! Products of short vectors, written for the widest registers of the place where they are inlined. The order of sums is fixed, so
//! results are the same with registers of any width.

use nalgebra::DMatrix;

use decore_math::number::Number;

/// Independent sums.
pub(super) const LANES: usize = 4;

/// Sum of no products: adding it changes nothing, not even the sign of a zero.
const NONE: f64 = -0.0;

/// `sum a b`, one after the other.
#[inline(always)]
pub(super) fn sum<R: Number>(a: &[R], b: &[R]) -> R {
    let mut sum = R::splat(NONE);
    for (a, b) in a.iter().zip(b) {
        sum = a.mul_add(*b, sum);
    }
    sum
}

/// `sum a b` of long vectors, in several sums: one alone would wait for itself.
#[inline(always)]
pub(super) fn long_sum<R: Number>(a: &[R], b: &[R]) -> R {
    let mut sums = [R::splat(NONE); LANES];
    let ((a, a_left), (b, b_left)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] = a[lane].mul_add(b[lane], sums[lane]);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + sum(a_left, b_left)
}

/// Copies a few numbers, of which there are equally many: for these a call of the library's function takes longer.
#[inline(always)]
pub(super) fn copy<R: Number>(from: &[R], to: &mut [R]) {
    let ((from, from_left), (to, to_left)) = (from.as_chunks::<LANES>(), to.as_chunks_mut::<LANES>());
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
    for (to, from) in to_left.iter_mut().zip(from_left) {
        *to = *from;
    }
}

/// Sets a few numbers to zero, as [`copy`].
#[inline(always)]
pub(super) fn clear<R: Number>(numbers: &mut [R]) {
    let (blocks, left) = numbers.as_chunks_mut::<LANES>();
    for block in blocks {
        *block = [R::splat(0.0); LANES];
    }
    for number in left {
        *number = R::splat(0.0);
    }
}

/// Sets a lane of numbers that stand one after the other.
pub(super) fn put_all<'v, R: Number>(own: &mut [R], lane: usize, values: impl IntoIterator<Item = &'v f64>) {
    for (own, value) in own.iter_mut().zip(values) {
        own.put(lane, value);
    }
}

/// `out += A factors`, the columns of `A` one after the other. Several columns are taken in one pass over `out`, unless that is short.
#[inline(always)]
pub(super) fn add_columns<R: Number>(out: &mut [R], columns: &[R], factors: &[R]) {
    let rows = out.len();
    if rows == 0 {
        return;
    }
    if rows < LANES {
        for (factor, column) in factors.iter().zip(columns.chunks_exact(rows)) {
            out.iter_mut().zip(column).for_each(|(out, value)| *out = factor.mul_add(*value, *out));
        }
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
fn add_scaled<R: Number, const N: usize>(out: &mut [R], vectors: [&[R]; N], factors: &[R; N]) {
    let (blocks, rest) = out.as_chunks_mut::<LANES>();
    let whole = vectors.map(|vector| &vector.as_chunks::<LANES>().0[..blocks.len()]);
    for (at, out) in blocks.iter_mut().enumerate() {
        let mut sums = *out;
        for (factor, vector) in factors.iter().zip(whole) {
            let values = vector[at];
            for lane in 0..LANES {
                sums[lane] = factor.mul_add(values[lane], sums[lane]);
            }
        }
        *out = sums;
    }
    for (factor, vector) in factors.iter().zip(vectors) {
        for (out, value) in rest.iter_mut().zip(vector.as_chunks::<LANES>().1) {
            *out = factor.mul_add(*value, *out);
        }
    }
}

/// A matrix whose columns stand in blocks: several of them together, row by row, filled up with zeros.
#[derive(Debug, Clone)]
pub(super) struct Blocks<R> {
    rows: usize,
    entries: Vec<[R; LANES]>,
}

impl<R: Number> Blocks<R> {
    /// Zeros of a shape.
    pub fn zeros((rows, columns): (usize, usize)) -> Self {
        Self { rows, entries: vec![[R::splat(0.0); LANES]; rows * columns.div_ceil(LANES)] }
    }

    /// Takes the matrix of a lane, of the same shape.
    pub fn put(&mut self, lane: usize, matrix: &DMatrix<f64>) {
        for (j, column) in matrix.column_iter().enumerate() {
            for (i, value) in column.iter().enumerate() {
                self.entries[j / LANES * self.rows + i][j % LANES].put(lane, value);
            }
        }
    }

    /// Products of the columns of block `at` with several vectors: one pass over the block serves all.
    #[inline(always)]
    pub fn products<const D: usize>(&self, at: usize, vectors: [&[R]; D]) -> [[R; LANES]; D] {
        // Rows two by two: two chains of sums per product hide each other's latency.
        let (pairs, last) = self.entries[at * self.rows..(at + 1) * self.rows].as_chunks::<2>();
        let factors = vectors.map(|vector| &vector.as_chunks::<2>().0[..pairs.len()]);
        let mut sums = [[[R::splat(0.0); LANES]; 2]; D];
        for (i, pair) in pairs.iter().enumerate() {
            for (sums, factors) in sums.iter_mut().zip(factors) {
                for half in 0..2 {
                    for lane in 0..LANES {
                        sums[half][lane] = factors[i][half].mul_add(pair[half][lane], sums[half][lane]);
                    }
                }
            }
        }
        for entries in last {
            for (sums, vector) in sums.iter_mut().zip(vectors) {
                for lane in 0..LANES {
                    sums[0][lane] = vector[self.rows - 1].mul_add(entries[lane], sums[0][lane]);
                }
            }
        }
        let mut products = [[R::splat(0.0); LANES]; D];
        for (products, [even, odd]) in products.iter_mut().zip(&sums) {
            for lane in 0..LANES {
                products[lane] = even[lane] + odd[lane];
            }
        }
        products
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

            let other = out.map(|value: f64| value * value - 3.0);
            let mut blocks = Blocks::<f64>::zeros(matrix.shape());
            blocks.put(0, &matrix);
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
