//! Criteria of a Latin hypercube, and its independent strata.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::permutation::Permutation;
use decore_math::random::{hash, uniform};

/// Place of a point within its stratum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Placement {
    /// Uniform at random.
    #[default]
    Random,
    /// In the stratum's middle.
    Centred,
}

/// Criterion for which a Latin hypercube is optimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HypercubeKind {
    /// Random, without optimisation.
    #[default]
    #[serde(rename = "none")]
    Random,
    /// A large smallest distance (by phi_p with p = 32 over the strata's middles).
    Maximin,
    /// A small centred L2 discrepancy (of the strata's middles).
    CentredDiscrepancy,
    /// Built on an orthogonal array of strength two (Tang 1993): `q^2` rows for a prime power `q`, at most `q + 1`
    /// factors; every pair of factors hits each of its `q x q` cells once.
    OrthogonalArray,
    /// Sliced over the categories (Qian 2012): there is a slice per combination of categories, row r belongs to slice
    /// `r mod slices`, and the other factors form a Latin hypercube in each slice and in the whole.
    Sliced,
}

/// A Latin hypercube.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LatinHypercube {
    /// Number of rows.
    pub rows: usize,
    /// Numbers of rows that the design had before, ascending: its first rows are that design's.
    ///
    /// Each stage fills strata that the rows before it leave empty. The whole is a Latin hypercube where `rows` is a multiple
    /// of the stage before; otherwise as many strata are hit as the first rows allow.
    pub grown_from: Vec<usize>,
    /// Place of a point within its stratum.
    pub placement: Placement,
    /// Criterion for which it is optimised.
    pub kind: HypercubeKind,
}

/// A Latin hypercube before anything is optimised, correlated or repaired.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OpenHypercube {
    pub spec: LatinHypercube,
    pub seed: u64,
    /// Number of categories per factor, where the hypercube is sliced; 1 for other factors.
    pub categories: Vec<u64>,
}

impl OpenHypercube {
    pub(super) fn columns(&self) -> usize {
        self.categories.len()
    }

    /// Two streams per factor: one for the permutation, one for the places within the strata.
    pub(super) fn place(&self, row: usize, column: usize) -> f64 {
        match self.spec.placement {
            Placement::Random => uniform(self.seed, 2 * column as u64 + 1, row as u64),
            Placement::Centred => 0.5,
        }
    }

    /// Stratum of a row of the first stage before anything is optimised or repaired.
    pub(super) fn stratum(&self, row: u64, column: u64) -> u64 {
        let key = hash(self.seed, 2 * column, 0);
        // A grown design starts as the first one did.
        let rows = self.spec.grown_from.first().copied().unwrap_or(self.spec.rows) as u64;
        match self.spec.kind {
            HypercubeKind::Sliced => {
                let slices: u64 = self.categories.iter().product();
                let (slice, index, coarse) = (row % slices, row / slices, rows / slices);
                let stratum = Permutation::new(hash(key, 1, slice), coarse).at(index);
                stratum * slices + Permutation::new(hash(key, 2, stratum), slices).at(slice)
            }
            _ => Permutation::new(key, rows).at(row),
        }
    }
}
