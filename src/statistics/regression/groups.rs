//! Groups of rows that must be left out together.

use std::cmp::Ordering;

use nalgebra::DMatrix;

use super::points::Points;
use decore_math::linalg::{LinalgError, cholesky, cholesky_inverse};
use decore_math::random::{hash, uniform};

/// Shares of a factor's range up to which two values are one.
const SAME: f64 = 1e-9;
/// New places that rows left out are compared with, and the stream of their coordinates.
const NEW_PLACES: usize = 256;
const NEW: u64 = 0x706c_6163;
/// Of the median distance of new places to the nearest row, what that of rows left out has to be at least: one of half of it is
/// chance or a design in clusters, nearly none that of replicates.
const LEAST_SHARE: f64 = 0.5;
/// Groups that coordinates may be left out of account for; of fewer, no share of the variance means anything.
const LEAST_GROUPS: usize = 3;

/// Rows that are left out together, because one of them reveals the others.
///
/// Rows at one place are a group. Where single coordinates repeat (factorials, Saltelli's tables), rows that differ only in what
/// hardly matters are nearly at one place too: factors are taken out of account, that with the least effect on the correlations
/// (weight times squared range) first, and rows that are equal in the others are a group, until rows left out are about as far from
/// the rest as new places in the ranges are, in the distances of the fitted lengths (nearest neighbour distance matching: Mila and
/// others, Methods Ecol. Evol. 13, 2022). Where no two rows share a coordinate, each is its own group.
#[derive(Debug, Clone, PartialEq)]
pub struct Groups {
    /// Rows of each group in ascending order, by their first rows.
    members: Vec<Vec<usize>>,
    /// Number of rows.
    rows: usize,
}

impl Groups {
    /// Each row by itself.
    pub fn singles(rows: usize) -> Self {
        Self { members: (0..rows).map(|row| vec![row]).collect(), rows }
    }

    /// The groups of rows under inverse squared lengths.
    pub(super) fn new(points: &Points, weights: &[f64]) -> Self {
        let mut order: Vec<(usize, f64)> =
            (0..points.factors()).map(|factor| (factor, weights[factor] * span(points, factor).powi(2))).collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        let order: Vec<usize> = order.into_iter().map(|(factor, _)| factor).collect();
        let singles = Self::singles(points.rows());
        let ranges: Vec<usize> = order.iter().copied().filter(|factor| !points.nominal()[*factor]).collect();
        let shared = |factor: &usize| Self::equal(points, &[*factor]).len() < points.rows();
        if !ranges.is_empty() && !ranges.iter().any(shared) {
            return singles;
        }
        let mut found = Self::equal(points, &order);
        // Rows at a single place leave nothing over to be predicted from.
        if found.len() < 2 {
            return singles;
        }
        let new = new_distance(points, weights);
        let mut here = found.distance(points, weights);
        // Of groups that leave rows too near and such that leave them too far, those count whose ratio to new places is nearer to 1.
        let off = |distance: f64| libm::log(distance / new).abs();
        let mut least_off = off(here);
        for count in (1..order.len()).rev() {
            // Names alone are no places: rows of one name lie all over the ranges.
            let places = ranges.is_empty() || order[..count].iter().any(|factor| ranges.contains(factor));
            let coarser = Self::equal(points, &order[..count]);
            if here >= LEAST_SHARE * LEAST_SHARE * new || !places || coarser.len() < LEAST_GROUPS {
                break;
            }
            here = coarser.distance(points, weights);
            if off(here) < least_off {
                (found, least_off) = (coarser, off(here));
            }
        }
        found
    }

    /// Rows that are equal in these factors.
    pub(super) fn equal(points: &Points, factors: &[usize]) -> Self {
        let number = |row: usize, factor: usize| (points.row(row)[factor] / SAME).round() + 0.0;
        let compared = |a: usize, b: usize| {
            let each = factors.iter().map(|factor| number(a, *factor).total_cmp(&number(b, *factor)));
            each.fold(Ordering::Equal, Ordering::then)
        };
        let mut order: Vec<usize> = (0..points.rows()).collect();
        order.sort_by(|a, b| compared(*a, *b).then(a.cmp(b)));
        let mut members: Vec<Vec<usize>> =
            order.chunk_by(|a, b| compared(*a, *b) == Ordering::Equal).map(<[usize]>::to_vec).collect();
        members.sort_unstable();
        Self { members, rows: points.rows() }
    }

    /// Median over the rows of the squared distance to the nearest row of another group.
    fn distance(&self, points: &Points, weights: &[f64]) -> f64 {
        let mut own = vec![0; self.rows];
        self.members.iter().enumerate().for_each(|(group, rows)| rows.iter().for_each(|row| own[*row] = group));
        let nearest = |row: usize| {
            let others = (0..self.rows).filter(|other| own[*other] != own[row]);
            others
                .map(|other| squared(points, weights, [points.row(row), points.row(other)]))
                .fold(f64::INFINITY, f64::min)
        };
        median((0..self.rows).map(nearest).collect())
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// Rows of each group in ascending order.
    pub fn members(&self) -> &[Vec<usize>] {
        &self.members
    }

    /// Groups in an order that does not depend on their contents.
    pub(super) fn shuffled(&self, stream: u64) -> Vec<&[usize]> {
        let mut order: Vec<&[usize]> = self.members.iter().map(Vec::as_slice).collect();
        order.sort_by_key(|rows| hash(stream, 0, rows[0] as u64));
        order
    }

    /// Weight of each row if each group has weight 1.
    pub(super) fn counts(&self) -> Vec<f64> {
        let mut counts = vec![1.0; self.rows];
        self.members.iter().for_each(|rows| rows.iter().for_each(|row| counts[*row] = 1.0 / rows.len() as f64));
        counts
    }

    /// Values less the mean of the rows of other groups.
    pub(super) fn deviations(&self, values: &[f64]) -> Vec<f64> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let mut found = vec![0.0; values.len()];
        for rows in &self.members {
            match rows[..] {
                // Without its row, the difference from the mean is n / (n - 1) times as large.
                [row] => found[row] = count / (count - 1.0) * (values[row] - mean),
                _ => {
                    let own: f64 = rows.iter().map(|row| values[*row] - mean).sum();
                    let shift = own / (count - rows.len() as f64);
                    rows.iter().for_each(|row| found[*row] = values[*row] - mean + shift);
                }
            }
        }
        found
    }
}

/// Errors of left-out rows, and the inverses of their variances, with a model variance of 1.
pub(super) struct LeftOut {
    pub errors: Vec<f64>,
    pub owns: Vec<f64>,
}

impl LeftOut {
    /// From a matrix `B` whose part of a group `I` of more than one row is `part`, and `weighted = B r`: the errors are
    /// `B_II^-1 (B r)_I`, their covariance `B_II^-1` (block form of leave-one-out: Dubrule, Math. Geol. 15, 1983).
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`] with a part that has no inverse.
    pub fn new(
        groups: &Groups,
        (weighted, own): (&[f64], &[f64]),
        part: impl Fn(usize, usize) -> f64,
    ) -> Result<Self, LinalgError> {
        let [mut errors, mut owns] = [vec![0.0; groups.rows], vec![0.0; groups.rows]];
        for rows in &groups.members {
            if let [row] = rows[..] {
                (errors[row], owns[row]) = (weighted[row] / own[row], own[row]);
                continue;
            }
            let block = DMatrix::from_fn(rows.len(), rows.len(), |a, b| part(rows[a], rows[b]));
            let inverse = cholesky_inverse(&cholesky(block)?)?;
            for (column, row) in rows.iter().enumerate() {
                errors[*row] = inverse.column(column).iter().zip(rows).map(|(of, other)| of * weighted[*other]).sum();
                owns[*row] = inverse[(column, column)].recip();
            }
        }
        Ok(Self { errors, owns })
    }
}

/// Span of the rows in a factor; 1 for names.
fn span(points: &Points, factor: usize) -> f64 {
    let values = (0..points.rows()).map(|row| points.row(row)[factor]);
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    if points.nominal()[factor] { 1.0 } else { high - low }
}

/// Median squared distance of places in the ranges that rows span, with the names of some rows, to the nearest row.
fn new_distance(points: &Points, weights: &[f64]) -> f64 {
    let rows = points.rows();
    let coordinate = |place: usize, factor: usize| {
        let share = uniform(NEW, factor as u64, place as u64);
        match points.nominal()[factor] {
            true => points.row((share * rows as f64) as usize % rows)[factor],
            false => {
                let low = (0..rows).map(|row| points.row(row)[factor]).fold(f64::INFINITY, f64::min);
                low + share * span(points, factor)
            }
        }
    };
    let nearest = |place: usize| {
        let at: Vec<f64> = (0..points.factors()).map(|factor| coordinate(place, factor)).collect();
        (0..rows).map(|row| squared(points, weights, [&at, points.row(row)])).fold(f64::INFINITY, f64::min)
    };
    median((0..NEW_PLACES).map(nearest).collect())
}

fn squared(points: &Points, weights: &[f64], [a, b]: [&[f64]; 2]) -> f64 {
    weights.iter().enumerate().map(|(factor, weight)| weight * points.squared(factor, [a[factor], b[factor]])).sum()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
