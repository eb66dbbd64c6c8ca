//! What a model says of itself where rows share places, are few, or say nothing.

use decore_lab::surrogate::{OutputSurrogate, ProcessFigures, Surrogate};
use decore_math::random::uniform;
use decore_statistics::regression::{
    GaussianProcess, Groups, Hyperparameters, Kernel, Places, Points, PolynomialChaos, Prediction, RegressionError,
    Residuals,
};

fn points(rows: impl Iterator<Item = Vec<f64>>, nominal: &[bool]) -> Points {
    Points::new(rows.flatten().collect(), nominal.to_vec()).expect("points")
}

fn places(rows: usize, factors: usize, seed: u64) -> Points {
    let row = |row: usize| (0..factors).map(|factor| uniform(seed, factor as u64, row as u64)).collect();
    points((0..rows).map(row), &vec![false; factors])
}

/// Each place three times.
fn thrice(places: &Points) -> Points {
    places.select(&(0..places.rows()).flat_map(|row| [row; 3]).collect::<Vec<usize>>())
}

fn values(points: &Points, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    (0..points.rows()).map(|row| of(points.row(row))).collect()
}

/// Share of the variance of new places that is predicted.
fn true_q2(model: &GaussianProcess, new: &Points, of: impl Fn(&[f64]) -> f64) -> f64 {
    let (truth, predicted) = (values(new, of), model.predict(new).expect("predictions"));
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let left: f64 = truth.iter().zip(&predicted).map(|(truth, at)| (truth - at.mean).powi(2)).sum();
    1.0 - left / truth.iter().map(|truth| (truth - mean).powi(2)).sum::<f64>()
}

fn folds(model: &GaussianProcess) -> Residuals {
    model.folds().expect("folds").expect("few rows")
}

fn brought_together(points: &Points, values: &[f64]) -> Places {
    Places::new(points, values).expect("places")
}

fn wavy(x: &[f64]) -> f64 {
    (9.0 * x[0]).sin() * (11.0 * x[1]).cos() + x[2]
}

#[test]
fn errors_of_places_left_out_are_those_of_refits() {
    let name = |row: usize| (3.0 * uniform(1, 7, row as u64)).floor();
    let coordinates = |row: usize| vec![uniform(1, 0, row as u64), uniform(1, 1, row as u64), name(row)];
    let points = thrice(&points((0..14).map(coordinates), &[false, false, true]));
    let noisy = |row: usize| wavy(points.row(row)) + 0.1 * uniform(2, 0, row as u64);
    let values: Vec<f64> = (0..points.rows()).map(noisy).collect();
    let places = brought_together(&points, &values);
    assert_eq!((places.values().len(), places.spread().freedom), (14, 28.0));
    for kernel in Kernel::ALL {
        let of = Hyperparameters { weights: vec![8.0, 3.0, 0.7], noise: 1e-2, spread: 5e-3 };
        let whole = GaussianProcess::with(&places, (kernel, of.clone())).expect("a model");
        for place in 0..14 {
            let others: Vec<usize> = (0..points.rows()).filter(|row| row / 3 != place).collect();
            let known: Vec<f64> = others.iter().map(|other| values[*other]).collect();
            let rest = brought_together(&points.select(&others), &known);
            let refit = GaussianProcess::with(&rest, (kernel, of.clone())).expect("a model");
            let at = refit.predict(&points.select(&[3 * place])).expect("a prediction")[0];
            let error = places.values()[place] - at.mean;
            assert!((whole.residuals().errors()[place] - error).abs() < 1e-10, "place {place}");
            // The mean of three runs has a third of their noise, and the process the variance of all places.
            let single = refit.variance() * of.spread * (1.0 - 1.0 / 3.0);
            let own = ((at.std_dev.powi(2) - single) * whole.variance() / refit.variance()).sqrt();
            assert!((whole.residuals().std_devs()[place] - own).abs() < 1e-10, "place {place}");
        }
    }
}

/// What `surrogate` remarks of factors with few values: a jump between them is nowhere to be seen in rows left out.
#[test]
fn a_jump_between_few_values_is_hidden_from_rows_left_out() {
    for levels in [3, 4, 5, 6] {
        let at = |index: usize| index as f64 / (levels - 1) as f64;
        let grid = points((0..levels * levels).map(|row| vec![at(row / levels), at(row % levels)]), &[false; 2]);
        let (mut told, mut true_share) = (Vec::new(), Vec::new());
        for place in 0..6 {
            let jump = 0.2 + 0.1 * f64::from(place);
            let step = |x: &[f64]| f64::from(u8::from(x[0] > jump)) + (4.0 * x[1]).sin();
            let known = values(&grid, step);
            let model = GaussianProcess::fit(&grid, &known).expect("a model");
            told.push(folds(&model).q2().min(model.residuals().q2()));
            true_share.push(true_q2(&model, &places(1000, 2, 5), step));
        }
        let mean = true_share.iter().sum::<f64>() / 6.0;
        eprintln!("{levels} values: Q2 {told:.3?}, of new places {mean:.3}");
        assert!(told.iter().sum::<f64>() / 6.0 > mean + 0.02 && mean < 0.92, "{levels}: {told:?} {true_share:?}");
    }
}

#[test]
fn replicates_do_not_vouch_for_each_other() {
    for seed in 0..6 {
        let points = thrice(&places(32, 3, 30 + seed));
        let known = values(&points, wavy);
        let model = GaussianProcess::fit(&points, &known).expect("a model");
        let new = places(400, 3, 60 + seed);
        let (q2, truth) = (folds(&model).q2().min(model.residuals().q2()), true_q2(&model, &new, wavy));
        assert_eq!(model.groups().members().len(), 32);
        assert!(q2 < truth.max(0.0) + 0.25, "seed {seed}: {q2} where {truth} is true");
    }
}

#[test]
fn levels_of_what_does_not_matter_are_replicates() {
    let level = |row: usize, [stride, levels]: [usize; 2]| (row / stride % levels) as f64 / (levels - 1) as f64;
    let row = |row: usize| [[1, 5], [5, 5], [25, 3], [75, 3]].map(|of| level(row, of)).to_vec();
    let factorial = points((0..225).map(row), &[false; 4]);
    // Values of 25 places that no place tells of another.
    let rough = |x: &[f64]| uniform(4, (4.0 * x[0]).round() as u64, (4.0 * x[1]).round() as u64);
    let known = values(&factorial, rough);
    let model = GaussianProcess::fit(&factorial, &known).expect("a model");
    assert_eq!(model.groups().members().len(), 25);
    let found = [model.residuals().q2(), folds(&model).q2()];
    assert!(found.iter().all(|q2| *q2 < 0.3), "{found:?}");
    // Where all factors matter alike, single rows are new enough; rows that share no coordinate are by themselves.
    let with = |weights: [f64; 4]| {
        let of = Hyperparameters { weights: weights.to_vec(), noise: 1e-3, spread: 0.0 };
        GaussianProcess::with(&brought_together(&factorial, &known), (Kernel::Matern52, of))
            .expect("a model")
            .groups()
            .members()
            .len()
    };
    assert_eq!([with([3.0; 4]), with([9.0, 5.0, 3.0, 1e-5]), with([9.0, 5.0, 1e-5, 2e-5])], [225, 75, 25]);
    let scattered = places(40, 3, 3);
    let model = GaussianProcess::fit(&scattered, &values(&scattered, wavy)).expect("a model");
    assert_eq!(model.groups(), &Groups::singles(40));
}

#[test]
fn few_rows_have_folds_and_intervals_that_hold() {
    let curved = |x: &[f64]| (4.0 * x[0]).sin() + x[1] * x[1] + 0.5 * x[0] * x[2];
    for (rows, least) in [(8, 0.8), (12, 0.84), (19, 0.88)] {
        let share = (0..20).map(|seed| {
            let (points, new) = (places(rows, 3, 300 + seed), places(200, 3, 400 + seed));
            let known = values(&points, curved);
            let model = GaussianProcess::fit(&points, &known).expect("a model");
            let reach = folds(&model).reach(0.95);
            let inside = |(at, row): (&Prediction, usize)| (at.mean - curved(new.row(row))).abs() <= reach * at.std_dev;
            model.predict(&new).expect("predictions").iter().zip(0..200).filter(|(at, row)| inside((at, *row))).count()
        });
        let share = share.sum::<usize>() as f64 / 4000.0;
        eprintln!("{rows} rows: {share}");
        assert!(share > least, "{rows} rows: {share}");
    }
}

#[test]
fn a_rest_that_is_constant_predicts_its_constant() {
    let points = places(192, 2, 5);
    let known: Vec<f64> = (0..192).map(|row| f64::from(u8::from(row == 17))).collect();
    let model = GaussianProcess::fit(&points, &known).expect("a model");
    let found = folds(&model);
    assert_eq!(found.errors()[17], 1.0);
    assert!(found.q2() < 0.1 && found.reach(0.95).is_finite(), "{} {}", found.q2(), found.reach(0.95));
}

#[test]
fn a_polynomial_whose_term_stands_on_one_row_has_no_q2() {
    for rows in 9..34 {
        let x = |factor: u64, row: usize| uniform(7, factor, row as u64);
        let coordinates = |row: usize| vec![x(0, row), x(1, row), f64::from(u8::from(row == 0))];
        let points = points((0..rows).map(coordinates), &[false, false, true]);
        let known: Vec<f64> = (0..rows).map(|row| points.row(row)[0] + 0.1 * uniform(6, 0, row as u64)).collect();
        let alone = PolynomialChaos::fit(&points, &known, &Groups::singles(rows));
        assert_eq!(alone, Err(RegressionError::Alone), "{rows} rows");
    }
}

/// Fault 10: a row that is run again shows nothing new.
#[test]
fn exact_repeats_do_not_change_a_model() {
    let single = places(15, 4, 71);
    let known = values(&single, wavy);
    let again: Vec<usize> = (0..15).chain((0..10).map(|row| row * row % 15)).collect();
    let (repeated, all) = (single.select(&again), again.iter().map(|row| known[*row]).collect::<Vec<f64>>());
    let [one, other] = [(&single, &known), (&repeated, &all)].map(|(points, values)| {
        let model = GaussianProcess::fit(points, values).expect("a model");
        let at = model.predict(&places(40, 4, 72)).expect("predictions");
        (folds(&model), model.residuals().clone(), at)
    });
    assert_eq!(one, other);
}

/// Replicates that differ are the noise of a run; they do not drive the noise of places to nothing.
#[test]
fn the_noise_of_a_run_is_what_replicates_show() {
    let rows = thrice(&places(40, 2, 73));
    let known: Vec<f64> = (0..120).map(|row| wavy_plane(rows.row(row)) + 0.3 * normal(74, row)).collect();
    let model = GaussianProcess::fit(&rows, &known).expect("a model");
    assert!((0.24..0.38).contains(&model.noise_std_dev()), "{}", model.noise_std_dev());
    assert!(model.hyperparameters().spread > 0.0 && model.hyperparameters().noise >= 1e-6);
    // Of 240 new runs, intervals hold what they should.
    let new = places(240, 2, 75);
    let reach = folds(&model).reach(0.95);
    let at = model.predict(&new).expect("predictions");
    let inside =
        |row: usize| (wavy_plane(new.row(row)) + 0.3 * normal(76, row) - at[row].mean).abs() <= reach * at[row].std_dev;
    let share = (0..240).filter(|row| inside(*row)).count() as f64 / 240.0;
    assert!(share > 0.9, "{share}");
}

fn wavy_plane(x: &[f64]) -> f64 {
    (5.0 * x[0]).sin() + x[1]
}

/// Numbers of a normal distribution.
fn normal(seed: u64, row: usize) -> f64 {
    let [a, b] = [0, 1].map(|stream| uniform(seed, stream, row as u64));
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// Fault 10: intervals of few rows are neither absurdly wide nor empty promises.
#[test]
fn intervals_of_few_rows_are_sane() {
    let curved = |x: &[f64]| (4.0 * x[0]).sin() + x[1] * x[1] + 0.5 * x[0] * x[2];
    let waves = |x: &[f64]| (9.0 * x[0]).sin() * (7.0 * x[1]).cos() + x[2];
    let jump = |x: &[f64]| f64::from(u8::from(x[0] + 0.3 * x[1] > 0.6)) + x[1] + 0.3 * x[2];
    type Function<'f> = &'f dyn Fn(&[f64]) -> f64;
    let functions: [Function<'_>; 3] = [&curved, &waves, &jump];
    for rows in [10, 15, 20, 30] {
        let (mut held, mut tables) = (0.0, 0.0);
        for of in functions {
            for seed in 0..10 {
                let (points, new) = (places(rows, 3, 500 + seed), places(200, 3, 600 + seed));
                let (known, truth) = (values(&points, of), values(&new, of));
                let model = GaussianProcess::fit(&points, &known).expect("a model");
                let reach = folds(&model).reach(0.95);
                let at = model.predict(&new).expect("predictions");
                let inside = at.iter().zip(&truth).filter(|(at, y)| (at.mean - *y).abs() <= reach * at.std_dev);
                held += inside.count() as f64 / 200.0;
                tables += 1.0;
                let mut widths: Vec<f64> = at.iter().map(|at| 2.0 * reach * at.std_dev).collect();
                widths.sort_by(f64::total_cmp);
                let [low, high] = [f64::min, f64::max].map(|pick| known.iter().copied().reduce(pick).expect("rows"));
                assert!(widths[100] < 3.0 * (high - low), "{rows} rows: {} of {}", widths[100], high - low);
            }
        }
        let share = held / tables;
        eprintln!("{rows} rows: {share:.3}");
        assert!((0.88..=0.99).contains(&share), "{rows} rows: {share}");
    }
}

#[test]
fn a_q2_that_is_no_number_warns() {
    let known = ProcessFigures {
        kernel: "matern_5_2".to_owned(),
        weights: vec![1.0],
        noise: 1e-6,
        spread: 0.0,
        run_squares: 0.0,
        run_freedom: 0.0,
        mean: 0.0,
        variance: 1.0,
        noise_std_dev: 1e-3,
        places: 8,
        groups: 8,
        q2: 0.99,
        q2_folds: Some(f64::NAN),
        rms_error: 0.1,
        reach: 2.0,
    };
    let [text, other] = [|| "text".to_owned(); 2];
    let output = |process: ProcessFigures| OutputSurrogate {
        output: text(),
        unit: text(),
        description: text(),
        used: 8,
        left_out: Vec::new(),
        refused: None,
        process: Some(process),
        chaos: None,
        chaos_refused: None,
        success: None,
        twin_scatter: None,
    };
    let nan_alone = ProcessFigures { q2: f64::NAN, q2_folds: Some(0.99), ..known.clone() };
    let fine = ProcessFigures { q2_folds: Some(0.98), ..known.clone() };
    let surrogate = Surrogate {
        study: other(),
        study_hash: other(),
        program_version: other(),
        rows: 8,
        rows_there: 8,
        factors: Vec::new(),
        covered_distance: None,
        least_q2: 0.9,
        level: 0.95,
        notes: Vec::new(),
        outputs: [known, nan_alone, fine].map(output).to_vec(),
    };
    assert_eq!(surrogate.warnings().len(), 2);
}
