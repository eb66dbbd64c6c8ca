//! The eigenpairs near a window of poles.

use std::ops::Range;

use nalgebra::DMatrix;

use super::small::solve as solve_small;
use super::sums::{LeftOut, Poles};
use crate::linalg::{SymmetricEigen, cholesky, solve_lower, symmetric_eigen};

/// Poles whose rows of the matrix are kept as they are.
pub(super) const SIZE: usize = 12;
/// Share of `H_far / centre` by which its slope is raised, so that it is positive definite where far poles hardly couple; the
/// perturbation takes it back.
const SLOPE: f64 = 1e-3;
/// Largest share of another pair in a vector for which the perturbation is trusted.
const LARGEST_SHARE: f64 = 0.3;
/// Steps of the perturbation.
const STEPS: usize = 8;
/// Change of a value, relative, at which it has come to rest: the next one is smaller still, and Rayleigh's quotient has its square.
const AT_REST: f64 = 1e-12;

/// The pencil of `T` around `centre`, solved: `T_lin(nu) = B' diag(eta + centre - nu) B` in coordinates in which `-T_lin'` is 1.
pub(super) struct Window {
    /// Range of the kept poles.
    pub poles: Range<usize>,
    /// Between these lies no pole but those kept.
    free: (f64, f64),
    /// Centre, at which the pencil is exact.
    pub centre: f64,
    /// Distances of the pencil's eigenvalues from the centre, falling.
    pub eta: Vec<f64>,
    /// Vectors over the kept poles (poles x pairs).
    vectors: DMatrix<f64>,
    /// `q` of its pairs (r x pairs).
    coupled: DMatrix<f64>,
    /// Amount that was added to the slope of `-H_far`.
    raised: f64,
    /// `1 / (centre - nu_i)^2` of far poles, 0 of those kept.
    curvature: Vec<f64>,
}

/// A pair of T.
pub(super) struct PencilPair {
    pub value: f64,
    /// Over the window's poles.
    near: Vec<f64>,
    q: Vec<f64>,
}

/// Result for a pair of the pencil.
pub(super) enum Outcome {
    Found(PencilPair),
    /// The value did not converge; the last one, if it can serve as a centre.
    Open(Option<f64>),
}

/// Memory that refinements share.
pub(super) struct Scratch {
    /// `E`.
    e: DMatrix<f64>,
    /// `G`, and `I + G E` by rows.
    g: Vec<f64>,
    matrix: Vec<f64>,
    q: Vec<f64>,
    /// `E q`.
    force: Vec<f64>,
    /// Shares of the window's pairs in a vector.
    shares: Vec<f64>,
}

impl Scratch {
    pub fn new(rank: usize) -> Self {
        let zeros = |len: usize| vec![0.0; len];
        let (g, matrix) = (zeros(rank * rank), zeros(rank * rank));
        Self {
            e: DMatrix::zeros(rank, rank),
            g,
            matrix,
            q: zeros(rank),
            force: zeros(rank),
            shares: zeros(SIZE + rank),
        }
    }
}

impl Window {
    /// Solves the pencil; `None` if its eigenvalues do not converge. `poles` leaves out the window's after this.
    pub fn new(values: &[f64], columns: &DMatrix<f64>, poles: &mut Poles, centre: f64) -> Option<Self> {
        let (n, r) = columns.shape();
        let first = values.partition_point(|value| *value > centre).saturating_sub(SIZE / 2);
        let first = first.min(n.saturating_sub(SIZE));
        let kept = first..(first + SIZE).min(n);
        poles.leave_out(kept.clone());
        let mut factors = vec![0.0; poles.padded()];
        let is_far = |i: &usize| !kept.contains(i);
        (0..n).filter(is_far).for_each(|i| factors[i] = 1.0);
        let mut h = DMatrix::zeros(r, r);
        poles.sum(centre, &factors, &mut h);
        h.neg_mut();
        (0..r).for_each(|k| h[(k, k)] += 1.0);
        (0..n).filter(is_far).for_each(|i| factors[i] /= centre - values[i]);
        let mut slope = DMatrix::zeros(r, r);
        poles.sum(centre, &factors, &mut slope);
        let raised = SLOPE * h.diagonal().abs().mean() / centre;
        (0..r).for_each(|k| slope[(k, k)] += raised);
        factors.iter_mut().for_each(|factor| *factor *= *factor);
        let (eigen, l) = solve(&values[kept.clone()], &columns.rows(kept.start, kept.len()), Far { centre, h, slope })?;
        let size = kept.len();
        let mut order: Vec<usize> = (0..eigen.values.len()).collect();
        order.reverse();
        let vectors = eigen.vectors.select_columns(&order);
        let mut coupled = vectors.rows(size, r).into_owned();
        if !l.tr_solve_lower_triangular_mut(&mut coupled) {
            return None;
        }
        let above = kept.start.checked_sub(1).map_or(f64::INFINITY, |i| values[i]);
        let below = values.get(kept.end).copied().unwrap_or(f64::NEG_INFINITY);
        Some(Self {
            poles: kept,
            free: (below, above),
            centre,
            eta: order.iter().map(|&i| eigen.values[i]).collect(),
            vectors: vectors.rows(0, size).into_owned(),
            coupled,
            raised,
            curvature: factors,
        })
    }

    /// Number of eigenvalues of the whole problem above the centre.
    pub fn above(&self) -> usize {
        self.poles.start + self.eta.iter().take_while(|eta| **eta > 0.0).count()
    }

    /// The pair of T that one of the pencil turns into: with `E = T - T_lin`, `delta = nu - centre`, the others' shares
    /// `x_j = -c_j' E q / (eta_j - delta)`, and `delta = eta + c' E q` by Newton's method, the slope of E taken as `2 E / delta`.
    pub fn refine(&self, rank: usize, poles: &mut Poles, scratch: &mut Scratch) -> Outcome {
        let eta = self.eta[rank];
        let mut delta = eta;
        for _ in 0..STEPS {
            let value = self.centre + delta;
            if !(value > self.free.0 && value < self.free.1) {
                return Outcome::Open(None);
            }
            let e = &mut scratch.e;
            poles.sum(value, &self.curvature, e);
            *e *= delta * delta;
            (0..e.nrows()).for_each(|k| e[(k, k)] += delta * self.raised);
            if !self.couple(rank, delta, scratch) || self.largest_share(rank, delta, scratch) > LARGEST_SHARE {
                return Outcome::Open(None);
            }
            let shift = dot(self.coupled_of(rank), &scratch.force);
            let slope = if delta == 0.0 { 1.0 } else { 1.0 - 2.0 * shift / delta };
            let change = (delta - eta - shift) / if slope > 0.5 { slope } else { 1.0 };
            delta -= change;
            if change.abs() <= AT_REST * (self.centre + delta).abs() {
                scratch.shares[rank] = 1.0;
                return Outcome::Found(PencilPair {
                    value: self.centre + delta,
                    near: self.near(&scratch.shares),
                    q: scratch.q.clone(),
                });
            }
        }
        Outcome::Open(Some(self.centre + delta))
    }

    /// `q` of a pair of the pencil.
    fn coupled_of(&self, rank: usize) -> &[f64] {
        let r = self.coupled.nrows();
        &self.coupled.as_slice()[rank * r..(rank + 1) * r]
    }

    /// `q` with `(I + G E) q = c`, `G = sum c_j c_j' / (eta_j - delta)` over the other pairs, and `E q`. Whether there is one.
    fn couple(&self, rank: usize, delta: f64, scratch: &mut Scratch) -> bool {
        let r = self.coupled.nrows();
        let Scratch { e, g, matrix, q, force, .. } = scratch;
        let e = e.as_slice();
        g.fill(0.0);
        for (j, eta) in self.eta.iter().enumerate().filter(|(j, _)| *j != rank) {
            let (weight, c) = ((eta - delta).recip(), self.coupled_of(j));
            for (row, value) in g.chunks_exact_mut(r).zip(c) {
                let scaled = weight * value;
                row.iter_mut().zip(c).for_each(|(sum, value)| *sum += scaled * value);
            }
        }
        for (i, (row, g)) in matrix.chunks_exact_mut(r).zip(g.chunks_exact(r)).enumerate() {
            // E is symmetric: its columns are its rows.
            row.iter_mut().zip(e.chunks_exact(r)).for_each(|(entry, e)| *entry = dot(g, e));
            row[i] += 1.0;
        }
        q.copy_from_slice(self.coupled_of(rank));
        if !solve_small(matrix, q) {
            return false;
        }
        force.iter_mut().zip(e.chunks_exact(r)).for_each(|(force, e)| *force = dot(e, q));
        true
    }

    /// Shares of the other pairs in a vector; the largest of them.
    fn largest_share(&self, rank: usize, delta: f64, scratch: &mut Scratch) -> f64 {
        let Scratch { force, shares, .. } = scratch;
        let mut largest = 0.0_f64;
        for (j, (share, eta)) in shares.iter_mut().zip(&self.eta).enumerate() {
            *share = if j == rank { 0.0 } else { -dot(self.coupled_of(j), force) / (eta - delta) };
            // A share that is not a number is not small.
            largest = if share.is_nan() { f64::INFINITY } else { largest.max(share.abs()) };
        }
        largest
    }

    /// A vector over the window's poles.
    fn near(&self, shares: &[f64]) -> Vec<f64> {
        let mut near = vec![0.0; self.poles.len()];
        for (column, share) in self.vectors.column_iter().zip(shares) {
            near.iter_mut().zip(column.iter()).for_each(|(sum, value)| *sum += share * value);
        }
        near
    }

    /// Writes the unit vector of a pair over all poles; `poles` leaves out the window's.
    pub fn vector(&self, pair: &PencilPair, poles: &mut Poles, out: &mut [f64]) {
        poles.vector(pair.value, &pair.q, LeftOut { poles: self.poles.clone(), near: &pair.near }, out);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Contribution of the poles beyond a window: a matrix and its slope at the window's centre.
struct Far {
    centre: f64,
    h: DMatrix<f64>,
    slope: DMatrix<f64>,
}

/// The pencil's eigenvalues less the centre, rising, its vectors, and the factor of its slope.
fn solve(
    values: &[f64],
    columns: &nalgebra::DMatrixView<'_, f64>,
    Far { centre, h, slope }: Far,
) -> Option<(SymmetricEigen, DMatrix<f64>)> {
    let (size, r) = columns.shape();
    let l = cholesky(slope).ok()?;
    let mut coupling = columns.transpose();
    solve_lower(&l, &mut coupling).ok()?;
    let mut h = h;
    solve_lower(&l, &mut h).ok()?;
    h.transpose_mut();
    solve_lower(&l, &mut h).ok()?;
    let mut matrix = DMatrix::zeros(size + r, size + r);
    for (i, value) in values.iter().enumerate() {
        matrix[(i, i)] = value - centre;
    }
    // Only the lower triangle is read.
    matrix.view_mut((size, 0), (r, size)).copy_from(&coupling);
    matrix.view_mut((size, size), (r, r)).copy_from(&-h);
    Some((symmetric_eigen(&matrix).ok()?, l))
}
