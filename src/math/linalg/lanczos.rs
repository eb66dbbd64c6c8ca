//! Lowest eigenpairs of a symmetric sparse pencil: block Lanczos on the inverse, with full reorthogonalisation.
//!
//! With `K + shift M = L L'` the operator `C = L^-1 M L^-T` has the eigenvalues `theta = 1 / (lambda + shift)` and, for a
//! positive semidefinite M, none below 0: DOFs without mass only add zeros. The basis V stays orthonormal to rounding, so the
//! modes from `V' C V` are orthogonal in K and M to rounding however far the iteration went, and eigenvalues converge with
//! the square of the residual. Blocks find repeated eigenvalues; the number of eigenvalues that must be there comes from the
//! inertia of `K - limit M`, and the iteration continues, with new random directions where needed, until all are found.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector, DVectorView};
use sprs::CsMat;

use super::LinalgError;
use super::dense::{symmetric_eigen, symmetric_eigenvalues, view, view_mut};
use super::panel::{WIDTH, orthogonalise, pack, unpack};
use super::pencil::{PencilFactor, SymmetricPencil};

/// Columns of a block: the factor is read once per block and solve, and eigenvalues may be this often repeated. More columns
/// make a solve cheaper per column, but the basis larger.
const BLOCK: usize = 8;
/// Residual at which an eigenpair of C counts as found, relative to its eigenvalue; the eigenvalue is then exact to
/// rounding.
const TOLERANCE: f64 = 1e-8;
/// Relative distance within which an eigenvalue cannot be distinguished from the limit.
const AT_LIMIT: f64 = 1e-8;
/// Times that new random directions are added before missing eigenvalues become an error.
const INJECTIONS: usize = 4;

/// Eigenpairs of `K x = lambda M x`.
#[derive(Debug, Clone)]
pub struct PencilModes {
    /// Eigenvalues lambda, rising.
    pub values: Vec<f64>,
    /// Eigenvectors by column, `X' M X = I`, in the order of the pencil.
    pub vectors: DMatrix<f64>,
    /// Columns of the basis that was needed.
    pub basis: usize,
}

/// Eigenvalues that were counted before they are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Below {
    /// Upper limit of the eigenvalues.
    pub limit: f64,
    /// Number of eigenvalues, from [`SymmetricPencil::count_below`] at the same limit.
    pub count: usize,
}

/// Eigenpairs below a limit; `factor`: factor of `K + shift M`.
///
/// # Errors
/// More or fewer eigenvalues than `count` below the limit (a wrong count, or an indefinite M), not enough memory.
pub fn modes_below(
    pencil: &SymmetricPencil,
    factor: &PencilFactor,
    shift: f64,
    Below { limit, count }: Below,
) -> Result<PencilModes, LinalgError> {
    let order = pencil.order();
    if count == 0 {
        return Ok(PencilModes { values: Vec::new(), vectors: DMatrix::zeros(order, 0), basis: 0 });
    }
    if count > order {
        return Err(LinalgError::Incomplete { found: order, counted: count });
    }
    let mut krylov = Krylov::new(pencil, factor)?;
    let mut injections = 0;
    let mut next_check = count;
    loop {
        krylov.expand()?;
        let exhausted = krylov.open == 0;
        if krylov.done < next_check && !exhausted {
            continue;
        }
        // An examination of T is cheap compared with a block of solutions while T is small.
        next_check = krylov.done + BLOCK.max(krylov.done.saturating_sub(300) / 8);
        let ritz = krylov.ritz()?;
        let value = |index: usize| ritz.theta.get(index).map(|theta| theta.recip() - shift);
        let converged = |index: usize| ritz.residual[index] <= TOLERANCE * ritz.theta[index];
        if !(exhausted || (0..count).all(converged)) {
            continue;
        }
        let beyond = value(count - 1).is_none_or(|last| last > limit * (1.0 + AT_LIMIT));
        let within = value(count).is_some_and(|next| next > 0.0 && next < limit * (1.0 - AT_LIMIT));
        if within || (beyond && (exhausted || injections == INJECTIONS)) {
            let found = (0..ritz.theta.len()).filter_map(value).take_while(|value| *value < limit).count();
            return Err(LinalgError::Incomplete { found, counted: count });
        }
        if !beyond {
            return krylov.modes(&ritz, shift, count);
        }
        injections += 1;
        krylov.inject()?;
    }
}

/// The basis `V`, of which the first `done` columns have been multiplied by C, and `T = V' C V` of those.
struct Krylov<'p> {
    pencil: &'p SymmetricPencil<'p>,
    factor: &'p PencilFactor,
    order: usize,
    basis: Vec<f64>,
    done: usize,
    /// Columns at the end of the basis that C has not been applied to.
    open: usize,
    t: DMatrix<f64>,
    /// Coupling of the open block (rows) with the last block that is done (columns).
    coupling: DMatrix<f64>,
    random: Random,
}

/// Eigenvalues of T, falling, with their vectors and the norms of their residuals.
struct Ritz {
    theta: Vec<f64>,
    residual: Vec<f64>,
    vectors: DMatrix<f64>,
}

impl<'p> Krylov<'p> {
    fn new(pencil: &'p SymmetricPencil<'p>, factor: &'p PencilFactor) -> Result<Self, LinalgError> {
        let order = pencil.order();
        let mut krylov = Self {
            pencil,
            factor,
            order,
            basis: Vec::new(),
            done: 0,
            open: 0,
            t: DMatrix::zeros(0, 0),
            coupling: DMatrix::zeros(0, 0),
            random: Random(0x2545_f491_4f6c_dd1d),
        };
        let mut start = DMatrix::zeros(order, BLOCK.min(order));
        start.iter_mut().for_each(|value| *value = krylov.random.next());
        // One product removes parts without mass.
        let start = pencil.inverse_times(factor, &start)?;
        krylov.append(start)?;
        krylov.coupling = DMatrix::zeros(krylov.open, 0);
        Ok(krylov)
    }

    fn columns(&self) -> usize {
        self.done + self.open
    }

    /// Applies C to the open block, extends T, and opens the next block with the new directions.
    fn expand(&mut self) -> Result<(), LinalgError> {
        let (first, width) = (self.done, self.open);
        let block = DMatrix::from_column_slice(self.order, width, &self.basis[first * self.order..]);
        let mut image = self.pencil.inverse_times(self.factor, &block)?;
        let projections = self.orthogonalise(&mut image);
        let diagonal = projections.rows(first, width).into_owned();
        let diagonal = (&diagonal + diagonal.transpose()) * 0.5;
        self.t.resize_mut(first + width, first + width, 0.0);
        self.t.view_mut((first, first), (width, width)).copy_from(&diagonal);
        let previous = self.coupling.ncols();
        self.t.view_mut((first, first - previous), (width, previous)).copy_from(&self.coupling);
        self.t.view_mut((first - previous, first), (previous, width)).copy_from(&self.coupling.transpose());
        self.done += width;
        self.open = 0;
        self.coupling = self.append(image)?;
        Ok(())
    }

    /// Takes the components along the basis out of `w`, twice; returns their coefficients.
    fn orthogonalise(&self, w: &mut DMatrix<f64>) -> DMatrix<f64> {
        let mut total = DMatrix::zeros(self.columns(), w.ncols());
        let (mut panel, basis) = (Vec::new(), &self.basis[..self.order * self.columns()]);
        for first in (0..w.ncols()).step_by(WIDTH) {
            pack(w, first, &mut panel);
            unpack(&orthogonalise(basis, &mut panel), first, &mut total);
            unpack(&panel, first, w);
        }
        total
    }

    /// Appends an orthonormal basis Q of `w` (orthogonal to the basis) as the open block; returns R of `w = Q R`. A column
    /// that has nothing new is replaced by a random direction, with zeros in R, as long as there is room.
    fn append(&mut self, w: DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        let width = w.ncols().min(self.order - self.columns());
        let scale = w.column_iter().map(|column| column.norm()).fold(self.t.amax(), f64::max);
        if !scale.is_finite() {
            return Err(LinalgError::NotFinite { order: self.order });
        }
        let mut r = DMatrix::zeros(width, w.ncols());
        let mut accepted = 0;
        for (index, column) in w.column_iter().enumerate() {
            let mut column = DVector::from_column_slice(column.as_slice());
            let before = column.norm();
            self.against_block(&mut column, accepted, |row, value| r[(row, index)] += value);
            let norm = column.norm();
            if accepted == width || norm <= 1e-15 * scale {
                continue;
            }
            column.unscale_mut(norm);
            // If much cancelled within the block, the remainder may not be orthogonal to the basis.
            if norm > 1e-3 * before || self.clean(&mut column, accepted) {
                r[(accepted, index)] = norm;
                self.push(&column)?;
                accepted += 1;
            }
        }
        while accepted < width {
            self.push_random(accepted)?;
            accepted += 1;
        }
        self.open = width;
        Ok(r)
    }

    /// Takes the components along the `accepted` last columns of the basis out of a vector, twice.
    fn against_block(&self, column: &mut DVector<f64>, accepted: usize, mut found: impl FnMut(usize, f64)) {
        let first = self.basis.len() - accepted * self.order;
        for _ in 0..2 {
            for (row, known) in self.basis[first..].chunks_exact(self.order).enumerate() {
                let known = DVectorView::from_slice(known, self.order);
                let value = known.dot(column);
                column.axpy(-value, &known, 1.0);
                found(row, value);
            }
        }
    }

    /// Makes a unit vector orthogonal to all columns so far, the `accepted` ones of the block being built included: repeated
    /// until nothing more is taken out. Returns `false` for a vector that is all within the basis.
    fn clean(&self, column: &mut DVector<f64>, accepted: usize) -> bool {
        const ROUNDS: usize = 8;
        for _ in 0..ROUNDS {
            let mut block = DMatrix::from_column_slice(self.order, 1, column.as_slice());
            self.orthogonalise(&mut block);
            column.copy_from_slice(block.as_slice());
            self.against_block(column, accepted, |_, _| {});
            let norm = column.norm();
            if norm == 0.0 {
                return false;
            }
            column.unscale_mut(norm);
            if norm > 0.5 {
                return true;
            }
        }
        false
    }

    fn push_random(&mut self, accepted: usize) -> Result<(), LinalgError> {
        let random = &mut self.random;
        let mut column = DVector::from_fn(self.order, |_, _| random.next());
        column.normalize_mut();
        if !self.clean(&mut column, accepted) {
            return Err(LinalgError::NoConvergence { order: self.order });
        }
        self.push(&column)
    }

    fn push(&mut self, column: &DVector<f64>) -> Result<(), LinalgError> {
        if self.basis.capacity() < self.basis.len() + self.order {
            let more = self.order * BLOCK.max(self.columns() / 4);
            self.basis.try_reserve_exact(more).map_err(|_| LinalgError::OutOfMemory { order: self.order })?;
        }
        self.basis.extend_from_slice(column.as_slice());
        Ok(())
    }

    /// Widens the open block by random directions.
    fn inject(&mut self) -> Result<(), LinalgError> {
        let extra = BLOCK.min(self.order - self.columns());
        for _ in 0..extra {
            // The open block is part of the basis here.
            self.push_random(0)?;
            self.open += 1;
        }
        self.coupling.resize_vertically_mut(self.open, 0.0);
        Ok(())
    }

    fn ritz(&self) -> Result<Ritz, LinalgError> {
        let eigen = symmetric_eigen(&self.t)?;
        let (size, last) = (self.done, self.coupling.ncols());
        let falling: Vec<usize> = (0..size).rev().collect();
        let vectors = eigen.vectors.select_columns(&falling);
        let tail = &self.coupling * vectors.rows(size - last, last);
        Ok(Ritz {
            theta: falling.iter().map(|&index| eigen.values[index]).collect(),
            residual: tail.column_iter().map(|column| column.norm()).collect(),
            vectors,
        })
    }

    /// `X = L^-T V S / sqrt(theta)` of the first `count` Ritz pairs.
    fn modes(self, ritz: &Ritz, shift: f64, count: usize) -> Result<PencilModes, LinalgError> {
        let mut vectors = DMatrix::zeros(self.order, count);
        let chosen = ritz.vectors.columns(0, count).into_owned();
        let used = MatRef::from_column_major_slice(&self.basis[..self.order * self.done], self.order, self.done);
        let target: MatMut<f64> = view_mut(&mut vectors);
        matmul(target, Accum::Replace, used, view(&chosen), 1.0, Par::Seq);
        let (factor, basis) = (self.factor, self.done);
        drop(self.basis);
        factor.solve_lower_transposed(&mut vectors)?;
        for (mut column, theta) in vectors.column_iter_mut().zip(&ritz.theta) {
            column.unscale_mut(theta.sqrt());
        }
        Ok(PencilModes {
            values: ritz.theta[..count].iter().map(|theta| theta.recip() - shift).collect(),
            vectors,
            basis,
        })
    }
}

/// Numbers between -1 and 1 (xorshift64*): always the same sequence.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// An upper bound of the smallest eigenvalue of `D^-1/2 A D^-1/2`, D the diagonal of a symmetric A; rows whose diagonal is 0
/// are left out. Exact for small matrices; for large ones eigenvalues that stand apart at the lower end are found.
///
/// # Errors
/// Entries that are not finite.
pub fn lowest_eigenvalue(a: &CsMat<f64>) -> Result<f64, LinalgError> {
    const STEPS: usize = 60;
    let scale: Vec<f64> = (0..a.rows())
        .map(|row| a.get(row, row).map_or(0.0, |value| if *value > 0.0 { value.sqrt().recip() } else { 0.0 }))
        .collect();
    let size = scale.iter().filter(|value| **value > 0.0).count();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut vector =
        DVector::from_iterator(scale.len(), scale.iter().map(|s| if *s > 0.0 { random.next() } else { 0.0 }));
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let (mut diagonal, mut couplings) = (Vec::new(), Vec::new());
    while basis.len() < STEPS.min(size) {
        let norm = vector.norm();
        if !norm.is_finite() {
            return Err(LinalgError::NotFinite { order: a.rows() });
        }
        if norm < 1e-13 {
            break;
        }
        couplings.push(norm);
        vector.unscale_mut(norm);
        let mut image = DVector::zeros(scale.len());
        for (row, view) in a.outer_iterator().enumerate() {
            let sum: f64 = view.iter().map(|(column, value)| value * scale[column] * vector[column]).sum();
            image[row] = scale[row] * sum;
        }
        diagonal.push(image.dot(&vector));
        basis.push(vector);
        for _ in 0..2 {
            for known in &basis {
                let value = known.dot(&image);
                image.axpy(-value, known, 1.0);
            }
        }
        vector = image;
    }
    let t = DMatrix::from_fn(diagonal.len(), diagonal.len(), |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => couplings[i.max(j)],
        _ => 0.0,
    });
    Ok(symmetric_eigenvalues(&t)?.first().copied().unwrap_or(0.0))
}
