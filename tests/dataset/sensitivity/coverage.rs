//! How often intervals hold the truth: functions whose indices are known in closed form.
//!
//! `DECORE_REPLICATES=1000` repeats each table so often; without it 100 times, and the bounds are as wide as that asks for.

use std::f64::consts::PI;

use decore_math::random::{hash, uniform};
use decore_statistics::analysis::{Bootstrap, Estimate, Estimator, SaltelliBlocks, sobol};
use rayon::prelude::*;

/// Base points of a table.
const BASE_POINTS: u64 = 1024;

/// A function of the unit cube with its indices: S1 of all factors, then ST.
struct Function {
    name: &'static str,
    factors: usize,
    value: fn(&[f64]) -> f64,
    truth: Vec<f64>,
}

/// Ishigami and Homma's function with a = 7, b = 0.1.
fn ishigami() -> Function {
    let (a, b) = (7.0, 0.1_f64);
    let alone = [0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2), a * a / 8.0, 0.0];
    let pair = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
    let variance = alone.iter().sum::<f64>() + pair;
    let total = [alone[0] + pair, alone[1], pair];
    Function {
        name: "Ishigami",
        factors: 3,
        value: |u| {
            let [x, y, z] = [0, 1, 2].map(|factor| PI * (2.0 * u[factor] - 1.0));
            x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
        },
        truth: alone.into_iter().chain(total).map(|share| share / variance).collect(),
    }
}

const G_WEIGHTS: [f64; 4] = [0.0, 1.0, 4.5, 9.0];

/// Sobol's g-function.
fn g() -> Function {
    let alone = G_WEIGHTS.map(|weight| 1.0 / (3.0 * (1.0 + weight) * (1.0 + weight)));
    let product = alone.iter().map(|part| 1.0 + part).product::<f64>();
    let total = alone.iter().map(|part| part / (1.0 + part) * product);
    Function {
        name: "g",
        factors: 4,
        value: |u| {
            u.iter().zip(G_WEIGHTS).map(|(u, weight)| ((4.0 * u - 2.0).abs() + weight) / (1.0 + weight)).product()
        },
        truth: alone.into_iter().chain(total).map(|share| share / (product - 1.0)).collect(),
    }
}

impl Function {
    /// The values of a Saltelli table with independent base points.
    fn table(&self, seed: u64) -> Vec<f64> {
        let mut values = Vec::new();
        for point in 0..BASE_POINTS {
            let both: Vec<f64> = (0..2 * self.factors).map(|column| uniform(seed, point, column as u64)).collect();
            let (a, b) = both.split_at(self.factors);
            values.push((self.value)(a));
            for factor in 0..self.factors {
                let mut mixed = a.to_vec();
                mixed[factor] = b[factor];
                values.push((self.value)(&mixed));
            }
            values.push((self.value)(b));
        }
        values
    }

    /// Share of `repeats` tables whose interval holds the truth, by index.
    fn coverage(&self, estimator: Estimator, repeats: u64) -> Vec<f64> {
        let holds = |repeat: u64| -> Vec<bool> {
            let seed = hash(repeat, 11, 0);
            let bootstrap = Bootstrap { replicates: 400, seed, level: Bootstrap::LEVEL };
            let blocks = SaltelliBlocks { factors: self.factors, second_order: false };
            let found = sobol(&self.table(seed), blocks, estimator, &bootstrap).expect("indices");
            let inside = |(estimate, truth): (&Estimate, &f64)| {
                estimate.interval.is_some_and(|[low, high]| low <= *truth && *truth <= high)
            };
            found.first.iter().chain(&found.total).zip(&self.truth).map(inside).collect()
        };
        let held: Vec<Vec<bool>> = (0..repeats).into_par_iter().map(holds).collect();
        let share = |index: usize| held.iter().filter(|of| of[index]).count() as f64 / repeats as f64;
        (0..self.truth.len()).map(share).collect()
    }
}

#[test]
fn analytic_intervals_hold_the_truth_as_often_as_they_say() {
    let repeats = std::env::var("DECORE_REPLICATES").ok().and_then(|text| text.parse().ok()).unwrap_or(100_u64);
    // A share of so many repeats scatters by this; three times are allowed to each index, and 93 to 97 % to their mean.
    let scatter = (0.95_f64 * 0.05 / repeats as f64).sqrt();
    for function in [ishigami(), g()] {
        for estimator in Estimator::ALL {
            let shares = function.coverage(estimator, repeats);
            let mean = shares.iter().sum::<f64>() / shares.len() as f64;
            println!("{} {estimator:?}: mean {mean:.4}, by index {shares:.3?}", function.name);
            let (name, slack) = (function.name, (scatter - 0.007).max(0.0));
            assert!((0.93 - slack..=0.97 + slack).contains(&mean), "{name} {estimator:?}: {mean}");
            let far = |share: &&f64| (**share - 0.95).abs() > 3.5 * scatter + 0.01;
            assert_eq!(shares.iter().find(far), None, "{name} {estimator:?}: {shares:?}");
        }
    }
}
