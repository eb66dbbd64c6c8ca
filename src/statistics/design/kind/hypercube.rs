//! Latin hypercubes as a kind of design.

use std::sync::Arc;

use super::super::constraint::Conditions;
use super::super::coordinate::Coordinate;
use super::super::correlation::Correlation;
use super::super::error::DesignError;
use super::super::group::{GroupKind, GroupSpan, chained};
use super::super::latin::Latin;
use super::super::options::{DesignOptions, Needs, count};
use super::super::strata::{HypercubeKind, LatinHypercube, Placement};
use super::points::{Points, Request, Specification};

impl Specification for LatinHypercube {
    fn of(keys: &DesignOptions) -> Result<Self, Needs> {
        let kind = keys.optimise.unwrap_or_default();
        let optimised = matches!(kind, HypercubeKind::Maximin | HypercubeKind::CentredDiscrepancy);
        let centred = keys.centred.unwrap_or(optimised);
        Ok(Self {
            rows: keys.row_count()?,
            grown_from: keys.grown_from.iter().flatten().map(|rows| count(*rows)).collect(),
            placement: if centred { Placement::Centred } else { Placement::Random },
            kind,
        })
    }

    fn points(&self, request: Request<'_>) -> Result<Arc<dyn Points>, DesignError> {
        Ok(Arc::new(Latin::new(self, request.factors, request.seed, request.correlation)?))
    }
}

impl Points for Latin {
    fn rows(&self) -> usize {
        self.row_count()
    }

    fn at(&self, row: usize) -> Vec<Coordinate> {
        (0..self.columns()).map(|column| self.coordinate(row, column)).collect()
    }

    fn takes_correlation(&self) -> bool {
        true
    }

    fn is_open(&self) -> bool {
        !self.is_table()
    }

    fn groups(&self) -> Vec<GroupSpan> {
        let part = |rows: usize| (rows, vec![GroupSpan::whole(GroupKind::GrownPart, rows, rows)]);
        let stages = self.stages();
        if stages.len() < 2 {
            return Vec::new();
        }
        let sizes = stages.iter().scan(0, |before, end| Some(*end - std::mem::replace(before, *end)));
        chained(sizes.map(part))
    }

    fn constrained(
        &self,
        correlation: Option<&Correlation>,
        conditions: Conditions<'_>,
    ) -> Option<Result<Arc<dyn Points>, DesignError>> {
        Some(self.repaired(correlation, conditions).map(|latin| Arc::new(latin) as Arc<dyn Points>))
    }
}
