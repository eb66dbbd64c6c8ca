//! The pencil (K, M) of some rows of two symmetric sparse matrices: factorisations of `K + shift M` and counts of eigenvalues.

use std::sync::Arc;

use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLdltRef, SupernodalLltRef, SymbolicSupernodalCholesky, factorize_supernodal_numeric_ldlt,
    factorize_supernodal_numeric_ldlt_scratch, factorize_supernodal_numeric_llt,
    factorize_supernodal_numeric_llt_scratch, factorize_supernodal_symbolic_cholesky,
    factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use nalgebra::DMatrix;
use sprs::{CsMat, CsStructure};

use super::LinalgError;
use super::ordering::{SymmetricPattern, fill_reducing};
use super::panel::{PanelRow, WIDTH, pack, solve_lower, solve_lower_transposed, unpack};

/// Row of the matrices that the pencil leaves out.
const LEFT_OUT: u32 = u32::MAX;

/// K and M restricted to some of their rows, in an order of their own that keeps factors sparse.
///
/// All vectors and blocks of vectors that go in and out are in that order: entry i belongs to row `rows()[i]` of K and M.
/// The symbolic factorisation is done once, for all shifts.
#[derive(Debug)]
pub struct SymmetricPencil<'a> {
    stiffness: &'a CsMat<f64>,
    mass: &'a CsMat<f64>,
    rows: Vec<u32>,
    place: Vec<u32>,
    /// Lower triangle by columns, on the union of both patterns.
    lower: CsStructure,
    symbolic: Arc<SymbolicSupernodalCholesky<usize>>,
    mass_rows: CompressedRows,
}

/// Both triangles by rows, entries that are 0 left out.
///
/// No matrix of sprs, which multiplies by one vector or by a matrix of ndarray: here panels of [`WIDTH`] vectors are read once
/// per entry. Its rows also keep the order in which the matrix has their entries, and so the order of their sums.
#[derive(Debug)]
struct CompressedRows {
    pointers: Vec<usize>,
    indices: Vec<u32>,
    values: Vec<f64>,
}

impl<'a> SymmetricPencil<'a> {
    /// The pencil of the rows for which `kept` is true; both matrices hold both triangles.
    ///
    /// # Errors
    /// Sizes that differ, entries that are not finite, not enough memory.
    pub fn new(stiffness: &'a CsMat<f64>, mass: &'a CsMat<f64>, kept: &[bool]) -> Result<Self, LinalgError> {
        let order = kept.len();
        for matrix in [stiffness, mass] {
            if matrix.shape() != (order, order) {
                return Err(LinalgError::Shape { left: matrix.shape(), right: (order, order) });
            }
            if matrix.data().iter().any(|value| !value.is_finite()) {
                return Err(LinalgError::NotFinite { order });
            }
        }
        let mut rows: Vec<u32> = (0_u32..).zip(kept).filter_map(|(row, kept)| kept.then_some(row)).collect();
        let pattern = union(stiffness, mass, &rows, &places(&rows, order));
        rows = fill_reducing(&pattern)?.into_iter().map(|position| rows[position as usize]).collect();
        drop(pattern);
        let place = places(&rows, order);
        let lower = lower_triangle(stiffness, mass, &rows, &place);
        let symbolic = Arc::new(symbolic(&lower)?);
        let mass_rows = CompressedRows::new(mass, &rows, &place);
        Ok(Self { stiffness, mass, rows, place, lower, symbolic, mass_rows })
    }

    /// Number of rows of the pencil.
    pub fn order(&self) -> usize {
        self.rows.len()
    }

    /// Row of the matrices behind every row of the pencil.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Numbers that a factor holds, 8 bytes each.
    pub fn factor_len(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Lower triangle of `K + shift M`.
    fn shifted(&self, shift: f64) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.lower.nnz());
        let mut work = vec![0.0; self.order()];
        for ((column, &row), pattern) in self.rows.iter().enumerate().zip(self.lower.outer_iterator()) {
            let mut add = |matrix: &CsMat<f64>, factor: f64| {
                for (other, value) in row_of(matrix, row) {
                    let position = self.place[other];
                    if position != LEFT_OUT && position as usize >= column {
                        work[position as usize] += factor * value;
                    }
                }
            };
            add(self.stiffness, 1.0);
            if shift != 0.0 {
                add(self.mass, shift);
            }
            values.extend(pattern.indices().iter().map(|&position| std::mem::take(&mut work[position])));
        }
        values
    }

    fn matrix<'m>(&'m self, values: &'m [f64]) -> SparseColMatRef<'m, usize, f64> {
        SparseColMatRef::new(columns_of(&self.lower), values)
    }

    fn factor_values(&self) -> Result<Vec<f64>, LinalgError> {
        let mut values = Vec::new();
        values.try_reserve_exact(self.factor_len()).map_err(|_| LinalgError::OutOfMemory { order: self.order() })?;
        values.resize(self.factor_len(), 0.0);
        Ok(values)
    }

    /// `K + shift M = L L'`.
    ///
    /// # Errors
    /// Not positive definite, not enough memory.
    pub fn cholesky(&self, shift: f64) -> Result<PencilFactor, LinalgError> {
        let order = self.order();
        let mut values = self.factor_values()?;
        let shifted = self.shifted(shift);
        let scratch =
            factorize_supernodal_numeric_llt_scratch::<usize, f64>(&self.symbolic, Par::Seq, Default::default());
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| LinalgError::OutOfMemory { order })?;
        factorize_supernodal_numeric_llt(
            &mut values,
            self.matrix(&shifted),
            Default::default(),
            &self.symbolic,
            Par::Seq,
            MemStack::new(&mut buffer),
            Default::default(),
        )
        .map_err(|_| LinalgError::NotPositiveDefinite { order })?;
        if values.iter().any(|value| !value.is_finite()) {
            return Err(LinalgError::NotPositiveDefinite { order });
        }
        Ok(PencilFactor { symbolic: Arc::clone(&self.symbolic), values })
    }

    /// Number of eigenvalues of `K x = lambda M x` below `sigma`: the negative pivots of `K - sigma M = L D L'` (Sylvester's
    /// law of inertia).
    ///
    /// # Errors
    /// A pivot that is 0, as when `sigma` is an eigenvalue: move it a little. Not enough memory.
    pub fn count_below(&self, sigma: f64) -> Result<usize, LinalgError> {
        let order = self.order();
        let mut values = self.factor_values()?;
        let shifted = self.shifted(-sigma);
        let scratch =
            factorize_supernodal_numeric_ldlt_scratch::<usize, f64>(&self.symbolic, Par::Seq, Default::default());
        let mut buffer = MemBuffer::try_new(scratch).map_err(|_| LinalgError::OutOfMemory { order })?;
        factorize_supernodal_numeric_ldlt(
            &mut values,
            self.matrix(&shifted),
            LdltRegularization::default(),
            &self.symbolic,
            Par::Seq,
            MemStack::new(&mut buffer),
            Default::default(),
        )
        .map_err(|_| LinalgError::ZeroPivot { order })?;
        let factor = SupernodalLdltRef::new(&self.symbolic, &values);
        let mut negative = 0;
        for index in 0..self.symbolic.n_supernodes() {
            let block = factor.supernode(index).val();
            for pivot in (0..block.ncols()).map(|column| block[(column, column)]) {
                if !pivot.is_finite() {
                    return Err(LinalgError::ZeroPivot { order });
                }
                negative += usize::from(pivot < 0.0);
            }
        }
        Ok(negative)
    }

    /// `M X`.
    ///
    /// # Errors
    /// Sizes that do not match.
    pub fn mass_times(&self, x: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        self.require_rows(x)?;
        let mut out = DMatrix::zeros(self.order(), x.ncols());
        let (mut panel, mut product) = (Vec::new(), Vec::new());
        for first in (0..x.ncols()).step_by(WIDTH) {
            pack(x, first, &mut panel);
            self.mass_rows.times(&panel, &mut product);
            unpack(&product, first, &mut out);
        }
        Ok(out)
    }

    /// `C X = L^-1 M L^-T X` with the factor of `K + shift M = L L'`.
    ///
    /// # Errors
    /// Sizes that do not match.
    pub fn inverse_times(&self, factor: &PencilFactor, x: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        self.require_rows(x)?;
        let mut out = DMatrix::zeros(self.order(), x.ncols());
        let (mut panel, mut product) = (Vec::new(), Vec::new());
        let factor = SupernodalLltRef::new(&factor.symbolic, &factor.values);
        for first in (0..x.ncols()).step_by(WIDTH) {
            pack(x, first, &mut panel);
            solve_lower_transposed(factor, &mut panel);
            self.mass_rows.times(&panel, &mut product);
            solve_lower(factor, &mut product);
            unpack(&product, first, &mut out);
        }
        Ok(out)
    }

    /// `K X`.
    ///
    /// # Errors
    /// Sizes that do not match.
    pub fn stiffness_times(&self, x: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        self.require_rows(x)?;
        let mut out = DMatrix::zeros(self.order(), x.ncols());
        for (source, mut target) in x.column_iter().zip(out.column_iter_mut()) {
            for (value, &row) in target.iter_mut().zip(&self.rows) {
                let terms = row_of(self.stiffness, row).filter_map(|(column, entry)| {
                    let position = self.place[column];
                    (position != LEFT_OUT).then(|| entry * source[position as usize])
                });
                *value = terms.sum();
            }
        }
        Ok(out)
    }

    /// Condition number of `A = K + shift M` in the 1-norm: `|A|` exactly, `|A^-1|` estimated from a few solutions (Hager's
    /// method), which is rarely too low by more than a factor of 3. `scaled`: of A scaled to a diagonal of 1, which neither units
    /// nor stiff springs to the ground change.
    ///
    /// # Errors
    /// As for [`PencilFactor::solve`].
    pub fn condition(&self, factor: &PencilFactor, shift: f64, scaled: bool) -> Result<f64, LinalgError> {
        let order = self.order();
        let values = self.shifted(shift);
        // In the order of the values.
        let entries = || self.lower.iter().map(|(_, place)| place).zip(&values);
        let mut root = DMatrix::from_element(order, 1, 1.0);
        if scaled {
            let diagonal = entries().filter(|((row, column), value)| row == column && **value > 0.0);
            diagonal.for_each(|((row, _), value)| root[row] = value.sqrt());
        }
        let mut sums = vec![0.0; order];
        for ((row, column), value) in entries() {
            let value = value.abs() / (root[row] * root[column]);
            sums[column] += value;
            sums[row] += if row == column { 0.0 } else { value };
        }
        let norm = sums.iter().copied().fold(0.0, f64::max);
        let solve = |x: &mut DMatrix<f64>| {
            x.component_mul_assign(&root);
            factor.solve(x)?;
            x.component_mul_assign(&root);
            Ok::<_, LinalgError>(())
        };
        let mut x = DMatrix::from_element(order, 1, 1.0 / order.max(1) as f64);
        let (mut inverse_norm, mut last) = (0.0_f64, usize::MAX);
        for _ in 0..5 {
            solve(&mut x)?;
            inverse_norm = inverse_norm.max(x.iter().map(|value| value.abs()).sum());
            let mut signs = x.map(f64::signum);
            solve(&mut signs)?;
            let at = (0..order).max_by(|i, j| signs[*i].abs().total_cmp(&signs[*j].abs())).unwrap_or(0);
            if at == last || order == 0 {
                break;
            }
            last = at;
            x = DMatrix::from_fn(order, 1, |row, _| f64::from(u8::from(row == at)));
        }
        Ok(norm * inverse_norm)
    }

    fn require_rows(&self, x: &DMatrix<f64>) -> Result<(), LinalgError> {
        if x.nrows() == self.order() {
            return Ok(());
        }
        Err(LinalgError::Shape { left: (self.order(), self.order()), right: x.shape() })
    }
}

/// A Cholesky factor `K + shift M = L L'`, in the order of its pencil.
#[derive(Debug)]
pub struct PencilFactor {
    symbolic: Arc<SymbolicSupernodalCholesky<usize>>,
    values: Vec<f64>,
}

impl PencilFactor {
    /// Solves `(K + shift M) X = B` in place.
    ///
    /// # Errors
    /// Sizes that do not match.
    pub fn solve(&self, rhs: &mut DMatrix<f64>) -> Result<(), LinalgError> {
        self.in_place(rhs, |factor, panel| {
            solve_lower(factor, panel);
            solve_lower_transposed(factor, panel);
        })
    }

    /// Solves `L' X = B` in place.
    ///
    /// # Errors
    /// As for [`PencilFactor::solve`].
    pub fn solve_lower_transposed(&self, rhs: &mut DMatrix<f64>) -> Result<(), LinalgError> {
        self.in_place(rhs, solve_lower_transposed)
    }

    fn in_place(
        &self,
        rhs: &mut DMatrix<f64>,
        solve: impl Fn(SupernodalLltRef<'_, usize, f64>, &mut [PanelRow]),
    ) -> Result<(), LinalgError> {
        let order = self.symbolic.nrows();
        if rhs.nrows() != order {
            return Err(LinalgError::Shape { left: (order, order), right: rhs.shape() });
        }
        let mut panel = Vec::new();
        for first in (0..rhs.ncols()).step_by(WIDTH) {
            pack(rhs, first, &mut panel);
            solve(SupernodalLltRef::new(&self.symbolic, &self.values), &mut panel);
            unpack(&panel, first, rhs);
        }
        Ok(())
    }
}

impl CompressedRows {
    fn new(matrix: &CsMat<f64>, rows: &[u32], place: &[u32]) -> Self {
        let mut out = Self { pointers: vec![0], indices: Vec::new(), values: Vec::new() };
        for &row in rows {
            for (column, value) in row_of(matrix, row).filter(|(_, value)| *value != 0.0) {
                if place[column] != LEFT_OUT {
                    out.indices.push(place[column]);
                    out.values.push(value);
                }
            }
            out.pointers.push(out.indices.len());
        }
        out
    }

    fn times(&self, panel: &[PanelRow], product: &mut Vec<PanelRow>) {
        product.clear();
        product.extend(self.pointers.windows(2).map(|ends| {
            let mut sum = [0.0; WIDTH];
            let range = ends[0]..ends[1];
            for (&column, &entry) in self.indices[range.clone()].iter().zip(&self.values[range]) {
                sum.iter_mut().zip(&panel[column as usize]).for_each(|(sum, value)| *sum += entry * value);
            }
            sum
        }));
    }
}

fn row_of(matrix: &CsMat<f64>, row: u32) -> impl Iterator<Item = (usize, f64)> + '_ {
    let range = matrix.indptr().outer_inds_sz(row as usize);
    matrix.indices()[range.clone()].iter().copied().zip(matrix.data()[range].iter().copied())
}

fn places(rows: &[u32], order: usize) -> Vec<u32> {
    let mut place = vec![LEFT_OUT; order];
    for (position, &row) in (0_u32..).zip(rows) {
        place[row as usize] = position;
    }
    place
}

/// Non-zeros of K or M among the rows, in positions of `rows`.
fn union(k: &CsMat<f64>, m: &CsMat<f64>, rows: &[u32], place: &[u32]) -> SymmetricPattern {
    let (mut pointers, mut indices) = (vec![0], Vec::new());
    let mut seen = vec![LEFT_OUT; rows.len()];
    for (position, &row) in (0_u32..).zip(rows) {
        for (column, _) in row_of(k, row).chain(row_of(m, row)) {
            let other = place[column];
            if other != LEFT_OUT && seen[other as usize] != position {
                seen[other as usize] = position;
                indices.push(other);
            }
        }
        pointers.push(indices.len());
    }
    SymmetricPattern { pointers, indices }
}

/// The lower triangle of the union by columns, rows rising, every diagonal entry included.
fn lower_triangle(k: &CsMat<f64>, m: &CsMat<f64>, rows: &[u32], place: &[u32]) -> CsStructure {
    let (mut pointers, mut indices) = (vec![0], Vec::new());
    for (column, &row) in rows.iter().enumerate() {
        let first = indices.len();
        indices.push(column);
        for (other, _) in row_of(k, row).chain(row_of(m, row)) {
            let position = place[other];
            if position != LEFT_OUT && position as usize > column {
                indices.push(position as usize);
            }
        }
        indices[first..].sort_unstable();
        let mut last = first;
        for index in first + 1..indices.len() {
            if indices[index] != indices[last] {
                last += 1;
                indices[last] = indices[index];
            }
        }
        indices.truncate(last + 1);
        pointers.push(indices.len());
    }
    indices.shrink_to_fit();
    let entries = vec![(); indices.len()];
    CsStructure::new_csc((rows.len(), rows.len()), pointers, indices, entries)
}

/// The pattern of a matrix that is stored by columns, as faer has it.
fn columns_of(pattern: &CsStructure) -> SymbolicSparseColMatRef<'_, usize> {
    SymbolicSparseColMatRef::new_checked(
        pattern.rows(),
        pattern.cols(),
        pattern.indptr().into_raw_storage(),
        None,
        pattern.indices(),
    )
}

fn symbolic(lower: &CsStructure) -> Result<SymbolicSupernodalCholesky<usize>, LinalgError> {
    let order = lower.rows();
    // The symbolic factorisation reads the upper triangle by columns: the transposed lower one.
    let upper = lower.transpose_view().to_csc();
    let pattern = columns_of(&upper);
    let memory = |_| LinalgError::OutOfMemory { order };
    let scratch = prefactorize_symbolic_cholesky_scratch::<usize>(order, upper.nnz())
        .or(factorize_supernodal_symbolic_cholesky_scratch::<usize>(order));
    let mut buffer = MemBuffer::try_new(scratch).map_err(|_| LinalgError::OutOfMemory { order })?;
    let (mut parents, mut counts) = (vec![0; order], vec![0; order]);
    let tree = prefactorize_symbolic_cholesky(&mut parents, &mut counts, pattern, MemStack::new(&mut buffer));
    factorize_supernodal_symbolic_cholesky(pattern, tree, &counts, MemStack::new(&mut buffer), Default::default())
        .map_err(memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{Below, LinalgError, modes_below};
    use sprs::TriMat;

    /// Chain of n unit masses and unit springs, held at its ends or free.
    fn chain(n: usize, held: bool) -> CsMat<f64> {
        let mut triplets = TriMat::new((n, n));
        for i in 0..n {
            let end = !held && (i == 0 || i + 1 == n);
            triplets.add_triplet(i, i, if end { 1.0 } else { 2.0 });
            if i + 1 < n {
                triplets.add_triplet(i, i + 1, -1.0);
                triplets.add_triplet(i + 1, i, -1.0);
            }
        }
        triplets.to_csr()
    }

    fn exact(n: usize, j: usize) -> f64 {
        (2.0 * (j as f64 * std::f64::consts::PI / (2.0 * (n as f64 + 1.0))).sin()).powi(2)
    }

    #[test]
    fn chain_under_unit_load_takes_the_parabola() {
        let n = 300;
        let (k, m) = (chain(n, true), CsMat::eye(n));
        let pencil = SymmetricPencil::new(&k, &m, &vec![true; n]).expect("sound");
        let mut x = DMatrix::from_element(n, 2, 1.0);
        pencil.cholesky(0.0).expect("positive definite").solve(&mut x).expect("sizes");
        for (position, &row) in pencil.rows().iter().enumerate() {
            let exact = 0.5 * (f64::from(row) + 1.0) * (n as f64 - f64::from(row));
            assert!((x[(position, 1)] / exact - 1.0).abs() < 1e-11, "{row}: {} {exact}", x[(position, 1)]);
        }
        assert!((pencil.stiffness_times(&x).expect("sizes").add_scalar(-1.0)).amax() < 1e-10);
    }

    /// Supernodes wider and higher than the tiles of the solution, and more columns than a panel has.
    #[test]
    fn full_blocks_are_solved_to_rounding() {
        let (n, full) = (700, 500);
        let mut triplets = TriMat::new((n, n));
        for i in 0..n {
            for j in (0..n).filter(|j| (i < full && *j < full) || i.abs_diff(*j) < 2) {
                let value = 1.0 / (1.0 + i.abs_diff(j) as f64) + if i == j { 2.0 } else { 0.0 };
                triplets.add_triplet(i, j, value);
            }
        }
        let (k, m): (CsMat<f64>, _) = (triplets.to_csr(), CsMat::eye(n));
        let pencil = SymmetricPencil::new(&k, &m, &vec![true; n]).expect("sound");
        let factor = pencil.cholesky(0.0).expect("positive definite");
        let exact = DMatrix::from_fn(n, 11, |row, column| ((row * 7 + column * 13) % 17) as f64 - 8.0);
        let mut x = pencil.stiffness_times(&exact).expect("sizes");
        factor.solve(&mut x).expect("sizes");
        assert!((&x - &exact).amax() < 1e-12, "{}", (&x - &exact).amax());
        let limit = 2.2;
        let count = pencil.count_below(limit).expect("no eigenvalue there");
        let modes = modes_below(&pencil, &factor, 0.0, Below { limit, count }).expect("converges");
        assert!((modes.vectors.transpose() * &modes.vectors - DMatrix::identity(count, count)).amax() < 1e-10);
        let image = pencil.stiffness_times(&modes.vectors).expect("sizes");
        let expected = &modes.vectors * DMatrix::from_diagonal(&modes.values.into());
        assert!((image - expected).amax() < 1e-6);
    }

    #[test]
    fn counts_and_modes_of_a_chain_have_closed_forms() {
        let n = 400;
        let (k, m) = (chain(n, true), CsMat::eye(n));
        let pencil = SymmetricPencil::new(&k, &m, &vec![true; n]).expect("sound");
        let factor = pencil.cholesky(0.0).expect("positive definite");
        for count in [1, 2, 7, 40, 399] {
            let limit = 0.5 * (exact(n, count) + exact(n, count + 1));
            assert_eq!(pencil.count_below(limit), Ok(count));
            let modes = modes_below(&pencil, &factor, 0.0, Below { limit, count }).expect("converges");
            for (j, value) in (1..).zip(&modes.values) {
                assert!((value / exact(n, j) - 1.0).abs() < 1e-10, "{count}, {j}: {value}");
            }
            let gram = modes.vectors.transpose() * &modes.vectors;
            assert!((gram - DMatrix::identity(count, count)).amax() < 1e-10);
        }
        let error = modes_below(&pencil, &factor, 0.0, Below { limit: exact(n, 9) * 0.99, count: 11 }).err();
        assert_eq!(error, Some(LinalgError::Incomplete { found: 8, counted: 11 }));
    }

    /// Thirty equal chains side by side: every eigenvalue thirty times, more often than a block has columns.
    #[test]
    fn eigenvalues_repeated_more_often_than_a_block_is_wide_are_all_found() {
        let (n, copies) = (20, 30);
        let mut triplets = TriMat::new((n * copies, n * copies));
        for (value, (i, j)) in chain(n, true).iter() {
            for copy in 0..copies {
                triplets.add_triplet(copy * n + i, copy * n + j, *value);
            }
        }
        let (k, m): (CsMat<f64>, _) = (triplets.to_csr(), CsMat::eye(n * copies));
        let pencil = SymmetricPencil::new(&k, &m, &vec![true; n * copies]).expect("sound");
        let factor = pencil.cholesky(0.0).expect("positive definite");
        let limit = 0.5 * (exact(n, 2) + exact(n, 3));
        assert_eq!(pencil.count_below(limit), Ok(60));
        let modes = modes_below(&pencil, &factor, 0.0, Below { limit, count: 60 }).expect("converges");
        assert!(modes.values[..30].iter().all(|value| (value / exact(n, 1) - 1.0).abs() < 1e-10));
        assert!(modes.values[30..].iter().all(|value| (value / exact(n, 2) - 1.0).abs() < 1e-10));
    }

    #[test]
    fn condition_estimates_are_close() {
        let n = 100;
        let (k, m) = (chain(n, true), CsMat::eye(n));
        let pencil = SymmetricPencil::new(&k, &m, &vec![true; n]).expect("sound");
        let factor = pencil.cholesky(0.0).expect("positive definite");
        // |K| = 4; the inverse's largest column sum is the parabola's top.
        let exact = 4.0 * 0.5 * 50.0 * 51.0;
        for scaled in [false, true] {
            let estimate = pencil.condition(&factor, 0.0, scaled).expect("sizes");
            assert!((estimate / exact - 1.0).abs() < 1e-9, "{estimate} {exact}");
        }
        // Rows in other units make the one worse, the other not.
        let units: Vec<f64> = (0..n).map(|row| if row % 2 == 0 { 1.0 } else { 1e6 }).collect();
        let mut entries = sprs::TriMat::new((n, n));
        k.iter()
            .for_each(|(value, (row, column))| entries.add_triplet(row, column, value * units[row] * units[column]));
        let scaled: CsMat<f64> = entries.to_csr();
        let pencil = SymmetricPencil::new(&scaled, &m, &vec![true; n]).expect("sound");
        let factor = pencil.cholesky(0.0).expect("positive definite");
        assert!(pencil.condition(&factor, 0.0, false).expect("sizes") > 1e10 * exact);
        let estimate = pencil.condition(&factor, 0.0, true).expect("sizes");
        assert!((estimate / exact - 1.0).abs() < 1e-6, "{estimate} {exact}");
    }

    #[test]
    fn free_chain_and_bad_shapes_are_errors() {
        let (mut k, m) = (chain(10, true), CsMat::eye(10));
        k.data_mut()[0] = 0.5;
        let pencil = SymmetricPencil::new(&k, &m, &[true; 10]).expect("sound");
        assert_eq!(pencil.cholesky(0.0).err(), Some(LinalgError::NotPositiveDefinite { order: 10 }));
        assert_eq!(pencil.count_below(0.0), Ok(1));
        assert!(pencil.cholesky(1.0).is_ok());
        assert!(matches!(pencil.mass_times(&DMatrix::zeros(9, 1)), Err(LinalgError::Shape { .. })));
        k.data_mut()[0] = f64::NAN;
        assert_eq!(SymmetricPencil::new(&k, &m, &[true; 10]).err(), Some(LinalgError::NotFinite { order: 10 }));
        let wide: CsMat<f64> = CsMat::zero((2, 3));
        assert!(matches!(SymmetricPencil::new(&wide, &m, &[true; 10]), Err(LinalgError::Shape { .. })));
    }
}
