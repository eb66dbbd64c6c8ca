//! Solutions with a supernodal factor for eight right-hand sides at a time.
//!
//! The factor of a large structure does not fit into any cache, so the time of a solution is the time to read it once. A panel holds
//! eight values of a row next to each other. Every number of the factor is read once, in the order in which it is stored, for two or more
//! vector registers.

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

/// Columns of a panel.
pub const WIDTH: usize = 8;
/// Columns of the factor that are processed together: as many as fit into the registers with their operands.
const TOGETHER: usize = 4;
/// Columns of the factor after which the rows below are treated, and rows that stay in the nearest cache meanwhile.
const STRIP: usize = 32;
const TILE: usize = 256;

/// The values of one row in the columns of a panel.
pub type PanelRow = [f64; WIDTH];

/// Columns `first..first + WIDTH` of a matrix by rows; zeros where it has no more columns.
pub fn pack(matrix: &DMatrix<f64>, first: usize, panel: &mut Vec<PanelRow>) {
    panel.clear();
    panel.resize(matrix.nrows(), [0.0; WIDTH]);
    for column in 0..WIDTH.min(matrix.ncols() - first) {
        for (row, value) in panel.iter_mut().zip(&matrix.column(first + column)) {
            row[column] = *value;
        }
    }
}

/// The way back.
pub fn unpack(panel: &[PanelRow], first: usize, matrix: &mut DMatrix<f64>) {
    for column in 0..WIDTH.min(matrix.ncols() - first) {
        for (row, value) in panel.iter().zip(matrix.column_mut(first + column).iter_mut()) {
            *value = row[column];
        }
    }
}

/// Solves `L X = B` in place.
pub fn solve_lower(factor: SupernodalLltRef<'_, usize, f64>, panel: &mut [PanelRow]) {
    Arch::new().dispatch(Lower { factor, panel });
}

/// Solves `L' X = B` in place.
pub fn solve_lower_transposed(factor: SupernodalLltRef<'_, usize, f64>, panel: &mut [PanelRow]) {
    Arch::new().dispatch(LowerTransposed { factor, panel });
}

struct Lower<'a> {
    factor: SupernodalLltRef<'a, usize, f64>,
    panel: &'a mut [PanelRow],
}

impl WithSimd for Lower<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut work = Vec::new();
        for index in 0..self.factor.symbolic().n_supernodes() {
            let node = Node::new(self.factor, index);
            work.clear();
            work.extend_from_slice(&self.panel[node.rows()]);
            work.resize(node.height, [0.0; WIDTH]);
            for strip in strips(node.width) {
                let below = strip.end;
                for columns in together(strip.clone()) {
                    node.solve_triangle(&columns, &mut work);
                    node.subtract(simd, &columns, columns.end..below, &mut work);
                }
                for first in (below..node.height).step_by(TILE) {
                    let tile = first..node.height.min(first + TILE);
                    together(strip.clone()).for_each(|columns| node.subtract(simd, &columns, tile.clone(), &mut work));
                }
            }
            self.panel[node.rows()].copy_from_slice(&work[..node.width]);
            for (&row, change) in node.pattern.iter().zip(&work[node.width..]) {
                self.panel[row].iter_mut().zip(change).for_each(|(value, change)| *value += change);
            }
        }
    }
}

struct LowerTransposed<'a> {
    factor: SupernodalLltRef<'a, usize, f64>,
    panel: &'a mut [PanelRow],
}

impl WithSimd for LowerTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut work = Vec::new();
        for index in (0..self.factor.symbolic().n_supernodes()).rev() {
            let node = Node::new(self.factor, index);
            work.clear();
            work.extend_from_slice(&self.panel[node.rows()]);
            work.extend(node.pattern.iter().map(|&row| self.panel[row]));
            for strip in strips(node.width).rev() {
                let below = strip.end;
                for first in (below..node.height).step_by(TILE) {
                    let tile = first..node.height.min(first + TILE);
                    together(strip.clone())
                        .for_each(|columns| node.subtract_transposed(simd, &columns, tile.clone(), &mut work));
                }
                for columns in together(strip).rev() {
                    node.subtract_transposed(simd, &columns, columns.end..below, &mut work);
                    node.solve_transposed_triangle(&columns, &mut work);
                }
            }
            self.panel[node.rows()].copy_from_slice(&work[..node.width]);
        }
    }
}

/// Parts of `0..width` of at most [`STRIP`] columns.
fn strips(width: usize) -> impl DoubleEndedIterator<Item = Range<usize>> {
    (0..width).step_by(STRIP).map(move |first| first..width.min(first + STRIP))
}

/// Parts of a strip of at most [`TOGETHER`] columns.
fn together(strip: Range<usize>) -> impl DoubleEndedIterator<Item = Range<usize>> {
    strip.clone().step_by(TOGETHER).map(move |first| first..strip.end.min(first + TOGETHER))
}

/// A supernode: columns with the same rows, stored as a dense trapezoid by columns.
struct Node<'a> {
    begin: usize,
    /// Columns.
    width: usize,
    /// Number of rows, including the triangle.
    height: usize,
    /// Rows of the factor below the triangle.
    pattern: &'a [usize],
    values: &'a [f64],
}

impl<'a> Node<'a> {
    fn new(factor: SupernodalLltRef<'a, usize, f64>, index: usize) -> Self {
        let node = factor.supernode(index);
        let (height, width) = node.val().shape();
        let values = &factor.values()[factor.symbolic().col_ptr_for_val()[index]..][..height * width];
        Self { begin: node.start(), width, height, pattern: node.pattern(), values }
    }

    /// Rows of the panel that the triangle meets.
    fn rows(&self) -> Range<usize> {
        self.begin..self.begin + self.width
    }

    fn column(&self, column: usize) -> &'a [f64] {
        &self.values[column * self.height..][..self.height]
    }

    /// `x = L^-1 x` with the small triangle of some columns.
    #[inline(always)]
    fn solve_triangle(&self, columns: &Range<usize>, x: &mut [PanelRow]) {
        for j in columns.clone() {
            let (known, rest) = x.split_at_mut(j + 1);
            let (known, column) = (&mut known[j], self.column(j));
            known.iter_mut().for_each(|value| *value /= column[j]);
            for (row, factor) in rest.iter_mut().zip(&column[j + 1..columns.end]) {
                row.iter_mut().zip(&*known).for_each(|(value, known)| *value -= factor * known);
            }
        }
    }

    /// `x = L'^-1 x` with the small triangle of some columns.
    #[inline(always)]
    fn solve_transposed_triangle(&self, columns: &Range<usize>, x: &mut [PanelRow]) {
        for j in columns.clone().rev() {
            let (open, known) = x.split_at_mut(j + 1);
            let (open, column) = (&mut open[j], self.column(j));
            for (row, factor) in known.iter().zip(&column[j + 1..columns.end]) {
                open.iter_mut().zip(row).for_each(|(value, known)| *value -= factor * known);
            }
            open.iter_mut().for_each(|value| *value /= column[j]);
        }
    }

    /// Subtracts the contribution of the rows `columns` of `x` from the rows `tile` below.
    #[inline(always)]
    fn subtract<S: Simd>(&self, simd: S, columns: &Range<usize>, tile: Range<usize>, x: &mut [PanelRow]) {
        let (known, below) = x.split_at_mut(tile.start);
        let entries = segments(columns, |column| &self.column(column)[tile.clone()]);
        subtract(simd, entries, &known[columns.clone()], below);
    }

    /// Subtracts the contribution of the rows `tile` of `x` from the rows `columns` above.
    #[inline(always)]
    fn subtract_transposed<S: Simd>(&self, simd: S, columns: &Range<usize>, tile: Range<usize>, x: &mut [PanelRow]) {
        let (open, below) = x.split_at_mut(tile.start);
        let entries = segments(columns, |column| &self.column(column)[tile.clone()]);
        subtract_transposed(simd, entries, below, &mut open[columns.clone()]);
    }
}

/// Columns processed together; the last one fills missing places.
#[inline(always)]
fn segments<'a>(columns: &Range<usize>, column: impl Fn(usize) -> &'a [f64]) -> [&'a [f64]; TOGETHER] {
    std::array::from_fn(|index| column((columns.start + index).min(columns.end - 1)))
}

/// `rows -= entries factors`; as many rows as the entries have.
#[inline(always)]
fn subtract<S: Simd>(simd: S, entries: [&[f64]; TOGETHER], factors: &[PanelRow], rows: &mut [PanelRow]) {
    let mut registers = [[simd.splat_f64s(0.0); WIDTH]; TOGETHER];
    for (registers, row) in registers.iter_mut().zip(factors) {
        let (row, _) = S::as_simd_f64s(row);
        registers.iter_mut().zip(row).for_each(|(register, value)| *register = simd.neg_f64s(*value));
    }
    let [a, b, c, d] = entries;
    for ((((row, a), b), c), d) in rows.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let entries = [a, b, c, d].map(|entry| simd.splat_f64s(*entry));
        let (row, _) = S::as_mut_simd_f64s(row);
        for (index, value) in row.iter_mut().enumerate() {
            let terms = entries.iter().zip(&registers);
            *value = terms.fold(*value, |sum, (entry, factor)| simd.mul_add_f64s(*entry, factor[index], sum));
        }
    }
}

/// `sums -= entries' rows`; as many rows as the entries have.
#[inline(always)]
fn subtract_transposed<S: Simd>(simd: S, entries: [&[f64]; TOGETHER], rows: &[PanelRow], sums: &mut [PanelRow]) {
    let mut registers = [[simd.splat_f64s(0.0); WIDTH]; TOGETHER];
    let [a, b, c, d] = entries;
    for ((((row, a), b), c), d) in rows.iter().zip(a).zip(b).zip(c).zip(d) {
        let entries = [a, b, c, d].map(|entry| simd.splat_f64s(*entry));
        let (row, _) = S::as_simd_f64s(row);
        for (index, value) in row.iter().enumerate() {
            for (entry, register) in entries.iter().zip(&mut registers) {
                register[index] = simd.mul_add_f64s(*entry, *value, register[index]);
            }
        }
    }
    for (sum, registers) in sums.iter_mut().zip(&registers) {
        let (sum, _) = S::as_mut_simd_f64s(sum);
        sum.iter_mut().zip(registers).for_each(|(value, change)| *value = simd.sub_f64s(*value, *change));
    }
}

/// Takes the components along an orthonormal basis (columns, one after the other) out of a panel, twice; returns their
/// coefficients.
pub fn orthogonalise(basis: &[f64], panel: &mut [PanelRow]) -> Vec<PanelRow> {
    Arch::new().dispatch(Orthogonalisation { basis, panel })
}

struct Orthogonalisation<'a> {
    basis: &'a [f64],
    panel: &'a mut [PanelRow],
}

impl WithSimd for Orthogonalisation<'_> {
    type Output = Vec<PanelRow>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<PanelRow> {
        let order = self.panel.len();
        let count = self.basis.len() / order.max(1);
        let tiles = || (0..order).step_by(TILE).map(|first| first..order.min(first + TILE));
        let entries = |columns: &Range<usize>, tile: &Range<usize>| {
            segments(columns, |column| &self.basis[column * order..][tile.clone()])
        };
        let mut total = vec![[0.0; WIDTH]; count];
        for _ in 0..2 {
            let mut part = vec![[0.0; WIDTH]; count];
            for tile in tiles() {
                for columns in together(0..count) {
                    let sums = &mut part[columns.clone()];
                    subtract_transposed(simd, entries(&columns, &tile), &self.panel[tile.clone()], sums);
                }
            }
            part.iter_mut().for_each(|row| row.iter_mut().for_each(|value| *value = -*value));
            for tile in tiles() {
                for columns in together(0..count) {
                    subtract(simd, entries(&columns, &tile), &part[columns.clone()], &mut self.panel[tile.clone()]);
                }
            }
            let terms = total.iter_mut().flatten().zip(part.iter().flatten());
            terms.for_each(|(total, part)| *total += part);
        }
        total
    }
}
