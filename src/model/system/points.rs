//! Rows of the points that links can join. Watched points are not among them: they cost no state.

use std::collections::BTreeMap;

use crate::scene::PointId;

/// Motion of a point as a sum over columns of the elements' rows, each with its coefficient.
pub type PointRow = Vec<(usize, f64)>;

/// Points of a scene's parts with their rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points(pub(super) BTreeMap<PointId, PointRow>);

impl Points {
    /// The row of a point; empty for one that the scene does not have.
    pub fn row(&self, point: PointId) -> &[(usize, f64)] {
        self.0.get(&point).map_or(&[], Vec::as_slice)
    }

    /// Row of the distance between two points: the first row less the second.
    pub(super) fn between(&self, [plus, minus]: [PointId; 2]) -> PointRow {
        let negative = self.row(minus).iter().map(|(column, coefficient)| (*column, -coefficient));
        self.row(plus).iter().copied().chain(negative).collect()
    }
}
