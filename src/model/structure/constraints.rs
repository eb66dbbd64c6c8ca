//! Rows that are not degrees of freedom: Lagrange multipliers, and rows held with a diagonal of 1.
//!
//! A model with multipliers l has the stiffness `[K C'; C -B]` and no mass in the rows of l. Stationary in l means `C u = B l`. Along the
//! null space N of B that is a constraint `N' C u = 0`; the rest is stiffness, `K + C' B^+ C`. Constraints are solved for as many
//! displacements, which follow the others: `u = T u`, `K -> T' K T`, and so for mass and damping. Rows that follow, and multipliers, become
//! empty.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, SymmetricEigen};
use sprs::{CsMat, TriMat};

use super::matrices::ModelMatrices;

/// Coefficients of a constraint below this share of its largest are rounding.
const ROUNDING: f64 = 1e-12;
/// Eigenvalues of B below this share of the largest count as none.
const NULL: f64 = 1e-9;
/// Stiffness in comparison with which a diagonal of 1 means a held row.
const STIFF: f64 = 1e3;
/// Multipliers that are coupled to each other are solved as one dense block of at most so many rows.
const MOST_COUPLED: usize = 500;

/// Coefficients of a constraint by row.
pub(super) type Constraint = BTreeMap<usize, f64>;

/// Empties multipliers and held rows. Returns the changes, in sentences. `kept`: rows that must not follow others.
///
/// # Errors
/// In words: multipliers whose own stiffness cannot be made out.
pub(super) fn eliminate(matrices: &mut ModelMatrices, kept: &BTreeSet<usize>) -> Result<Vec<String>, String> {
    let mut said = Vec::new();
    let held = held_rows(matrices);
    if let Some(first) = held.first() {
        let gone: BTreeSet<usize> = held.iter().copied().collect();
        for_each(matrices, |matrix| *matrix = without(matrix, &gone));
        said.push(format!(
            "{} {} a diagonal of 1 and nothing else (the first is row {}): held by the program that wrote {}, left out",
            held.len(),
            if held.len() == 1 { "row has" } else { "rows have" },
            first + 1,
            if held.len() == 1 { "it" } else { "them" },
        ));
    }
    let multipliers = multipliers(matrices);
    let Some(first) = multipliers.iter().next() else { return Ok(said) };
    let (constraints, stiffening) = constraints(&matrices.stiffness, &multipliers)?;
    let (count, asked) = (multipliers.len(), constraints.len());
    let following = solve(constraints, kept);
    said.push(format!(
        "{count} Lagrange {} (the first is row {}): {} of {asked} {} solved for a displacement each, which follow the others",
        if count == 1 { "multiplier" } else { "multipliers" },
        first + 1,
        following.len(),
        if asked == 1 { "constraint" } else { "constraints" },
    ));
    matrices.stiffness = &without(&matrices.stiffness, &multipliers) + &stiffening;
    let (forward, back) = transformation(matrices.stiffness.rows(), &following);
    for_each(matrices, |matrix| *matrix = &(&back * &without(matrix, &multipliers)) * &forward);
    Ok(said)
}

pub(super) fn for_each(matrices: &mut ModelMatrices, change: impl Fn(&mut CsMat<f64>)) {
    [&mut matrices.mass, &mut matrices.stiffness].into_iter().chain(matrices.damping.as_mut()).for_each(change);
}

fn diagonal(matrix: &CsMat<f64>, row: usize) -> f64 {
    matrix.get(row, row).copied().unwrap_or(0.0)
}

/// Whether a row has an entry off its diagonal.
fn is_coupled(matrix: &CsMat<f64>, row: usize) -> bool {
    matrix.outer_view(row).is_some_and(|view| view.iter().any(|(column, value)| column != row && *value != 0.0))
}

/// Rows with a diagonal of 1 in the stiffness, 1 or 0 in the mass and nothing else, in a model that is stiff elsewhere.
fn held_rows(matrices: &ModelMatrices) -> Vec<usize> {
    let ModelMatrices { mass, stiffness, .. } = matrices;
    let order = stiffness.rows();
    let is_held = |row: &usize| {
        let row = *row;
        diagonal(stiffness, row) == 1.0
            && [0.0, 1.0].contains(&diagonal(mass, row))
            && !is_coupled(stiffness, row)
            && !is_coupled(mass, row)
    };
    let held: Vec<usize> = (0..order).filter(is_held).collect();
    let stiff = (0..order).any(|row| diagonal(stiffness, row) > STIFF);
    if stiff { held } else { Vec::new() }
}

/// Rows without mass, with a stiffness that is not positive, that are coupled to others.
fn multipliers(matrices: &ModelMatrices) -> BTreeSet<usize> {
    let ModelMatrices { mass, stiffness, .. } = matrices;
    let massless = |row: usize| diagonal(mass, row) == 0.0 && !is_coupled(mass, row);
    let is_one = |row: &usize| diagonal(stiffness, *row) <= 0.0 && is_coupled(stiffness, *row) && massless(*row);
    (0..stiffness.rows()).filter(is_one).collect()
}

/// Constraints of the multipliers, and the stiffness of the others.
fn constraints(stiffness: &CsMat<f64>, multipliers: &BTreeSet<usize>) -> Result<(Vec<Constraint>, CsMat<f64>), String> {
    let mut out = Vec::new();
    let mut stiffening = TriMat::new(stiffness.shape());
    for block in coupled(stiffness, multipliers) {
        if block.len() > MOST_COUPLED {
            return Err(format!(
                "{} rows without mass and with a diagonal of 0 or less (the first is row {}) are coupled to each other: expected Lagrange multipliers, each coupled to displacements; check the signs",
                block.len(),
                block[0] + 1
            ));
        }
        let own = DMatrix::from_fn(block.len(), block.len(), |i, j| {
            -stiffness.get(block[i], block[j]).copied().unwrap_or(0.0)
        });
        let eigen = SymmetricEigen::new(own);
        let largest = eigen.eigenvalues.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            let combined = combine(stiffness, &block, vector.as_slice(), multipliers);
            if value.abs() <= NULL * largest || largest == 0.0 {
                out.push(combined);
            } else if *value < 0.0 {
                return Err(format!(
                    "row {} has no mass and a stiffness of {:e} against a motion of its own: check the signs",
                    block[0] + 1,
                    value
                ));
            } else {
                for (i, a) in &combined {
                    combined.iter().for_each(|(j, b)| stiffening.add_triplet(*i, *j, a * b / value));
                }
            }
        }
    }
    Ok((out.into_iter().filter(|constraint| !constraint.is_empty()).collect(), stiffening.to_csr()))
}

/// Multipliers in groups that are coupled to each other.
fn coupled(stiffness: &CsMat<f64>, multipliers: &BTreeSet<usize>) -> Vec<Vec<usize>> {
    let mut seen = BTreeSet::new();
    let mut out = Vec::new();
    for &start in multipliers {
        if !seen.insert(start) {
            continue;
        }
        let (mut block, mut open) = (vec![start], vec![start]);
        while let Some(row) = open.pop() {
            let others = stiffness.outer_view(row);
            for (column, value) in others.iter().flat_map(|view| view.iter()) {
                if *value != 0.0 && multipliers.contains(&column) && seen.insert(column) {
                    block.push(column);
                    open.push(column);
                }
            }
        }
        block.sort_unstable();
        out.push(block);
    }
    out
}

/// A combination of the couplings of multipliers with displacements.
fn combine(stiffness: &CsMat<f64>, block: &[usize], weights: &[f64], multipliers: &BTreeSet<usize>) -> Constraint {
    let mut out = Constraint::new();
    for (row, weight) in block.iter().zip(weights) {
        for (column, value) in stiffness.outer_view(*row).iter().flat_map(|view| view.iter()) {
            if !multipliers.contains(&column) {
                *out.entry(column).or_default() += weight * value;
            }
        }
    }
    let size = |constraint: &Constraint| constraint.values().fold(0.0_f64, |most, value| most.max(value.abs()));
    let couplings = |row: &usize| {
        let view = stiffness.outer_view(*row);
        view.iter()
            .flat_map(|view| view.iter())
            .filter(|(column, _)| !multipliers.contains(column))
            .map(|(_, value)| value.abs())
            .fold(0.0, f64::max)
    };
    let scale = block.iter().map(couplings).fold(size(&out), f64::max);
    out.retain(|_, value| value.abs() > ROUNDING * scale);
    out
}

/// Displacements that follow others, each with the coefficients of those. A row of `kept` follows only where a constraint has no other.
pub(super) fn solve(constraints: Vec<Constraint>, kept: &BTreeSet<usize>) -> BTreeMap<usize, Constraint> {
    let mut following: BTreeMap<usize, Constraint> = BTreeMap::new();
    for constraint in constraints {
        let scale = constraint.values().fold(0.0_f64, |most, value| most.max(value.abs()));
        let mut left = Constraint::new();
        for (row, value) in constraint {
            match following.get(&row) {
                Some(others) => {
                    others.iter().for_each(|(other, weight)| *left.entry(*other).or_default() += value * weight)
                }
                None => *left.entry(row).or_default() += value,
            }
        }
        left.retain(|_, value| value.abs() > ROUNDING * scale);
        // The largest coefficient, of a row that nothing else refers to if there is one.
        let largest = |free: bool| {
            let rows = left.iter().filter(|(row, _)| !free || !kept.contains(row));
            rows.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.cmp(a.0))).map(|(row, value)| (*row, *value))
        };
        let Some((pivot, value)) = largest(true).or_else(|| largest(false)) else { continue };
        left.remove(&pivot);
        left.values_mut().for_each(|other| *other /= -value);
        for others in following.values_mut() {
            if let Some(weight) = others.remove(&pivot) {
                left.iter().for_each(|(row, value)| *others.entry(*row).or_default() += weight * value);
            }
        }
        following.insert(pivot, left);
    }
    following
}

/// T and T'.
pub(super) fn transformation(order: usize, following: &BTreeMap<usize, Constraint>) -> (CsMat<f64>, CsMat<f64>) {
    let (mut forward, mut back) = (TriMat::new((order, order)), TriMat::new((order, order)));
    let mut put = |row: usize, column: usize, value: f64| {
        forward.add_triplet(row, column, value);
        back.add_triplet(column, row, value);
    };
    for row in 0..order {
        match following.get(&row) {
            None => put(row, row, 1.0),
            Some(others) => others.iter().for_each(|(other, value)| put(row, *other, *value)),
        }
    }
    (forward.to_csr(), back.to_csr())
}

/// The matrix with some rows and columns left empty.
pub(super) fn without(matrix: &CsMat<f64>, gone: &BTreeSet<usize>) -> CsMat<f64> {
    let mut out = TriMat::new(matrix.shape());
    for (value, (row, column)) in matrix.iter() {
        if !gone.contains(&row) && !gone.contains(&column) {
            out.add_triplet(row, column, *value);
        }
    }
    out.to_csr()
}
