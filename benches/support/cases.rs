//! Functions whose values are known, and rows at which they are asked: what models and refinements are compared on.

use decore_statistics::design::{Design, Distribution, Factor, HypercubeKind, Kind, LatinHypercube, Level, Sobol};
use decore_statistics::regression::Points;

/// A function of factors that are scaled to [0, 1].
#[derive(Clone, Copy)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// Number of factors.
    pub factors: usize,
    /// Its value.
    pub at: fn(&[f64]) -> f64,
}

impl Function {
    /// Its values at places.
    pub fn values(&self, places: &Points) -> Vec<f64> {
        (0..places.rows()).map(|row| (self.at)(places.row(row))).collect()
    }
}

/// Ishigami's function with a = 7, b = 0.1.
pub const ISHIGAMI: Function = Function { name: "Ishigami", factors: 3, at: ishigami };
/// Sobol's g-function with a = 0, 1, 4.5, 9, 99, 99.
pub const G: Function = Function { name: "g", factors: 6, at: g };
/// Midpoint voltage of a push-pull circuit without output transformer (Ben-Ari and Steinberg, 2007).
pub const OTL: Function = Function { name: "OTL circuit", factors: 6, at: otl };
/// Flow of water through a borehole (Morris, Mitchell and Ylvisaker, 1993).
pub const BOREHOLE: Function = Function { name: "borehole", factors: 8, at: borehole };

fn ishigami(x: &[f64]) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|factor| std::f64::consts::PI * (2.0 * x[factor] - 1.0));
    a.sin() + 7.0 * b.sin().powi(2) + 0.1 * c.powi(4) * a.sin()
}

fn g(x: &[f64]) -> f64 {
    x.iter().zip([0.0, 1.0, 4.5, 9.0, 99.0, 99.0]).map(|(x, a)| ((4.0 * x - 2.0).abs() + a) / (1.0 + a)).product()
}

/// A share of a range.
fn between([low, high]: [f64; 2], share: f64) -> f64 {
    low + (high - low) * share
}

fn otl(x: &[f64]) -> f64 {
    let ranges = [[50.0, 150.0], [25.0, 70.0], [0.5, 3.0], [1.2, 2.5], [0.25, 1.2], [50.0, 300.0]];
    let [rb1, rb2, rf, rc1, rc2, beta] = [0, 1, 2, 3, 4, 5].map(|factor| between(ranges[factor], x[factor]));
    let (middle, load) = (12.0 * rb2 / (rb1 + rb2), beta * (rc2 + 9.0));
    (middle + 0.74) * load / (load + rf) + 11.35 * rf / (load + rf) + 0.74 * rf * load / ((load + rf) * rc1)
}

fn borehole(x: &[f64]) -> f64 {
    let ranges = [
        [0.05, 0.15],
        [100.0, 50_000.0],
        [63_070.0, 115_600.0],
        [990.0, 1110.0],
        [63.1, 116.0],
        [700.0, 820.0],
        [1120.0, 1680.0],
        [9855.0, 12_045.0],
    ];
    let [rw, r, tu, hu, tl, hl, l, kw] = [0, 1, 2, 3, 4, 5, 6, 7].map(|factor| between(ranges[factor], x[factor]));
    let wide = (r / rw).ln();
    2.0 * std::f64::consts::PI * tu * (hu - hl) / (wide * (1.0 + 2.0 * l * tu / (wide * rw * rw * kw) + tu / tl))
}

fn points(kind: Kind, factors: usize, seed: u64) -> Points {
    let factor = Factor { distribution: Distribution::Uniform { low: 0.0, high: 1.0 }, levels: None };
    let design = Design::new(kind, vec![factor; factors], seed).expect("a design");
    let value = |level: Level| if let Level::Real(value) = level { value } else { f64::NAN };
    let rows = (0..design.row_count()).flat_map(|row| design.row(row).unwrap_or_default());
    Points::new(rows.map(value).collect(), vec![false; factors]).expect("points")
}

/// A maximin Latin hypercube.
#[allow(dead_code, reason = "each bench has the designs that it compares on")]
pub fn hypercube(rows: usize, factors: usize, seed: u64) -> Points {
    let kind = HypercubeKind::Maximin;
    points(Kind::LatinHypercube(LatinHypercube { rows, kind, ..LatinHypercube::default() }), factors, seed)
}

/// A Latin hypercube at random among all, as studies have it by default.
#[allow(dead_code, reason = "each bench has the designs that it compares on")]
pub fn plain_hypercube(rows: usize, factors: usize, seed: u64) -> Points {
    points(Kind::LatinHypercube(LatinHypercube { rows, ..LatinHypercube::default() }), factors, seed)
}

/// Scrambled Sobol' points.
pub fn sobol(rows: usize, factors: usize, seed: u64) -> Points {
    points(Kind::Sobol(Sobol { rows, scramble: true }), factors, seed)
}

/// Share of the variance of values that predictions hold.
pub fn q2(truth: &[f64], predicted: &[f64]) -> f64 {
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let total: f64 = truth.iter().map(|truth| (truth - mean).powi(2)).sum();
    let left: f64 = truth.iter().zip(predicted).map(|(truth, predicted)| (truth - predicted).powi(2)).sum();
    1.0 - left / total
}

/// The middle of some figures.
pub fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    let half = figures.len() / 2;
    if figures.len() % 2 == 1 { figures[half] } else { 0.5 * (figures[half - 1] + figures[half]) }
}
