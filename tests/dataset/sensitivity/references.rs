//! The indices of one table as SALib and OpenTURNS give them; `source` in the file says which gives which.

use decore_math::random::uniform;
use decore_math::special::normal_quantile;
use decore_statistics::analysis::{
    Bootstrap, Estimate, Estimator, FactorValues, SaltelliBlocks, Trajectories, given, morris, shapley, sobol,
};
use serde_json::Value;

/// Largest difference of two programs that sum the same numbers in another order.
const ROUNDING: f64 = 1e-12;
const NO_INTERVALS: Bootstrap = Bootstrap { replicates: 0, seed: 0, level: 0.95 };

fn references() -> Value {
    serde_json::from_str(include_str!("../../data/sensitivity_references.json")).expect("JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

#[track_caller]
fn assert_near(found: impl Iterator<Item = Estimate>, expected: &Value, what: &str) {
    let (found, expected) = (found.map(|estimate| estimate.value).collect::<Vec<_>>(), numbers(expected));
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() <= ROUNDING * expected.abs().max(1.0), "{what}: {found} for {expected}");
    }
}

#[test]
fn val_sobol_indices_are_those_of_salib_and_openturns() {
    let references = references();
    let tables = references["sobol"].as_array().expect("tables");
    assert_eq!(tables.len(), 2);
    for table in tables {
        let second_order = table["second_order"].as_bool().expect("a choice");
        let factors = table["factors"].as_u64().expect("a count") as usize;
        let blocks = SaltelliBlocks { factors, second_order };
        for estimator in Estimator::ALL {
            let found = sobol(&numbers(&table["outputs"]), blocks, estimator, &NO_INTERVALS).expect("indices");
            let expected = &table[estimator.name()];
            assert_near(found.first.into_iter(), &expected["s1"], "S1");
            assert_near(found.total.into_iter(), &expected["st"], "ST");
            assert_near(found.second.into_iter().map(|pair| pair.index), &expected["s2"], "S2");
        }
    }
}

/// They are three, not one by three names.
#[test]
fn estimators_differ_on_one_table() {
    let references = references();
    let values = numbers(&references["sobol"][0]["outputs"]);
    let first = |estimator| {
        let blocks = SaltelliBlocks { factors: 3, second_order: true };
        sobol(&values, blocks, estimator, &NO_INTERVALS).expect("indices").first[0].value
    };
    let [salib, jansen, martinez] = Estimator::ALL.map(first);
    assert!((salib - jansen).abs() > 1e-3 && (jansen - martinez).abs() > 1e-3, "{salib} {jansen} {martinez}");
}

#[test]
fn val_elementary_effects_are_those_of_salib() {
    let reference = &references()["morris"];
    let factors: Vec<Vec<f64>> = reference["factors"].as_array().expect("columns").iter().map(numbers).collect();
    let trajectories =
        Trajectories { factors: &factors, levels: reference["levels"].as_u64().expect("a count"), reaches: &[] };
    let found = morris(&numbers(&reference["outputs"]), trajectories, &NO_INTERVALS).expect("effects");
    let found: Vec<_> = found.into_iter().map(|effects| effects.expect("every factor moves")).collect();
    assert_near(found.iter().map(|effects| effects.mean), &reference["mu"], "mu");
    assert_near(found.iter().map(|effects| effects.mean_size), &reference["mu_star"], "mu*");
    assert_near(found.iter().map(|effects| effects.std_dev), &reference["sigma"], "sigma");
    assert!(found.iter().all(|effects| effects.count == 8));
}

#[test]
fn val_indices_of_any_rows_are_those_of_salib_and_openturns() {
    let reference = &references()["given"];
    let columns: Vec<Vec<f64>> = reference["factors"].as_array().expect("columns").iter().map(numbers).collect();
    let factors: Vec<FactorValues<'_>> = columns.iter().map(|values| FactorValues { values, nominal: false }).collect();
    let found = given(&numbers(&reference["outputs"]), &factors, &NO_INTERVALS).expect("indices");
    let plain = |value: f64| Estimate { value, interval: None };
    assert_near(found.iter().map(|of| of.rank), &reference["rank"], "rank");
    assert_near(found.iter().map(|of| plain(of.pawn.median)), &reference["pawn"]["median"], "PAWN, median");
    assert_near(found.iter().map(|of| plain(of.pawn.maximum)), &reference["pawn"]["maximum"], "PAWN, maximum");
    assert_near(found.iter().map(|of| plain(of.hsic.r2)), &reference["hsic"]["r2"], "R2-HSIC");
    assert_near(found.iter().map(|of| plain(of.hsic.p_value)), &reference["hsic"]["p_value"], "p-value of HSIC");
}

/// Standard normal numbers, a column per factor.
fn normal_columns(rows: u64, factors: u64) -> Vec<Vec<f64>> {
    let number = |row: u64, factor: u64| normal_quantile(uniform(5, factor, row).max(1e-16));
    (0..factors).map(|factor| (0..rows).map(|row| number(row, factor)).collect()).collect()
}

/// Names are classes: of an output that is a number per name and noise, the ratio is known.
#[test]
fn analytic_correlation_ratio_of_names() {
    let noise = normal_columns(4000, 1).remove(0);
    let names: Vec<f64> = (0..4000).map(|row| f64::from(row % 3)).collect();
    let values: Vec<f64> = names.iter().zip(&noise).map(|(name, noise)| name + noise).collect();
    let factors = [FactorValues { values: &names, nominal: true }, FactorValues { values: &noise, nominal: false }];
    let found = given(&values, &factors, &Bootstrap { replicates: 100, ..NO_INTERVALS }).expect("indices");
    // The variance of 0, 1, 2 is 2/3.
    let truth = (2.0 / 3.0) / (2.0 / 3.0 + 1.0);
    for estimate in [found[0].correlation_ratio, found[0].rank] {
        let [low, high] = estimate.interval.expect("an interval");
        // An interval reaches 1.96 standard deviations from the estimate; a single table may be 3 away.
        let std_dev = (high - low) / (2.0 * 1.96);
        assert!((estimate.value - truth).abs() < 3.0 * std_dev && std_dev < 0.02, "{estimate:?} about {truth}");
    }
    assert!(found[0].hsic.p_value < 1e-12 && found[0].pawn.maximum > 0.2, "{:?}", found[0]);
}

/// A linear function of normal factors, two of which are correlated (Owen and Prieur, 2017, have the effects).
#[test]
fn analytic_shapley_effects_of_correlated_factors() {
    for correlation in [0.0, 0.9_f64] {
        let mut columns = normal_columns(1500, 3);
        let second = columns[1].clone();
        let rest = (1.0 - correlation * correlation).sqrt();
        columns[2].iter_mut().zip(&second).for_each(|(third, second)| *third = correlation * second + rest * *third);
        let values: Vec<f64> = (0..1500).map(|row| columns[0][row] + columns[1][row] + 2.0 * columns[2][row]).collect();
        let factors: Vec<FactorValues<'_>> =
            columns.iter().map(|values| FactorValues { values, nominal: false }).collect();
        let found = shapley(&values, &factors, &Bootstrap { replicates: 60, ..NO_INTERVALS }).expect("effects");
        let square = correlation * correlation;
        let shared = 2.0 * correlation;
        let truth =
            [1.0, 1.0 - square / 2.0 + shared + 2.0 * square, 4.0 * (1.0 - square / 2.0) + shared + square / 2.0];
        let variance: f64 = truth.iter().sum();
        for (estimate, truth) in found.iter().zip(truth) {
            let [low, high] = estimate.interval.expect("an interval");
            // Neighbours are near, not in the same place: a bias of 0.01 at so many rows.
            let truth = truth / variance;
            assert!(low - 0.01 < truth && truth < high + 0.01 && high - low < 0.1, "{estimate:?} about {truth}");
        }
        let sum: f64 = found.iter().map(|estimate| estimate.value).sum();
        assert!((sum - 1.0).abs() < 1e-12, "they add up to {sum}");
    }
}
