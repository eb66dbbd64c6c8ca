//! From window to window, from the largest eigenvalue down.

use nalgebra::DMatrix;

use super::sums::Poles;
use super::window::{Outcome, PencilPair, Scratch, Window};
use crate::linalg::symmetric_eigenvalues;

/// Centres that are tried for a pair before the problem is given up.
const TRIES: usize = 60;
/// Tries in which a value that did not come to rest is taken as centre; then the interval is halved.
const TRUSTED_TRIES: usize = 4;
/// Eigenvalues closer than this, relative, are not separated by a count.
const SEPARATE: f64 = 1e-9;
/// A count within this of a pole, relative, is not to be relied on.
const OFF_POLE: f64 = 1e-13;
/// Relative distance of the count below the last value of a window, if no pole is nearer.
const BELOW_LAST: f64 = 1e-6;

/// Eigenvalues above `least`, falling, with unit vectors by column; `None` if the march does not end.
pub(super) fn march(poles: &[f64], columns: &DMatrix<f64>, least: f64) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let mut march = March::new(poles, columns)?;
    let wanted = march.wanted(least)?;
    let mut vectors = DMatrix::zeros(poles.len(), wanted);
    while march.values.len() < wanted {
        march.next(&mut vectors)?;
    }
    march.values.truncate(wanted);
    Some((march.values, vectors))
}

struct March<'a> {
    poles: &'a [f64],
    columns: &'a DMatrix<f64>,
    sums: Poles,
    ones: Vec<f64>,
    scratch: Scratch,
    values: Vec<f64>,
    /// Above it lie as many eigenvalues as have been found.
    cut: f64,
}

impl<'a> March<'a> {
    fn new(poles: &'a [f64], columns: &'a DMatrix<f64>) -> Option<Self> {
        let top = poles.first()? + columns.norm_squared();
        let sums = Poles::new(poles, columns);
        let ones = vec![1.0; sums.padded()];
        let scratch = Scratch::new(columns.ncols());
        Some(Self { poles, columns, sums, ones, scratch, values: Vec::new(), cut: top * 1.01 })
    }

    /// Number of eigenvalues above `least`, moved off a pole.
    fn wanted(&mut self, least: f64) -> Option<usize> {
        let mut at = least;
        while self.is_pole(at) {
            at *= 1.0 - 4.0 * OFF_POLE;
        }
        self.count(at)
    }

    fn is_pole(&self, at: f64) -> bool {
        let next = self.poles.partition_point(|pole| *pole > at);
        let near = |pole: Option<&f64>| pole.is_some_and(|pole| (pole - at).abs() <= OFF_POLE * at);
        near(self.poles.get(next)) || near(next.checked_sub(1).and_then(|last| self.poles.get(last)))
    }

    /// Number of eigenvalues above `at`: poles above it and negative eigenvalues of `H(at)`.
    fn count(&mut self, at: f64) -> Option<usize> {
        let rank = self.columns.ncols();
        let mut h = DMatrix::zeros(rank, rank);
        self.sums.sum(at, &self.ones, &mut h);
        h.neg_mut();
        (0..rank).for_each(|k| h[(k, k)] += 1.0);
        let negative = symmetric_eigenvalues(&h).ok()?.iter().filter(|value| **value < 0.0).count();
        Some(self.poles.partition_point(|pole| *pole > at) + negative)
    }

    /// Finds the next eigenvalues, at least one.
    fn next(&mut self, vectors: &mut DMatrix<f64>) -> Option<()> {
        let known = self.values.len();
        let first = *self.poles.get(known)?;
        let (mut low, mut high, mut centre) = (first, self.cut, first);
        for attempt in 0..TRIES {
            let window = Window::new(self.poles, self.columns, &mut self.sums, centre)?;
            let (found, open) = self.refine(&window);
            self.sums.take_in(window.poles.clone(), self.poles);
            if self.keep(&window, &found, vectors)? {
                return Some(());
            }
            if window.above() > known {
                low = low.max(centre)
            } else {
                high = high.min(centre)
            }
            let trusted = open.filter(|value| attempt < TRUSTED_TRIES && *value > low && *value < high);
            centre = trusted.unwrap_or(0.5 * (low + high));
        }
        None
    }

    /// Pairs of the window below the cut, falling, down to the first that does not converge, and the place to continue.
    fn refine(&mut self, window: &Window) -> (Vec<PencilPair>, Option<f64>) {
        let mut found = Vec::new();
        let mut open = None;
        for (rank, eta) in window.eta.iter().enumerate() {
            if window.centre + eta > self.cut + 0.1 * eta.abs() {
                continue;
            }
            match window.refine(rank, &mut self.sums, &mut self.scratch) {
                Outcome::Found(pair) if pair.value < self.cut => found.push(pair),
                Outcome::Found(_) => {}
                Outcome::Open(last) => {
                    open = open.or(last);
                    // Above the centre it may lie beyond the cut; if not, the count tells.
                    if *eta < 0.0 {
                        break;
                    }
                }
            }
        }
        found.sort_by(|a, b| b.value.total_cmp(&a.value));
        (found, open)
    }

    /// Keeps the longest row of pairs that a count confirms; whether there is one.
    fn keep(&mut self, window: &Window, found: &[PencilPair], vectors: &mut DMatrix<f64>) -> Option<bool> {
        let known = self.values.len();
        for kept in (1..=found.len()).rev() {
            let last = found[kept - 1].value;
            let at = match found.get(kept) {
                Some(next) if last - next.value < SEPARATE * last => continue,
                Some(next) => 0.5 * (last + next.value),
                None => {
                    let next = self.poles.partition_point(|pole| *pole >= last);
                    let pole = self.poles.get(next).copied().unwrap_or(0.0);
                    (last * (1.0 - BELOW_LAST)).max(0.5 * (last + pole))
                }
            };
            if self.is_pole(at) || self.count(at)? != known + kept {
                continue;
            }
            self.sums.leave_out(window.poles.clone());
            for pair in &found[..kept] {
                // More than wanted may lie in the last window.
                if let Some(column) = (self.values.len() < vectors.ncols()).then_some(self.values.len()) {
                    let start = column * self.poles.len();
                    let out = &mut vectors.as_mut_slice()[start..start + self.poles.len()];
                    window.vector(pair, &mut self.sums, out);
                }
                self.values.push(pair.value);
            }
            self.sums.take_in(window.poles.clone(), self.poles);
            self.cut = at;
            return Some(true);
        }
        Some(false)
    }
}
