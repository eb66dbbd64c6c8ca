//! What models promise: errors of rows left out as refits have them, intervals that hold, figures that no thread changes.

use decore_math::random::{hash, uniform};
use decore_statistics::regression::{
    GaussianProcess, Groups, Hyperparameters, Kernel, LEAST_ROWS, Places, Points, PolynomialChaos, Prediction,
    RegressionError, Success,
};

/// Rows of uniform coordinates; the last factor has three names where `names` says so.
fn places(rows: usize, factors: usize, names: bool, seed: u64) -> Points {
    let value = |row: usize, factor: usize| {
        let value = uniform(seed, factor as u64, row as u64);
        if names && factor + 1 == factors { (3.0 * value).floor() } else { value }
    };
    let values = (0..rows).flat_map(|row| (0..factors).map(move |factor| value(row, factor))).collect();
    Points::new(values, (0..factors).map(|factor| names && factor + 1 == factors).collect()).expect("points")
}

fn values(points: &Points, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    (0..points.rows()).map(|row| of(points.row(row))).collect()
}

fn together(points: &Points, values: &[f64]) -> Places {
    Places::new(points, values).expect("places")
}

fn smooth(x: &[f64]) -> f64 {
    (5.0 * x[0]).sin() + x[1] * x[1] + [0.0, 1.0, -0.5][x[2] as usize]
}

/// Numbers of a normal distribution.
fn normal(seed: u64, row: usize) -> f64 {
    let [a, b] = [0, 1].map(|stream| uniform(hash(seed, 9, 9), stream, row as u64));
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

#[test]
fn errors_of_rows_left_out_are_those_of_refits() {
    let points = places(40, 3, true, 1);
    let values = values(&points, smooth);
    for kernel in Kernel::ALL {
        let of = Hyperparameters { weights: vec![8.0, 3.0, 0.7], noise: 1e-3, spread: 0.0 };
        let whole = GaussianProcess::with(&together(&points, &values), (kernel, of.clone())).expect("a model");
        for row in 0..points.rows() {
            let others: Vec<usize> = (0..points.rows()).filter(|other| *other != row).collect();
            let known: Vec<f64> = others.iter().map(|other| values[*other]).collect();
            let refit = GaussianProcess::with(&together(&points.select(&others), &known), (kernel, of.clone()))
                .expect("a model");
            let predicted = refit.predict(&points.select(&[row])).expect("a prediction")[0];
            let error = values[row] - predicted.mean;
            assert!((whole.residuals().errors()[row] - error).abs() < 1e-10, "{kernel:?}, row {row}");
            // The variance of the process is that of all rows.
            let own = predicted.std_dev * (whole.variance() / refit.variance()).sqrt();
            assert!((whole.residuals().std_devs()[row] - own).abs() < 1e-10, "{kernel:?}, row {row}");
        }
    }
}

#[test]
fn intervals_hold_what_they_say() {
    let rough = |x: &[f64]| 3.0 * (4.0 * x[0] - 2.0).abs() + (7.0 * x[1]).sin() * x[2];
    let mean = |noise: f64, of: &dyn Fn(&[f64]) -> f64, rows: usize| {
        let shares = (0..12).map(|repeat| {
            let (points, new) = (places(rows, 3, false, 100 + repeat), places(400, 3, false, 200 + repeat));
            let noisy = |points: &Points, seed: u64| -> Vec<f64> {
                values(points, of).iter().enumerate().map(|(row, value)| value + noise * normal(seed, row)).collect()
            };
            let (known, truth) = (noisy(&points, 2 * repeat), noisy(&new, 2 * repeat + 1));
            let model = GaussianProcess::fit(&points, &known).expect("a model");
            let folds = model.folds().expect("folds").expect("few rows");
            let reach = folds.reach(0.95);
            let inside = |(at, truth): (&Prediction, &f64)| (at.mean - truth).abs() <= reach * at.std_dev;
            model.predict(&new).expect("predictions").iter().zip(&truth).filter(|pair| inside(*pair)).count()
        });
        shares.sum::<usize>() as f64 / (12.0 * 400.0)
    };
    let waves = |x: &[f64]| (5.0 * x[0]).sin() + x[1] * x[1] + x[0] * x[2];
    let shares = [mean(0.2, &waves, 60), mean(0.05, &rough, 60), mean(0.0, &rough, 150), mean(0.2, &waves, 150)];
    assert!(shares.iter().all(|share| (0.92..=0.98).contains(share)), "{shares:.3?}");
}

#[test]
fn noise_is_found_and_smooth_functions_have_none() {
    let points = places(200, 3, true, 5);
    let plain = values(&points, smooth);
    let noisy: Vec<f64> = plain.iter().enumerate().map(|(row, value)| value + 0.1 * normal(3, row)).collect();
    let [plain, noisy] = [plain, noisy].map(|values| GaussianProcess::fit(&points, &values).expect("a model"));
    assert!(plain.residuals().q2() > 0.9999 && plain.noise_std_dev() < 1e-2, "{}", plain.noise_std_dev());
    assert!((0.08..0.12).contains(&noisy.noise_std_dev()), "{}", noisy.noise_std_dev());
}

#[test]
fn a_factor_of_names_counts_and_has_no_order() {
    let points = places(120, 3, true, 6);
    let values = values(&points, smooth);
    let model = GaussianProcess::fit(&points, &values).expect("a model");
    let swapped = |points: &Points| {
        let number = |row: &[f64]| [row[0], row[1], [2.0, 0.0, 1.0][row[2] as usize]];
        let coordinates = (0..points.rows()).flat_map(|row| number(points.row(row))).collect();
        Points::new(coordinates, points.nominal().to_vec()).expect("points")
    };
    let other = GaussianProcess::fit(&swapped(&points), &values).expect("a model");
    let new = places(50, 3, true, 7);
    let [a, b] = [model.predict(&new), other.predict(&swapped(&new))].map(|predicted| predicted.expect("predictions"));
    assert!(a.iter().zip(&b).all(|(a, b)| (a.mean - b.mean).abs() < 1e-9), "the numbers of names matter");
    let names = |row: usize| new.row(row)[2] as usize;
    let effect = (0..50).filter(|row| names(*row) == 1).map(|row| a[row].mean - smooth(new.row(row)));
    assert!(effect.map(f64::abs).fold(0.0, f64::max) < 0.05);
}

#[test]
fn equal_rows_few_rows_and_rows_without_values() {
    let points = places(30, 2, false, 8);
    let twice: Vec<usize> = (0..30).chain(0..30).collect();
    let doubled = points.select(&twice);
    let of = |x: &[f64]| x[0] + x[1];
    assert!(GaussianProcess::fit(&doubled, &values(&doubled, of)).expect("a model").residuals().q2() > 0.999);
    // More factors than rows.
    let wide = places(12, 20, false, 9);
    let known = values(&wide, |x| 10.0 * x[0]);
    assert!(GaussianProcess::fit(&wide, &known).is_ok());
    assert!(matches!(
        PolynomialChaos::fit(&wide, &known, &Groups::singles(12)),
        Err(RegressionError::TooFew { found: 12, least: 30 })
    ));
    let fit = |values: Vec<f64>| GaussianProcess::fit(&points, &values).map(|_| ());
    assert_eq!(fit(vec![2.0; 30]), Err(RegressionError::Constant { value: 2.0 }));
    let mut broken = values(&points, of);
    broken[4] = f64::INFINITY;
    assert_eq!(fit(broken), Err(RegressionError::NotFinite { row: 4, value: f64::INFINITY }));
    assert!(matches!(fit(vec![1.0; 29]), Err(RegressionError::Size { found: 29, expected: 30, .. })));
    let few = places(7, 2, false, 8);
    let error = GaussianProcess::fit(&few, &values(&few, of)).map(|_| ());
    assert_eq!(error, Err(RegressionError::TooFew { found: 7, least: LEAST_ROWS }));
    let negative = Hyperparameters { weights: vec![1.0, 1.0], noise: -1.0, spread: 0.0 };
    let refused =
        GaussianProcess::with(&together(&doubled, &values(&doubled, of)), (Kernel::Matern52, negative)).map(|_| ());
    assert!(matches!(refused, Err(RegressionError::Parameter { name: "noise", .. })), "{refused:?}");
}

#[test]
fn no_number_of_threads_changes_a_bit() {
    let points = places(180, 3, true, 10);
    let known = values(&points, smooth);
    let new = places(200, 3, true, 11);
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let model = GaussianProcess::fit(&points, &known).expect("a model");
            let reach = model.folds().expect("folds").map(|folds| folds.reach(0.95).to_bits());
            let predicted = model.predict(&new).expect("predictions");
            let bits = predicted.iter().flat_map(|at| [at.mean.to_bits(), at.std_dev.to_bits()]);
            (reach, bits.collect::<Vec<u64>>())
        })
    };
    assert_eq!(bits(1), bits(2));
}

#[test]
fn polynomials_are_found_as_they_are() {
    let points = places(80, 3, true, 12);
    let cubic = |x: &[f64]| x[0] * x[0] * x[1] - 2.0 * x[1] + if x[2] == 1.0 { x[0] } else { 0.0 };
    let chaos =
        PolynomialChaos::fit(&points, &values(&points, cubic), &Groups::singles(points.rows())).expect("a polynomial");
    assert!(chaos.degree >= 3 && chaos.residuals.q2() > 1.0 - 1e-12, "{} {}", chaos.degree, chaos.residuals.q2());
}

#[test]
fn success_depends_on_the_place_where_enough_rows_fail() {
    let points = places(150, 2, false, 13);
    let succeeded: Vec<bool> = (0..150).map(|row| points.row(row)[0] < 0.7).collect();
    let success = Success::fit(&points, &succeeded).expect("a model");
    let at = |x: f64| {
        let place = Points::new(vec![x, 0.5], vec![false; 2]).expect("a point");
        success.predict(&place).expect("a probability")[0]
    };
    assert!(at(0.3) > 0.95 && at(0.95) < 0.05, "{} {}", at(0.3), at(0.95));
    let mut all = vec![true; 150];
    all[3] = false;
    let everywhere = Success::fit(&points, &all).expect("a model");
    assert_eq!(everywhere.predict(&points).expect("probabilities")[0], 150.0 / 152.0);
}
