//! The eigenpairs near a window of poles.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::sums::Poles;
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
/// Change of a value, relative, at which it has come to rest.
const AT_REST: f64 = 4.0 * f64::EPSILON;

/// The pencil of `T` around `centre`, solved: `T_lin(nu) = B' diag(eta + centre - nu) B` in coordinates in which `-T_lin'` is 1.
pub(super) struct Window {
    /// Which poles are kept.
    pub poles: Range<usize>,
    /// Between these lies no pole but those kept.
    free: (f64, f64),
    /// Where the pencil is exact.
    pub centre: f64,
    /// Distances of the pencil's eigenvalues from the centre, falling.
    pub eta: Vec<f64>,
    /// Its vectors over the kept poles (poles x pairs).
    vectors: DMatrix<f64>,
    /// `q` of its pairs (r x pairs).
    coupled: DMatrix<f64>,
    /// What the slope of `-H_far` was raised by.
    raised: f64,
    /// `1 / (centre - nu_i)^2` of far poles, 0 of those kept.
    curvature: Vec<f64>,
}

/// A pair of T.
pub(super) struct Pair {
    pub value: f64,
    /// Over the window's pairs.
    shares: DVector<f64>,
    q: DVector<f64>,
}

/// What became of a pair of the pencil.
pub(super) enum Outcome {
    Found(Pair),
    /// Its value did not come to rest; the last one, where that may serve as a centre.
    Open(Option<f64>),
}

/// Memory that refinements share.
pub(super) struct Scratch {
    far: DMatrix<f64>,
}

impl Scratch {
    pub fn new(rank: usize) -> Self {
        Self { far: DMatrix::zeros(rank, rank) }
    }
}

impl Window {
    /// Solves the pencil; `None` where its eigenvalues do not converge. `poles` leaves out the window's after this.
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
        let (eigen, l) = solve(&values[kept.clone()], &columns.rows(kept.start, kept.len()), (centre, h, slope))?;
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

    /// How many eigenvalues of the whole problem lie above the centre.
    pub fn above(&self) -> usize {
        self.poles.start + self.eta.iter().take_while(|eta| **eta > 0.0).count()
    }

    /// The pair of T that one of the pencil turns into: with `E = T - T_lin`, `delta = nu - centre`, the others' shares
    /// `x_j = -c_j' E q / (eta_j - delta)`, and `delta = eta + c' E q` by Newton's method, the slope of E taken as `2 E / delta`.
    pub fn refine(&self, rank: usize, poles: &mut Poles, scratch: &mut Scratch) -> Outcome {
        let own = self.coupled.column(rank);
        let eta = self.eta[rank];
        let mut delta = eta;
        for _ in 0..STEPS {
            let value = self.centre + delta;
            if !(value > self.free.0 && value < self.free.1) {
                return Outcome::Open(None);
            }
            let e = &mut scratch.far;
            poles.sum(value, &self.curvature, e);
            *e *= delta * delta;
            (0..e.nrows()).for_each(|k| e[(k, k)] += delta * self.raised);
            let Some((q, force)) = self.coupling(rank, delta, e) else { return Outcome::Open(None) };
            let shares = self.shares(rank, delta, &force);
            if !(shares.amax() < LARGEST_SHARE) {
                return Outcome::Open(None);
            }
            let shift = own.dot(&force);
            let slope = if delta == 0.0 { 1.0 } else { 1.0 - 2.0 * shift / delta };
            let change = (delta - eta - shift) / if slope > 0.5 { slope } else { 1.0 };
            delta -= change;
            if change.abs() <= AT_REST * (self.centre + delta).abs() {
                return Outcome::Found(Pair { value: self.centre + delta, shares, q });
            }
        }
        Outcome::Open(Some(self.centre + delta))
    }

    /// `q` with `(I + G E) q = c`, `G = sum c_j c_j' / (eta_j - delta)` over the other pairs, and `E q`.
    fn coupling(&self, rank: usize, delta: f64, e: &DMatrix<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
        let mut weighted = self.coupled.clone();
        for (j, mut column) in weighted.column_iter_mut().enumerate() {
            let weight = if j == rank { 0.0 } else { (self.eta[j] - delta).recip() };
            column *= weight;
        }
        let mut matrix = weighted * (self.coupled.tr_mul(e));
        (0..matrix.nrows()).for_each(|k| matrix[(k, k)] += 1.0);
        let q = matrix.lu().solve(&self.coupled.column(rank).into_owned())?;
        let force = e * &q;
        Some((q, force))
    }

    /// Shares of the other pairs in a vector.
    fn shares(&self, rank: usize, delta: f64, force: &DVector<f64>) -> DVector<f64> {
        let mut shares = self.coupled.tr_mul(force);
        for (j, share) in shares.iter_mut().enumerate() {
            *share = if j == rank { 0.0 } else { -*share / (self.eta[j] - delta) };
        }
        shares
    }

    /// Writes the unit vector of a pair over all poles.
    pub fn vector(&self, rank: usize, pair: &Pair, (values, columns): (&[f64], &DMatrix<f64>), out: &mut [f64]) {
        let mut shares = pair.shares.clone();
        shares[rank] = 1.0;
        out.fill(0.0);
        for (column, q) in columns.column_iter().zip(pair.q.iter()) {
            out.iter_mut().zip(column.iter()).for_each(|(out, value)| *out += value * q);
        }
        out.iter_mut().zip(values).for_each(|(out, pole)| *out /= pair.value - pole);
        let near = &self.vectors * shares;
        out[self.poles.clone()].copy_from_slice(near.as_slice());
        let norm = out.iter().map(|value| value * value).sum::<f64>().sqrt();
        out.iter_mut().for_each(|value| *value /= norm);
    }
}

/// The pencil's eigenvalues less the centre, rising, its vectors, and the factor of its slope.
fn solve(
    values: &[f64],
    columns: &nalgebra::DMatrixView<'_, f64>,
    (centre, h, slope): (f64, DMatrix<f64>, DMatrix<f64>),
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
    // The lower triangle is what is read.
    matrix.view_mut((size, 0), (r, size)).copy_from(&coupling);
    matrix.view_mut((size, size), (r, r)).copy_from(&-h);
    Some((symmetric_eigen(&matrix).ok()?, l))
}
