//! Dependence by kernels (Gretton et al., 2005 and 2007; Da Veiga, J. Stat. Comput. Simul. 85, 2015).

use statrs::function::gamma::checked_gamma_ur;

use super::factor::{FactorValues, drawn_rows};
use decore_math::random::hash;

/// Rows at most: their number goes into the time squared.
const MOST_ROWS: usize = 1000;
/// Stream of the numbers that draw them.
const ROWS: u64 = 1 << 34;

/// Hilbert-Schmidt independence criterion of a factor and an output, biased (V-statistic): 0 if they are independent.
///
/// Kernels are Gaussian with the standard deviation of the values, of names 1 where they are equal. Of more than 1000 rows, 1000
/// drawn by the seed of the intervals without replacement are taken, the same for all factors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hsic {
    /// Criterion over the geometric mean of the criteria of factor and output with themselves, in [0, 1].
    pub r2: f64,
    /// Probability of a larger criterion were they independent, by a gamma distribution with the criterion's mean and variance
    /// then.
    pub p_value: f64,
}

/// The criterion for one factor.
pub(super) fn hsic(values: &[f64], factor: FactorValues<'_>, seed: u64) -> Hsic {
    let rows = drawn_rows(values.len(), MOST_ROWS, hash(seed, ROWS, 0));
    let thinned = |of: &[f64]| rows.iter().map(|row| of[*row]).collect::<Vec<f64>>();
    let x = CentredKernel::new(thinned(factor.values), factor.nominal);
    let y = CentredKernel::new(thinned(values), false);
    let n = x.values.len() as f64;
    let mut sums = KernelSums::default();
    for i in 0..x.values.len() {
        sums.add(x.centred(i, i), y.centred(i, i), 1.0);
        sums.diagonal += (x.centred(i, i) * y.centred(i, i)).powi(2);
        for j in 0..i {
            sums.add(x.centred(i, j), y.centred(i, j), 2.0);
        }
    }
    let criterion = sums.xy / (n * n);
    // Mean and variance of the criterion where both are independent.
    let (off_x, off_y) = (x.off_diagonal(), y.off_diagonal());
    let mean = (1.0 + off_x * off_y - off_x - off_y) / n;
    let pairs = n * (n - 1.0);
    let variance =
        2.0 * (n - 4.0) * (n - 5.0) * (sums.squares - sums.diagonal) / (pairs * pairs * (n - 2.0) * (n - 3.0));
    Hsic {
        r2: sums.xy / (sums.xx * sums.yy).sqrt(),
        p_value: checked_gamma_ur(mean * mean / variance, criterion * mean / variance).unwrap_or(f64::NAN),
    }
}

/// Sums over pairs of rows of products of centred kernels.
#[derive(Debug, Default)]
struct KernelSums {
    xy: f64,
    xx: f64,
    yy: f64,
    /// Of `(x y)^2`.
    squares: f64,
    /// The part of it on the diagonal.
    diagonal: f64,
}

impl KernelSums {
    fn add(&mut self, x: f64, y: f64, times: f64) {
        self.xy += times * x * y;
        self.xx += times * x * x;
        self.yy += times * y * y;
        self.squares += times * (x * y) * (x * y);
    }
}

/// A kernel over the rows, with its means.
struct CentredKernel {
    values: Vec<f64>,
    nominal: bool,
    /// Of the Gaussian's exponent: `-1 / (2 variance)`.
    rate: f64,
    means: Vec<f64>,
    mean: f64,
}

impl CentredKernel {
    fn new(values: Vec<f64>, nominal: bool) -> Self {
        let n = values.len() as f64;
        let centre = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - centre).powi(2)).sum::<f64>() / (n - 1.0);
        let mut kernel = Self { means: vec![0.0; values.len()], values, nominal, rate: -0.5 / variance, mean: 0.0 };
        let mean = |row: usize| (0..kernel.values.len()).map(|other| kernel.at(row, other)).sum::<f64>() / n;
        kernel.means = (0..kernel.values.len()).map(mean).collect();
        kernel.mean = kernel.means.iter().sum::<f64>() / n;
        kernel
    }

    fn at(&self, a: usize, b: usize) -> f64 {
        let [a, b] = [self.values[a], self.values[b]];
        match self.nominal {
            true => f64::from(u8::from(a == b)),
            false => ((a - b) * (a - b) * self.rate).exp(),
        }
    }

    fn centred(&self, a: usize, b: usize) -> f64 {
        self.at(a, b) - self.means[a] - self.means[b] + self.mean
    }

    /// Mean of the entries off the diagonal, which is 1.
    fn off_diagonal(&self) -> f64 {
        let n = self.values.len() as f64;
        (n * self.mean - 1.0) / (n - 1.0)
    }
}
