//! Suitability of a design's rows for estimators that compare a row with its neighbours.

use std::collections::HashMap;

use super::table::{FactorColumn, Table};
use decore_statistics::analysis::{FactorValues, spread};
use decore_statistics::design::{HypercubeKind, Kind, LatinHypercube};
use decore_study::DesignOutline;

/// Whether S1 by ranks and Shapley effects are computed, and of which rows.
#[derive(Debug, Default)]
pub(super) struct Neighbours {
    /// Reason why they are not suitable.
    pub refused: Option<String>,
    /// Whether rows are somewhat more even than independent draws, so that both are a little off.
    pub hypercube: bool,
    /// Whether rows fill every factor's classes evenly in the others.
    pub even: bool,
    /// Rows at the place of another row; 0 if rows are drawn, as drawn ones may meet.
    pub repeated: usize,
}

impl Neighbours {
    /// By the kind of the design; of rows of a file or of parts by the rows.
    pub fn of(table: &Table, outline: &DesignOutline) -> Self {
        let varying: Vec<&FactorColumn> = table.factors.iter().filter(|factor| factor.varies()).collect();
        let columns: Vec<&[f64]> = varying.iter().map(|factor| factor.values.as_slice()).collect();
        let laid_out = outline.design.as_ref().and_then(laid_out);
        if varying.is_empty() || outline.design.is_some() {
            // Of one factor alone neighbours differ in nothing else.
            let refused = laid_out.filter(|_| varying.len() > 1).map(refusal);
            let hypercube = varying.len() > 1 && outline.design.as_ref().is_some_and(is_optimised_hypercube);
            return Self { even: refused.is_some(), refused, hypercube, repeated: 0 };
        }
        let places = places(&columns);
        let firsts: Vec<Vec<f64>> =
            columns.iter().map(|values| places.iter().map(|rows| values[rows[0]]).collect()).collect();
        let factors = firsts.iter().zip(&varying);
        let factors: Vec<FactorValues<'_>> =
            factors.map(|(values, factor)| FactorValues { values, nominal: factor.nominal }).collect();
        let even = spread(&factors);
        Self {
            refused: even.then(|| refusal("these rows")),
            even,
            hypercube: false,
            repeated: table.rows.len() - places.len().min(table.rows.len()),
        }
    }

    /// Returns notes for the reader.
    pub fn notes(&self) -> Vec<String> {
        let repeated = (self.repeated > 0).then(|| {
            format!(
                "Rows at the place of another one in all factors: {}. Those at one place count once, with the mean of their outputs.",
                self.repeated
            )
        });
        let hypercube = self.hypercube.then(|| {
            "Rows of an optimised Latin hypercube are more even than independent draws. So the errors of S1 by ranks \
             and Shapley effects exceed their intervals: in a known case by up to 0.15 with 240 rows and 0.05 \
             with 2000. eta2 is not affected."
                .to_owned()
        });
        self.refused.iter().cloned().chain(hypercube).chain(repeated).collect()
    }

    /// Columns and an output with a row for each place, where rows are repeated.
    pub fn once_each(&self, columns: &mut [Vec<f64>], values: &mut Vec<f64>) {
        if self.repeated == 0 || columns.is_empty() {
            return;
        }
        let places = places(&columns.iter().map(Vec::as_slice).collect::<Vec<&[f64]>>());
        for column in columns.iter_mut() {
            *column = places.iter().map(|rows| column[rows[0]]).collect();
        }
        // Each is divided first, as outputs may be near the largest number.
        let mean = |rows: &Vec<usize>| rows.iter().map(|row| values[*row] / rows.len() as f64).sum::<f64>();
        *values = places.iter().map(mean).collect();
    }
}

/// The rows at every place, in the order of the first ones.
fn places(columns: &[&[f64]]) -> Vec<Vec<usize>> {
    let mut known: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut places: Vec<Vec<usize>> = Vec::new();
    for row in 0..columns.first().map_or(0, |values| values.len()) {
        let key: Vec<u64> = columns.iter().map(|values| values[row].to_bits()).collect();
        let place = *known.entry(key).or_insert(places.len());
        match places.get_mut(place) {
            Some(rows) => rows.push(row),
            None => places.push(vec![row]),
        }
    }
    places
}

fn refusal(what: &str) -> String {
    format!(
        "S1 by ranks and Shapley effects are not computed: they need independent draws, but {what} are so even that \
         neighbours in one factor differ more in the others. Use eta2, the share of the variance due to a factor \
         alone, or `random` rows or a Latin hypercube to get all indices."
    )
}

/// Name of a design whose rows are not independent draws.
fn laid_out(kind: &Kind) -> Option<&'static str> {
    match kind {
        Kind::Random(_) | Kind::LatinHypercube(_) => None,
        Kind::Sobol(_) => Some("Sobol' points"),
        Kind::Halton(_) => Some("Halton points"),
        Kind::Saltelli(_) => Some("the base points of a Saltelli design, which are Sobol' points,"),
        _ => Some("the rows of this design"),
    }
}

fn is_optimised_hypercube(kind: &Kind) -> bool {
    matches!(kind, Kind::LatinHypercube(LatinHypercube { kind, .. }) if *kind != HypercubeKind::Random)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_at_one_place_count_once() {
        let mut columns = vec![vec![1.0, 2.0, 1.0, 1.0], vec![5.0, 5.0, 5.0, 6.0]];
        let mut values = vec![10.0, 20.0, 30.0, 40.0];
        Neighbours { repeated: 1, ..Neighbours::default() }.once_each(&mut columns, &mut values);
        assert_eq!((columns, values), (vec![vec![1.0, 2.0, 1.0], vec![5.0, 5.0, 6.0]], vec![20.0, 20.0, 40.0]));
    }
}
