//! Space-filling quality of a design's points in the unit cube.

use super::Design;

/// Rows measured at most: the effort grows with their square.
pub const MAX_MEASURED_ROWS: usize = 2048;
/// Exponent p of phi_p.
pub const PHI_EXPONENT: i32 = 20;

/// Measures of a design in the unit cube, see [`super::Coordinate::unit`].
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Quality {
    /// Rows measured: all, or the first [`MAX_MEASURED_ROWS`].
    pub rows: usize,
    /// Smallest distance of two rows; infinite for a single one.
    pub minimum_distance: f64,
    /// `phi_p = (sum over pairs of d^-p)^(1/p)` with p = [`PHI_EXPONENT`] (Morris and Mitchell 1995); infinite if two rows
    /// coincide, 0 for a single one.
    pub phi_p: f64,
    /// Squared centred L2 discrepancy (Hickernell 1998).
    pub centred_discrepancy: f64,
    /// Squared wrap-around L2 discrepancy (Hickernell 1998).
    pub wrap_around_discrepancy: f64,
    /// Largest absolute Pearson correlation of two factors' coordinates; 0 if none varies.
    pub maximum_correlation: f64,
}

impl Quality {
    /// Measures a design; `None` without factors.
    pub fn of(design: &Design) -> Option<Self> {
        let rows = design.row_count().min(MAX_MEASURED_ROWS);
        let points: Vec<Vec<f64>> = (0..rows).filter_map(|row| design.unit_row(row)).collect();
        (!design.factors().is_empty()).then(|| Self::of_points(&points))
    }

    /// Measures points in the unit cube, all of the same dimension.
    pub fn of_points(points: &[Vec<f64>]) -> Self {
        let (minimum_distance, phi_p) = distances(points);
        Self {
            rows: points.len(),
            minimum_distance,
            phi_p,
            centred_discrepancy: centred_discrepancy(points),
            wrap_around_discrepancy: wrap_around_discrepancy(points),
            maximum_correlation: maximum_correlation(points),
        }
    }
}

fn pairs(points: &[Vec<f64>]) -> impl Iterator<Item = (&Vec<f64>, &Vec<f64>)> {
    points.iter().enumerate().flat_map(|(index, a)| points.iter().take(index).map(move |b| (a, b)))
}

fn distances(points: &[Vec<f64>]) -> (f64, f64) {
    let distance = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let least = pairs(points).map(distance).fold(f64::INFINITY, f64::min);
    if least == f64::INFINITY {
        return (least, 0.0);
    }
    // Relative to the smallest distance, as the powers would overflow.
    let sum: f64 = pairs(points).map(|pair| (least / distance(pair).max(f64::MIN_POSITIVE)).powi(PHI_EXPONENT)).sum();
    let phi = if least > 0.0 { libm::pow(sum, 1.0 / f64::from(PHI_EXPONENT)) / least } else { f64::INFINITY };
    (least, phi)
}

/// A discrepancy: `constant + weight/n sum over rows of product(single) + 1/n^2 sum over pairs (all, ordered) of product(pair)`.
struct Discrepancy<S, P> {
    constant: f64,
    weight: f64,
    single: S,
    pair: P,
}

fn discrepancy(points: &[Vec<f64>], kernel: &Discrepancy<impl Fn(f64) -> f64, impl Fn(f64, f64) -> f64>) -> f64 {
    let Discrepancy { constant, weight, single, pair } = kernel;
    let rows = points.len() as f64;
    let singles: f64 = points.iter().map(|row| row.iter().map(|x| single(*x)).product::<f64>()).sum();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| pair(*a, *b)).product::<f64>();
    let own: f64 = points.iter().map(|row| product(row, row)).sum();
    // By rows, so that the sum keeps its digits.
    let others: f64 =
        points.iter().enumerate().map(|(index, a)| points.iter().take(index).map(|b| product(a, b)).sum::<f64>()).sum();
    constant + weight / rows * singles + (own + 2.0 * others) / (rows * rows)
}

/// `base` to the number of factors.
fn power(base: f64, points: &[Vec<f64>]) -> f64 {
    base.powi(points.first().map_or(0, Vec::len) as i32)
}

/// Squared centred L2 discrepancy: "CD" of `scipy.stats.qmc.discrepancy`.
pub fn centred_discrepancy(points: &[Vec<f64>]) -> f64 {
    let z = |x: f64| (x - 0.5).abs();
    let single = |x: f64| 1.0 + 0.5 * z(x) - 0.5 * z(x) * z(x);
    let pair = |a: f64, b: f64| 1.0 + 0.5 * z(a) + 0.5 * z(b) - 0.5 * (a - b).abs();
    discrepancy(points, &Discrepancy { constant: power(13.0 / 12.0, points), weight: -2.0, single, pair })
}

/// Squared wrap-around L2 discrepancy: "WD" of `scipy.stats.qmc.discrepancy`.
pub fn wrap_around_discrepancy(points: &[Vec<f64>]) -> f64 {
    let pair = |a: f64, b: f64| 1.5 - (a - b).abs() * (1.0 - (a - b).abs());
    discrepancy(points, &Discrepancy { constant: -power(4.0 / 3.0, points), weight: 0.0, single: |_| 0.0, pair })
}

/// Squared mixture discrepancy (Zhou, Fang and Ning 2013): "MD" of `scipy.stats.qmc.discrepancy`.
pub fn mixture_discrepancy(points: &[Vec<f64>]) -> f64 {
    let z = |x: f64| (x - 0.5).abs();
    let single = |x: f64| 5.0 / 3.0 - 0.25 * z(x) - 0.25 * z(x) * z(x);
    let pair = |a: f64, b: f64| 15.0 / 8.0 - 0.25 * z(a) - 0.25 * z(b) - 0.75 * (a - b).abs() + 0.5 * (a - b) * (a - b);
    discrepancy(points, &Discrepancy { constant: power(19.0 / 12.0, points), weight: -2.0, single, pair })
}

/// L2 star discrepancy (Warnock 1972, not squared): "L2-star" of `scipy.stats.qmc.discrepancy`.
pub fn l2_star_discrepancy(points: &[Vec<f64>]) -> f64 {
    let weight = -2.0 * power(0.5, points);
    let (single, pair) = (|x: f64| 1.0 - x * x, |a: f64, b: f64| 1.0 - a.max(b));
    discrepancy(points, &Discrepancy { constant: power(1.0 / 3.0, points), weight, single, pair }).max(0.0).sqrt()
}

fn maximum_correlation(points: &[Vec<f64>]) -> f64 {
    let rows = points.len() as f64;
    let factors = points.first().map_or(0, Vec::len);
    let centred = |factor: usize| -> Vec<f64> {
        let column = || points.iter().filter_map(|row| row.get(factor));
        let mean = column().sum::<f64>() / rows;
        column().map(|x| x - mean).collect()
    };
    let columns: Vec<Vec<f64>> = (0..factors).map(centred).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let norm = (product(a, a) * product(b, b)).sqrt();
        if norm > 0.0 { (product(a, b) / norm).abs() } else { 0.0 }
    };
    pairs(&columns).map(correlation).fold(0.0, f64::max)
}
