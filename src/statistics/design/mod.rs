//! Designs of experiments: values of the factors in each row.
//!
//! A row is a pure function of (design, row). Rows can run in any order, on any number of threads, and be repeated after an interruption.
//! Factors are numbers or indices of categories here; the study assigns them to parameters.
//!
//! A [`Kind`] gives every row a [`Coordinate`] per factor; correlations bend coordinates, [`Distribution`]s make values of
//! them, constraints choose among rows. Most kinds compute a row alone; optimised, grown, correlated and constrained Latin
//! hypercubes, and small classical plans, keep a table of all rows.

mod constraint;
mod coordinate;
mod correlation;
mod distribution;
mod error;
mod factor;
mod group;
mod kind;
mod latin;
mod mirrored;
mod optimise;
mod options;
mod orthogonal;
mod permutation;
mod polish;
mod quality;
mod ranks;
mod repair;
mod selection;
mod sobol;
mod strata;
mod table;

use std::sync::Arc;

use constraint::Conditions;
use correlation::Correlation;
use kind::{Points, Request};
use selection::Selection;

pub use constraint::Constraints;
pub use coordinate::Coordinate;
pub use distribution::{Distribution, Level};
pub use error::{DesignError, MOST_ROWS};
pub use factor::Factor;
pub use group::{GroupKind, GroupSpan};
pub use kind::*;
pub use options::{Axial, DesignOptions, Needs, design_keys};
pub use quality::{
    PHI_EXPONENT, Quality, centred_discrepancy, l2_star_discrepancy, mixture_discrepancy, wrap_around_discrepancy,
};
pub use selection::Acceptance;
pub use strata::{HypercubeKind, LatinHypercube, Placement};

/// A checked design.
#[derive(Debug, Clone)]
pub struct Design {
    kind: Kind,
    factors: Vec<Factor>,
    seed: u64,
    correlation: Option<Correlation>,
    points: Arc<dyn Points>,
    selection: Option<Selection>,
}

impl Design {
    /// Checks the factors and counts the rows.
    ///
    /// # Errors
    /// [`DesignError`] for a factor or kind that gives no design.
    pub fn new(kind: Kind, factors: Vec<Factor>, seed: u64) -> Result<Self, DesignError> {
        Self::build(kind, factors, seed, None)
    }

    /// A design whose factors have these rank correlations (Spearman), a row of the matrix per factor.
    ///
    /// Latin hypercubes are rearranged (Iman and Conover), which keeps them Latin; Sobol', Halton and random points go
    /// through a Gaussian copula, which keeps every row computable alone. Categories cannot be correlated.
    ///
    /// # Errors
    /// As [`Design::new`]; [`DesignError::Correlation`] for a matrix that is none, or a kind of design without chance.
    pub fn with_correlation(
        kind: Kind,
        factors: Vec<Factor>,
        seed: u64,
        matrix: &[Vec<f64>],
    ) -> Result<Self, DesignError> {
        let correlation = Correlation::new(matrix, factors.len())?;
        let categories = |factor: &Factor| matches!(factor.distribution, Distribution::Categories { .. });
        for (index, row) in matrix.iter().enumerate() {
            if factors.get(index).is_some_and(categories) && row.iter().filter(|entry| **entry != 0.0).count() > 1 {
                return Err(DesignError::FactorKind {
                    factor: index,
                    expected: "categories have no rank to correlate",
                });
            }
        }
        Self::build(kind, factors, seed, Some(correlation))
    }

    fn build(
        kind: Kind,
        factors: Vec<Factor>,
        seed: u64,
        correlation: Option<Correlation>,
    ) -> Result<Self, DesignError> {
        for (index, factor) in factors.iter().enumerate() {
            factor.distribution.check(index)?;
        }
        let request = Request { factors: &factors, seed, correlation: correlation.as_ref() };
        let points = kind.points(request)?;
        if correlation.is_some() && !points.takes_correlation() {
            let message = "only Latin hypercubes, Sobol', Halton and random points can be correlated";
            return Err(DesignError::Correlation(message.into()));
        }
        Ok(Self { kind, factors, seed, correlation, points, selection: None })
    }

    /// The design restricted to rows that meet the constraints.
    ///
    /// Latin hypercubes stay Latin: entries are moved within their columns until every row passes. Sobol', Halton and
    /// random points, Morris trajectories and Saltelli blocks that do not pass are skipped and the next ones taken, so the
    /// number of rows stays. All other kinds lose the rows that do not pass.
    ///
    /// # Errors
    /// [`DesignError::Unsatisfiable`] if no row is left, less than a thousandth of the points pass, or no Latin hypercube
    /// is found (the message says whether it is proved that there is none); errors of the constraints as
    /// [`DesignError::Constraint`].
    pub fn constrained(&self, constraints: Constraints<'_>) -> Result<Self, DesignError> {
        let Constraints { factors, met } = constraints;
        let unselected = Self { selection: None, ..self.clone() };
        let mut met_levels = |levels: &[Level], among: &[usize]| met(levels, among).map_err(DesignError::Constraint);
        let mut met_coordinates =
            |coordinates: &[Coordinate], among: &[usize]| met_levels(&self.levels(coordinates), among);
        let conditions = Conditions { factors: &factors, met: &mut met_coordinates };
        let all = conditions.all();
        if let Some(points) = self.points.constrained(self.correlation.as_ref(), conditions) {
            return Ok(Self { points: points?, ..unselected });
        }
        let accept = |row| Ok(met_levels(&unselected.candidate(row), &all)? == all.len());
        let selection = Selection::choose(unselected.points.as_ref(), accept)?;
        Ok(Self { selection: Some(selection), ..unselected })
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.selection.as_ref().map_or(self.points.rows(), Selection::rows)
    }

    /// Kind of the design.
    pub fn kind(&self) -> &Kind {
        &self.kind
    }

    /// The factors, in order.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Seed of the random numbers.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Number of points that passed the constraints; `None` if none were left out (no constraints, or a Latin hypercube).
    pub fn acceptance(&self) -> Option<Acceptance> {
        self.selection.as_ref().map(Selection::acceptance)
    }

    /// Groups of dependent rows: of a trajectory, a base point, or a part by which the design grew.
    pub fn groups(&self) -> Vec<GroupSpan> {
        let spans = self.points.groups();
        self.selection.as_ref().map_or(spans.clone(), |selection| selection.groups(&spans))
    }

    /// Confounded effects of a regular two-level fraction; `None` for other kinds, and if constraints left out rows.
    pub fn aliases(&self) -> Option<Aliases> {
        self.points.aliases().filter(|_| self.selection.is_none())
    }

    /// Whether every row is computed from (design, row) alone, without a table of all rows.
    pub fn is_open(&self) -> bool {
        self.points.is_open() && self.selection.is_none()
    }

    /// Values of all factors in this row; `None` past the last row.
    pub fn row(&self, row: usize) -> Option<Vec<Level>> {
        self.index(row).map(|index| self.candidate(index))
    }

    /// The row as a point of the unit cube, see [`Coordinate::unit`]; `None` past the last row.
    pub fn unit_row(&self, row: usize) -> Option<Vec<f64>> {
        let coordinates = self.bent(&self.points.at(self.index(row)?));
        Some(coordinates.iter().zip(&self.factors).map(|(c, factor)| c.unit(&factor.distribution)).collect())
    }

    fn index(&self, row: usize) -> Option<usize> {
        match &self.selection {
            Some(selection) => selection.index(row),
            None => (row < self.points.rows()).then_some(row),
        }
    }

    fn candidate(&self, index: usize) -> Vec<Level> {
        self.levels(&self.bent(&self.points.at(index)))
    }

    fn levels(&self, coordinates: &[Coordinate]) -> Vec<Level> {
        coordinates.iter().zip(&self.factors).map(|(c, factor)| c.level(&factor.distribution)).collect()
    }

    /// Sends points through the copula.
    fn bent(&self, coordinates: &[Coordinate]) -> Vec<Coordinate> {
        let Some(correlation) = self.correlation.as_ref().filter(|_| self.points.is_sampled()) else {
            return coordinates.to_vec();
        };
        let probability = |coordinate: &Coordinate| match *coordinate {
            Coordinate::Probability(probability) => probability,
            _ => 0.5,
        };
        let independent: Vec<f64> = coordinates.iter().map(probability).collect();
        correlation.copula(&independent).into_iter().map(Coordinate::Probability).collect()
    }
}
