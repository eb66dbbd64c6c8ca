//! Strata, grid levels and faults of designs.

use decore_statistics::design::{
    Design, DesignError, Distribution, Factor, FullFactorial, Kind, LatinHypercube, Level, MOST_ROWS, Placement, Single,
};
use proptest::prelude::*;

fn factor(distribution: Distribution) -> Factor {
    Factor { distribution, levels: None }
}

fn latin(rows: usize, placement: Placement) -> Kind {
    Kind::LatinHypercube(LatinHypercube { rows, placement, ..LatinHypercube::default() })
}

fn hypercube(rows: usize, placement: Placement, seed: u64, factors: &[Distribution]) -> Design {
    let factors = factors.iter().cloned().map(factor).collect();
    Design::new(latin(rows, placement), factors, seed).unwrap()
}

fn real(level: Level) -> f64 {
    match level {
        Level::Real(value) => value,
        other => panic!("{other:?}"),
    }
}

/// All rows of one factor.
fn column(design: &Design, index: usize) -> Vec<Level> {
    (0..design.row_count()).map(|row| design.row(row).unwrap()[index]).collect()
}

proptest! {
    #[test]
    fn every_stratum_of_every_real_factor_is_hit_once(
        rows in 1usize..300, seed: u64, centred: bool, low in -10.0..10.0f64, width in 0.1..10.0f64,
    ) {
        let placement = if centred { Placement::Centred } else { Placement::Random };
        let uniform = Distribution::Uniform { low, high: low + width };
        let log = Distribution::LogUniform { low: 0.01, high: 100.0 };
        let design = hypercube(rows, placement, seed, &[uniform.clone(), log, uniform]);
        for index in 0..3 {
            let mut hit = vec![0; rows];
            for level in column(&design, index) {
                let value = real(level);
                let share = if index == 1 {
                    prop_assert!((0.01..=100.0).contains(&value));
                    (value / 0.01).ln() / 1e4_f64.ln()
                } else {
                    prop_assert!(value >= low && value <= low + width);
                    (value - low) / width
                };
                // A point on a border may come out a rounding error beside its stratum.
                let scaled = share * rows as f64;
                let stratum = if (scaled - scaled.round()).abs() < 1e-9 { scaled.round() } else { scaled.floor() };
                hit[(stratum as usize).min(rows - 1)] += 1;
                if centred {
                    prop_assert!((scaled.fract() - 0.5).abs() < 1e-6);
                }
            }
            prop_assert!(hit.iter().all(|&count| count == 1), "{hit:?}");
        }
    }

    #[test]
    fn integers_and_categories_are_hit_evenly(rows in 1usize..300, seed: u64, count in 1usize..40, low in -50i64..50) {
        let integer = Distribution::Integer { low, high: low + count as i64 - 1 };
        let design = hypercube(rows, Placement::Random, seed, &[integer, Distribution::Categories { count }]);
        let mut integers = vec![0usize; count];
        let mut categories = vec![0usize; count];
        for row in 0..rows {
            match design.row(row).unwrap()[..] {
                [Level::Integer(value), Level::Category(index)] => {
                    integers[usize::try_from(value - low).unwrap()] += 1;
                    categories[index] += 1;
                }
                ref other => panic!("{other:?}"),
            }
        }
        for counts in [integers, categories] {
            let most = counts.iter().max().unwrap();
            let least = counts.iter().min().unwrap();
            prop_assert!(most - least <= 1, "{counts:?}");
        }
    }

    #[test]
    fn rows_depend_on_seed_and_row_only(rows in 2usize..200, seed: u64) {
        let uniform = Distribution::Uniform { low: 0.0, high: 1.0 };
        let design = hypercube(rows, Placement::Random, seed, &[uniform.clone(), uniform.clone()]);
        let forward: Vec<_> = (0..rows).map(|row| design.row(row)).collect();
        let mut backward: Vec<_> = (0..rows).rev().map(|row| design.clone().row(row)).collect();
        backward.reverse();
        prop_assert_eq!(&forward, &backward);
        // A further factor leaves the others alone.
        let more = hypercube(rows, Placement::Random, seed, &[uniform.clone(), uniform.clone(), Distribution::Categories { count: 3 }]);
        for (row, values) in forward.iter().enumerate() {
            prop_assert_eq!(&more.row(row).unwrap()[..2], &values.clone().unwrap()[..]);
        }
        let other = hypercube(rows, Placement::Random, seed ^ 1, &[uniform.clone(), uniform.clone()]);
        prop_assert_ne!(forward, (0..rows).map(|row| other.row(row)).collect::<Vec<_>>());
        prop_assert_eq!(design.row(rows), None);
    }

    #[test]
    fn a_grid_holds_every_combination_once(a in 2usize..6, b in 1usize..6, c in 1i64..6) {
        let factors = vec![
            Factor { distribution: Distribution::Uniform { low: 0.0, high: 1.0 }, levels: Some(a) },
            factor(Distribution::Categories { count: b }),
            factor(Distribution::Integer { low: 0, high: c - 1 }),
        ];
        let design = Design::new(Kind::FullFactorial(FullFactorial), factors, 0).unwrap();
        prop_assert_eq!(design.row_count(), a * b * c as usize);
        let mut rows: Vec<String> = (0..design.row_count()).map(|row| format!("{:?}", design.row(row))).collect();
        rows.sort();
        rows.dedup();
        prop_assert_eq!(rows.len(), design.row_count());
    }
}

#[test]
fn grid_levels_include_their_ends() {
    let levels = |distribution, levels| {
        let design =
            Design::new(Kind::FullFactorial(FullFactorial), vec![Factor { distribution, levels: Some(levels) }], 0)
                .unwrap();
        column(&design, 0)
    };
    let close = |levels: Vec<Level>, wanted: &[f64]| {
        assert_eq!(levels.len(), wanted.len());
        for (level, wanted) in levels.into_iter().zip(wanted) {
            assert!((real(level) / wanted - 1.0).abs() < 1e-14, "{level:?} for {wanted}");
        }
    };
    close(levels(Distribution::Uniform { low: 4.0, high: 6.0 }, 5), &[4.0, 4.5, 5.0, 5.5, 6.0]);
    close(levels(Distribution::LogUniform { low: 1.0, high: 1e4 }, 5), &[1.0, 1e1, 1e2, 1e3, 1e4]);
    let integers = levels(Distribution::Integer { low: 1, high: 10 }, 4);
    assert_eq!(integers, [1, 4, 7, 10].map(Level::Integer));
    let all =
        Design::new(Kind::FullFactorial(FullFactorial), vec![factor(Distribution::Integer { low: -1, high: 1 })], 0)
            .unwrap();
    assert_eq!(column(&all, 0), [-1, 0, 1].map(Level::Integer));
}

#[test]
fn columns_of_a_hypercube_are_uncorrelated() {
    // Correlation of two random permutations of n: mean 0, variance 1 / (n - 1). Over 400 seeds the mean of its square,
    // times n - 1, has mean 1 and a standard deviation of about sqrt(2 / 400).
    let n = 50;
    let uniform = Distribution::Uniform { low: 0.0, high: 1.0 };
    let mut squares = 0.0;
    for seed in 0..400 {
        let design = hypercube(n, Placement::Centred, seed, &[uniform.clone(), uniform.clone()]);
        let centred = |index| column(&design, index).into_iter().map(|level| real(level) - 0.5).collect::<Vec<_>>();
        let (a, b) = (centred(0), centred(1));
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let correlation = product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt();
        squares += correlation * correlation * (n - 1) as f64 / 400.0;
    }
    assert!((squares - 1.0).abs() < 4.0 * (2.0f64 / 400.0).sqrt(), "{squares}");
}

#[test]
fn a_row_of_a_large_design_is_computed_alone() {
    let uniform = Distribution::Uniform { low: 0.0, high: 1.0 };
    let design = hypercube(MOST_ROWS, Placement::Random, 3, &vec![uniform; 20]);
    let start = std::time::Instant::now();
    for row in 0..1000 {
        assert_eq!(design.row(row * (MOST_ROWS / 1000)).map(|values| values.len()), Some(20));
    }
    assert!(start.elapsed().as_secs_f64() < 1.0);
}

#[test]
fn designs_that_make_no_sense_are_errors() {
    let new = |kind, distribution, levels| Design::new(kind, vec![Factor { distribution, levels }], 0).unwrap_err();
    let cube = || latin(4, Placement::Random);
    let range = |low, high| Distribution::Uniform { low, high };
    assert!(matches!(new(cube(), range(1.0, 1.0), None), DesignError::EmptyRange { factor: 0, .. }));
    assert!(matches!(new(cube(), range(2.0, 1.0), None), DesignError::EmptyRange { .. }));
    assert!(matches!(new(cube(), range(f64::NAN, 1.0), None), DesignError::NotFinite { .. }));
    assert!(matches!(new(cube(), range(0.0, f64::INFINITY), None), DesignError::NotFinite { .. }));
    assert!(matches!(
        new(cube(), Distribution::LogUniform { low: 0.0, high: 1.0 }, None),
        DesignError::NotPositive { .. }
    ));
    assert!(matches!(new(cube(), Distribution::Integer { low: 1, high: 0 }, None), DesignError::EmptyRange { .. }));
    assert!(matches!(new(cube(), Distribution::Categories { count: 0 }, None), DesignError::NoCategories { .. }));
    let none = latin(0, Placement::Random);
    assert_eq!(new(none, range(0.0, 1.0), None), DesignError::NoRows);
    assert!(matches!(
        new(Kind::FullFactorial(FullFactorial), range(0.0, 1.0), None),
        DesignError::LevelsNeeded { factor: 0 }
    ));
    assert!(matches!(new(Kind::FullFactorial(FullFactorial), range(0.0, 1.0), Some(1)), DesignError::Levels { .. }));
    let few = Distribution::Integer { low: 1, high: 3 };
    assert!(matches!(new(Kind::FullFactorial(FullFactorial), few, Some(4)), DesignError::Levels { most: 3, .. }));
    assert!(matches!(new(Kind::Single(Single), range(0.0, 1.0), None), DesignError::Factors(_)));
    assert!(matches!(Design::new(cube(), Vec::new(), 0), Err(DesignError::Factors(_))));
    let wide = Factor { distribution: Distribution::Integer { low: i64::MIN, high: i64::MAX }, levels: None };
    let error = Design::new(Kind::FullFactorial(FullFactorial), vec![wide.clone(); 2], 0).unwrap_err();
    assert_eq!(error, DesignError::TooManyRows);
    assert!(Design::new(cube(), vec![wide], 0).unwrap().row(3).is_some());
}

#[test]
fn logarithmic_whole_numbers_have_their_shares() {
    let factor = |levels| Factor { distribution: Distribution::LogInteger { low: 1, high: 1000 }, levels };
    let rows = 20_000;
    let design = Design::new(latin(rows, Placement::Random), vec![factor(None)], 5).unwrap();
    let mut counts = vec![0_usize; 1001];
    for level in column(&design, 0) {
        match level {
            Level::Integer(value) => counts[usize::try_from(value).unwrap()] += 1,
            other => panic!("{other:?}"),
        }
    }
    // The share of v is log((v + 1/2) / (v - 1/2)) of log(1000.5 / 0.5); a stratified sample is off by one at each end.
    let all = (1000.5_f64 / 0.5).ln();
    for (value, count) in counts.iter().enumerate().skip(1) {
        let share = ((value as f64 + 0.5) / (value as f64 - 0.5)).ln() / all;
        assert!((*count as f64 - share * rows as f64).abs() < 2.0, "{value}: {count}");
    }
    let grid =
        |levels| column(&Design::new(Kind::FullFactorial(FullFactorial), vec![factor(Some(levels))], 0).unwrap(), 0);
    assert_eq!(grid(4), [1, 10, 100, 1000].map(Level::Integer));
    // Where ratios are too fine for whole numbers, the levels are still different and end where they should.
    let fine: Vec<i64> =
        grid(40).iter().map(|level| if let Level::Integer(value) = level { *value } else { 0 }).collect();
    assert!(fine.windows(2).all(|pair| pair[0] < pair[1]) && fine[0] == 1 && fine[39] == 1000, "{fine:?}");
    let whole = Factor { distribution: Distribution::LogInteger { low: 3, high: 9 }, levels: None };
    let all = Design::new(Kind::FullFactorial(FullFactorial), vec![whole], 0).unwrap();
    assert_eq!(column(&all, 0), [3, 4, 5, 6, 7, 8, 9].map(Level::Integer));
    let zero = vec![Factor { distribution: Distribution::LogInteger { low: 0, high: 9 }, levels: None }];
    assert!(matches!(Design::new(latin(3, Placement::Random), zero, 0).unwrap_err(), DesignError::NotPositive { .. }));
}
