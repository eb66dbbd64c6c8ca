//! Limits of the rows' information about the factors: names that no row has, and places between few values.

use std::collections::{BTreeMap, BTreeSet};

use super::space::FactorSpace;
use crate::sensitivity::Table;
use decore_dataset::DatasetInfo;
use decore_quantity::Kind;

/// Number of values of a factor up to which Q2 may deceive. If half of an output's variance is one jump on a grid of two factors, Q2 is
/// 1.00 for left-out rows, and on average 0.76 (3 values), 0.83 (4), 0.89 (5 and 6), 0.94 (8) and 0.97 (12) at new places. If the jump is
/// the whole variance, twice as much is missing.
const FEW: usize = 12;

/// Returns notes on these rows of the table, a sentence each.
pub(super) fn remarks(factors: &[FactorSpace], table: &Table, rows: &[usize], info: &DatasetInfo) -> Vec<String> {
    let mut remarks = Vec::new();
    for factor in factors.iter().filter(|factor| !factor.unseen.is_empty()) {
        let names = factor.unseen.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        remarks.push(format!("None of the used rows has {names} of `{}`: predictions there are guesses.", factor.name));
    }
    let few = factors.iter().enumerate().filter_map(|(place, factor)| {
        let levels = levels(table, place, rows);
        let whole = info.factors.iter().any(|of| of.name == factor.name && of.kind == Kind::Integer);
        let told = factor.names.is_empty() && (2..=FEW).contains(&levels.count);
        let is_few = told && 2 * levels.single <= levels.count && !(whole && levels.are_all);
        is_few.then(|| format!("`{}` ({})", factor.name, levels.count))
    });
    let few: Vec<String> = few.collect();
    if !few.is_empty() {
        remarks.push(format!(
            "The rows have few values of {}. Left-out rows mostly have the same values as others, so Q2, errors and \
             intervals are valid only at these values. If an output jumps between them, its predictions there \
             are wrong, whatever Q2 is. Rows between them would show it (a Latin hypercube, Sobol' points).",
            few.join(", ")
        ));
    }
    remarks
}

/// The different values of a factor.
struct Levels {
    /// Number of values.
    count: usize,
    /// Number of values of one place only: leaving out this place tests a gap between the other values.
    single: usize,
    /// Whether they are all whole numbers from the least to the largest.
    are_all: bool,
}

fn levels(table: &Table, factor: usize, rows: &[usize]) -> Levels {
    // Zero has two signs.
    let bits = |value: f64| (value + 0.0).to_bits();
    let mut places: BTreeMap<u64, BTreeSet<Vec<u64>>> = BTreeMap::new();
    for row in rows {
        let place = table.factors.iter().map(|column| bits(column.values[*row])).collect();
        places.entry(bits(table.factors[factor].values[*row])).or_default().insert(place);
    }
    let values = || places.keys().map(|value| f64::from_bits(*value));
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    Levels {
        count: places.len(),
        single: places.values().filter(|places| places.len() == 1).count(),
        are_all: high - low + 1.0 == places.len() as f64,
    }
}
