//! Tests whether factors depend on each other, and the consequences for the indices.

use super::table::{FactorColumn, Table, differ};
use decore_statistics::analysis::{drawn_rows, kruskal_wallis, rank_correlation, rank_correlation_p_value};
use decore_study::DesignOutline;

/// Probability of a pair that goes together by chance, of all pairs together (Bonferroni): a table of independent rows in a
/// thousand has one.
const CHANCE: f64 = 1e-3;
/// Rows at most that are compared.
const COMPARED_ROWS: usize = 10_000;
/// Rank correlations below this are ignored, and shares of ranks between names below its square.
const LEAST_CORRELATION: f64 = 0.1;
/// Rows below which nothing is compared.
const LEAST_ROWS: usize = 10;

/// The note on it.
pub(super) fn dependence(table: &Table, outline: &DesignOutline, shapley: bool) -> Option<String> {
    let why = match (outline.constraints.as_slice(), outline.correlated.as_slice()) {
        ([], []) => {
            let DependentFactors { first, second, bond, .. } = closest(table)?;
            let how = match bond {
                Bond::Correlation(correlation) => format!("with a rank correlation of {correlation:.2}"),
                Bond::Share(share) => format!("the names having {:.0} % of the variance of the ranks", 100.0 * share),
            };
            format!("`{first}` and `{second}` go together in the rows, {how}")
        }
        ([], correlated) => format!("the study correlates {}", correlated.join(", ")),
        (constraints, _) => format!("the rows meet the constraints {}", constraints.join("; ")),
    };
    let instead = if shapley { "; Shapley effects do it here" } else { "" };
    Some(format!(
        "The factors depend on each other: {why}. Sobol' indices need independent factors{instead}. S1 by ranks, eta2, \
         PAWN and HSIC of a factor may come from the other factors."
    ))
}

/// Strength of the relation of two factors.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bond {
    /// Rank correlation of two numbers.
    Correlation(f64),
    /// Share of a number's ranks that lies between names.
    Share(f64),
}

/// Two factors that go together in the rows.
#[derive(Debug, PartialEq)]
struct DependentFactors<'a> {
    first: &'a str,
    second: &'a str,
    bond: Bond,
    /// Probability of a stronger bond by chance.
    p_value: f64,
}

impl Bond {
    /// As a correlation, whatever its sign.
    fn size(self) -> f64 {
        match self {
            Self::Correlation(correlation) => correlation.abs(),
            Self::Share(share) => share.max(0.0).sqrt(),
        }
    }
}

/// The two factors with the strongest significant relation. Pairs of factors of names are not tested.
fn closest(table: &Table) -> Option<DependentFactors<'_>> {
    let done: Vec<usize> = (0..table.rows.len()).filter(|place| table.faults[*place].is_none()).collect();
    let rows: Vec<usize> = drawn_rows(done.len(), COMPARED_ROWS, 0).into_iter().map(|place| done[place]).collect();
    if rows.len() < LEAST_ROWS {
        return None;
    }
    let of_rows = |factor: &FactorColumn| rows.iter().map(|row| factor.values[*row]).collect::<Vec<f64>>();
    let columns: Vec<(&FactorColumn, Vec<f64>)> =
        table.factors.iter().map(|factor| (factor, of_rows(factor))).filter(|(_, values)| differ(values)).collect();
    let pairs = columns
        .iter()
        .enumerate()
        .flat_map(|(place, first)| columns[place + 1..].iter().map(move |second| (first, second)));
    let pairs: Vec<DependentFactors<'_>> = pairs.filter_map(|(first, second)| pair(first, second)).collect();
    let chance = CHANCE / pairs.len() as f64;
    let surprising = pairs.into_iter().filter(|pair| pair.p_value < chance && pair.bond.size() > LEAST_CORRELATION);
    surprising.max_by(|a, b| a.bond.size().total_cmp(&b.bond.size()))
}

fn pair<'a>(
    (first, a): &(&'a FactorColumn, Vec<f64>),
    (second, b): &(&'a FactorColumn, Vec<f64>),
) -> Option<DependentFactors<'a>> {
    let (bond, p_value) = match (first.nominal, second.nominal) {
        (false, false) => {
            let correlation = rank_correlation(a, b);
            (Bond::Correlation(correlation), rank_correlation_p_value(correlation, a.len()))
        }
        (true, true) => return None,
        (names_first, _) => {
            let found = if names_first { kruskal_wallis(a, b) } else { kruskal_wallis(b, a) }?;
            (Bond::Share(found.share), found.p_value)
        }
    };
    Some(DependentFactors { first: &first.name, second: &second.name, bond, p_value })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: [(&str, Vec<f64>, bool); 2]) -> Table {
        let rows = columns[0].1.len();
        let column = |(name, values, nominal): (&str, Vec<f64>, bool)| FactorColumn {
            name: name.into(),
            values,
            nominal,
            names: Vec::new(),
        };
        Table {
            rows: (0..rows as u64).collect(),
            faults: vec![None; rows],
            reasons: Vec::new(),
            factors: columns.map(column).into(),
            outputs: Vec::new(),
        }
    }

    #[test]
    fn factors_that_go_together_are_told() {
        let rising = |rows: u32| -> Vec<f64> { (0..rows).map(f64::from).collect() };
        let mixed: Vec<f64> = (0..100).map(|row| f64::from(row * 37 % 101)).collect();
        for rows in [25, 100] {
            let same = table([("a", rising(rows), false), ("b", rising(rows), false)]);
            let found = closest(&same).expect("a pair");
            assert_eq!((found.first, found.second, found.bond), ("a", "b", Bond::Correlation(1.0)), "{rows}");
        }
        assert_eq!(closest(&table([("a", rising(100), false), ("b", mixed.clone(), false)])), None);
        // A name that is fixed by a number, and one that is not.
        let names = |values: &[f64]| values.iter().map(|value| f64::from(*value > 50.0)).collect::<Vec<f64>>();
        let fixed = table([("mount", names(&mixed), true), ("pressure", mixed.clone(), false)]);
        assert!(matches!(closest(&fixed), Some(DependentFactors { bond: Bond::Share(share), .. }) if share > 0.7));
        assert_eq!(closest(&table([("mount", names(&mixed), true), ("pressure", rising(100), false)])), None);
    }
}
