//! Positions of hammers: interface points with their coordinates, and rails through them. Nodes of elastic castings.

use std::collections::BTreeMap;
use std::sync::Arc;

use decore_model::scene::Mount;
use decore_model::structure::BodyNodes;
use decore_quantity::words::nearest;

/// Lengths below this in m are rounding.
const LENGTH_TOLERANCE_M: f64 = 1e-9;

/// Named interface points of a structure and their positions x, y, z in m, and the nodes of elastic castings whose points are nodes.
#[derive(Debug, Clone, Default)]
pub struct PointTable {
    positions: BTreeMap<String, [f64; 3]>,
    nodes: BTreeMap<String, Arc<BodyNodes>>,
}

impl FromIterator<(String, [f64; 3])> for PointTable {
    fn from_iter<I: IntoIterator<Item = (String, [f64; 3])>>(points: I) -> Self {
        Self { positions: points.into_iter().collect(), nodes: BTreeMap::new() }
    }
}

impl PointTable {
    /// Position x, y, z in m; `None` for an unknown point.
    pub fn position(&self, name: &str) -> Option<[f64; 3]> {
        self.positions.get(name).copied()
    }

    /// The table with the nodes of an elastic casting.
    pub fn with_nodes(mut self, casting: &str, nodes: BodyNodes) -> Self {
        self.nodes.insert(casting.to_owned(), Arc::new(nodes));
        self
    }

    /// Nodes of an elastic casting; `None` where they were not read.
    pub fn nodes(&self, casting: &str) -> Option<&BodyNodes> {
        self.nodes.get(casting).map(Arc::as_ref)
    }

    /// The known name most like `name`, for messages.
    pub fn nearest_name(&self, name: &str) -> Option<String> {
        nearest(name, self.positions.keys().map(String::as_str))
    }
}

/// A rail: interface points in order along a polyline.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rail {
    /// Name as in the study.
    pub name: String,
    /// Interface points in order.
    pub points: Vec<String>,
}

/// Reason why a hammer cannot be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum PlacementError {
    #[error("the machine has no interface point `{0}`")]
    UnknownPoint(String),
    #[error("rail `{0}` needs at least two points at different places")]
    ShortRail(String),
    #[error("is {position} m, which lies off rail `{rail}`: its positions run from {} m to {half} m", -half)]
    OffRail { rail: String, position: f64, half: f64 },
}

/// A mount with its position.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Placed {
    pub mount: Mount,
    /// x, y, z in m.
    pub position: [f64; 3],
}

/// Places a hammer at an interface point.
pub(crate) fn at_point(point: &str, points: &PointTable) -> Result<Placed, PlacementError> {
    let position = points.position(point).ok_or_else(|| PlacementError::UnknownPoint(point.to_string()))?;
    Ok(Placed { mount: Mount { points: vec![(point.to_string(), 1.0)] }, position })
}

/// Places a hammer on a rail.
///
/// The position is the arc length in m from the rail's middle, positive towards the last point. Between two points their
/// rows are interpolated linearly; within [`LENGTH_TOLERANCE_M`] of a point the mount is that point alone.
pub(crate) fn on_rail(rail: &Rail, position_m: f64, points: &PointTable) -> Result<Placed, PlacementError> {
    let mut stations = Vec::with_capacity(rail.points.len());
    let mut length = 0.0;
    let mut last: Option<[f64; 3]> = None;
    for name in &rail.points {
        let place = points.position(name).ok_or_else(|| PlacementError::UnknownPoint(name.clone()))?;
        length += last.map_or(0.0, |last| distance(last, place));
        last = Some(place);
        stations.push((name, place, length));
    }
    if stations.len() < 2 || length < LENGTH_TOLERANCE_M {
        return Err(PlacementError::ShortRail(rail.name.clone()));
    }
    let half = 0.5 * length;
    let along = position_m + half;
    // Written so that a NaN is off the rail.
    let on = along >= -LENGTH_TOLERANCE_M && along <= length + LENGTH_TOLERANCE_M;
    if !on {
        // Rounded: summed lengths carry noise in their last digits.
        let half = (half * 1e9).round() / 1e9;
        return Err(PlacementError::OffRail { rail: rail.name.clone(), position: position_m, half });
    }
    if let Some((name, _, _)) = stations.iter().find(|(_, _, at)| (at - along).abs() <= LENGTH_TOLERANCE_M) {
        return at_point(name, points);
    }
    let between = |pair: &[(&String, [f64; 3], f64)]| match pair {
        [(first, from, start), (second, to, end)] if *start < along && along < *end => {
            let share = (along - start) / (end - start);
            let mut position = *from;
            for (value, target) in position.iter_mut().zip(to) {
                *value += share * (target - *value);
            }
            let points = vec![((*first).clone(), 1.0 - share), ((*second).clone(), share)];
            Some(Placed { mount: Mount { points }, position })
        }
        _ => None,
    };
    let placed = stations.windows(2).find_map(between);
    placed.ok_or_else(|| PlacementError::ShortRail(rail.name.clone()))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent() -> (Rail, PointTable) {
        let places = [("A", [0.0, 0.0, 1.0]), ("B", [0.3, 0.0, 1.0]), ("C", [0.3, 0.5, 1.0])];
        let points = places.map(|(name, place)| (name.to_string(), place)).into_iter().collect();
        let rail = Rail { name: "bent".into(), points: ["A", "B", "C"].map(String::from).to_vec() };
        (rail, points)
    }

    #[test]
    fn positions_run_along_the_polyline_from_its_middle() {
        let (rail, points) = bent();
        // Length 0.8: the middle lies 0.1 behind B.
        let middle = on_rail(&rail, 0.0, &points).unwrap();
        assert!((middle.position[0] - 0.3).abs() < 1e-15 && (middle.position[1] - 0.1).abs() < 1e-15);
        assert_eq!(middle.mount.points[0].0, "B");
        assert!((middle.mount.points[1].1 - 0.2).abs() < 1e-12);
        let first = on_rail(&rail, -0.25, &points).unwrap();
        assert!((first.position[0] - 0.15).abs() < 1e-12);
        let sum: f64 = first.mount.points.iter().map(|(_, weight)| weight).sum();
        assert_eq!(sum, 1.0);
    }

    #[test]
    fn a_position_at_a_point_is_the_point() {
        let (rail, points) = bent();
        for (position, name) in [(-0.4, "A"), (-0.1, "B"), (0.4, "C"), (0.4 + 1e-12, "C")] {
            let placed = on_rail(&rail, position, &points).unwrap();
            assert_eq!(placed.mount.points, [(name.to_string(), 1.0)]);
        }
    }

    #[test]
    fn positions_off_the_rail_are_errors() {
        let (rail, points) = bent();
        for position in [0.41, -0.5, f64::NAN, f64::INFINITY] {
            let error = on_rail(&rail, position, &points).unwrap_err();
            assert!(error.to_string().contains("from -0.4 m to 0.4 m"), "{error}");
        }
        let short = Rail { name: "short".into(), points: vec!["A".into(), "A".into()] };
        assert_eq!(on_rail(&short, 0.0, &points), Err(PlacementError::ShortRail("short".into())));
    }
}
