//! Elementary effects (Morris, Technometrics 33, 1991; Campolongo, Cariboni and Saltelli, Environ. Model. Softw. 22, 2007).

use super::error::{AnalysisError, check_values};
use super::estimate::{Bootstrap, Estimate};

/// Rows of a table that has trajectories of `factors + 1` rows one after the other.
#[derive(Debug, Clone, Copy)]
pub struct Trajectories<'a> {
    /// The factors' values, a column each; names by their index.
    pub factors: &'a [Vec<f64>],
    /// Levels of the grid: a factor moves by `levels / 2` of the `levels - 1` steps of its range.
    pub levels: u64,
    /// Reach of each factor's moves; [`Reach::Grid`] for missing ones.
    pub reaches: &'a [Reach],
}

/// Relation of a factor's whole range to its moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Moves on the grid.
    Grid,
    /// Of whole numbers and lists: the difference of its ends. Rounding makes their moves others than the grid's.
    Values(f64),
    /// Of names: every move is one from one name to another.
    Names,
}

/// Effects of a factor on one output, per range of the factor: changes of the output over the share of the range by which the factor moved.
/// This share is `(levels / 2) / (levels - 1)`; for whole numbers and lists the difference of the values over the difference of their ends;
/// for names 1. In units of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effects {
    /// Mean effect, mu.
    pub mean: Estimate,
    /// Mean of the effects' sizes, mu*: how much the factor matters.
    pub mean_size: Estimate,
    /// Standard deviation of the effects, sigma: how much that depends on the factor itself and the others.
    pub std_dev: Estimate,
    /// Number of effects.
    pub count: usize,
}

/// Change from a row to the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Move {
    factor: usize,
    /// Difference of its values.
    by: f64,
}

/// Effects of every factor on an output, given for the rows of `trajectories`; `None` for a factor that never moves.
///
/// # Errors
/// [`AnalysisError::Length`] for part of a trajectory, [`AnalysisError::TooFew`] for fewer than two,
/// [`AnalysisError::NoTrajectory`] for rows that differ in several factors, [`AnalysisError::NotFinite`],
/// [`AnalysisError::Constant`].
pub fn morris(
    values: &[f64],
    trajectories: Trajectories<'_>,
    bootstrap: &Bootstrap,
) -> Result<Vec<Option<Effects>>, AnalysisError> {
    let factors = trajectories.factors.len();
    let size = factors + 1;
    if !values.len().is_multiple_of(size) {
        return Err(AnalysisError::Length { rows: values.len(), unit: "trajectories", size });
    }
    let count = values.len() / size;
    if count < 2 {
        return Err(AnalysisError::TooFew { unit: "trajectories", found: count, least: 2 });
    }
    check_values(values)?;
    let effects = elementary_effects(values, trajectories)?;
    let counted = |factor: usize| effects.iter().filter(|of| of.get(factor).is_some_and(Option::is_some)).count();
    let estimates = bootstrap.estimates(count, &|weights| statistics(&effects, factors, weights));
    let of_factor = |(factor, figures): (usize, &[Estimate])| match (counted(factor), figures) {
        (0, _) => None,
        (count, &[mean, mean_size, std_dev]) => Some(Effects { mean, mean_size, std_dev, count }),
        _ => None,
    };
    Ok(estimates.chunks_exact(3).enumerate().map(of_factor).collect())
}

/// The effect of every factor in every trajectory.
fn elementary_effects(values: &[f64], trajectories: Trajectories<'_>) -> Result<Vec<Vec<Option<f64>>>, AnalysisError> {
    let factors = trajectories.factors.len();
    let grid = (trajectories.levels / 2) as f64 / (trajectories.levels.max(2) - 1) as f64;
    let mut effects = Vec::with_capacity(values.len() / (factors + 1));
    for (trajectory, outputs) in values.chunks_exact(factors + 1).enumerate() {
        let mut of = vec![None; factors];
        for (step, pair) in outputs.windows(2).enumerate() {
            let row = trajectory * (factors + 1) + step;
            if let (Some(Move { factor, by }), [before, after]) = (moved(trajectories.factors, row)?, pair) {
                let share = match trajectories.reaches.get(factor) {
                    Some(Reach::Values(reach)) => by.abs() / reach,
                    Some(Reach::Names) => 1.0,
                    Some(Reach::Grid) | None => grid,
                };
                of[factor] = Some((after - before) * by.signum() / share);
            }
        }
        effects.push(of);
    }
    Ok(effects)
}

/// The factor that differs between a row and the next; `None` if none does.
fn moved(factors: &[Vec<f64>], row: usize) -> Result<Option<Move>, AnalysisError> {
    let mut found = None;
    let mut changed = 0;
    for (factor, column) in factors.iter().enumerate() {
        if let Some([before, after]) = column.get(row..row + 2)
            && before != after
        {
            changed += 1;
            found = Some(Move { factor, by: after - before });
        }
    }
    if changed > 1 { Err(AnalysisError::NoTrajectory { row, changed }) } else { Ok(found) }
}

/// Mean, mean size and standard deviation for every factor, with this weight for each trajectory.
fn statistics(effects: &[Vec<Option<f64>>], factors: usize, weights: &[f64]) -> Vec<f64> {
    let mut figures = Vec::with_capacity(3 * factors);
    for factor in 0..factors {
        let weighted = || {
            let of = effects.iter().zip(weights);
            of.filter_map(|(of, weight)| of.get(factor).copied().flatten().map(|effect| (effect, *weight)))
        };
        let count: f64 = weighted().map(|(_, weight)| weight).sum();
        let mean = weighted().map(|(effect, weight)| weight * effect).sum::<f64>() / count;
        let size = weighted().map(|(effect, weight)| weight * effect.abs()).sum::<f64>() / count;
        let squares: f64 = weighted().map(|(effect, weight)| weight * (effect - mean).powi(2)).sum();
        figures.extend([mean, size, (squares / (count - 1.0)).sqrt()]);
    }
    figures
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trajectories of one factor, whose output is its value: per whole range it changes by the range, by one name to another by 1.
    #[test]
    fn effects_are_per_range_of_the_values_that_there_are() {
        let none = Bootstrap { replicates: 0, seed: 0, level: 0.95 };
        // Whole numbers from 1 to 5 and a list of two, at the four levels of a grid.
        let whole = (vec![1.0, 4.0, 5.0, 2.0], Reach::Values(4.0), 4.0);
        let list = (vec![1.0, 2.0, 2.0, 1.0], Reach::Values(1.0), 1.0);
        let names = (vec![0.0, 1.0, 1.0, 0.0], Reach::Names, 1.0);
        let grid = (vec![0.0, 2.0, 3.0, 1.0], Reach::Grid, 3.0);
        for (values, reach, expected) in [whole, list, names, grid] {
            let factors = [values.clone()];
            let trajectories = Trajectories { factors: &factors, levels: 4, reaches: &[reach] };
            let found = morris(&values, trajectories, &none).expect("effects").remove(0).expect("it moves");
            let figures = [found.mean, found.mean_size, found.std_dev].map(|estimate| estimate.value);
            assert!((figures[0] - expected).abs() < 1e-12 && (figures[1] - expected).abs() < 1e-12, "{figures:?}");
            assert!(figures[2] < 1e-12, "{figures:?}");
        }
    }
}
