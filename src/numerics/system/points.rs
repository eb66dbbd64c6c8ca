//! Points of a scene's parts that links join, found by id. Watched points are not among them: they cost no state.

use std::collections::BTreeMap;

/// Id of a part of a scene. A part has coordinates, and points that follow from them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PartId {
    /// The machine.
    Machine,
    /// The bodies of a hammer.
    Hammer(usize),
    /// A casting.
    Casting(usize),
}

/// Id of a fixture: its casting, and its index among that casting's fixtures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FixtureId {
    /// The casting that it holds.
    pub casting: usize,
    /// Index among the fixtures of that casting.
    pub fixture: usize,
}

/// A point of a part that links join, along the strike axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PointId {
    /// A body of a hammer; a guide that is tied is the mount itself.
    Body {
        /// The hammer.
        hammer: usize,
        /// The body, see [`crate::hammer::body`].
        body: usize,
    },
    /// The point of the machine that carries a hammer.
    Mount {
        /// The hammer.
        hammer: usize,
    },
    /// The point of a casting that a hammer strikes.
    Strike {
        /// The hammer.
        hammer: usize,
    },
    /// The point of the machine that carries a fixture.
    Support(FixtureId),
    /// The point of a casting that a fixture holds.
    Held(FixtureId),
    /// The measuring point of a casting.
    Measured {
        /// The casting.
        casting: usize,
    },
}

/// Owner of an element. Its books record the element's work and loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// A hammer.
    Hammer(usize),
    /// A fixture of a casting.
    Fixture(FixtureId),
}

/// Motion of a point as a sum over columns of the elements' rows, each with its coefficient.
pub type Row = Vec<(usize, f64)>;

/// Points of a scene's parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points(BTreeMap<PointId, Row>);

impl Points {
    /// Adds a point.
    pub(super) fn add(&mut self, point: PointId, row: Row) {
        self.0.insert(point, row);
    }

    /// The row of a point; empty for one that the scene does not have.
    pub fn row(&self, point: PointId) -> &[(usize, f64)] {
        self.0.get(&point).map_or(&[], Vec::as_slice)
    }

    /// Row of the distance between two points: the first row less the second.
    pub(super) fn between(&self, [plus, minus]: [PointId; 2]) -> Row {
        let negative = self.row(minus).iter().map(|(column, coefficient)| (*column, -coefficient));
        self.row(plus).iter().copied().chain(negative).collect()
    }
}
